//! The plan of a network: fittings with names, ports and dimensions, ends, what stands in it, and the route.

use std::fmt::Write;

use ductloop_duct::cell::{Beyond, FaceKind, Solid};
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{Blade, Fitting, GrilleSide, Hand, Shape};
use ductloop_duct::network::{Attached, End, Network};
use nalgebra::{Point2, Point3, Vector2};

use super::floor_plan::{Room, Scale, hull, wall_pieces};
use super::plot::escaped;
use crate::scenario::Scenario;

/// Beside the network is room for labels; small ones are not blown up, and their drawing is no wider than it must be.
const ROOM: Room = Room { width: [460.0, 1200.0], height_max: 1500.0, margin: 110.0, below: 0.0, per_m_max: 200.0 };
/// Size of the letters, and about how wide one is.
const LETTER: f64 = 12.0;
const LETTER_WIDE: f64 = 6.4;
const LINE: f64 = 14.0;
/// Size of a port's letters, about how wide one is, and how far from its port the name's middle is.
const PORT_LETTER: f64 = 9.0;
const PORT_LETTER_WIDE: f64 = 4.8;
const PORT_IN: f64 = 4.0;
/// Ducts are drawn at least so wide, in pixels, unless the drawing would be so many times as large as its room.
const DUCT_MIN: f64 = 44.0;
const GROWN_MAX: f64 = 8.0;
/// Arrows on the route are about this far apart, in pixels.
const ARROWS: f64 = 70.0;

const STYLE: &str = "\
text{font:12px system-ui,'DejaVu Sans',sans-serif;fill:#222}\
.name{font-weight:600}.size{fill:#555}.end{font-size:10px;fill:#777}\
.port{font-size:9px;fill:#7a3e9d;stroke:#e9edf0;stroke-width:2.5;paint-order:stroke}.head{font-size:16px;font-weight:600}\
.floor{fill:#e9edf0}.sloped{fill:#d9e6d3}.shaft{fill:#3b4045;stroke:#222;stroke-dasharray:4 2}\
.wall{fill:none;stroke:#333;stroke-width:2;stroke-linecap:round}.joint{stroke:#9aa4ab;stroke-dasharray:3 3}\
.open{stroke:#2a9d4b;stroke-width:3;stroke-dasharray:6 3}.cap{stroke:#333;stroke-width:4}\
.grille{stroke:#2a9d4b;stroke-width:4;stroke-dasharray:2 2}\
.solid{fill:#8a6d3b;stroke:#5b4725}.object{fill:#c0662b;stroke:#7a3a10}\
.route{fill:none;stroke:#1769c2;stroke-width:1.6}.arrow{fill:#1769c2}.leader{stroke:#aab;stroke-width:.8}\
.start{fill:#fff;stroke:#1769c2;stroke-width:2}.stop{fill:#1769c2}";

/// The drawing, as a whole SVG file.
pub fn svg(scenario: &Scenario, network: &Network) -> String {
    let scale = scale(network);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = draw(&mut out, &scale, scenario, network);
    out
}

/// As large as there is room for, and larger where a duct would be too narrow for the names of its ports.
fn scale(network: &Network) -> Scale {
    let scale = Scale::of(network, &ROOM);
    let ports = network.fittings.iter().flat_map(Fitting::ports);
    let narrowest_m = ports.map(|port| port.width_m).fold(f64::INFINITY, f64::min);
    let grown = (DUCT_MIN / (narrowest_m * scale.per_m)).min(GROWN_MAX);
    if grown <= 1.0 {
        return scale;
    }
    let grow = |size: f64| (size - 2.0 * ROOM.margin) * grown + 2.0 * ROOM.margin;
    let width = [ROOM.width[0], grow(ROOM.width[1])];
    Scale::of(network, &Room { width, height_max: grow(ROOM.height_max), ..ROOM })
}

