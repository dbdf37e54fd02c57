//! Text to [`Table`]: the TOML parser's spanned tables, every syntax error kept.

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

use super::diagnostic::Finding;
use super::source::{Sources, Span};
use super::tree::{Entry, Node, Table, Value};

/// Reads a whole TOML document. What could be read comes back even where there are errors.
pub(super) fn document(sources: &Sources, source: usize) -> (Table, Vec<Finding>) {
    let (table, errors) = DeTable::parse_recoverable(sources.text(source));
    let findings = errors.iter().map(|error| syntax(error, source)).collect();
    (self::table(table.into_inner(), source, 0), findings)
}

/// Reads one TOML value that starts at byte `offset` of its source.
///
/// # Errors
/// What keeps it from being TOML.
pub(super) fn value(text: &str, source: usize, offset: usize) -> Result<Node, Finding> {
    match DeValue::parse(text) {
        Ok(value) => Ok(node(value, source, offset)),
        Err(error) => Err(not_toml(&error, source, offset).0),
    }
}

/// The error at its place, and what the parser said.
fn not_toml(error: &Error, source: usize, offset: usize) -> (Finding, &str) {
    let message = match error.message() {
        // That is what the parser says of nothing, too.
        quoted if quoted.starts_with("string values must be quoted") && error.span().is_some_and(|s| s.is_empty()) => {
            "missing value"
        }
        message => message,
    };
    let range = error.span().unwrap_or(0..0);
    let span = Span::new(source, range.start + offset..range.end + offset);
    (Finding::new(span, format!("not TOML: {message}")), message)
}

fn syntax(error: &Error, source: usize) -> Finding {
    let (finding, message) = not_toml(error, source, 0);
    if message.starts_with("duplicate key") {
        finding.help("a key or table stands once in a file: keep one of the two")
    } else if message.starts_with("string values must be quoted") {
        finding.help("strings stand in double quotes, as in `name = \"straight\"`")
    } else if message.starts_with("missing") || message.starts_with("key with no value") {
        finding.help("a line is `key = value`, a table's header `[table]`, a comment starts with `#`")
    } else {
        finding
    }
}

fn table(table: DeTable<'_>, source: usize, offset: usize) -> Table {
    let mut entries: Vec<Entry> = table
        .into_iter()
        .map(|(key, value)| {
            let key_span = shifted(&key, source, offset);
            Entry { key: key.into_inner().into_owned(), key_span, node: node(value, source, offset) }
        })
        .collect();
    // The parser sorts by name; the text's order is what numbers the lasers.
    entries.sort_by_key(|e| e.key_span);
    Table { entries }
}

fn node(value: Spanned<DeValue<'_>>, source: usize, offset: usize) -> Node {
    let span = shifted(&value, source, offset);
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => Value::Other("a number beyond 64 bits"),
        },
        DeValue::Float(number) => number.as_str().parse().map_or(Value::Other("an unreadable number"), Value::Number),
        DeValue::Boolean(flag) => Value::Flag(flag),
        DeValue::Datetime(_) => Value::Other("a date or time"),
        DeValue::Array(list) => Value::List(list.into_iter().map(|item| node(item, source, offset)).collect()),
        DeValue::Table(inner) => Value::Table(table(inner, source, offset)),
    };
    Node { value, span }
}

fn shifted<T>(spanned: &Spanned<T>, source: usize, offset: usize) -> Span {
    let range = spanned.span();
    Span::new(source, range.start + offset..range.end + offset)
}
