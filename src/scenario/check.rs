//! Each value against its row of the table of fields.

use std::collections::BTreeSet;

use super::diagnostic::Finding;
use super::fields::{Default, Field, Kind, Shape, TableShape};
use super::source::Span;
use super::tree::{Entry, Node, Table, Value};
use super::unknown_key;

/// What a walk over a tree found, and the paths of what was wrong: whatever rests on those is not judged further.
#[derive(Debug, std::default::Default)]
pub(super) struct Checked {
    pub(super) findings: Vec<Finding>,
    pub(super) wrong: BTreeSet<String>,
}

impl Checked {
    /// Notes an error at a path.
    pub(super) fn wrong(&mut self, path: &str, finding: Finding) {
        self.wrong.insert(path.to_owned());
        self.findings.push(finding);
    }

    /// Whether nothing at, below or above any of these paths is wrong.
    pub(super) fn is_sound(&self, paths: &[&str]) -> bool {
        let within = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        !self.wrong.iter().any(|wrong| paths.iter().any(|path| within(wrong, path) || within(path, wrong)))
    }

    /// Checks keys, types and bounds of what was typed, and takes out what is wrong.
    pub(super) fn table(&mut self, shape: &TableShape, table: &mut Table, path: &str, span: Span) {
        self.rules(shape, table, path, span);
        table.entries.retain_mut(|entry| {
            let inner = join(path, &entry.key);
            match shape.child(&entry.key) {
                None => {
                    self.findings.push(unknown_key::finding(shape, path, entry));
                    false
                }
                Some(Shape::Leaf(field)) => self.leaf(field, entry, &inner),
                Some(Shape::Table(shape)) => self.inner_table(shape, &mut entry.node, &inner),
                Some(Shape::Named(shape)) => self.named(shape, &mut entry.node, &inner),
                Some(Shape::List(shape)) => self.list(shape, &mut entry.node, &inner),
            }
        });
    }

    fn leaf(&mut self, field: &Field, entry: &Entry, path: &str) -> bool {
        match value(field, path, &entry.node) {
            None => true,
            Some(finding) => {
                self.wrong(path, finding);
                false
            }
        }
    }

    fn inner_table(&mut self, shape: &TableShape, node: &mut Node, path: &str) -> bool {
        match &mut node.value {
            Value::Table(table) => {
                self.table(shape, table, path, node.span);
                true
            }
            other => {
                let finding = Finding::new(node.span, format!("`{path}` is a table, but {} stands here", other.kind()))
                    .help(format!("write `[{path}]` on a line of its own, and its keys below: {}", keys(shape)));
                self.wrong(path, finding);
                false
            }
        }
    }

    fn named(&mut self, shape: &TableShape, node: &mut Node, path: &str) -> bool {
        let Value::Table(table) = &mut node.value else {
            let help = format!("write `[{path}.NAME]` with a name of your own, and its keys below: {}", keys(shape));
            let message = format!("`{path}` holds tables, but {} stands here", node.value.kind());
            self.wrong(path, Finding::new(node.span, message).help(help));
            return false;
        };
        table.entries.retain_mut(|entry| {
            let inner = join(path, &entry.key);
            if !is_name(&entry.key) {
                let message = format!("`{}` is not a name", entry.key);
                self.wrong(path, Finding::new(entry.key_span, message).help(NAME_RULE));
                return false;
            }
            self.inner_table(shape, &mut entry.node, &inner)
        });
        true
    }

