//! Comma-separated tables with a line of names: small files that people write, so every error is told with its place.
//!
//! Strict where a slip could pass for data: each line has as many cells as there are names, numbers are finite, names occur once.
//! Empty lines and lines that begin with `#` are left out. A cell may stand in double quotes (`""` within them is one), but not
//! go on in the next line. Columns that nobody asks for are left alone.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use crate::bounded_file;
use crate::scenario::{Diagnostic, Diagnostics, Place, shown};

/// A table as it stands in a file.
#[derive(Clone, Debug)]
pub struct Table {
    file: String,
    names: Line,
    rows: Vec<Line>,
}

#[derive(Clone, Debug)]
struct Line {
    number: usize,
    text: String,
    cells: Vec<Cell>,
}

#[derive(Clone, Debug)]
struct Cell {
    text: String,
    bytes: Range<usize>,
}

/// Most errors told of one file: after so many a person has seen what is wrong.
const TOLD: usize = 20;
/// Largest file, in bytes: half a million points.
const MOST_BYTES: u64 = 64 << 20;

impl Table {
    /// Reads a file.
    ///
    /// # Errors
    /// Everything that is wrong with its form.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        let file = path.display().to_string();
        let whole = |message: String| Diagnostics(vec![of_file(&file, message, None)]);
        let bytes = bounded_file::read(path, MOST_BYTES).map_err(|error| {
            let help = Some("check the name of the file".into());
            Diagnostics(vec![of_file(&file, format!("cannot be read: {error}"), help)])
        })?;
        match String::from_utf8(bytes) {
            Ok(text) => Self::parse(&file, &text),
            Err(error) => {
                let good = error.utf8_error().valid_up_to();
                let line = error.as_bytes()[..good].iter().filter(|byte| **byte == b'\n').count() + 1;
                Err(whole(format!("is not UTF-8 text: line {line} holds other bytes")))
            }
        }
    }

    /// Reads a text; errors name it `file`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(file: &str, text: &str) -> Result<Self, Diagnostics> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let meant = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
        let lines = text.lines().enumerate().filter(|(_, line)| meant(line));
        let mut wrong = Vec::new();
        let mut split = Vec::new();
        for (index, line) in lines {
            match cells(line) {
                Ok(cells) => split.push(Line { number: index + 1, text: line.to_owned(), cells }),
                Err(from) => {
                    let here = Line { number: index + 1, text: line.to_owned(), cells: Vec::new() };
                    wrong.push(here.error(
                        file,
                        from..line.len(),
                        "a quotation mark is not closed, or text follows it".into(),
                        None,
                    ));
                }
            }
        }
        let mut rows = split.into_iter();
        let Some(names) = rows.next() else {
            wrong.push(of_file(file, "holds no line of names".into(), Some("the first line names the columns".into())));
            return Err(Diagnostics(wrong));
        };
        let rows: Vec<_> = rows.collect();
        let mut seen = BTreeMap::new();
        for (index, name) in names.cells.iter().enumerate().filter(|(_, cell)| !cell.text.is_empty()) {
            if seen.insert(name.text.as_str(), index).is_some() {
                wrong.push(names.error(file, name.bytes.clone(), format!("column `{}` occurs twice", name.text), None));
            }
        }
        for row in &rows {
            let (count, wanted) = (row.cells.len(), names.cells.len());
            if count != wanted {
                let place = row.cells.get(wanted).map_or(row.text.len()..row.text.len(), |cell| cell.bytes.clone());
                let message = format!("{count} cells instead of {wanted}");
                let help = format!("line {} names {wanted} columns, with commas between", names.number);
                wrong.push(row.error(file, place, message, Some(help)));
            }
        }
        if wrong.is_empty() { Ok(Self { file: file.to_owned(), names, rows }) } else { Err(told(wrong)) }
    }

    /// The file, as errors name it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// How many rows there are below the names.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The line in which a row stands, from 1.
    pub fn line(&self, row: usize) -> usize {
        self.rows[row].number
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.cells.iter().map(|cell| cell.text.as_str())
    }

    /// Whether there is such a column.
    pub fn has(&self, name: &str) -> bool {
        self.names().any(|known| known == name)
    }

    /// The numbers of these columns, row by row.
    ///
    /// # Errors
    /// Columns that are missing, and every cell of them that holds no finite number.
    pub fn numbers<const N: usize>(&self, names: [&str; N]) -> Result<Vec<[f64; N]>, Diagnostics> {
        let columns = self.columns(names)?;
        let mut wrong = Vec::new();
        let mut rows = Vec::with_capacity(self.rows.len());
        for row in &self.rows {
            rows.push(columns.map(|column| {
                let cell = &row.cells[column];
                self.number(row, cell, column).unwrap_or_else(|error| {
                    wrong.push(*error);
                    0.0
                })
            }));
        }
        if wrong.is_empty() { Ok(rows) } else { Err(told(wrong)) }
    }

    /// The text of a column, row by row.
    ///
    /// # Errors
    /// If the column is missing.
    pub fn texts(&self, name: &str) -> Result<Vec<&str>, Diagnostics> {
        let [column] = self.columns([name])?;
        Ok(self.rows.iter().map(|row| row.cells[column].text.as_str()).collect())
    }

    /// An error about a row as a whole.
    pub fn error(&self, row: usize, message: String, help: Option<String>) -> Diagnostic {
        let row = &self.rows[row];
        row.error(&self.file, 0..row.text.len(), message, help)
    }

    /// An error about the line of names.
    pub fn error_of_names(&self, message: String, help: Option<String>) -> Diagnostic {
        self.names.error(&self.file, 0..self.names.text.len(), message, help)
    }

    /// An error about the file as a whole.
    pub fn error_of_all(&self, message: String, help: Option<String>) -> Diagnostic {
        of_file(&self.file, message, help)
    }

    fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], Diagnostics> {
        let find = |name: &str| self.names.cells.iter().position(|cell| cell.text == name);
        let missing: Vec<_> = names.into_iter().filter(|name| find(name).is_none()).map(|name| format!("`{name}`")).collect();
        if missing.is_empty() {
            return Ok(names.map(|name| find(name).unwrap_or_default()));
        }
        let (word, there) = (if missing.len() == 1 { "column" } else { "columns" }, self.names.text.trim());
        let message = format!("{word} {} missing", missing.join(", "));
        let semicolons = self.names.cells.len() == 1 && there.contains(';');
        let help = if semicolons { "columns are parted by commas".into() } else { format!("wanted: {}", names.join(",")) };
        let all = 0..self.names.text.len();
        Err(Diagnostics(vec![self.names.error(&self.file, all, message, Some(help))]))
    }

    fn number(&self, row: &Line, cell: &Cell, column: usize) -> Result<f64, Box<Diagnostic>> {
        let name = &self.names.cells[column].text;
        let wrong = |what: String| {
            let help = Some(format!("`{name}` is a finite number, with a point before decimals"));
            Err(Box::new(row.error(&self.file, cell.bytes.clone(), what, help)))
        };
        match cell.text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(value) => wrong(format!("{} is not finite", shown(value))),
            Err(_) if cell.text.is_empty() => wrong(format!("`{name}` is empty")),
            Err(_) => wrong(format!("`{}` is not a number", cell.text)),
        }
    }
}

