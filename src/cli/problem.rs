//! What a command can end with other than its result, for people and for programs.

use std::io::{IsTerminal, Write};

use ductloop::scenario::Diagnostics;
use serde_json::{Value, json};

/// Why a command did not come to its result.
#[derive(Debug)]
pub(crate) struct Problem {
    exit_code: u8,
    errors: Vec<Complaint>,
}

/// One thing that is wrong.
#[derive(Debug)]
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

    /// This and another one; the higher exit code counts.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.exit_code = self.exit_code.max(other.exit_code);
        self.errors.extend(other.errors);
        self
    }

    /// `{"file", "line", "column", "message", "help"}` of each error.
    pub(crate) fn to_json(&self) -> Vec<Value> {
        self.errors
            .iter()
            .flat_map(|error| match error {
                Complaint::Files(diagnostics) => diagnostics.0.iter().map(|d| d.to_json()).collect(),
                Complaint::Other { about, message, help } => {
                    vec![json!({"file": about, "line": null, "column": null, "message": message, "help": help})]
                }
            })
            .collect()
    }

    /// Tells it on standard error, and with `json` as a document on standard output; returns the exit code.
    pub(crate) fn report(&self, json: bool) -> u8 {
        let styled = std::io::stderr().is_terminal();
        for error in &self.errors {
            match error {
                Complaint::Files(diagnostics) => eprintln!("{}\n", diagnostics.render(styled)),
                Complaint::Other { about, message, help } => {
                    let about = about.as_ref().map_or(String::new(), |what| format!("{what}: "));
                    eprintln!("error: {about}{message}");
                    if let Some(help) = help {
                        eprintln!("  help: {help}");
                    }
                }
            }
        }
        if json {
            print_json(&json!({"runs": [], "errors": self.to_json()}));
        }
        self.exit_code
    }
}

/// Prints a document on standard output. A reader who has gone away is no error.
pub(crate) fn print_json(document: &Value) {
    let _ = writeln!(std::io::stdout().lock(), "{document:#}");
}