    fn list(&mut self, shape: &TableShape, node: &mut Node, path: &str) -> bool {
        let Value::List(list) = &mut node.value else {
            let help = format!("an array of tables, `{path} = [ {{ … }}, … ]` or `[[{path}]]`, with the keys {}", keys(shape));
            let message = format!("`{path}` is an array of tables, but {} stands here", node.value.kind());
            self.wrong(path, Finding::new(node.span, message).help(help));
            return false;
        };
        if list.len() < shape.row.min_len {
            let finding = Finding::new(node.span, format!("`{path}` is empty: it needs at least {}", shape.row.min_len))
                .help(format!("an element has one of {}", quoted(shape.row.exactly_one)));
            self.wrong(path, finding);
        }
        // Not removed where wrong: the others' indices would shift.
        for (i, element) in list.iter_mut().enumerate() {
            if !self.inner_table(shape, element, &format!("{path}[{i}]")) {
                element.value = Value::Table(Table::default());
            }
        }
        true
    }

    /// The rules between the keys of one table.
    fn rules(&mut self, shape: &TableShape, table: &Table, path: &str, span: Span) {
        let given = |keys: &[&str]| -> Vec<&Entry> {
            table.entries.iter().filter(|e| keys.contains(&e.key.as_str())).collect()
        };
        let row = shape.row;
        if let [first, second, ..] = given(row.exactly_one)[..] {
            let finding = Finding::new(second.key_span, format!("`{}` beside `{}` in `{path}`", second.key, first.key))
                .help(format!("exactly one of {}", quoted(row.exactly_one)));
            self.wrong(path, finding);
        }
        if !row.exactly_one.is_empty() && given(row.exactly_one).is_empty() {
            let finding = Finding::new(span, format!("`{path}` says nothing of its kind"))
                .help(format!("exactly one of {}", quoted(row.exactly_one)));
            self.wrong(path, finding);
        }
        if let [first, second, ..] = given(row.at_most_one)[..] {
            let finding = Finding::new(second.key_span, format!("`{}` beside `{}` in `{path}`", second.key, first.key))
                .help("both say the same thing in different frames: keep one of them");
            self.wrong(path, finding);
        }
    }

    /// What must be there and is not, after presets were laid beneath. `span` is where the table was typed.
    pub(super) fn missing(&mut self, shape: &TableShape, table: Option<&Table>, path: &str, span: &dyn Fn(&str) -> Span) {
        let absent = |field: &&Field| {
            let path = join(path, field.key());
            table.and_then(|t| t.get(field.key())).is_none() && !self.wrong.contains(&path)
        };
        let required: Vec<_> = shape.leaves().filter(absent).filter(|f| matches!(f.default, Default::Required(_))).collect();
        let from_preset: Vec<_> = shape.leaves().filter(absent).filter(|f| f.default == Default::Preset).collect();
        for field in required {
            let Default::Required(example) = field.default else { continue };
            let place = if path.is_empty() { "at the top of the file".to_owned() } else { format!("in [{path}]") };
            let finding = Finding::new(span(path), format!("missing `{}` {place}", field.key()))
                .help(format!("for example `{} = {example}`: {}", field.key(), field.sentence()));
            self.wrong(&join(path, field.key()), finding);
        }
        if !from_preset.is_empty() {
            let names: Vec<_> = from_preset.iter().map(|f| f.key()).collect();
            let top = path.split('.').next().unwrap_or_default();
            let message = format!("without a preset [{path}] must give {}", quoted(&names));
            let help = format!("or name a preset, as in `preset = \"incra1\"` in [{top}]");
            self.wrong(path, Finding::new(span(path), message).help(help));
        }
        for (key, shape) in &shape.children {
            let inner = join(path, key);
            let node = table.and_then(|t| t.get(key));
            match shape {
                Shape::Leaf(_) => {}
                Shape::Table(shape) => self.missing(shape, node.and_then(Node::as_table), &inner, span),
                Shape::Named(shape) => {
                    for entry in node.and_then(Node::as_table).into_iter().flat_map(|t| &t.entries) {
                        self.missing(shape, entry.node.as_table(), &join(&inner, &entry.key), span);
                    }
                }
                Shape::List(shape) => {
                    let list = node.and_then(Node::as_list);
                    if list.is_none() && shape.row.min_len > 0 && self.is_sound(&[&inner]) {
                        let finding = Finding::new(span(path), format!("missing `{key}` in [{path}]"))
                            .help(format!("for example `{key} = [ {{ straight_m = 6.0 }} ]`: {}", shape.row.about));
                        self.wrong(&inner, finding);
                    }
                    for (i, element) in list.into_iter().flatten().enumerate() {
                        let element_path = format!("{inner}[{i}]");
                        if !self.wrong.contains(&element_path) {
                            self.missing(shape, element.as_table(), &element_path, span);
                        }
                    }
                }
            }
        }
    }
}