impl Line {
    fn error(&self, file: &str, mark: Range<usize>, message: String, help: Option<String>) -> Diagnostic {
        let column = self.text[..mark.start].chars().count() + 1;
        let place = Place { line: self.number, column, text: self.text.clone(), mark };
        Diagnostic::new(file, Some(place), message, help)
    }
}

fn of_file(file: &str, message: String, help: Option<String>) -> Diagnostic {
    Diagnostic::new(file, None, message, help)
}

/// The first errors, and how many there are.
fn told(mut wrong: Vec<Diagnostic>) -> Diagnostics {
    wrong.sort_by_key(|error| error.place.as_ref().map(|place| (place.line, place.column)));
    let count = wrong.len();
    if count > TOLD {
        wrong.truncate(TOLD);
        let file = wrong[0].file.clone();
        wrong.push(of_file(&file, format!("{} more errors", count - TOLD), None));
    }
    Diagnostics(wrong)
}

/// The cells of a line; where they go wrong, the byte from which on.
fn cells(line: &str) -> Result<Vec<Cell>, usize> {
    let mut cells = Vec::new();
    let mut start = 0;
    loop {
        let rest = &line[start..];
        let blank = rest.len() - rest.trim_start().len();
        let open = start + blank;
        let end = if line[open..].starts_with('"') {
            let (text, close) = quoted(line, open).ok_or(open)?;
            let after = &line[close..];
            let end = close + after.find(',').unwrap_or(after.len());
            if !line[close..end].trim().is_empty() {
                return Err(close);
            }
            cells.push(Cell { text, bytes: open..close });
            end
        } else {
            let end = start + rest.find(',').unwrap_or(rest.len());
            let text = line[start..end].trim();
            let from = if text.is_empty() { start } else { open };
            cells.push(Cell { text: text.to_owned(), bytes: from..from + text.len() });
            end
        };
        if end == line.len() {
            return Ok(cells);
        }
        start = end + 1;
    }
}

