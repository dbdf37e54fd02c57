//! The robot's path on the plan of the duct, to scale.

use std::collections::BTreeSet;
use std::fmt::Write;

use ductloop_duct::cell::{Face, FaceKind, Solid};
use ductloop_duct::network::Network;
use ductloop_nav::navigator::State;
use nalgebra::{Point2, Point3};

use super::plot::escaped;
use super::robot_plan;
use super::thinning::thin;
use super::ticks::step;
use crate::output::words::number;
use crate::record::{FrameRecord, RunRecord};
use crate::scenario::Scenario;

const WIDTH: f64 = 1000.0;
const HEIGHT_MAX: f64 = 560.0;
const MARGIN: f64 = 34.0;
/// Robots shown at most, and the least distance from one to the next.
const ROBOTS: f64 = 10.0;
const ROBOT_GAP_M: f64 = 0.4;

/// From metres in the world to the drawing.
struct Scale {
    per_m: f64,
    left_m: f64,
    top_m: f64,
    height: f64,
}

impl Scale {
    fn of(network: &Network) -> Self {
        let corners = || network.cells.iter().flat_map(|cell| cell.faces.iter().flat_map(|face| &face.outline));
        let least = |coordinate: fn(&Point3<f64>) -> f64| corners().map(coordinate).fold(f64::INFINITY, f64::min);
        let (left, right) = (least(|p| p.x), -least(|p| -p.x));
        let (bottom, top) = (least(|p| p.y), -least(|p| -p.y));
        let across = (WIDTH - 2.0 * MARGIN) / (right - left);
        let per_m = across.min((HEIGHT_MAX - 2.0 * MARGIN) / (top - bottom));
        // In the middle where the height decides.
        let spare_m = (WIDTH - 2.0 * MARGIN) / per_m - (right - left);
        Self { per_m, left_m: left - spare_m / 2.0, top_m: top, height: (top - bottom) * per_m + 2.0 * MARGIN + 16.0 }
    }

    fn at(&self, x_m: f64, y_m: f64) -> [f64; 2] {
        [MARGIN + (x_m - self.left_m) * self.per_m, MARGIN + (self.top_m - y_m) * self.per_m]
    }

    fn path(&self, points: impl IntoIterator<Item = Point2<f64>>, closed: bool) -> String {
        let mut path = String::new();
        for (i, point) in points.into_iter().enumerate() {
            let [u, v] = self.at(point.x, point.y);
            let _ = write!(path, "{}{u:.1} {v:.1}", if i == 0 { 'M' } else { 'L' });
        }
        if closed { path + "Z" } else { path }
    }
}

/// The drawing.
pub(super) fn svg(scenario: &Scenario, network: &Network, run: &RunRecord) -> String {
    let scale = Scale::of(network);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = draw(&mut out, &scale, scenario, network, run);
    out
}