/// What is wrong with a value, if anything is.
fn value(field: &Field, path: &str, node: &Node) -> Option<Finding> {
    let finding = |message: String| Some(Finding::new(node.span, message).help(field.sentence()));
    if let Some((word, why)) = node.as_text().and_then(|text| field.refused.iter().find(|(word, _)| *word == text)) {
        return Some(Finding::new(node.span, format!("`{path}` is \"{word}\": {why}")).help(accepted(field)));
    }
    match (field.kind, &node.value) {
        (Kind::Number { min, max }, Value::Number(_) | Value::Integer(_)) => {
            number(field, path, node, min, max).and_then(finding)
        }
        (Kind::Integer { min, max }, Value::Integer(x)) => integer(field, path, *x, min, max).and_then(finding),
        (Kind::Numbers { min, max, single: true, .. }, Value::Number(_) | Value::Integer(_)) => {
            number(field, path, node, min, max).and_then(finding)
        }
        (Kind::Numbers { len, .. } | Kind::Integers { len, .. }, Value::List(list)) if list.len() != len => {
            finding(format!("`{path}` has {} elements: it takes {len}", list.len()))
        }
        (Kind::Numbers { .. } | Kind::Integers { .. } | Kind::List { .. }, Value::List(list)) => {
            list.iter().enumerate().find_map(|(i, item)| {
                let message = item_of(field, &format!("{path}[{i}]"), item)?;
                Some(Finding::new(item.span, message).help(field.sentence()))
            })
        }
        (Kind::Flag, Value::Flag(_)) | (Kind::Text, Value::Text(_)) => None,
        (Kind::Word(words), Value::Text(text)) if words.contains(&text.as_str()) => None,
        (Kind::Word(words), Value::Text(text)) => {
            let guess = unknown_key::nearest(text, words.iter().copied()).map(|w| format!("did you mean \"{w}\"? "));
            Some(
                Finding::new(node.span, format!("`{path}` does not know \"{text}\""))
                    .help(format!("{}{}", guess.unwrap_or_default(), accepted(field))),
            )
        }
        (Kind::Name, Value::Text(text)) if is_name(text) => None,
        (Kind::Name, Value::Text(text)) => {
            Some(Finding::new(node.span, format!("`{path}` is \"{text}\", which is not a name")).help(NAME_RULE))
        }
        (_, other) => {
            let message = format!("`{path}` must be {}, not {}", wanted(field), other.kind());
            Some(Finding::new(node.span, message).help(type_help(field, other)))
        }
    }
}

/// What is wrong with an element of an array, if anything is.
fn item_of(field: &Field, path: &str, item: &Node) -> Option<String> {
    match (field.kind, &item.value) {
        (Kind::Numbers { min, max, .. } | Kind::List { min, max }, Value::Number(_) | Value::Integer(_)) => {
            number(field, path, item, min, max)
        }
        (Kind::Integers { min, max, .. }, Value::Integer(x)) => integer(field, path, *x, min, max),
        (Kind::Integers { .. }, other) => Some(format!("`{path}` must be a whole number, not {}", other.kind())),
        (_, other) => Some(format!("`{path}` must be a number, not {}", other.kind())),
    }
}

