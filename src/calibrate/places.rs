//! Places in a text whose reader tells bytes.

use crate::scenario::Place;

/// The place of a byte: the line from there to its end.
pub(super) fn at(text: &str, byte: usize) -> Place {
    let byte = (0..=byte.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
    let start = text[..byte].rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[start..].lines().next().unwrap_or_default();
    let from = (byte - start).min(line.len());
    let column = line[..from].chars().count() + 1;
    Place { line: text[..start].matches('\n').count() + 1, column, text: line.to_owned(), mark: from..line.len() }
}
