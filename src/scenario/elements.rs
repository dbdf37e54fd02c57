//! The tables with names of their own and the arrays of tables: lasers, surfaces, fittings, objects.

use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::Shape;
use ductloop_duct::network::{End, Turn};
use ductloop_nav::rig::{Laser, MountAngles, Rig};
use ductloop_sensor::surface::Look;
use nalgebra::{Point3, Unit, Vector3};

use super::check::{Checked, quoted};
use super::diagnostic::Finding;
use super::fields::{self, Scale};
use super::model::{Branch, Object, ObjectShape, Piece, Route, Surface};
use super::resolve::default_of;
use super::tree::{Entry, Node, Table, Value};
use super::typed::Typed;
use super::unknown_key::nearest;
use super::{Scenario, fittings, layout};

/// A normal this near to unit length is taken as it is: it was written by this program, and dividing it by its length again
/// would change its last bits.
const UNIT_EXACT: f64 = 1e-12;

/// A normal further than this from unit length was not meant as one. Six digits, as people type them, are within 1e-6.
const UNIT_TYPED: f64 = 1e-3;

/// Reads the fields of one element.
pub(super) struct Element<'t>(&'t Table);

impl Element<'_> {
    /// Whether it has this key.
    pub(super) fn has(&self, key: &str) -> bool {
        self.0.get(key).is_some()
    }

    pub(super) fn number(&self, key: &str, scale: Scale) -> Option<f64> {
        self.0.get(key)?.as_number().map(|x| scale.si(x))
    }

    fn vector(&self, key: &str) -> Option<Vector3<f64>> {
        let list = self.0.get(key)?.as_list()?;
        let number = |i: usize| list.get(i).and_then(Node::as_number);
        Some(Vector3::new(number(0)?, number(1)?, number(2)?))
    }

    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key)?.as_text()
    }
}

fn named<'t>(layered: &'t Table, path: &str) -> impl Iterator<Item = (&'t Entry, Element<'t>)> {
    let entries = layered.at(path).and_then(Node::as_table).map_or(&[][..], |t| &t.entries);
    entries.iter().filter_map(|e| e.node.as_table().map(|t| (e, Element(t))))
}

fn listed<'t>(layered: &'t Table, path: &str) -> impl Iterator<Item = Element<'t>> {
    let list = layered.at(path).and_then(Node::as_list).unwrap_or_default();
    list.iter().filter_map(Node::as_table).map(Element)
}

/// The lasers with their powers, in the order of the file, those of a preset first.
pub(super) fn lasers(layered: &Table, rig: &Rig, typed: &Typed, checked: &mut Checked) -> Vec<(Laser, f64)> {
    let base_from_camera = rig.mount.base_from_camera(MountAngles::default());
    let default = |key: &str| default_of(&format!("sensor.laser.*.{key}")).and_then(|n| n.as_number()).unwrap_or_default();
    let (default_fan, default_power) = (default("fan_deg"), default("power"));
    let lasers: Vec<_> = named(layered, "sensor.laser")
        .filter_map(|(entry, laser)| {
            let path = format!("sensor.laser.{}", entry.key);
            let normal_in_camera = unit(laser.vector("normal")?, &path, typed, checked)?;
            let offset_m = laser.number("offset_m", Scale::Si)?;
            let given = laser.vector("source_in_camera_m").map(Point3::from);
            let in_base = laser.vector("source_in_base_m").map(|p| base_from_camera.inverse() * Point3::from(p));
            let power = laser.number("power", Scale::Si).unwrap_or(default_power);
            let laser = Laser {
                name: entry.key.clone(),
                normal_in_camera,
                offset_m,
                source_in_camera: given.or(in_base).unwrap_or_else(|| Point3::from(*normal_in_camera * offset_m)),
                fan_rad: laser.number("fan_deg", Scale::Degrees).unwrap_or_else(|| Scale::Degrees.si(default_fan)),
            };
            Some((laser, power))
        })
        .collect();
    if lasers.is_empty() && checked.is_sound(&["sensor"]) {
        let help = "add `[sensor.laser.NAME]` with `normal` and `offset_m`, or name a preset";
        checked.wrong("sensor.laser", Finding::new(typed.span("sensor"), "the sensor has no laser").help(help));
    }
    lasers
}

