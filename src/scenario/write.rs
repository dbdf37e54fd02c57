//! A resolved scenario as a file, every default written out.

use std::fmt::Write as _;

use ductloop_duct::network::End;

use ductloop_sensor::surface::Look;

use super::Scenario;
use super::check::join;
use super::criteria::Bound;
use super::fields::{self, Field, Kind, Scale, Shape, Slot, TableShape};
use super::model::{ObjectShape, end_word};
use super::source::Span;
use super::tree::{Entry, Node, Table, Value};
use super::{fittings, parse};

/// The file's text.
pub(super) fn to_toml(scenario: &Scenario) -> String {
    let tree = tree(scenario);
    let mut text = String::new();
    table(&mut text, fields::root(), &tree, "");
    text
}

/// The scenario as the tree that reading the file gives.
fn tree(scenario: &Scenario) -> Table {
    let mut root = Table::default();
    // Slots lend their places mutably: reading them needs a copy.
    let mut copy = scenario.clone();
    for field in fields::fields() {
        if let Some(value) = load(field, &mut copy) {
            root.put(field.path, value);
        }
    }
    root.put("duct.surface", Value::Text(surface_name(scenario, scenario.duct.surface.0)));
    root.put("duct.run", Value::List(run(scenario, &scenario.duct.run)));
    root.put("duct.branch", Value::List(branches(scenario)));
    if let Some(route) = route(scenario) {
        root.put("route", Value::Table(route));
    }
    root.put("duct.object", Value::List(objects(scenario)));
    root.put("sensor.laser", Value::Table(lasers(scenario)));
    root.put("surface", Value::Table(surfaces(scenario)));
    root.put("fault", Value::List(faults(scenario)));
    root
}

fn load(field: &Field, scenario: &mut Scenario) -> Option<Value> {
    let numbers =
        |values: &[f64], scale: Scale| Value::List(values.iter().map(|x| node(Value::Number(scale.in_file(*x)))).collect());
    Some(match field.slot {
        Slot::ByTable => return None,
        Slot::Fixed(toml) => parse::value(toml, 0, 0).ok()?.value,
        Slot::Number(at, scale) => Value::Number(scale.in_file(*at(scenario))),
        Slot::NumberOr(at, scale) => match (*at(scenario), field.kind) {
            (None, Kind::NumberOr { word, .. }) => Value::Text(word.to_owned()),
            (value, _) => Value::Number(scale.in_file(value?)),
        },
        Slot::Part { get, .. } => Value::Number(get(scenario)?),
        Slot::Values { get, .. } => numbers(&get(scenario), Scale::Si),
        Slot::Choice { get, .. } => Value::Integer(get(scenario)),
        Slot::Numbers(at, scale) => {
            let values = &*at(scenario);
            let all_equal = values.windows(2).all(|w| w[0] == w[1]);
            match field.kind {
                Kind::Numbers { single: true, .. } if all_equal => Value::Number(scale.in_file(values[0])),
                _ => numbers(values, scale),
            }
        }
        Slot::List(at, scale) => numbers(at(scenario), scale),
        Slot::Usize(at) => Value::Integer(i64::try_from(*at(scenario)).unwrap_or(i64::MAX)),
        Slot::Sizes(at) => {
            let size = |x: &usize| node(Value::Integer(i64::try_from(*x).unwrap_or(i64::MAX)));
            Value::List(at(scenario).iter().map(size).collect())
        }
        Slot::U32(at) => Value::Integer(i64::from(*at(scenario))),
        Slot::U64(at) => Value::Integer(i64::try_from(*at(scenario)).unwrap_or(i64::MAX)),
        Slot::Flag(at) => Value::Flag(*at(scenario)),
        Slot::Text(at) => Value::Text(at(scenario).clone()),
        Slot::Word { get, .. } => Value::Text(get(scenario).to_owned()),
        Slot::Criterion(..) => match &scenario.pass.get(field.key())?.bound {
            Bound::Is(flag) => Value::Flag(*flag),
            Bound::Word(word) => Value::Text(word.clone()),
            Bound::AtMost(x) | Bound::AtLeast(x) if matches!(field.kind, Kind::Integer { .. }) => Value::Integer(*x as i64),
            Bound::AtMost(x) | Bound::AtLeast(x) => {
                let scale = scenario.pass.get(field.key())?.scale;
                Value::Number(scale.in_file(*x))
            }
        },
    })
}

