//! A scenario as it was typed: TOML values with their places, in the order of the text.

use super::source::Span;

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) span: Span,
}

/// A TOML value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Integer(i64),
    Number(f64),
    Flag(bool),
    List(Vec<Node>),
    Table(Table),
    /// What no field takes (a date, an integer beyond 64 bits), with the name of what it is.
    Other(&'static str),
}

/// Entries in the order of the text; keys are unique.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    pub(super) entries: Vec<Entry>,
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) key_span: Span,
    pub(super) node: Node,
}

/// Keys that say the same thing in different ways: one laid over a table takes the place of the other.
const ALTERNATIVES: [&str; 2] = ["source_in_base_m", "source_in_camera_m"];

impl Value {
    /// What it is, in an error message.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Integer(_) => "a whole number",
            Self::Number(_) => "a number with a fraction",
            Self::Flag(_) => "true or false",
            Self::List(_) => "an array",
            Self::Table(_) => "a table",
            Self::Other(what) => what,
        }
    }
}

impl Node {
    pub(super) fn as_table(&self) -> Option<&Table> {
        if let Value::Table(table) = &self.value { Some(table) } else { None }
    }

    pub(super) fn as_list(&self) -> Option<&[Node]> {
        if let Value::List(list) = &self.value { Some(list) } else { None }
    }

    /// A number, whole or not.
    pub(super) fn as_number(&self) -> Option<f64> {
        match self.value {
            Value::Number(x) => Some(x),
            Value::Integer(x) => Some(x as f64),
            _ => None,
        }
    }

    pub(super) fn as_integer(&self) -> Option<i64> {
        if let Value::Integer(x) = self.value { Some(x) } else { None }
    }

    pub(super) fn as_text(&self) -> Option<&str> {
        if let Value::Text(text) = &self.value { Some(text) } else { None }
    }
}

impl Table {
    /// The entry with this key.
    pub(super) fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.key == key)
    }

    pub(super) fn entry_mut(&mut self, key: &str) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|e| e.key == key)
    }

    /// The value of this key.
    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|e| &e.node)
    }

    /// The value at a path of keys, `robot.drive.supply_v`.
    pub(super) fn at(&self, path: &str) -> Option<&Node> {
        match path.split_once('.') {
            None => self.get(path),
            Some((key, rest)) => self.get(key)?.as_table()?.at(rest),
        }
    }

    /// Puts a value at a path of keys, making the tables on the way.
    ///
    /// # Panics
    /// If something else than a table is in the way.
    pub(super) fn put(&mut self, path: &str, value: Value) {
        let (key, rest) = path.split_once('.').map_or((path, None), |(key, rest)| (key, Some(rest)));
        let node = match self.entries.iter().position(|e| e.key == key) {
            Some(i) => &mut self.entries[i].node,
            None => {
                let node = Node { value: Value::Table(Self::default()), span: Span::default() };
                self.entries.push(Entry { key: key.to_owned(), key_span: Span::default(), node });
                let last = self.entries.len() - 1;
                &mut self.entries[last].node
            }
        };
        match (rest, &mut node.value) {
            (None, slot) => *slot = value,
            (Some(rest), Value::Table(table)) => table.put(rest, value),
            (Some(_), other) => panic!("`{key}` is {}", other.kind()),
        }
    }

    /// Lays `over` on top: tables merge, everything else is replaced.
    pub(super) fn merge(&mut self, over: Self) {
        if let Some(given) = over.entries.iter().find(|e| ALTERNATIVES.contains(&e.key.as_str())) {
            self.entries.retain(|e| e.key == given.key || !ALTERNATIVES.contains(&e.key.as_str()));
        }
        for entry in over.entries {
            match self.entry_mut(&entry.key) {
                None => self.entries.push(entry),
                Some(old) => match (&mut old.node.value, entry.node.value) {
                    (Value::Table(base), Value::Table(over)) => base.merge(over),
                    (slot, value) => {
                        *slot = value;
                        old.node.span = entry.node.span;
                        old.key_span = entry.key_span;
                    }
                },
            }
        }
    }
}