fn unit(normal: Vector3<f64>, path: &str, typed: &Typed, checked: &mut Checked) -> Option<Unit<Vector3<f64>>> {
    let length = normal.norm();
    if (length - 1.0).abs() <= UNIT_EXACT {
        return Some(Unit::new_unchecked(normal));
    }
    if (length - 1.0).abs() <= UNIT_TYPED {
        return Some(Unit::new_normalize(normal));
    }
    let path = format!("{path}.normal");
    let finding = Finding::new(typed.span(&path), format!("`{path}` has length {length:.4}: it must be a unit vector"));
    let help = if length > 0.0 {
        let n = normal / length;
        format!("in the same direction: [{:.6}, {:.6}, {:.6}]; divide `offset_m` by the length too", n.x, n.y, n.z)
    } else {
        "a plane needs a direction".to_owned()
    };
    checked.wrong(&path, finding.help(help));
    None
}

/// The run of fittings, what stands in it, and the surfaces that they are made of.
///
/// Surfaces are numbered by first use, then come those that the file defines and does not use.
pub(super) fn duct(layered: &Table, root: &Table, scenario: &mut Scenario, typed: &Typed, checked: &mut Checked) {
    let default = default_of("duct.surface").and_then(|n| n.as_text().map(str::to_owned)).unwrap_or_default();
    let typed_surface = layered.at("duct.surface").and_then(Node::as_text).unwrap_or(&default);
    let mut surfaces = Vec::new();
    let mut id = |name: &str, path: &str, checked: &mut Checked| match surface(layered, name) {
        Some(surface) => Some(number(&mut surfaces, surface)),
        None => {
            unknown_surface(layered, name, path, typed, checked);
            None
        }
    };
    scenario.duct.surface = id(typed_surface, "duct.surface", checked).unwrap_or_default();
    let branches: Vec<Element<'_>> = listed(layered, "duct.branch").collect();
    let runs = runs(listed(layered, "duct.run").collect(), &branches);
    let names = layout::names(
        runs.iter()
            .flat_map(|run| &run.pieces)
            .map(|piece| (piece.text("name").unwrap_or_default(), fittings::kind_of(piece).map_or("fitting", |kind| kind.word))),
    );
    let mut rest = &names[..];
    let mut from = Vec::new();
    for run in &runs {
        let (own, others) = rest.split_at(run.pieces.len());
        from.push((run.from.and_then(layout::named_port), own));
        rest = others;
    }
    let mut shapes: Vec<Vec<Option<Shape>>> = runs.iter().map(|run| vec![None; run.pieces.len()]).collect();
    layout::sections([scenario.duct.width_m, scenario.duct.height_m], &from, |run, index, section| {
        shapes[run][index] = fittings::read(&runs[run].pieces[index], section);
        shapes[run][index]
    });
    let own_surface = scenario.duct.surface;
    let mut pieces = runs.iter().zip(shapes).map(|(run, shapes)| {
        let mut pieces = Vec::new();
        for (i, (piece, shape)) in run.pieces.iter().zip(shapes).enumerate() {
            let path = format!("{}[{i}]", run.path);
            if let Some((key, message, help)) = fittings::stray_key(piece).filter(|_| checked.is_sound(&[&path])) {
                let path = format!("{path}.{key}");
                checked.wrong(&path, Finding::new(typed.span(&path), message).help(help));
            }
            let name = piece.text("surface").map(|name| (name, format!("{path}.surface")));
            let surface = name.and_then(|(name, path)| id(name, &path, checked)).unwrap_or(own_surface);
            let end = |key: &str| piece.text(key).map_or(End::Cap, fields::end);
            pieces.extend(shape.map(|shape| Piece {
                name: piece.text("name").unwrap_or_default().to_owned(),
                left_end: end("left_end"),
                right_end: end("right_end"),
                shape,
                surface,
            }));
        }
        pieces
    });
    scenario.duct.run = pieces.next().unwrap_or_default();
    scenario.duct.branches = branches
        .iter()
        .zip(pieces)
        .map(|(branch, run)| Branch {
            from: branch.text("from").unwrap_or_default().to_owned(),
            run,
            to: branch.text("to").map(str::to_owned),
            end: branch.text("end").map_or(End::Cap, fields::end),
        })
        .collect();
    scenario.duct.route = route(layered);
    scenario.duct.objects.clear();
    for (i, object) in listed(layered, "duct.object").enumerate() {
        let name = object.text("surface").map(|name| (name, format!("duct.object[{i}].surface")));
        let surface = name.and_then(|(name, path)| id(name, &path, checked)).unwrap_or(scenario.duct.surface);
        scenario.duct.objects.extend(self::object(&object, surface));
    }
    for (entry, _) in named(root, "surface") {
        if let Some(surface) = surface(layered, &entry.key) {
            number(&mut surfaces, surface);
        }
    }
    scenario.surfaces = surfaces;
}