fn node(value: Value) -> Node {
    Node { value, span: Span::default() }
}

/// A table of these keys, without those that have no value.
fn element<const N: usize>(entries: [(&str, Option<Value>); N]) -> Table {
    let entry = |(key, value): (&str, Option<Value>)| {
        value.map(|value| Entry { key: key.to_owned(), key_span: Span::default(), node: node(value) })
    };
    Table { entries: entries.into_iter().filter_map(entry).collect() }
}

fn named(entries: impl Iterator<Item = (String, Table)>) -> Table {
    let entry = |(key, table)| Entry { key, key_span: Span::default(), node: node(Value::Table(table)) };
    Table { entries: entries.map(entry).collect() }
}

fn surface_name(scenario: &Scenario, id: u16) -> String {
    // An index of none, which only a scenario made by hand can have, gives a name that validation refuses.
    scenario.surfaces.get(usize::from(id)).map_or_else(|| format!("surface {id}"), |s| s.name.clone())
}

fn run(scenario: &Scenario, pieces: &[super::Piece]) -> Vec<Node> {
    let end = |key: &'static str, end: End| (end == End::Open).then(|| (key, Value::Text(end_word(end).to_owned())));
    let piece = |piece: &super::Piece| {
        let mut table = Table::default();
        let name = (!piece.name.is_empty()).then(|| ("name", Value::Text(piece.name.clone())));
        let ends = [end("left_end", piece.left_end), end("right_end", piece.right_end)];
        let surface = ("surface", Value::Text(surface_name(scenario, piece.surface.0)));
        let own = fittings::write(&piece.shape);
        for (key, value) in name.into_iter().chain(own).chain(ends.into_iter().flatten()).chain([surface]) {
            table.put(key, value);
        }
        node(Value::Table(table))
    };
    pieces.iter().map(piece).collect()
}

fn branches(scenario: &Scenario) -> Vec<Node> {
    let branch = |branch: &super::Branch| {
        let end = branch.to.is_none().then(|| Value::Text(end_word(branch.end).to_owned()));
        node(Value::Table(element([
            ("from", Some(Value::Text(branch.from.clone()))),
            ("to", branch.to.clone().map(Value::Text)),
            ("end", end),
            ("run", Some(Value::List(run(scenario, &branch.run)))),
        ])))
    };
    scenario.duct.branches.iter().map(branch).collect()
}

/// The route; nothing where there is nothing to decide.
fn route(scenario: &Scenario) -> Option<Table> {
    let route = &scenario.duct.route;
    if *route == super::Route::default() {
        return None;
    }
    let turns = route.turns.iter().map(|turn| node(Value::Text(turn.as_str().to_owned()))).collect();
    Some(element([
        ("turns", (!route.turns.is_empty()).then_some(Value::List(turns))),
        ("explore", Some(Value::Flag(route.explore))),
        ("turn_back_m", Some(Value::Number(route.turn_back_m))),
    ]))
}

fn vector(v: [f64; 3]) -> Option<Value> {
    Some(Value::List(v.map(|x| node(Value::Number(x))).into()))
}

fn objects(scenario: &Scenario) -> Vec<Node> {
    let object = |object: &super::Object| {
        let ObjectShape::Box { size_m } = object.shape;
        let number = |x| Some(Value::Number(x));
        node(Value::Table(element([
            ("name", (!object.name.is_empty()).then(|| Value::Text(object.name.clone()))),
            ("shape", Some(Value::Text("box".to_owned()))),
            ("size_m", vector(size_m)),
            ("at_m", number(object.at_m)),
            ("left_m", number(object.left_m)),
            ("above_m", number(object.above_m)),
            ("turned_deg", number(Scale::Degrees.in_file(object.turned_rad))),
            ("surface", Some(Value::Text(surface_name(scenario, object.surface.0)))),
        ])))
    };
    scenario.duct.objects.iter().map(object).collect()
}

