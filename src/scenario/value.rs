//! A value against its row: type, bounds, words; and what would be right.

use super::check::{NAME_RULE, is_name};
use super::diagnostic::Finding;
use super::fields::{Default, Field, Kind};
use super::tree::{Node, Value};
use super::unknown_key::nearest;

/// What is wrong with a value, if anything is.
pub(super) fn wrong(field: &Field, path: &str, node: &Node) -> Option<Finding> {
    let finding = |message: String| Some(Finding::new(node.span, message).help(field.sentence()));
    if let Some((word, why)) = node.as_text().and_then(|text| field.refused.iter().find(|(word, _)| *word == text)) {
        return Some(Finding::new(node.span, format!("`{path}` is \"{word}\": {why}")).help(accepted(field)));
    }
    match (field.kind, &node.value) {
        (Kind::Number { min, max }, Value::Number(_) | Value::Integer(_)) => {
            number(field, path, node, min, max).and_then(finding)
        }
        (Kind::NumberOr { min, max, .. }, Value::Number(_) | Value::Integer(_)) => {
            number(field, path, node, min, max).and_then(finding)
        }
        (Kind::NumberOr { word, .. }, Value::Text(text)) if text == word => None,
        (Kind::Choice(numbers), Value::Integer(x)) if numbers.contains(x) => None,
        (Kind::Choice(numbers), Value::Integer(x)) => finding(format!("`{path}` is {x}: it must be {}", one_of(numbers))),
        (Kind::Integer { min, max }, Value::Integer(x)) => integer(field, path, *x, min, max).and_then(finding),
        (Kind::Numbers { min, max, single: true, .. }, Value::Number(_) | Value::Integer(_)) => {
            number(field, path, node, min, max).and_then(finding)
        }
        (Kind::Numbers { len, .. } | Kind::Integers { len, .. }, Value::List(list)) if list.len() != len => {
            finding(format!("`{path}` takes {len} elements, not {}", list.len()))
        }
        (Kind::Numbers { .. } | Kind::Integers { .. } | Kind::List { .. } | Kind::Words(_), Value::List(list)) => {
            list.iter().enumerate().find_map(|(i, item)| {
                let message = item_of(field, &format!("{path}[{i}]"), item)?;
                let help = if matches!(field.kind, Kind::Words(_)) { accepted(field) } else { field.sentence() };
                Some(Finding::new(item.span, message).help(help))
            })
        }
        (Kind::Flag, Value::Flag(_)) | (Kind::Text, Value::Text(_)) => None,
        (Kind::Word(words), Value::Text(text)) if words.contains(&text.as_str()) => None,
        (Kind::Word(words), Value::Text(text)) => {
            let guess = nearest(text, words.iter().copied()).map(|w| format!("did you mean \"{w}\"? "));
            Some(Finding::new(node.span, format!("`{path}` does not know \"{text}\"")).help(format!(
                "{}{}",
                guess.unwrap_or_default(),
                accepted(field)
            )))
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
        (Kind::Words(words), Value::Text(text)) if words.contains(&text.as_str()) => None,
        (Kind::Words(_), Value::Text(text)) => Some(format!("`{path}` does not know \"{text}\"")),
        (Kind::Words(_), other) => Some(format!("`{path}` must be one of its words, not {}", other.kind())),
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
    let [low, high] = [min, max].map(shown);
    (!(min..=max).contains(&x)).then(|| format!("`{path}` is {}{unit}: it must be between {low} and {high}{unit}", shown(x)))
}

/// A number as people read it and TOML takes it: one with many zeros by its exponent.
pub fn shown(x: f64) -> String {
    if x == 0.0 || (1e-5..=1e15).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// What a field takes, as an article and a noun.
fn wanted(field: &Field) -> String {
    match field.kind {
        Kind::Number { .. } => "a number".to_owned(),
        Kind::NumberOr { word, .. } => format!("a number or \"{word}\""),
        Kind::Choice(numbers) => one_of(numbers),
        Kind::Integer { .. } => "a whole number".to_owned(),
        Kind::Numbers { len, single, .. } => {
            format!("{}an array of {len} numbers", if single { "a number or " } else { "" })
        }
        Kind::Integers { len, .. } => format!("an array of {len} whole numbers"),
        Kind::List { .. } => "an array of numbers".to_owned(),
        Kind::Flag => "true or false".to_owned(),
        Kind::Word(_) => "one of its words".to_owned(),
        Kind::Words(_) => "an array of words".to_owned(),
        Kind::Name => "a name".to_owned(),
        Kind::Text => "a string".to_owned(),
    }
}

/// Numbers as a sentence lists what may be chosen: `8, 10 or 12`.
fn one_of(numbers: &[i64]) -> String {
    let words: Vec<_> = numbers.iter().map(i64::to_string).collect();
    match words.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => words.concat(),
    }
}

/// What would be right where a value has the wrong type.
fn type_help(field: &Field, given: &Value) -> String {
    let is_number = matches!(field.kind, Kind::Number { .. } | Kind::NumberOr { .. } | Kind::Choice(_) | Kind::Integer { .. });
    let leading = |text: &str| {
        let end = text.find(|c: char| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+')).unwrap_or(text.len());
        text[..end].parse::<f64>().ok()
    };
    match given {
        Value::Text(text) if is_number && leading(text.trim()).is_some() => {
            let unit = if field.unit.is_empty() { String::new() } else { format!(", in {}", field.unit) };
            let number = leading(text.trim()).unwrap_or_default();
            format!("write the number without quotes{unit}, as in `{} = {}`: {}", field.key(), shown(number), field.sentence())
        }
        // Below 2^53 every whole number is one, and it reads as it was meant.
        Value::Number(x) if matches!(field.kind, Kind::Integer { .. } | Kind::Choice(_)) && x.abs() <= 1e15 => {
            format!("write it without a decimal point, as in `{} = {}`: {}", field.key(), x.round(), field.sentence())
        }
        Value::Text(text) if field.kind == Kind::Flag && (text == "true" || text == "false") => {
            format!("write `{text}` without quotes: {}", field.sentence())
        }
        _ if matches!(field.kind, Kind::Word(_) | Kind::Words(_)) => accepted(field),
        Value::Other(_) if let Kind::Integer { min, max } = field.kind => format!("from {min} to {max}: {}", field.sentence()),
        _ => field.sentence(),
    }
}

/// The words that a field takes, and what it is.
fn accepted(field: &Field) -> String {
    match field.kind {
        Kind::Word(words) | Kind::Words(words) => {
            let words: Vec<_> = words.iter().map(|w| format!("\"{w}\"")).collect();
            format!("allowed: {}. {}", words.join(", "), field.about)
        }
        _ => match field.default {
            Default::Value(toml) => format!("give it as in `{} = {toml}`: {}", field.key(), field.sentence()),
            _ => field.sentence(),
        },
    }
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}