/// The text within quotation marks that open at `open`, and the byte after the closing one.
fn quoted(line: &str, open: usize) -> Option<(String, usize)> {
    let mut text = String::new();
    let mut at = open + 1;
    loop {
        let close = at + line[at..].find('"')?;
        text += &line[at..close];
        at = close + 1;
        if !line[at..].starts_with('"') {
            return Some((text, at));
        }
        text.push('"');
        at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Table {
        Table::parse("t.csv", text).unwrap_or_else(|errors| panic!("{errors}"))
    }

    /// Line, column and words of the first error.
    fn refused(text: &str) -> (usize, usize, String) {
        let read = Table::parse("t.csv", text).and_then(|table| table.numbers(["a", "b"]));
        let errors = read.expect_err("refused").0;
        let place = errors[0].place.as_ref();
        (place.map_or(0, |place| place.line), place.map_or(0, |place| place.column), errors[0].message.clone())
    }

    #[test]
    fn comments_blanks_quotes_and_other_columns_are_read_over() {
        let text = "\u{feff}# from a gauge\r\nname, a ,c,b\r\n\r\n\"x, \"\"y\"\"\", 1.5 ,zzz,-2e3\r\n  # more\nz,0,,1\n";
        let table = table(text);
        assert_eq!(table.numbers(["b", "a"]).expect("numbers"), [[-2e3, 1.5], [1.0, 0.0]]);
        assert_eq!(table.texts("name").expect("texts"), ["x, \"y\"", "z"]);
        assert_eq!((table.line(0), table.line(1), table.len()), (4, 6, 2));
    }

    #[test]
    fn what_is_wrong_has_its_place() {
        assert_eq!(refused("a,b\n1,2\n3,x\n"), (3, 3, "`x` is not a number".into()));
        assert_eq!(refused("a,b\n1,inf\n"), (2, 3, "inf is not finite".into()));
        assert_eq!(refused("a,b\n1,\n"), (2, 3, "`b` is empty".into()));
        assert_eq!(refused("a,b\n\u{fc},1\n"), (2, 1, "`\u{fc}` is not a number".into()));
        assert_eq!(refused("a,b\n1,2,3\n"), (2, 5, "3 cells instead of 2".into()));
        assert_eq!(refused("a,b\n1\n"), (2, 2, "1 cells instead of 2".into()));
        assert_eq!(refused("a,c\n"), (1, 1, "column `b` missing".into()));
        assert_eq!(refused("a,b,a\n"), (1, 5, "column `a` occurs twice".into()));
        assert_eq!(refused("a,b\n\"1,2\n").0, 2);
        assert_eq!(refused("# nothing\n\n"), (0, 0, "holds no line of names".into()));
        let german = Table::parse("t.csv", "a;b\n1;2\n").and_then(|table| table.numbers(["a", "b"])).expect_err("refused");
        assert_eq!(german.0[0].help.as_deref(), Some("columns are parted by commas"));
    }

    #[test]
    fn not_every_error_of_thousands_is_told() {
        let text = format!("a,b\n{}", "x,y\n".repeat(5000));
        let errors = table(&text).numbers(["a", "b"]).expect_err("refused").0;
        assert_eq!(errors.len(), TOLD + 1);
        assert_eq!(errors[TOLD].message, "9980 more errors");
    }
}