fn lasers(scenario: &Scenario) -> Table {
    named(scenario.rig.lasers.iter().enumerate().map(|(index, laser)| {
        let table = element([
            ("normal", vector(laser.normal_in_camera.into_inner().into())),
            ("offset_m", Some(Value::Number(laser.offset_m))),
            ("fan_deg", Some(Value::Number(Scale::Degrees.in_file(laser.fan_rad)))),
            ("source_in_camera_m", vector(laser.source_in_camera.coords.into())),
            ("power", scenario.laser_power.get(index).copied().map(Value::Number)),
        ]);
        (laser.name.clone(), table)
    }))
}

fn surfaces(scenario: &Scenario) -> Table {
    named(scenario.surfaces.iter().map(|surface| {
        let Look { albedo, specular, roughness, spangle, spangle_m, seam_m } = surface.look;
        let number = |x| Some(Value::Number(x));
        let table = element([
            ("albedo", number(albedo)),
            ("specular", number(specular)),
            ("roughness", number(roughness)),
            ("spangle", number(spangle)),
            ("spangle_mm", number(Scale::Milli.in_file(spangle_m))),
            ("seam_mm", number(Scale::Milli.in_file(seam_m))),
            ("friction", number(surface.friction)),
        ]);
        (surface.name.clone(), table)
    }))
}

fn faults(scenario: &Scenario) -> Vec<Node> {
    let fault = |pairs: Vec<(&'static str, Value)>| {
        let mut table = Table::default();
        for (key, value) in pairs {
            table.put(key, value);
        }
        node(Value::Table(table))
    };
    super::faults::write(scenario).map(fault).collect()
}

/// A table's own fields, then its tables, each in the order of the table of fields.
fn table(text: &mut String, shape: &TableShape, tree: &Table, path: &str) {
    for field in shape.leaves() {
        if let Some(node) = tree.get(field.key()) {
            line(text, field.key(), &inline(&node.value));
        }
    }
    for (key, shape) in &shape.children {
        let (path, node) = (join(path, key), tree.get(key));
        match (shape, node.map(|n| &n.value)) {
            (Shape::Table(shape), Some(Value::Table(inner))) => {
                headed(text, shape, inner, &path, "[", "]");
            }
            (Shape::Named(shape), Some(Value::Table(inner))) => {
                for entry in &inner.entries {
                    if let Value::Table(inner) = &entry.node.value {
                        headed(text, shape, inner, &join(&path, &quoted_key(&entry.key)), "[", "]");
                    }
                }
            }
            (Shape::List(shape), Some(Value::List(list))) => {
                for inner in list.iter().filter_map(Node::as_table) {
                    headed(text, shape, inner, &path, "[[", "]]");
                }
            }
            _ => {}
        }
    }
}

fn headed(text: &mut String, shape: &TableShape, inner: &Table, path: &str, open: &str, close: &str) {
    let start = text.len();
    table(text, shape, inner, path);
    if text[start..].starts_with(|c: char| c != '\n') || inner.entries.is_empty() {
        text.insert_str(start, &format!("\n{open}{path}{close}\n"));
    }
}

fn line(text: &mut String, key: &str, value: &str) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{key} = {value}");
}

/// A value on one line.
fn inline(value: &Value) -> String {
    match value {
        Value::Text(string) => toml::Value::String(string.clone()).to_string(),
        Value::Integer(x) => x.to_string(),
        Value::Number(x) => number(*x),
        Value::Flag(flag) => flag.to_string(),
        Value::List(list) => format!("[{}]", list.iter().map(|n| inline(&n.value)).collect::<Vec<_>>().join(", ")),
        // Tables are written by `table`; of other values the tree of a scenario has none.
        Value::Table(_) | Value::Other(_) => "{}".to_owned(),
    }
}

/// The shortest text that reads back to the same bits, as TOML spells it.
fn number(x: f64) -> String {
    match x {
        x if x.is_nan() => "nan".to_owned(),
        f64::INFINITY => "inf".to_owned(),
        f64::NEG_INFINITY => "-inf".to_owned(),
        x => format!("{x:?}"),
    }
}

/// A key as it must be typed.
fn quoted_key(key: &str) -> String {
    if super::check::is_name(key) { key.to_owned() } else { toml::Value::String(key.to_owned()).to_string() }
}
