//! A partial scenario as settings `path=value`, so that a case can be repeated by `--set` alone.

use crate::scenario::tree::{Node, Table, Value};

/// The settings of a table's leaves, in its order; arrays as a whole.
pub(super) fn of(table: &Table) -> Vec<String> {
    let mut settings = Vec::new();
    walk("", table, &mut settings);
    settings
}

fn walk(path: &str, table: &Table, settings: &mut Vec<String>) {
    for entry in &table.entries {
        let path = if path.is_empty() { entry.key.clone() } else { format!("{path}.{}", entry.key) };
        match &entry.node.value {
            Value::Table(inner) => walk(&path, inner, settings),
            _ => settings.push(format!("{path}={}", toml(&entry.node))),
        }
    }
}

/// A value as TOML on one line.
pub(super) fn toml(node: &Node) -> String {
    match &node.value {
        Value::Text(text) => toml::Value::from(text.as_str()).to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Number(value) => format!("{value:?}"),
        Value::Flag(flag) => flag.to_string(),
        Value::List(list) => format!("[{}]", list.iter().map(toml).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let entries = table.entries.iter().map(|entry| format!("{} = {}", entry.key, toml(&entry.node)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
        Value::Other(what) => (*what).to_owned(),
    }
}