/// A list of fittings, and the port at which a branch begins.
struct Run<'t> {
    path: String,
    from: Option<&'t str>,
    pieces: Vec<Element<'t>>,
}

/// The duct's run and those of the branches.
fn runs<'t>(run: Vec<Element<'t>>, branches: &'t [Element<'t>]) -> Vec<Run<'t>> {
    let of_branch = |(i, branch): (usize, &'t Element<'t>)| Run {
        path: format!("duct.branch[{i}].run"),
        from: Some(branch.text("from").unwrap_or_default()),
        pieces: listed(branch.0, "run").collect(),
    };
    let own = Run { path: "duct.run".to_owned(), from: None, pieces: run };
    std::iter::once(own).chain(branches.iter().enumerate().map(of_branch)).collect()
}

fn route(layered: &Table) -> Route {
    let words = layered.at("route.turns").and_then(Node::as_list).unwrap_or_default();
    let default = Route::default();
    Route {
        turns: words.iter().filter_map(|word| Turn::named(word.as_text()?)).collect(),
        explore: layered.at("route.explore").is_some_and(|node| node.value == Value::Flag(true)),
        turn_back_m: layered.at("route.turn_back_m").and_then(Node::as_number).unwrap_or(default.turn_back_m),
    }
}

/// What stands in the duct; `None` where something that must be given is not, which has been reported.
fn object(object: &Element<'_>, surface: SurfaceId) -> Option<Object> {
    let or_default = |key: &str, scale: Scale| {
        let default = || default_of(&format!("duct.object[].{key}"))?.as_number().map(|x| scale.si(x));
        object.number(key, scale).or_else(default).unwrap_or_default()
    };
    Some(Object {
        name: object.text("name").unwrap_or_default().to_owned(),
        shape: ObjectShape::Box { size_m: object.vector("size_m")?.into() },
        at_m: object.number("at_m", Scale::Si)?,
        left_m: or_default("left_m", Scale::Si),
        above_m: or_default("above_m", Scale::Si),
        turned_rad: or_default("turned_deg", Scale::Degrees),
        surface,
    })
}

/// The index of a surface, which is taken in if it is new.
fn number(surfaces: &mut Vec<Surface>, surface: Surface) -> SurfaceId {
    let index = surfaces.iter().position(|s| s.name == surface.name).unwrap_or_else(|| {
        surfaces.push(surface);
        surfaces.len() - 1
    });
    SurfaceId(u16::try_from(index).unwrap_or(u16::MAX))
}

fn surface(layered: &Table, name: &str) -> Option<Surface> {
    let (_, surface) = named(layered, "surface").find(|(entry, _)| entry.key == name)?;
    // Fields that are missing or wrong have been reported; the surface is known all the same.
    let or_default = |key: &str, scale: Scale| {
        let default = || default_of(&format!("surface.*.{key}"))?.as_number().map(|x| scale.si(x));
        surface.number(key, scale).or_else(default).unwrap_or_default()
    };
    let look = Look {
        albedo: surface.number("albedo", Scale::Si).unwrap_or(1.0),
        specular: or_default("specular", Scale::Si),
        roughness: or_default("roughness", Scale::Si),
        spangle: or_default("spangle", Scale::Si),
        spangle_m: or_default("spangle_mm", Scale::Milli),
        seam_m: or_default("seam_mm", Scale::Milli),
    };
    Some(Surface { name: name.to_owned(), look, friction: surface.number("friction", Scale::Si).unwrap_or(1.0) })
}

fn unknown_surface(layered: &Table, name: &str, path: &str, typed: &Typed, checked: &mut Checked) {
    let known: Vec<&str> = named(layered, "surface").map(|(entry, _)| entry.key.as_str()).collect();
    let guess = nearest(name, known.iter().copied()).map(|near| format!("did you mean \"{near}\"? ")).unwrap_or_default();
    let finding = Finding::new(typed.span(path), format!("there is no surface \"{name}\""));
    checked.wrong(path, finding.help(format!("{guess}known: {}; `[surface.{name}]` would define it", quoted(&known))));
}