fn draw(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network, run: &RunRecord) -> std::fmt::Result {
    writeln!(out, r#"<svg class="plan" viewBox="0 0 {WIDTH} {:.1}" role="img" aria-label="Plan of the duct">"#, scale.height)?;
    let faces = || network.cells.iter().flat_map(|cell| &cell.faces);
    for floor in faces().filter(|face| face.kind == FaceKind::Floor) {
        writeln!(out, r#"<path class="floor" d="{}"/>"#, scale.path(floor.outline.iter().map(Point3::xy), true))?;
    }
    draw_solids(out, scale, scenario, network)?;
    let walls: String =
        faces().filter(|face| face.kind == FaceKind::Wall).flat_map(wall_pieces).map(|piece| scale.path(piece, false)).collect();
    writeln!(out, r#"<path class="wall" d="{walls}"/>"#)?;
    let length_m = network.centreline.length_m();
    let count = 4 * network.centreline.segments.len().max(64);
    let middle = (0..=count).map(|i| on_path(network, length_m * i as f64 / count as f64, 0.0));
    writeln!(out, r#"<path class="centreline" d="{}"/>"#, scale.path(middle, false))?;
    let finish_m = scenario.finish_m(network);
    let half_m = network.centreline.segment_at(finish_m).width_m / 2.0;
    let finish = [half_m, -half_m].map(|left_m| on_path(network, finish_m, left_m));
    writeln!(out, r#"<path class="finish" d="{}"><title>finish line</title></path>"#, scale.path(finish, false))?;

    draw_robots(out, scale, scenario, network, run)?;
    draw_path(out, scale, run)?;
    let hits = run.frames.windows(2).filter(|pair| pair[1].collisions.count > pair[0].collisions.count).map(|pair| &pair[1]);
    for hit in hits {
        let [u, v] = place(scale, hit);
        let title = escaped(&format!("collision at {} s", number(hit.time_s, 4)));
        writeln!(
            out,
            r#"<path class="collision" d="M{:.1} {:.1}l10 10m0 -10l-10 10"><title>{title}</title></path>"#,
            u - 5.0,
            v - 5.0
        )?;
    }
    draw_scale_bar(out, scale)?;
    writeln!(out, "</svg>")
}

/// What stands in the duct: beads, and objects with their names.
fn draw_solids(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network) -> std::fmt::Result {
    let objects: Vec<Solid> = scenario.duct.objects.iter().map(|object| object.solid(&network.centreline)).collect();
    let solids = network.cells.iter().flat_map(|cell| &cell.solids);
    let beads = solids.filter(|solid| !objects.contains(solid)).map(|solid| ("bead", "flange bead".to_owned(), solid));
    let named = scenario.duct.objects.iter().zip(&objects).enumerate().map(|(i, (object, solid))| {
        let name = if object.name.is_empty() { format!("object {i}") } else { object.name.clone() };
        ("object", name, solid)
    });
    // A solid that reaches into several cells is listed with each, and a bead's bars on floor and ceiling have one plan.
    let mut drawn = BTreeSet::new();
    for (class, title, solid) in beads.chain(named) {
        let outline = scale.path(hull(&solid.corners), true);
        let path = format!(r#"<path class="{class}" d="{outline}"><title>{}</title></path>"#, escaped(&title));
        if class == "object" || !drawn.contains(&path) {
            writeln!(out, "{path}")?;
            drawn.insert(path);
        }
    }
    Ok(())
}

/// The convex outline of points from above, anticlockwise (Andrew's monotone chain).
pub(super) fn hull(points: &[Point3<f64>]) -> Vec<Point2<f64>> {
    let mut sorted: Vec<Point2<f64>> = points.iter().map(Point3::xy).collect();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(point - a)) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        // The last point is the first of the other chain.
        chain.pop();
        chain
    };
    let mut outline = chain(&mut sorted.iter().copied());
    outline.extend(chain(&mut sorted.iter().rev().copied()));
    outline
}

fn place(scale: &Scale, frame: &FrameRecord) -> [f64; 2] {
    let base = frame.truth.world_from_base.translation;
    scale.at(base.x, base.y)
}

/// A point beside the reference path, from above.
fn on_path(network: &Network, along_m: f64, left_m: f64) -> Point2<f64> {
    (network.centreline.pose_at(along_m) * Point3::new(0.0, left_m, 0.0)).xy()
}

/// What of a wall's plan is sheet metal: its length without its portals.
pub(super) fn wall_pieces(face: &Face) -> Vec<[Point2<f64>; 2]> {
    let along = nalgebra::Vector2::new(-face.plane.normal.y, face.plane.normal.x);
    let span = |outline: &[Point3<f64>]| {
        let places = || outline.iter().map(|p| p.xy().coords.dot(&along));
        [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
    };
    let Some(first) = face.outline.first() else { return Vec::new() };
    let at = |place: f64| first.xy() + along * (place - first.xy().coords.dot(&along));
    let mut portals: Vec<[f64; 2]> = face.portals.iter().map(|portal| span(&portal.outline)).collect();
    portals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [mut from, to] = span(&face.outline);
    let mut pieces = Vec::new();
    for [opens, closes] in portals.into_iter().chain([[to, to]]) {
        if opens > from + 1e-6 {
            pieces.push([at(from), at(opens)]);
        }
        from = f64::max(from, closes);
    }
    pieces
}

/// The base's path, its colour by how sure the navigator was.
fn draw_path(out: &mut String, scale: &Scale, run: &RunRecord) -> std::fmt::Result {
    let class = |state: State| match state {
        State::Unknown | State::Tracking => "truth",
        State::Degraded => "degraded",
        State::Coasting => "coasting",
        State::Stopped => "stopped",
    };
    let mut from = 0;
    for piece in run.frames.chunk_by(|a, b| class(a.state) == class(b.state)) {
        // Each piece goes on to the beginning of the next, so that the path has no gaps.
        let to = (from + piece.len() + 1).min(run.frames.len());
        let places: Vec<_> = run.frames[from..to].iter().map(|frame| place(scale, frame)).map(|[u, v]| (u, Some(v))).collect();
        let path: String = thin(&places, 1500)
            .iter()
            .enumerate()
            .map(|(i, (u, v))| format!("{}{u:.1} {:.1}", if i == 0 { 'M' } else { 'L' }, v.unwrap_or(0.0)))
            .collect();
        writeln!(out, r#"<path class="line {}" d="{path}"/>"#, class(piece[0].state))?;
        from += piece.len();
    }
    Ok(())
}

fn draw_robots(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network, run: &RunRecord) -> std::fmt::Result {
    let (Some(first), Some(last)) = (run.frames.first(), run.frames.last()) else { return Ok(()) };
    let every_s = step(run.sim_time_s / ROBOTS);
    let gap = |a: &FrameRecord, b: &FrameRecord| {
        (a.truth.world_from_base.translation.vector - b.truth.world_from_base.translation.vector).norm()
    };
    let mut shown = vec![first];
    let mut next_s = every_s;
    for frame in &run.frames {
        if frame.time_s >= next_s {
            next_s = every_s * (libm::floor(frame.time_s / every_s) + 1.0);
            if gap(frame, shown[shown.len() - 1]) >= ROBOT_GAP_M && gap(frame, last) >= ROBOT_GAP_M {
                shown.push(frame);
            }
        }
    }
    shown.push(last);
    for (i, frame) in shown.iter().enumerate() {
        let class = if i == 0 || i + 1 == shown.len() { "robot end" } else { "robot" };
        writeln!(out, r#"<g class="{class}">"#)?;
        for (part, corners) in robot_plan::parts(&scenario.robot) {
            let corners = corners.map(|[x, y]| (frame.truth.world_from_base * Point3::new(x, y, 0.0)).xy());
            writeln!(out, r#"<path class="{part}" d="{}"/>"#, scale.path(corners, true))?;
        }
        let half_m = network.centreline.segment_at(frame.truth.distance_m).width_m / 2.0;
        let beside = on_path(network, frame.truth.distance_m, half_m + 13.0 / scale.per_m);
        let outward = beside - on_path(network, frame.truth.distance_m, 0.0);
        // Beside a wall that runs up the page the text must not reach back over it.
        let anchor = match outward.x / outward.norm() {
            right if right > 0.5 => "start",
            left if left < -0.5 => "end",
            _ => "middle",
        };
        let [u, v] = scale.at(beside.x, beside.y);
        let label = number(frame.time_s, if i + 1 == shown.len() { 3 } else { 2 });
        writeln!(out, r#"<text x="{u:.1}" y="{:.1}" text-anchor="{anchor}">{label} s</text></g>"#, v + 4.0)?;
    }
    Ok(())
}

fn draw_scale_bar(out: &mut String, scale: &Scale) -> std::fmt::Result {
    let length_m = step(60.0 / scale.per_m);
    let (y, length) = (scale.height - 12.0, length_m * scale.per_m);
    writeln!(out, r#"<path class="scale" d="M{MARGIN} {:.1}v6h{length:.1}v-6"/>"#, y - 6.0)?;
    writeln!(out, r#"<text x="{:.1}" y="{:.1}">{} m</text>"#, MARGIN + length + 8.0, y + 1.0, number(length_m, 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ductloop_duct::cell::{Beyond, Cell, Portal, Side, SurfaceId};

    #[test]
    fn the_outline_of_a_box_from_above_has_its_four_corners() {
        // Turned, so that the lower and the upper corners differ by rounding only.
        let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), 0.3);
        let corners = (0..8).map(|i| turn * Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let outline = hull(&corners.collect::<Vec<_>>());
        let area = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| a.coords.perp(&b.coords)).sum::<f64>() / 2.0;
        assert!((area - 1.0).abs() < 1e-12, "{area}");
        assert!((4..=8).contains(&outline.len()), "{outline:?}");
    }

    #[test]
    fn each_bead_and_each_object_is_drawn_once() {
        let scenario = Scenario::from_toml_str(
            "format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nbead_mm = 3\n\
             run = [{ straight_m = 2 }, { straight_m = 2 }]\n[[duct.object]]\nname = \"brick\"\nsize_m = [0.2, 0.1, 0.1]\nat_m = 2\n\
             [[duct.object]]\nsize_m = [0.1, 0.1, 0.1]\nat_m = 3\n",
        )
        .unwrap_or_else(|wrong| panic!("{wrong}"));
        let network = scenario.duct.network().expect("valid");
        let mut out = String::new();
        draw_solids(&mut out, &Scale::of(&network), &scenario, &network).expect("a string takes it");
        // Floor and ceiling, left, right; the one in the middle of the joint is in both cells.
        let count = |what: &str| out.matches(what).count();
        assert_eq!(
            [r#"class="object""#, "<title>brick<", "<title>object 1<", r#"class="bead""#].map(count),
            [2, 1, 1, 3],
            "{out}"
        );
    }

    #[test]
    fn a_wall_is_drawn_without_its_openings() {
        let plan = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point2::new(x, y));
        let outside = Side::Portal(Beyond::Outside);
        let mut cell = Cell::prism(&plan, 0.3, &[Side::Wall, outside, Side::Wall, outside], SurfaceId(0), 0);
        assert_eq!(wall_pieces(&cell.faces[2]), [[plan[0], plan[1]]]);
        assert!(wall_pieces(&cell.faces[3]).is_empty());
        let opening = [[0.5, 0.0], [0.8, 0.0], [0.8, 0.3], [0.5, 0.3]].map(|[x, z]| Point3::new(x, 0.0, z));
        let plane = cell.faces[2].plane;
        cell.faces[2].portals.push(Portal::new(&plane, opening.to_vec(), Beyond::Outside));
        let pieces: Vec<_> = wall_pieces(&cell.faces[2]).iter().map(|[a, b]| [a.x, b.x]).collect();
        for (piece, expected) in pieces.iter().zip([[0.0, 0.5], [0.8, 2.0]]) {
            assert!((piece[0] - expected[0]).abs() < 1e-12 && (piece[1] - expected[1]).abs() < 1e-12, "{pieces:?}");
        }
        assert_eq!(pieces.len(), 2);
    }
}