/// What is wrong with a whole number, if anything is.
fn integer(field: &Field, path: &str, x: i64, min: i64, max: i64) -> Option<String> {
    if (min..=max).contains(&x) {
        return None;
    }
    let unit = spaced(field.unit);
    Some(match (min, max) {
        _ if min == max => format!("`{path}` is {x}: it must be {min}"),
        (_, i64::MAX) => format!("`{path}` is {x}: it must be {min} or more"),
        _ => format!("`{path}` is {x}{unit}: it must be between {min} and {max}{unit}"),
    })
}

/// What is wrong with a number, if anything is.
fn number(field: &Field, path: &str, node: &Node, min: f64, max: f64) -> Option<String> {
    let x = node.as_number()?;
    if !x.is_finite() {
        return Some(format!("`{path}` is {x}: it must be a finite number"));
    }
    let unit = spaced(field.unit);
    (!(min..=max).contains(&x)).then(|| format!("`{path}` is {x}{unit}: it must be between {min} and {max}{unit}"))
}

/// What a field takes, as an article and a noun.
fn wanted(field: &Field) -> String {
    match field.kind {
        Kind::Number { .. } => "a number".to_owned(),
        Kind::Integer { .. } => "a whole number".to_owned(),
        Kind::Numbers { len, single, .. } => {
            format!("{}an array of {len} numbers", if single { "a number or " } else { "" })
        }
        Kind::Integers { len, .. } => format!("an array of {len} whole numbers"),
        Kind::List { .. } => "an array of numbers".to_owned(),
        Kind::Flag => "true or false".to_owned(),
        Kind::Word(_) => "one of its words".to_owned(),
        Kind::Name => "a name".to_owned(),
        Kind::Text => "a string".to_owned(),
    }
}

/// What would be right where a value has the wrong type.
fn type_help(field: &Field, given: &Value) -> String {
    let is_number = matches!(field.kind, Kind::Number { .. } | Kind::Integer { .. });
    let leading = |text: &str| {
        let end = text.find(|c: char| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+')).unwrap_or(text.len());
        text[..end].parse::<f64>().ok()
    };
    match given {
        Value::Text(text) if is_number && leading(text.trim()).is_some() => {
            let unit = if field.unit.is_empty() { String::new() } else { format!(", in {}", field.unit) };
            let number = leading(text.trim()).unwrap_or_default();
            format!("write the number without quotes{unit}, as in `{} = {number}`: {}", field.key(), field.sentence())
        }
        Value::Number(x) if matches!(field.kind, Kind::Integer { .. }) && x.is_finite() => {
            format!("write it without a decimal point, as in `{} = {}`: {}", field.key(), x.round(), field.sentence())
        }
        Value::Text(text) if field.kind == Kind::Flag && (text == "true" || text == "false") => {
            format!("write `{text}` without quotes: {}", field.sentence())
        }
        _ if matches!(field.kind, Kind::Word(_)) => accepted(field),
        _ => field.sentence(),
    }
}

/// The words that a field takes, and what it is.
fn accepted(field: &Field) -> String {
    match field.kind {
        Kind::Word(words) => {
            let words: Vec<_> = words.iter().map(|w| format!("\"{w}\"")).collect();
            format!("allowed: {}. {}", words.join(", "), field.about)
        }
        _ => match field.default {
            Default::Value(toml) => format!("give it as in `{} = {toml}`: {}", field.key(), field.sentence()),
            _ => field.sentence(),
        },
    }
}

pub(super) const NAME_RULE: &str = "a name has 1 to 64 letters (a to z, A to Z), digits, `-` and `_`";

/// Whether a text can name something.
pub(super) fn is_name(text: &str) -> bool {
    (1..=64).contains(&text.len()) && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'))
}

/// A key within a table.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Keys as a sentence lists them.
pub(super) fn quoted(keys: &[&str]) -> String {
    keys.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ")
}

fn keys(shape: &TableShape) -> String {
    quoted(&shape.keys().collect::<Vec<_>>())
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}
