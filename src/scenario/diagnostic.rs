//! What is wrong with a scenario, said so that a person can mend it and a program can show it in place.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Level, Origin, Renderer, Snippet, renderer::DecorStyle};

use super::source::{Sources, Span};

/// One error: where, what, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The file as it was named, or the argument (`--set path=value`), or `preset robot/incra1`.
    pub file: String,
    /// Where in it; `None` if it could not be read at all.
    pub place: Option<Place>,
    /// What is wrong, complete without the place.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
}

/// A place in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// The line itself, without its end.
    pub text: String,
    /// The bytes of `text` that are meant.
    pub mark: Range<usize>,
}

/// Every error found in a scenario and what was laid over it, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

/// An error in the making: its place is still a span of a source.
#[derive(Clone, Debug)]
pub(super) struct Finding {
    pub(super) span: Span,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

impl Finding {
    pub(super) fn new(span: Span, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), help: None }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl Diagnostic {
    /// An error about a file as a whole.
    pub(super) fn of_file(file: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { file: file.into(), place: None, message: message.into(), help: Some(help.into()) }
    }

    /// For a person: message, place, the line with the spot marked, help. `styled` adds colours for a terminal.
    pub fn render(&self, styled: bool) -> String {
        let title = Level::ERROR.primary_title(self.message.as_str());
        let mut group = match &self.place {
            None => title.element(Origin::path(self.file.as_str())),
            Some(place) => title.element(
                Snippet::source(place.text.as_str())
                    .line_start(place.line)
                    .path(self.origin())
                    .annotation(AnnotationKind::Primary.span(place.mark.clone())),
            ),
        };
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = if styled { Renderer::styled().decor_style(DecorStyle::Unicode) } else { Renderer::plain() };
        renderer.render(&[group])
    }

    /// The file as the person sees it. The text of a `--set` argument stands in the line below already.
    fn origin(&self) -> &str {
        if self.file.starts_with("--set ") { "--set" } else { &self.file }
    }

    /// For a program: `{"file", "line", "column", "message", "help"}`; what is not known is null.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!({
            "file": self.file,
            "line": self.place.as_ref().map(|p| p.line),
            "column": self.place.as_ref().map(|p| p.column),
            "message": self.message,
            "help": self.help,
        })
    }
}

impl Diagnostics {
    /// In the order of the sources and, within each, of the text; what was found twice is said once.
    pub(super) fn from_findings(mut findings: Vec<Finding>, sources: &Sources) -> Self {
        findings.sort_by_key(|f| (f.span.source, f.span.start, f.span.end));
        let mut all: Vec<Diagnostic> = findings
            .into_iter()
            .map(|f| Diagnostic {
                file: sources.label(f.span).to_owned(),
                place: Some(sources.place(f.span)),
                message: f.message,
                help: f.help,
            })
            .collect();
        all.dedup();
        Self(all)
    }

    /// All of them for a person, an empty line between.
    pub fn render(&self, styled: bool) -> String {
        self.0.iter().map(|d| d.render(styled)).collect::<Vec<_>>().join("\n\n")
    }

    /// All of them for a program: an array.
    pub fn to_json(&self) -> serde_json::Value {
        self.0.iter().map(Diagnostic::to_json).collect()
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}
