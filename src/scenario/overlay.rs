//! What is laid over a scenario file: partial files, and single fields by their paths.

use std::ops::Range;
use std::path::PathBuf;

use super::diagnostic::Finding;
use super::parse;
use super::source::{Sources, Span};
use super::tree::{Entry, Node, Table, Value};

/// What is laid over a scenario file, in the order of application: every `with`, then every `set`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overlays {
    /// Partial scenario files (`--with FILE`). Tables merge, everything else is replaced.
    pub with: Vec<PathBuf>,
    /// Single fields (`--set path=value`): the path as in `fault[0].at_s`, the value TOML, else a string, unless it begins
    /// like an array, a table or a string in quotes.
    pub set: Vec<String>,
}

/// How values are typed. Shells take away quotes that are not within quotes.
const VALUES: &str = "values look like `[0.1, 0.2]`, `{ straight_m = 2.0 }`, `\"brick\"` or `brick`; in a shell, put the whole \
                      argument between single quotes";

/// A step of a path, with its place in the argument.
enum Step<'a> {
    Key(&'a str, Range<usize>),
    Index(usize, Range<usize>),
}

/// Lays one `path=value` over `root`. `source` holds the argument's text.
pub(super) fn set(root: &mut Table, sources: &Sources, source: usize) -> Result<(), Finding> {
    let text = sources.text(source);
    let whole = Span::new(source, 0..text.len());
    let Some(equals) = text.find('=') else {
        return Err(Finding::new(whole, "no `=` between path and value").help("as in `robot.speed_m_s=0.2`"));
    };
    let typed = &text[equals + 1..];
    let lead = typed.len() - typed.trim_start().len();
    let value = typed.trim();
    let start = equals + 1 + lead;
    let node = match parse::value(value, source, start) {
        Ok(node) => node,
        // It was meant as TOML: an array, a table, a string in quotes.
        Err(finding) if value.starts_with(['[', '{', '"', '\'']) => return Err(finding.help(VALUES)),
        Err(_) => Node { value: Value::Text(value.to_owned()), span: Span::new(source, start..start + value.len()) },
    };
    let steps = path(&text[..equals], source)?;
    put(root, &steps, node, source)
}

/// Lays a value that stands elsewhere over `root`, at a path that stands at `span`: a level of a grid, say.
pub(super) fn lay(root: &mut Table, path_text: &str, span: Span, node: Node) -> Result<(), Finding> {
    let here = |finding: Finding| Finding { span, ..finding };
    let steps = path(path_text, span.source).map_err(here)?;
    put(root, &steps, node, span.source).map_err(here)
}

/// Splits `duct.run[1].elbow_deg` into its steps.
fn path(text: &str, source: usize) -> Result<Vec<Step<'_>>, Finding> {
    let mut steps = Vec::new();
    let mut at = 0;
    for part in text.split('.') {
        let wrong = |message: &str| {
            Finding::new(Span::new(source, at..at + part.len()), message).help("a path looks like `duct.run[1].elbow_deg`")
        };
        let key = part.split('[').next().unwrap_or_default();
        let lead = key.len() - key.trim_start().len();
        if key.trim().is_empty() {
            return Err(wrong("a step of the path has no name"));
        }
        steps.push(Step::Key(key.trim(), at + lead..at + lead + key.trim().len()));
        let mut rest = part[key.len()..].trim_end();
        while let Some(inner) = rest.strip_prefix('[') {
            let (digits, after) = inner.split_once(']').ok_or_else(|| wrong("`[` without `]`"))?;
            let index = digits.trim().parse().map_err(|_| wrong("an index is a whole number from 0"))?;
            let from = at + part.len() - rest.len();
            steps.push(Step::Index(index, from..from + digits.len() + 2));
            rest = after;
        }
        if !rest.is_empty() {
            return Err(wrong("after an index comes `.`, `[` or `=`"));
        }
        at += part.len() + 1;
    }
    Ok(steps)
}

fn put(root: &mut Table, steps: &[Step<'_>], node: Node, source: usize) -> Result<(), Finding> {
    let Some((Step::Key(key, range), rest)) = steps.split_first() else {
        unreachable!("a path starts with a key, and after each index `put_into` asks for a key or the end");
    };
    let key_span = Span::new(source, range.clone());
    let is_indexed = matches!(rest.first(), Some(Step::Index(..)));
    if root.entry(key).is_none() && !rest.is_empty() && !is_indexed {
        let table = Node { value: Value::Table(Table::default()), span: key_span };
        root.entries.push(Entry { key: (*key).to_owned(), key_span, node: table });
    }
    match root.entry_mut(key) {
        Some(entry) if !rest.is_empty() => put_into(&mut entry.node, rest, node, source, key),
        None if is_indexed => Err(no_element(Span::new(source, range.clone()), key, 0)),
        _ => {
            let entry = Entry { key: (*key).to_owned(), key_span, node };
            root.merge(Table { entries: vec![entry] });
            Ok(())
        }
    }
}

fn put_into(at: &mut Node, steps: &[Step<'_>], node: Node, source: usize, name: &str) -> Result<(), Finding> {
    match (steps.split_first(), &mut at.value) {
        (None, _) => {
            *at = node;
            Ok(())
        }
        (Some((Step::Key(..), _)), Value::Table(table)) => put(table, steps, node, source),
        (Some((Step::Index(index, range), rest)), Value::List(list)) => {
            let len = list.len();
            match list.get_mut(*index) {
                Some(element) => put_into(element, rest, node, source, name),
                None => Err(no_element(Span::new(source, range.clone()), name, len)),
            }
        }
        (Some((Step::Key(_, range) | Step::Index(_, range), _)), other) => {
            let (kind, span) = (other.kind(), Span::new(source, range.clone()));
            let help = match other {
                Value::List(_) => format!("say which element: `{name}[0]`"),
                _ => format!("the path ends at `{name}`"),
            };
            Err(Finding::new(span, format!("`{name}` is {kind}: the path cannot go on inside it")).help(help))
        }
    }
}

fn no_element(span: Span, name: &str, len: usize) -> Finding {
    let help = match len {
        0 => "the file has none; `--with FILE` can add one".to_owned(),
        1 => "there is one, with index 0".to_owned(),
        _ => format!("there are {len}, with indices 0 to {}", len - 1),
    };
    Finding::new(span, format!("`{name}` has no such element")).help(help)
}
