//! Each value against its row of the table of fields.

use std::collections::BTreeSet;

use super::diagnostic::Finding;
use super::fields::{Default, Field, Shape, TableShape};
use super::source::Span;
use super::tree::{Entry, Node, Table, Value};
use super::{unknown_key, value};

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
                    if let Some(meant) = unknown_key::meant(shape, entry) {
                        // It is there, under another name: not missing as well.
                        self.wrong.insert(join(path, meant));
                    }
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
        match value::wrong(field, path, &entry.node) {
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
            let path = format!("{path}[{i}]");
            if let Value::Table(table) = &mut element.value {
                self.table(shape, table, &path, element.span);
            } else {
                let finding =
                    Finding::new(element.span, format!("`{path}` is a table, but {} stands here", element.value.kind()))
                        .help(format!("a table in braces, with keys of {}", keys(shape)));
                self.wrong(&path, finding);
                element.value = Value::Table(Table::default());
            }
        }
        true
    }

    /// The rules between the keys of one table.
    fn rules(&mut self, shape: &TableShape, table: &Table, path: &str, span: Span) {
        let given = |keys: &[&str]| -> Vec<&Entry> { table.entries.iter().filter(|e| keys.contains(&e.key.as_str())).collect() };
        let row = shape.row;
        if let [first, second, ..] = given(row.exactly_one)[..] {
            let finding = Finding::new(second.key_span, format!("`{}` beside `{}` in `{path}`", second.key, first.key))
                .help(format!("exactly one of {}", quoted(row.exactly_one)));
            self.wrong(path, finding);
        }
        let is_meant =
            table.entries.iter().filter_map(|e| unknown_key::meant(shape, e)).any(|key| row.exactly_one.contains(&key));
        if !row.exactly_one.is_empty() && given(row.exactly_one).is_empty() && !is_meant {
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
            let finding = Finding::new(span(path), format!("missing `{}` {}", field.key(), inside(path))).help(format!(
                "for example `{} = {example}`: {}",
                field.key(),
                field.sentence()
            ));
            self.wrong(&join(path, field.key()), finding);
        }
        if !from_preset.is_empty() {
            let names: Vec<_> = from_preset.iter().map(|f| f.key()).collect();
            let top = path.split('.').next().unwrap_or_default();
            let message = format!("missing {} {}: no preset gives them", quoted(&names), inside(path));
            let help = format!("give them, or name a preset, as in `preset = \"incra1\"` in [{top}]");
            self.wrong(path, Finding::new(span(path), message).help(help));
        }
        for (key, shape) in &shape.children {
            let inner = join(path, key);
            let node = table.and_then(|t| t.get(key));
            match shape {
                Shape::Leaf(_) => {}
                Shape::Table(_) if self.wrong.contains(&inner) => {}
                Shape::Table(shape) if node.is_none() && shape.is_required() => {
                    let message = format!("missing table [{inner}]");
                    let help = format!("for example\n{}\n{}", example(shape, &inner), shape.row.about);
                    self.wrong(&inner, Finding::new(span(path), message).help(help));
                }
                Shape::Table(shape) => self.missing(shape, node.and_then(Node::as_table), &inner, span),
                Shape::Named(shape) => {
                    for entry in node.and_then(Node::as_table).into_iter().flat_map(|t| &t.entries) {
                        self.missing(shape, entry.node.as_table(), &join(&inner, &entry.key), span);
                    }
                }
                Shape::List(shape) => {
                    let list = node.and_then(Node::as_list);
                    if list.is_none() && shape.row.min_len > 0 && self.is_sound(&[&inner]) {
                        let finding = Finding::new(span(path), format!("missing `{key}` {}", inside(path)))
                            .help(format!("for example `{key} = {}`: {}", shape.row.example, shape.row.about));
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

pub(super) const NAME_RULE: &str = "a name has 1 to 64 letters (a to z, A to Z), digits, `-` and `_`";

/// Whether a text can name something.
pub(super) fn is_name(text: &str) -> bool {
    (1..=64).contains(&text.len()) && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'))
}

/// A key within a table.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Where a key stands, or should.
pub(super) fn inside(path: &str) -> String {
    match path {
        "" => "at the top of the file".to_owned(),
        path if path.ends_with(']') => format!("in `{path}`"),
        path => format!("in [{path}]"),
    }
}

/// The least that a table must hold, as it may be typed.
fn example(shape: &TableShape, path: &str) -> String {
    let mut lines = vec![format!("[{path}]")];
    for (key, child) in &shape.children {
        match child {
            Shape::Leaf(Field { default: Default::Required(toml), .. }) => lines.push(format!("{key} = {toml}")),
            Shape::List(inner) if inner.row.min_len > 0 => lines.push(format!("{key} = {}", inner.row.example)),
            _ => {}
        }
    }
    lines.join("\n")
}

/// Keys as a sentence lists them.
pub(super) fn quoted(keys: &[&str]) -> String {
    keys.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ")
}

fn keys(shape: &TableShape) -> String {
    quoted(&shape.keys().collect::<Vec<_>>())
}
