//! The robot's path on the plan of the duct, to scale.

use std::collections::BTreeSet;
use std::fmt::Write;

use ductloop_duct::cell::{FaceKind, Solid};
use ductloop_duct::network::Network;
use ductloop_nav::navigator::State;
use nalgebra::{Point2, Point3};

use super::floor_plan::{Room, Scale, hull, wall_pieces};
use super::plot::escaped;
use super::robot_plan;
use super::thinning::thin;
use super::ticks::step;
use crate::output::words::number;
use crate::record::{FrameRecord, RunRecord};
use crate::scenario::Scenario;

const MARGIN: f64 = 34.0;
/// The scale bar has its room below.
const ROOM: Room = Room { width: [1000.0; 2], height_max: 560.0, margin: MARGIN, below: 16.0, per_m_max: f64::INFINITY };
/// Robots shown at most, and the least distance from one to the next.
const ROBOTS: f64 = 10.0;
const ROBOT_GAP_M: f64 = 0.4;

/// The drawing.
pub(super) fn svg(scenario: &Scenario, network: &Network, run: &RunRecord) -> String {
    let scale = Scale::of(network, &ROOM);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = draw(&mut out, &scale, scenario, network, run);
    out
}

fn draw(out: &mut String, scale: &Scale, scenario: &Scenario, network: &Network, run: &RunRecord) -> std::fmt::Result {
    writeln!(
        out,
        r#"<svg class="plan" viewBox="0 0 {:.0} {:.1}" role="img" aria-label="Plan of the duct">"#,
        scale.width, scale.height
    )?;
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

fn place(scale: &Scale, frame: &FrameRecord) -> [f64; 2] {
    let base = frame.truth.world_from_base.translation;
    scale.at(&Point2::new(base.x, base.y))
}

/// A point beside the reference path, from above.
fn on_path(network: &Network, along_m: f64, left_m: f64) -> Point2<f64> {
    (network.centreline.pose_at(along_m) * Point3::new(0.0, left_m, 0.0)).xy()
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
        let [u, v] = scale.at(&beside);
        let label = number(frame.time_s, if i + 1 == shown.len() { 3 } else { 2 });
        writeln!(out, r#"<text x="{u:.1}" y="{:.1}" text-anchor="{anchor}">{label} s</text></g>"#, v + 4.0)?;
    }
    Ok(())
}

fn draw_scale_bar(out: &mut String, scale: &Scale) -> std::fmt::Result {
    let length_m = scale.bar_m();
    let (y, length) = (scale.height - 12.0, length_m * scale.per_m);
    writeln!(out, r#"<path class="scale" d="M{MARGIN} {:.1}v6h{length:.1}v-6"/>"#, y - 6.0)?;
    writeln!(out, r#"<text x="{:.1}" y="{:.1}">{} m</text>"#, MARGIN + length + 8.0, y + 1.0, number(length_m, 2))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        draw_solids(&mut out, &Scale::of(&network, &ROOM), &scenario, &network).expect("a string takes it");
        // Floor and ceiling, left, right; the one in the middle of the joint is in both cells.
        let count = |what: &str| out.matches(what).count();
        assert_eq!(
            [r#"class="object""#, "<title>brick<", "<title>object 1<", r#"class="bead""#].map(count),
            [2, 1, 1, 3],
            "{out}"
        );
    }
}
