//! What a command can end with other than its result, for people and for programs.

use std::io::IsTerminal;

use ductloop::scenario::Diagnostics;
use serde_json::{Map, Value, json};

use super::streams::{note, print_json};

/// Why a command did not come to its result.
#[derive(Debug)]
pub(crate) struct Problem {
    exit_code: u8,
    errors: Vec<Complaint>,
}

/// One thing that is wrong.
#[derive(Debug, PartialEq)]
enum Complaint {
    /// In files; each names its place.
    Files(Diagnostics),
    /// Anywhere else: what it is about, what is wrong, what would help.
    Other { about: Option<String>, message: String, help: Option<String> },
}

impl Problem {
    /// The command line or a file is wrong, or the output cannot be written.
    pub(crate) const WRONG_INPUT: u8 = 2;
    /// A run could not go on.
    pub(crate) const CANNOT_GO_ON: u8 = 3;

    /// One that is not in a scenario file.
    pub(crate) fn new(exit_code: u8, message: impl Into<String>) -> Self {
        Self { exit_code, errors: vec![Complaint::Other { about: None, message: message.into(), help: None }] }
    }

    /// Everything that is wrong with files.
    pub(crate) fn in_files(diagnostics: Vec<Diagnostics>) -> Self {
        Self { exit_code: Self::WRONG_INPUT, errors: diagnostics.into_iter().map(Complaint::Files).collect() }
    }

    /// Names what it is about: a file, a folder, an argument.
    pub(crate) fn about(mut self, what: impl Into<String>) -> Self {
        if let Some(Complaint::Other { about, .. }) = self.errors.last_mut() {
            *about = Some(what.into());
        }
        self
    }

    /// Says what would help.
    pub(crate) fn help(mut self, text: impl Into<String>) -> Self {
        if let Some(Complaint::Other { help, .. }) = self.errors.last_mut() {
            *help = Some(text.into());
        }
        self
    }

    /// With another exit code.
    pub(crate) fn with_code(self, exit_code: u8) -> Self {
        Self { exit_code, ..self }
    }

    /// This and another one; the higher exit code counts. What several runs complain of alike is said once.
    fn and(mut self, other: Self) -> Self {
        self.exit_code = self.exit_code.max(other.exit_code);
        for error in other.errors {
            if !self.errors.contains(&error) {
                self.errors.push(error);
            }
        }
        self
    }

    /// `{"file", "line", "column", "message", "help", "related"}` of each error.
    pub(crate) fn to_json(&self) -> Vec<Value> {
        self.errors
            .iter()
            .flat_map(|error| match error {
                Complaint::Files(diagnostics) => diagnostics.0.iter().map(|d| d.to_json()).collect(),
                Complaint::Other { about, message, help } => {
                    vec![json!({
                        "file": about, "line": null, "column": null, "message": message, "help": help, "related": [],
                    })]
                }
            })
            .collect()
    }

    /// The document that stands in for the result: an empty list of what would have been there, if the command gives one, and
    /// the errors.
    pub(crate) fn document(&self, list: Option<&str>) -> Value {
        let mut document = Map::new();
        document.extend(list.map(|key| (key.to_owned(), json!([]))));
        document.insert("errors".into(), self.to_json().into());
        document.into()
    }

    /// Tells it on standard error; returns the exit code.
    pub(crate) fn tell(&self) -> u8 {
        let styled = std::io::stderr().is_terminal();
        for error in &self.errors {
            match error {
                Complaint::Files(diagnostics) => note(&format!("{}\n", diagnostics.render(styled))),
                Complaint::Other { about, message, help } => {
                    let about = about.as_ref().map_or(String::new(), |what| format!("{what}: "));
                    note(&format!("error: {about}{message}"));
                    if let Some(help) = help {
                        note(&format!("  help: {help}"));
                    }
                }
            }
        }
        self.exit_code
    }

    /// Prints [`Problem::document`] on standard output; returns the exit code.
    pub(crate) fn print(&self, list: Option<&str>) -> u8 {
        let printed = print_json(&self.document(list));
        self.exit_code.max(printed.map_or_else(|lost| lost.tell(), |()| 0))
    }
}

/// Problems as they come up, one by one.
#[derive(Debug, Default)]
pub(crate) struct Problems(Option<Problem>);

impl Problems {
    /// Takes one in.
    pub(crate) fn note(&mut self, problem: Problem) {
        self.0 = Some(match self.0.take() {
            Some(before) => before.and(problem),
            None => problem,
        });
    }

    /// All of them as one.
    pub(crate) fn into_inner(self) -> Option<Problem> {
        self.0
    }

    /// The value, if there was none.
    pub(crate) fn or<T>(self, value: T) -> Result<T, Problem> {
        self.0.map_or(Ok(value), Err)
    }
}
