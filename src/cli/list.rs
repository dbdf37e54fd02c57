//! `ductloop list`: the library of scenarios that is built into the program.

use clap::Args;
use comfy_table::Table;
use ductloop::library::{self, Entry};
use serde_json::json;

use super::problem::Problem;
use super::streams::{note, print, print_json};

/// What may be typed.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop list                   all scenarios, theme by theme
  ductloop list elbow left        those with all of these words in name, theme or sentence
  ductloop list networks --json   name, theme and sentence of each as JSON

A scenario of the library is run, rendered or checked by its name from any folder:
  ductloop run elbow-left
  ductloop render elbow-left --at-s 4 --out frame.png
  ductloop check elbow-left --plan plan.svg
  ductloop new my-elbow.toml --from elbow-left    a commented copy to start from

A file or folder of that name in the working directory comes first, then a scenario of that name below ./scenarios.")]
pub(crate) struct ListArgs {
    /// Only scenarios that have all of these words, in their names, themes or sentences
    #[arg(value_name = "WORD")]
    pub(crate) words: Vec<String>,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Between a name and its sentence.
const GAP: usize = 2;
/// Sentences are not squeezed into fewer columns.
const LEAST_COLUMNS: usize = 30;

/// Carries it out.
///
/// # Errors
/// Where no scenario has all of the words.
pub(crate) fn command(args: &ListArgs) -> Result<u8, Problem> {
    let words: Vec<String> = args.words.iter().map(|word| word.to_lowercase()).collect();
    let found: Vec<&Entry> = library::all().iter().filter(|entry| words.iter().all(|word| has(entry, word))).collect();
    if found.is_empty() {
        let none = Problem::new(Problem::WRONG_INPUT, "no scenario of the library has this in its name, theme or sentence");
        return Err(none.about(args.words.join(" ")).help("`ductloop list` shows all of them"));
    }
    if args.json {
        let row = |entry: &&Entry| json!({"name": entry.name, "theme": entry.theme, "about": entry.about});
        print_json(&json!({"scenarios": found.iter().map(row).collect::<Vec<_>>(), "errors": []}))?;
        return Ok(0);
    }
    // Known where standard output is a terminal; what goes to a file or a pipe keeps a line each.
    let columns = Table::new().width().map(usize::from);
    print(&shown(&found, columns))?;
    note(&format!("{} of {} scenarios; `ductloop run NAME` runs one", found.len(), library::all().len()));
    Ok(0)
}

fn has(entry: &Entry, word: &str) -> bool {
    [entry.name, entry.theme, &entry.about].iter().any(|text| text.to_lowercase().contains(word))
}

/// A heading a theme; below it a line a scenario, its sentence beside its name, wrapped to so many columns.
fn shown(entries: &[&Entry], columns: Option<usize>) -> String {
    let indent = 2 + GAP + entries.iter().map(|entry| entry.name.len()).max().unwrap_or_default();
    let room = columns.map_or(usize::MAX, |columns| columns.saturating_sub(indent).max(LEAST_COLUMNS));
    let mut text = String::new();
    let mut theme = "";
    for entry in entries {
        if entry.theme != theme {
            let space = if theme.is_empty() { "" } else { "\n" };
            theme = entry.theme;
            text += &format!("{space}{theme}\n");
        }
        for (number, line) in wrapped(&entry.about, room).iter().enumerate() {
            let before = if number == 0 { format!("  {}", entry.name) } else { String::new() };
            text += &format!("{before:indent$}{line}\n");
        }
    }
    text.trim_end().to_owned()
}

/// A text in lines of at most so many characters, broken at spaces; a longer word stands alone.
fn wrapped(text: &str, room: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last] = word.to_owned();
        } else if lines[last].chars().count() + 1 + word.chars().count() <= room {
            lines[last] += &format!(" {word}");
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &'static str, theme: &'static str, about: &str) -> Entry {
        Entry { name, theme, about: about.to_owned(), text: "" }
    }

    #[test]
    fn sentences_stand_in_line_and_are_wrapped_to_the_terminal() {
        let [a, b] =
            [entry("elbow", "fittings", "A bend to the left, of ninety degrees."), entry("drop-it", "holes", "No floor.")];
        let wide = "fittings\n  elbow    A bend to the left, of ninety degrees.\n\nholes\n  drop-it  No floor.";
        assert_eq!(shown(&[&a, &b], None), wide);
        assert_eq!(shown(&[&a, &b], Some(200)), wide);
        let narrow = "fittings\n  elbow    A bend to the left, of ninety\n           degrees.\n\nholes\n  drop-it  No floor.";
        assert_eq!(shown(&[&a, &b], Some(42)), narrow);
        // A terminal of a few columns gets longer lines, not a word a line.
        assert_eq!(shown(&[&a, &b], Some(5)), narrow);
    }
}