fn draw(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network) -> std::fmt::Result {
    let (title, width, height) = (escaped(&scenario.name), scale.width, scale.height);
    writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.0} {height:.0}">"#
    )?;
    writeln!(out, "<title>Plan of {title}</title><style>{STYLE}</style>")?;
    writeln!(out, r##"<rect width="{width:.0}" height="{height:.0}" fill="#fff"/>"##)?;
    writeln!(out, r#"<text class="head" x="20" y="28">{title}</text>"#)?;
    let route_m = network.centreline.length_m();
    writeln!(
        out,
        r#"<text class="size" x="20" y="46">{} fittings, way {route_m:.2} m, begins {}; widths x heights in mm</text>"#,
        network.fittings.len(),
        section([scenario.duct.width_m, scenario.duct.height_m])
    )?;
    draw_sheets(out, scale, network)?;
    draw_solids(out, scale, scenario, network)?;
    draw_ends(out, scale, network)?;
    draw_route(out, scale, scenario, network)?;
    draw_ports(out, scale, network)?;
    draw_labels(out, scale, scenario, network)?;
    draw_scale_bar(out, scale)?;
    writeln!(out, "</svg>")
}

/// Floors, shafts, walls, grilles, joints.
fn draw_sheets(out: &mut String, scale: &Scale, network: &Network) -> std::fmt::Result {
    // Lower ones first: a duct that passes over another hides it.
    let mut cells: Vec<_> = network.cells.iter().collect();
    let low = |cell: &&ductloop_duct::cell::Cell| cell.bounds().low.z;
    cells.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let is_shaft = |cell: &ductloop_duct::cell::Cell| {
        cell.faces.iter().any(|face| face.kind == FaceKind::Ceiling && face.portals.iter().any(|p| p.beyond != Beyond::Outside))
    };
    let mut shafts = String::new();
    for cell in cells {
        for face in &cell.faces {
            let plan = || scale.path(face.outline.iter().map(Point3::xy), true);
            match face.kind {
                FaceKind::Floor if is_shaft(cell) => writeln!(shafts, r#"<path class="shaft" d="{}"/>"#, plan())?,
                FaceKind::Floor => {
                    let class = if face.plane.normal.z.abs() < 1.0 { "floor sloped" } else { "floor" };
                    writeln!(out, r#"<path class="{class}" d="{}"/>"#, plan())?;
                }
                FaceKind::Ceiling => {}
                FaceKind::Wall if is_shaft(cell) => {}
                FaceKind::Wall => {
                    for piece in wall_pieces(face) {
                        writeln!(out, r#"<path class="wall" d="{}"/>"#, scale.path(piece, false))?;
                    }
                }
            }
        }
    }
    out.push_str(&shafts);
    for (fitting, index) in network.fittings.iter().zip(0..) {
        if let Shape::Grille { side, .. } = fitting.shape {
            let cells = network.cells_of(index);
            let openings = network.cells[cells].iter().flat_map(|cell| &cell.faces).filter(|face| {
                face.portals.len() == 1 && face.portals[0].beyond == Beyond::Outside && face.portals[0].outline != face.outline
            });
            for opening in openings.flat_map(|face| &face.portals) {
                let plan = hull(&opening.outline);
                let closed = side == GrilleSide::Ceiling;
                writeln!(out, r#"<path class="grille" fill="none" d="{}"/>"#, scale.path(plan, closed))?;
            }
        }
    }
    for (_, port) in network.joined_ports() {
        if let Some(line) = port_line(network, port) {
            writeln!(out, r#"<path class="joint" d="{}"/>"#, scale.path(line, false))?;
        }
    }
    Ok(())
}

/// A port seen from above.
fn port_line(network: &Network, (piece, name): (usize, PortName)) -> Option<[Point2<f64>; 2]> {
    let half_m = network.fittings[piece].port(name)?.width_m / 2.0;
    let pose = network.world_from_port((piece, name))?;
    Some([half_m, -half_m].map(|y| (pose * Point3::new(0.0, y, 0.0)).xy()))
}

fn draw_solids(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network) -> std::fmt::Result {
    let objects: Vec<Solid> = scenario.duct.objects.iter().map(|object| object.solid(&network.centreline)).collect();
    let mut drawn = std::collections::BTreeSet::new();
    for solid in network.cells.iter().flat_map(|cell| &cell.solids) {
        let class = if objects.contains(solid) { "object" } else { "solid" };
        let path = format!(r#"<path class="{class}" d="{}"/>"#, scale.path(hull(&solid.corners), true));
        if drawn.insert(path.clone()) {
            writeln!(out, "{path}")?;
        }
    }
    Ok(())
}

/// Free ports: open or capped.
fn draw_ends(out: &mut String, scale: &Scale, network: &Network) -> std::fmt::Result {
    for (index, fitting) in network.fittings.iter().enumerate() {
        for port in fitting.ports() {
            let at = (index, port.name);
            let (Some(Attached::End(end)), Some(line)) = (network.attached(at), port_line(network, at)) else { continue };
            let word = if end == End::Open { "open" } else { "cap" };
            writeln!(out, r#"<path class="{word}" d="{}"/>"#, scale.path(line, false))?;
        }
    }
    Ok(())
}

/// The route, a little to the right of the middle, so that the way there and the way back are told apart.
fn draw_route(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network) -> std::fmt::Result {
    let path = &network.centreline;
    let start_m = scenario.start.distance_m;
    let end_m = scenario.finish_m(network).max(start_m);
    let beside = |along_m: f64| {
        let [width_m, _] = path.section_at_m(along_m);
        (path.pose_at(along_m) * Point3::new(0.0, -0.09 * width_m, 0.0)).xy()
    };
    let step_m = (4.0 / scale.per_m).max((end_m - start_m) / 20_000.0);
    let steps = ((end_m - start_m) / step_m).ceil().max(1.0) as usize;
    let places = (0..=steps).map(|i| beside(start_m + (end_m - start_m) * i as f64 / steps as f64));
    writeln!(out, r#"<path class="route" d="{}"/>"#, scale.path(places, false))?;
    let arrows = ((end_m - start_m) * scale.per_m / ARROWS).floor().max(1.0) as usize;
    for i in 1..=arrows {
        let along_m = start_m + (end_m - start_m) * (i as f64 - 0.5) / arrows as f64;
        let forward = path.pose_at(along_m).rotation * nalgebra::Vector3::x();
        arrow(out, scale.at(&beside(along_m)), Vector2::new(forward.x, -forward.y))?;
    }
    let [u, v] = scale.at(&beside(start_m));
    writeln!(out, r#"<circle class="start" cx="{u:.1}" cy="{v:.1}" r="5"><title>start</title></circle>"#)?;
    let [u, v] = scale.at(&beside(end_m));
    writeln!(out, r#"<rect class="stop" x="{:.1}" y="{:.1}" width="9" height="9"><title>finish</title></rect>"#, u - 4.5, v - 4.5)
}

fn arrow(out: &mut String, [u, v]: [f64; 2], forward: Vector2<f64>) -> std::fmt::Result {
    let length = forward.norm();
    let ahead = if length > 0.0 { forward / length } else { Vector2::x() };
    let aside = Vector2::new(-ahead.y, ahead.x);
    let at = |along: f64, across: f64| {
        let p = Vector2::new(u, v) + ahead * along + aside * across;
        format!("{:.1} {:.1}", p.x, p.y)
    };
    writeln!(out, r#"<path class="arrow" d="M{}L{}L{}Z"/>"#, at(6.0, 0.0), at(-4.0, 4.0), at(-4.0, -4.0))
}

/// Names of ports, each just inside its fitting, left of the middle as one comes out, away from the route; where another one is
/// there, on the other side, in the middle, or farther in.
fn draw_ports(out: &mut String, scale: &Scale, network: &Network) -> std::fmt::Result {
    let mut ports: Vec<_> =
        network.fittings.iter().enumerate().flat_map(|(i, f)| f.ports().into_iter().map(move |p| (i, f, p))).collect();
    // The shortest first: long ones have room to give way.
    ports.sort_by(|a, b| a.1.length_m().total_cmp(&b.1.length_m()));
    let mut taken: Vec<Area> = Vec::new();
    for (index, fitting, port) in ports {
        let Some(pose) = network.world_from_port((index, port.name)) else { continue };
        let word = port.name.as_str();
        let ahead = pose.rotation * nalgebra::Vector3::x();
        let (wide, high) = (word.len() as f64 * PORT_LETTER_WIDE, PORT_LETTER);
        // What the word takes along the duct.
        let along = ahead.x.abs() * wide + ahead.y.abs() * high;
        let steps = if fitting.length_m() * scale.per_m > 4.0 * (along + PORT_IN) { 3 } else { 1 };
        let mut best: Option<(f64, Area)> = None;
        for step in 0..steps {
            for (across, worse) in [(0.27, 0.0), (-0.27, 2.0), (0.0, 3.0)] {
                let inward = PORT_IN + (0.5 + f64::from(step)) * along;
                let at_m = Point3::new(-inward / scale.per_m, across * port.width_m, 0.0);
                let [u, v] = scale.at(&(pose * at_m).xy());
                let area = Area { low: [u - wide / 2.0, v - high / 2.0], high: [u + wide / 2.0, v + high / 2.0] };
                let cost = taken.iter().map(|other| area.shared(other)).sum::<f64>() + worse + f64::from(step);
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, area));
                }
            }
        }
        let Some((_, area)) = best else { continue };
        let [u, v] = [0, 1].map(|i| f64::midpoint(area.low[i], area.high[i]));
        writeln!(out, r#"<text class="port" text-anchor="middle" x="{u:.1}" y="{:.1}">{word}</text>"#, v + high / 3.0)?;
        taken.push(area);
    }
    Ok(())
}

/// A rectangle in the drawing.
#[derive(Clone, Copy)]
struct Area {
    low: [f64; 2],
    high: [f64; 2],
}

impl Area {
    /// How much of it the other one covers.
    fn shared(&self, other: &Self) -> f64 {
        let side = |i: usize| (self.high[i].min(other.high[i]) - self.low[i].max(other.low[i])).max(0.0);
        side(0) * side(1)
    }
}

/// What is written beside the drawing of a fitting or an end.
struct Label {
    at: [f64; 2],
    /// Directions in which there may be room, best first.
    toward: Vec<Vector2<f64>>,
    lines: Vec<(&'static str, String)>,
}

/// Names and dimensions, each beside what it names, where there is room.
fn draw_labels(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network) -> std::fmt::Result {
    let mut taken: Vec<Area> = Vec::new();
    // Ducts as squares: what is under a slanting one's box is not all duct.
    for cell in &network.cells {
        taken.extend(squares(scale, cell));
    }
    for label in labels(scale, scenario, network) {
        let wide = label.lines.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0) as f64 * LETTER_WIDE + 4.0;
        let high = label.lines.len() as f64 * LINE + 2.0;
        let mut best: Option<(f64, Area)> = None;
        for far in 1..=14 {
            for toward in &label.toward {
                let away = f64::from(far) * 12.0;
                // The label's near side is that far from the point.
                let centre: [f64; 2] =
                    std::array::from_fn(|i| label.at[i] + toward[i] * away + toward[i].clamp(-1.0, 1.0) * [wide, high][i] / 2.0);
                let area = Area {
                    low: [centre[0] - wide / 2.0, centre[1] - high / 2.0],
                    high: [centre[0] + wide / 2.0, centre[1] + high / 2.0],
                };
                let outside = area.low[0] < 2.0
                    || area.low[1] < 54.0
                    || area.high[0] > scale.width - 2.0
                    || area.high[1] > scale.height - 2.0;
                let covered: f64 = taken.iter().map(|other| area.shared(other)).sum();
                let cost = covered + if outside { 1e5 } else { 0.0 } + away * 0.4;
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, area));
                }
            }
        }
        let Some((_, area)) = best else { continue };
        let near: [f64; 2] = std::array::from_fn(|i| label.at[i].clamp(area.low[i], area.high[i]));
        writeln!(out, r#"<path class="leader" d="M{:.1} {:.1}L{:.1} {:.1}"/>"#, label.at[0], label.at[1], near[0], near[1])?;
        for (i, (class, text)) in label.lines.iter().enumerate() {
            writeln!(
                out,
                r#"<text class="{class}" text-anchor="middle" x="{:.1}" y="{:.1}">{}</text>"#,
                f64::midpoint(area.low[0], area.high[0]),
                area.low[1] + LETTER + i as f64 * LINE,
                escaped(text)
            )?;
        }
        taken.push(area);
    }
    Ok(())
}

/// A cell's plan as small rectangles, about as wide as letters are high.
fn squares(scale: &Scale, cell: &ductloop_duct::cell::Cell) -> Vec<Area> {
    const GRID: f64 = 10.0;
    let Some(floor) = cell.faces.iter().find(|face| face.kind == FaceKind::Floor) else { return Vec::new() };
    let corners: Vec<[f64; 2]> = floor.outline.iter().map(|p| scale.at(&p.xy())).collect();
    let bound = |i: usize, pick: fn(f64, f64) -> f64, from: f64| corners.iter().map(|c| c[i]).fold(from, pick);
    let (low, high) = (
        [bound(0, f64::min, f64::INFINITY), bound(1, f64::min, f64::INFINITY)],
        [bound(0, f64::max, f64::NEG_INFINITY), bound(1, f64::max, f64::NEG_INFINITY)],
    );
    let inside = |u: f64, v: f64| {
        let side = |i: usize| {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            (b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0])
        };
        let sides: Vec<f64> = (0..corners.len()).map(side).collect();
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    };
    let mut areas = Vec::new();
    let steps = |i: usize| ((high[i] - low[i]) / GRID).ceil().max(1.0);
    let size: [f64; 2] = std::array::from_fn(|i| (high[i] - low[i]) / steps(i));
    for i in 0..steps(0) as usize {
        for j in 0..steps(1) as usize {
            let corner = [low[0] + i as f64 * size[0], low[1] + j as f64 * size[1]];
            if inside(corner[0] + size[0] / 2.0, corner[1] + size[1] / 2.0) {
                areas.push(Area { low: corner, high: [corner[0] + size[0], corner[1] + size[1]] });
            }
        }
    }
    areas
}

fn labels(scale: &Scale, scenario: &Scenario, network: &Network) -> Vec<Label> {
    let mut labels = Vec::new();
    let around = |first: Vector2<f64>| {
        let turned = |quarters: i32| {
            let (s, c) = libm::sincos(f64::from(quarters) * std::f64::consts::FRAC_PI_4);
            Vector2::new(c * first.x - s * first.y, s * first.x + c * first.y)
        };
        [0, 4, 1, -1, 3, -3, 2, -2].map(turned).to_vec()
    };
    for (index, fitting) in network.fittings.iter().enumerate() {
        let world_from_fitting = network.world_from_fitting[index];
        let ports = fitting.ports();
        // Midway between `in` and the ports where the duct goes on.
        let others: Vec<_> = ports.iter().filter(|port| port.name != PortName::In).collect();
        let sum = others.iter().fold(nalgebra::Vector3::zeros(), |sum, port| sum + port.entry_from_port.translation.vector);
        let mut middle = sum / (2.0 * others.len() as f64);
        if let Some(path) =
            fitting.passage(PortName::In, PortName::Out).filter(|path| path.len() == 1 && path[0].curvature_1_m != 0.0)
        {
            let piece = path[0];
            let half = ductloop_duct::centreline::start_from_along(piece.curvature_1_m, piece.length_m / 2.0);
            middle = (piece.entry_from_start * half).translation.vector;
        }
        let at = scale.at(&(world_from_fitting * Point3::from(middle)).xy());
        let left = world_from_fitting.rotation * nalgebra::Vector3::y();
        let mut lines = vec![("name", network.names[index].clone())];
        lines.extend(dimensions(fitting).map(|text| ("size", text)));
        labels.push(Label { at, toward: around(Vector2::new(left.x, -left.y)), lines });
        for port in &ports {
            let Some(Attached::End(end)) = network.attached((index, port.name)) else { continue };
            let Some(pose) = network.world_from_port((index, port.name)) else { continue };
            let out = pose.rotation * nalgebra::Vector3::x();
            let word = if end == End::Open { "open" } else { "cap" };
            let text = if ports.len() > 2 { format!("{}: {word}", port.name) } else { word.to_owned() };
            let at = scale.at(&Point3::from(pose.translation.vector).xy());
            labels.push(Label { at, toward: around(Vector2::new(out.x, -out.y)), lines: vec![("end", text)] });
        }
    }
    for (i, object) in scenario.duct.objects.iter().enumerate() {
        let name = if object.name.is_empty() { format!("object {i}") } else { object.name.clone() };
        let solid = object.solid(&network.centreline);
        let sum = solid.corners.iter().fold(nalgebra::Vector3::zeros(), |sum, p| sum + p.coords);
        let at = scale.at(&Point3::from(sum / solid.corners.len() as f64).xy());
        labels.push(Label { at, toward: around(Vector2::new(0.0, -1.0)), lines: vec![("size", name)] });
    }
    let start = network.centreline.pose_at(scenario.start.distance_m);
    let at = scale.at(&Point3::from(start.translation.vector).xy());
    labels.push(Label { at, toward: around(Vector2::new(0.0, 1.0)), lines: vec![("size", "start".to_owned())] });
    let finish = network.centreline.pose_at(scenario.finish_m(network));
    let at = scale.at(&Point3::from(finish.translation.vector).xy());
    labels.push(Label { at, toward: around(Vector2::new(0.0, 1.0)), lines: vec![("size", "finish".to_owned())] });
    labels
}

fn mm(x_m: f64) -> String {
    let mm = (x_m * 1e4).round() / 10.0;
    format!("{mm}")
}

fn section([width_m, height_m]: [f64; 2]) -> String {
    format!("{} x {}", mm(width_m), mm(height_m))
}

fn metres(x_m: f64) -> String {
    format!("{} m", (x_m * 1e3).round() / 1e3)
}

fn degrees(angle_rad: f64) -> String {
    format!("{}°", (angle_rad.to_degrees() * 100.0).round() / 100.0)
}

/// What a fitting measures, in a line; of straights their section too.
fn dimensions(fitting: &Fitting) -> Option<String> {
    let hand = |left: bool| if left { "left" } else { "right" };
    let turn = |angle_rad: f64| format!("{} {}", degrees(angle_rad.abs()), hand(angle_rad > 0.0));
    let own = section([fitting.width_m, fitting.height_m]);
    Some(match fitting.shape {
        Shape::Straight { length_m } => format!("{}, {own}", metres(length_m)),
        Shape::RadiusElbow { angle_rad, throat_radius_m } => format!("{}, throat {}", turn(angle_rad), mm(throat_radius_m)),
        Shape::MitredElbow { angle_rad } => turn(angle_rad),
        Shape::VanedElbow { angle_rad } => format!("{}, vanes", turn(angle_rad)),
        Shape::Transition { length_m, to_width_m, to_height_m, .. } => {
            format!("{own} to {}, {}", section([to_width_m, to_height_m]), metres(length_m))
        }
        Shape::Offset { length_m, aside_m } => {
            format!("{} {} in {}", mm(aside_m.abs()), hand(aside_m > 0.0), metres(length_m))
        }
        Shape::Slope { length_m, angle_rad } => {
            format!("{} {}, {}", degrees(angle_rad.abs()), if angle_rad < 0.0 { "down" } else { "up" }, metres(length_m))
        }
        Shape::Tee { hand: side, branch_width_m } => format!("branch {} {}", mm(branch_width_m), hand(side == Hand::Left)),
        Shape::BullheadTee { branch_width_m } | Shape::Cross { branch_width_m } => format!("branches {}", mm(branch_width_m)),
        Shape::SideBranch { hand: side, branch_width_m, shoe_m } => {
            format!("branch {} {}, shoe {}", mm(branch_width_m), hand(side == Hand::Left), mm(shoe_m))
        }
        Shape::Wye { half_angle_rad, branch_width_m } => format!("{}, branches {}", degrees(half_angle_rad), mm(branch_width_m)),
        Shape::Damper { blade, .. } => if blade == Blade::Open { "open" } else { "shut" }.to_owned(),
        Shape::Grille { side, opening_length_m, opening_height_m, .. } => {
            let place = match side {
                GrilleSide::Left => "left",
                GrilleSide::Right => "right",
                GrilleSide::Ceiling => "ceiling",
            };
            format!("{} {place}", section([opening_length_m, opening_height_m]))
        }
        Shape::Drop { hole_length_m, hole_width_m, depth_m, .. } => {
            format!("hole {}, {} deep", section([hole_length_m, hole_width_m]), metres(depth_m))
        }
    })
}

fn draw_scale_bar(out: &mut String, scale: &Scale) -> std::fmt::Result {
    let length_m = scale.bar_m();
    let (x, y) = (scale.width - 30.0 - length_m * scale.per_m, 24.0);
    writeln!(out, r#"<path class="wall" d="M{x:.1} {y}h{:.1}"/>"#, length_m * scale.per_m)?;
    writeln!(out, r#"<text x="{x:.1}" y="{}">{length_m} m</text>"#, y - 6.0)
}
