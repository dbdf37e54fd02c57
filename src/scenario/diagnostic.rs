//! What is wrong with a scenario, said so that a person can mend it and a program can show it in place.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{Annotation, AnnotationKind, Level, Origin, Renderer, Snippet, renderer::DecorStyle};

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
    /// Other places that it is about: the other end of a join, what something overlaps.
    pub related: Vec<Related>,
}

/// Another place that an error is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Related {
    /// The file or the argument, as [`Diagnostic::file`].
    pub file: String,
    /// Where in it.
    pub place: Place,
    /// What stands there, as "`straight-1` is here".
    pub message: String,
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
    pub(super) related: Vec<(Span, String)>,
}

impl Finding {
    pub(super) fn new(span: Span, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), help: None, related: Vec::new() }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Names another place, unless it is the finding's own.
    pub(super) fn also(mut self, span: Span, what_is_there: impl Into<String>) -> Self {
        if span != self.span {
            self.related.push((span, what_is_there.into()));
        }
        self
    }
}

impl Diagnostic {
    /// An error about one place, or about a file as a whole.
    pub fn new(file: impl Into<String>, place: Option<Place>, message: impl Into<String>, help: Option<String>) -> Self {
        Self { file: file.into(), place, message: message.into(), help, related: Vec::new() }
    }

    /// An error about a file as a whole.
    pub(super) fn of_file(file: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(file, None, message, Some(help.into()))
    }

    /// For a person: message, each place with its line and the spot marked, help. `styled` adds colours for a terminal.
    pub fn render(&self, styled: bool) -> String {
        let mut group = Level::ERROR.primary_title(self.message.as_str()).elements(self.lines().iter().map(Line::snippet));
        if self.place.is_none() {
            group = group.element(Origin::path(self.file.as_str()));
        }
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = if styled { Renderer::styled().decor_style(DecorStyle::Unicode) } else { Renderer::plain() };
        renderer.render(&[group])
    }

    /// The lines that it is about, its own first.
    fn lines(&self) -> Vec<Line<'_>> {
        let mut lines: Vec<Line<'_>> = Vec::new();
        let own = self.place.iter().map(|place| (self.file.as_str(), place, None));
        let others = self.related.iter().map(|other| (other.file.as_str(), &other.place, Some(other.message.as_str())));
        for (file, place, what) in own.chain(others) {
            match lines.iter_mut().find(|line| line.file == file && line.place.line == place.line) {
                Some(line) => line.marks.push((place, what)),
                None => lines.push(Line { file, place, marks: vec![(place, what)] }),
            }
        }
        lines
    }

    /// For a program: `{"file", "line", "column", "message", "help", "related"}`; what is not known is null. `related` is an array of
    /// `{"file", "line", "column", "message"}`.
    pub fn to_json(&self) -> serde_json::Value {
        let related = |other: &Related| {
            serde_json::json!({
                "file": other.file, "line": other.place.line, "column": other.place.column, "message": other.message,
            })
        };
        serde_json::json!({
            "file": self.file,
            "line": self.place.as_ref().map(|p| p.line),
            "column": self.place.as_ref().map(|p| p.column),
            "message": self.message,
            "help": self.help,
            "related": self.related.iter().map(related).collect::<Vec<_>>(),
        })
    }
}

/// A line of a file with what is marked in it, and what is said of each mark.
struct Line<'d> {
    file: &'d str,
    place: &'d Place,
    marks: Vec<(&'d Place, Option<&'d str>)>,
}

impl<'d> Line<'d> {
    fn snippet(&self) -> Snippet<'d, Annotation<'d>> {
        // The text of a `--set` argument stands in the line below already.
        let file = if self.file.starts_with("--set ") { "--set" } else { self.file };
        let marks = self.marks.iter().map(|(place, what)| {
            let kind = if what.is_some() { AnnotationKind::Context } else { AnnotationKind::Primary };
            kind.span(place.mark.clone()).label(*what)
        });
        Snippet::source(self.place.text.as_str()).line_start(self.place.line).path(file).annotations(marks)
    }
}

impl Diagnostics {
    /// In the order of the sources and, within each, of the text; what was found twice is said once.
    pub(super) fn from_findings(mut findings: Vec<Finding>, sources: &Sources) -> Self {
        findings.sort_by_key(|f| (f.span.source, f.span.start, f.span.end));
        let mut all: Vec<Diagnostic> = findings
            .into_iter()
            .map(|f| {
                let file = |span| sources.label(span).to_owned();
                let related = f.related.into_iter().map(|(span, message)| {
                    let place = sources.place(span);
                    Related { file: file(span), place, message }
                });
                let related = related.collect();
                Diagnostic { related, ..Diagnostic::new(file(f.span), Some(sources.place(f.span)), f.message, f.help) }
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
