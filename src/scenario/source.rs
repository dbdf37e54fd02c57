//! The texts that a scenario is put together from, and places in them.

use std::ops::Range;

use super::diagnostic::Place;

/// A stretch of one of the sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Span {
    /// Index of the source.
    pub(super) source: usize,
    /// First byte.
    pub(super) start: usize,
    /// One past the last.
    pub(super) end: usize,
}

/// The file, what was laid over it, and the presets, in the order in which they were taken in.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources(Vec<Source>);

#[derive(Clone, Debug)]
struct Source {
    label: String,
    text: String,
}

impl Span {
    pub(super) fn new(source: usize, range: Range<usize>) -> Self {
        Self { source, start: range.start, end: range.end }
    }
}

impl Sources {
    /// Takes in a text under the name by which errors speak of it; returns its index.
    pub(super) fn add(&mut self, label: impl Into<String>, text: impl Into<String>) -> usize {
        self.0.push(Source { label: label.into(), text: text.into() });
        self.0.len() - 1
    }

    pub(super) fn text(&self, source: usize) -> &str {
        &self.0[source].text
    }

    pub(super) fn label(&self, span: Span) -> &str {
        &self.0[span.source].label
    }

    /// The line that a span starts on. A span that goes on to further lines is cut at the line's end.
    pub(super) fn place(&self, span: Span) -> Place {
        let text = self.text(span.source);
        let boundary = |at: usize| (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
        let start = boundary(span.start);
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
        let line = text[line_start..line_end].trim_end_matches('\r');
        let from = (start - line_start).min(line.len());
        let to = boundary(span.end).saturating_sub(line_start).clamp(from, line.len());
        Place {
            line: text[..line_start].matches('\n').count() + 1,
            column: line[..from].chars().count() + 1,
            text: line.to_owned(),
            mark: from..to,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_counts_lines_and_characters_from_one() {
        let mut sources = Sources::default();
        let id = sources.add("x", "a = 1\r\nb\u{e4}r = \"\u{fc}\"\n");
        let at = "a = 1\r\nb\u{e4}r = ".len();
        let place = sources.place(Span::new(id, at..at + 4));
        assert_eq!((place.line, place.column), (2, 7));
        assert_eq!(&place.text[place.mark.clone()], "\"\u{fc}\"");
        let end = sources.place(Span::new(id, 100..200));
        assert_eq!((end.line, end.column, end.text.as_str()), (3, 1, ""));
    }
}
