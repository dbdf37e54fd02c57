//! Ducts that the robot comes into again, and what that says of the way between.
//!
//! Dead reckoning carries each duct's frame on from the one before, and each passage leaves something in doubt, mostly its turn
//! (`doubts`). Where a duct lies on one that is known, it is that one: two ducts of a level cannot lie in one place. Then both have one
//! middle line, and a place that was met in both (a corner, the wall of a dead end) is one place. The frames of all ducts between are
//! moved so that this holds, by least squares over the passages' doubts: this is a pose graph with a chain of passages and an edge a
//! closed loop (G. Grisetti et al., "A tutorial on graph-based SLAM", 2010), solved by taking in one edge after the other with the
//! covariance of all frames (a Kalman filter without motion, which for one linearisation is the same).
//!
//! A duct is taken for a known one only if
//! - the robot drove in both over one stretch, and their widths are one;
//! - direction (or the opposite one), middle line and a place met in both agree within three standard deviations of the doubt;
//! - and that doubt is small against the width (`SURE_WIDTHS`): with more, the next duct beside it might be meant.
//!
//! What it does not do: levels are not told apart, so ducts above each other would be taken for one; a loop whose doubt is too large stays
//! open; lengths of ducts stay as they were measured.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};

use crate::ahead::Fitting;
use crate::angle::wrap;
use crate::course::DuctRecord;
use crate::planar::{compose, inverse};

/// What a right angle leaves in doubt, in radians: mitred, and curved, whose end is seen last. Over the library's runs 0.3 and 2 degrees.
const MITRE_RAD: f64 = 0.01;
const ARC_RAD: f64 = 0.04;
/// An arc's radius is larger than this share of the width.
const ARC_WIDTHS: f64 = 0.55;
/// What any passage leaves in doubt: heading, in radians, and place, in metres; and odometry, as a share of the way.
const HEADING_RAD: f64 = 0.003;
const PLACE_M: f64 = 0.01;
const WAY_SHARE: f64 = 0.004;
/// How well a duct's middle, its direction and places in it are known, in metres and radians.
const MIDDLE_M: f64 = 0.005;
const DIRECTION_RAD: f64 = 0.005;
const CORNER_M: f64 = 0.02;
/// A branch that was passed: its middle hangs on how wide it is.
const PASSED_M: f64 = 0.05;
/// Widths of one duct differ by no more, in metres.
const SAME_WIDTH_M: f64 = 0.01;
/// The doubt may be so large a share of the width, and the middle lines so far apart.
const SURE_WIDTHS: f64 = 0.3;
const APART_WIDTHS: f64 = 0.4;
/// Within so many standard deviations things agree.
const AGREE: f64 = 3.0;
/// And turns within this in any case, in radians.
const MOST_TURN_RAD: f64 = 0.35;
/// Turns beyond this are the robot's own, on the spot, in radians.
const ROUND_RAD: f64 = 0.9 * PI;
/// Both were driven over at least so much of one stretch, in metres.
const OVERLAP_M: f64 = 0.3;

/// Two ducts that are one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closed {
    /// The one that was known, and the one in which the robot came to it again, by their numbers in the log.
    pub ducts: [usize; 2],
    /// Whether it was driven the other way the second time.
    pub is_opposite: bool,
    /// By how much they did not meet: along and across the first one, in metres, and in direction, in radians.
    pub misclosure: [f64; 3],
}

/// The frames of the ducts with the loops closed, and the loops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closure {
    /// Pose of each duct's zero in the frame of the first.
    pub first_from_duct: Vec<[f64; 3]>,
    /// What was closed, in the order in which the robot came to it.
    pub loops: Vec<Closed>,
}

/// A place on a duct's middle line that can be known again.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mark {
    along_m: f64,
    sigma_m: f64,
    is_wall: bool,
}

/// Poses, and the covariance of all of them in the frame of the first duct, by blocks.
struct Graph {
    poses: Vec<[f64; 3]>,
    covariance: Vec<Vec<Matrix3<f64>>>,
}

/// Closes what loops the ducts make. `now_m` is how far along the last one the robot is.
pub fn close(ducts: &[DuctRecord], now_m: f64) -> Closure {
    let mut graph = Graph { poses: Vec::new(), covariance: Vec::new() };
    let mut loops = Vec::new();
    for again in 0..ducts.len() {
        graph.push(ducts, again);
        // The first duct that it lies on; those that came to it later are closed with that one already.
        let edge = (0..again).find_map(|known| {
            let turned_round = known + 1 == again && ducts[known].turn_rad.abs() > ROUND_RAD;
            let edge = graph.edge(ducts, [known, again], now_m)?;
            (!turned_round).then_some((known, edge))
        });
        if let Some((known, (edge, is_opposite))) = edge {
            loops.push(Closed { ducts: [known, again], is_opposite, misclosure: (-edge.residual).into() });
            graph.take_in(known, again, &edge);
        }
    }
    Closure { first_from_duct: graph.poses, loops }
}

/// What a loop says: its residual (along, across, direction), its derivatives by both poses, and its variances.
struct Edge {
    residual: Vector3<f64>,
    by_known: Matrix3<f64>,
    by_again: Matrix3<f64>,
    variances: Vector3<f64>,
}

impl Graph {
    /// Hangs on the next duct, by the passage before it.
    fn push(&mut self, ducts: &[DuctRecord], next: usize) {
        let Some(last) = next.checked_sub(1) else {
            self.poses.push(ducts[0].first_from_duct);
            self.covariance.push(vec![Matrix3::zeros()]);
            return;
        };
        let relative = compose(inverse(ducts[last].first_from_duct), ducts[next].first_from_duct);
        let pose = compose(self.poses[last], relative);
        let (dx, dy) = (pose[0] - self.poses[last][0], pose[1] - self.poses[last][1]);
        let carried = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let row: Vec<Matrix3<f64>> = self.covariance[last].iter().map(|block| carried * block).collect();
        let (sin, cos) = libm::sincos(self.poses[last][2]);
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let doubt = Matrix3::from_diagonal(&doubts(&ducts[last]).map(|sigma| sigma * sigma));
        let own = carried * self.covariance[last][last] * carried.transpose() + turned * doubt * turned.transpose();
        for (block, before) in row.iter().zip(&mut self.covariance) {
            before.push(block.transpose());
        }
        self.covariance.push(row);
        self.covariance[next].push(own);
        self.poses.push(pose);
    }

    /// What it says that a duct is a known one, and whether it is driven the other way; `None` where it is not, or may not be.
    fn edge(&self, ducts: &[DuctRecord], [i, j]: [usize; 2], now_m: f64) -> Option<(Edge, bool)> {
        let (known, again) = (&ducts[i], &ducts[j]);
        let (width_m, other_m) = (known.width_m, again.width_m);
        let measured = known.width_deviation_m.is_some() && again.width_deviation_m.is_some();
        if !measured || (width_m - other_m).abs() > SAME_WIDTH_M {
            return None;
        }
        let [along_m, across_m, turn_rad] = compose(inverse(self.poses[i]), self.poses[j]);
        let is_opposite = turn_rad.abs() > FRAC_PI_2;
        let (way, off_rad) = if is_opposite { (-1.0, wrap(turn_rad - PI)) } else { (1.0, turn_rad) };

        let (sin, cos) = libm::sincos(self.poses[i][2]);
        let by_place = |sign: f64, by_turn: [f64; 2], turn: f64| {
            Matrix3::new(sign * cos, sign * sin, by_turn[0], -sign * sin, sign * cos, by_turn[1], 0.0, 0.0, turn)
        };
        let (by_known, by_again) = (by_place(-1.0, [across_m, -along_m], -1.0), by_place(1.0, [0.0; 2], 1.0));
        let cross = by_known * self.covariance[i][j] * by_again.transpose();
        let doubt = by_known * self.covariance[i][i] * by_known.transpose()
            + by_again * self.covariance[j][j] * by_again.transpose()
            + cross
            + cross.transpose();
        let sigma = |k: usize, own: f64| (doubt[(k, k)] + own * own).max(0.0).sqrt();
        let (across_sigma_m, turn_sigma_rad) = (sigma(1, MIDDLE_M), sigma(2, DIRECTION_RAD));
        let is_sure = across_sigma_m < SURE_WIDTHS * width_m;
        let agrees = across_m.abs() < (AGREE * across_sigma_m).min(APART_WIDTHS * width_m)
            && off_rad.abs() < (AGREE * turn_sigma_rad).min(MOST_TURN_RAD);
        if !is_sure || !agrees {
            return None;
        }
        // A place of both: where it is in the known one, less where it is in this one.
        let (marks, others) = (marks(ducts, i), marks(ducts, j));
        let pairs = marks.iter().flat_map(|a| others.iter().map(move |b| (a, b))).filter(|(a, b)| a.is_wall == b.is_wall);
        let gaps =
            pairs.map(|(a, b)| (a.along_m - way * b.along_m - along_m, (a.sigma_m * a.sigma_m + b.sigma_m * b.sigma_m).sqrt()));
        let (gap_m, gap_sigma_m) = gaps.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
        let along_sigma_m = sigma(0, gap_sigma_m);
        if gap_m.abs() > (AGREE * along_sigma_m).min(APART_WIDTHS * width_m) || along_sigma_m > SURE_WIDTHS * width_m {
            return None;
        }
        // Driven over one stretch.
        let zero_m = along_m + gap_m;
        let driven = |duct: &DuctRecord| [duct.from_m, duct.to_m.unwrap_or(now_m)];
        let (one, other) = (driven(known), driven(again).map(|at_m| zero_m + way * at_m));
        let overlap_m = one[0].max(one[1]).min(other[0].max(other[1])) - one[0].min(one[1]).max(other[0].min(other[1]));
        if overlap_m < OVERLAP_M {
            return None;
        }
        let variances = Vector3::new(gap_sigma_m, MIDDLE_M, DIRECTION_RAD).map(|sigma| sigma * sigma);
        let residual = Vector3::new(gap_m, -across_m, -off_rad);
        Some((Edge { residual, by_known, by_again, variances }, is_opposite))
    }

    /// Moves all frames so that a loop closes.
    fn take_in(&mut self, i: usize, j: usize, edge: &Edge) {
        let (by_known, by_again) = (edge.by_known.transpose(), edge.by_again.transpose());
        let gains: Vec<Matrix3<f64>> = self.covariance.iter().map(|row| row[i] * by_known + row[j] * by_again).collect();
        let innovation = edge.by_known * gains[i] + edge.by_again * gains[j] + Matrix3::from_diagonal(&edge.variances);
        let Some(weight) = innovation.try_inverse() else { return };
        for (pose, gain) in self.poses.iter_mut().zip(&gains) {
            let moved = gain * (weight * edge.residual);
            *pose = [pose[0] + moved.x, pose[1] + moved.y, wrap(pose[2] + moved.z)];
        }
        for (row, gain) in self.covariance.iter_mut().zip(&gains) {
            for (block, other) in row.iter_mut().zip(&gains) {
                *block -= gain * weight * other.transpose();
            }
        }
    }
}

/// What the way through a duct and the passage behind it leave in doubt, along, across and in direction, as standard deviations.
fn doubts(duct: &DuctRecord) -> Vector3<f64> {
    let turn_rad = duct.turn_rad.abs();
    if turn_rad > ROUND_RAD {
        // Turned round: the same duct, and its walls are seen.
        return Vector3::new(PLACE_M, MIDDLE_M, HEADING_RAD);
    }
    let is_arc = duct.radius_m > ARC_WIDTHS * duct.width_m;
    let share = turn_rad / FRAC_PI_2;
    let way_m = duct.to_m.map_or(0.0, |to_m| (to_m - duct.from_m).abs());
    Vector3::new(PLACE_M + WAY_SHARE * way_m, PLACE_M, HEADING_RAD + share * if is_arc { ARC_RAD } else { MITRE_RAD })
}

/// The corners, the middles of branches and the walls of a duct, where they were seen.
fn marks(ducts: &[DuctRecord], number: usize) -> Vec<Mark> {
    let (duct, before) = (&ducts[number], number.checked_sub(1).map(|before| &ducts[before]));
    let is_bend = |duct: &&DuctRecord| duct.turn_rad != 0.0 && duct.turn_rad.abs() < ROUND_RAD && duct.radius_m.is_finite();
    // From an arc's end to the corner of the lines that it touches.
    let tangent_m = |duct: &DuctRecord| duct.radius_m * libm::tan(duct.turn_rad.abs() / 2.0);
    let mark = |along_m: f64, sigma_m: f64, is_wall: bool| Mark { along_m, sigma_m, is_wall };
    let entered = before.filter(is_bend).map(|before| mark(-tangent_m(before), CORNER_M, false));
    let left = Some(duct).filter(is_bend).and_then(|duct| Some(mark(duct.to_m? + tangent_m(duct), CORNER_M, false)));
    let behind = before.filter(|before| before.turn_rad.abs() > ROUND_RAD && before.by == Some(Fitting::DeadEnd));
    let behind = behind.and_then(|_| Some(mark(duct.begin_m?, CORNER_M, true)));
    let met = duct.met.iter().filter_map(|met| match met.fitting {
        Fitting::Branch(_) | Fitting::Cross => Some(mark(met.at_m + duct.width_m / 2.0, PASSED_M, false)),
        Fitting::DeadEnd => Some(mark(met.at_m, CORNER_M, true)),
        _ => None,
    });
    entered.into_iter().chain(left).chain(behind).chain(met).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ahead::Side;
    use crate::course::Met;

    const WIDTH_M: f64 = 0.5;
    const RADIUS_M: f64 = 0.25;

    /// The log of a way of straights with mitred bends between them, each turn taken for `wrong_rad` more than it is. A length is from
    /// arc to arc, a turn in quarters, positive to the left.
    fn driven(way: &[(f64, f64)], wrong_rad: &dyn Fn(usize) -> f64) -> Vec<DuctRecord> {
        let mut zero = [0.0; 3];
        let mut ducts = Vec::new();
        for (number, (length_m, quarters)) in way.iter().enumerate() {
            let turn_rad = quarters * FRAC_PI_2 + if *quarters == 0.0 { 0.0 } else { wrong_rad(number) };
            ducts.push(DuctRecord {
                first_from_duct: zero,
                width_m: WIDTH_M,
                width_deviation_m: Some(1e-4),
                begin_m: Some(0.0),
                end_m: Some(*length_m),
                from_m: 0.0,
                to_m: Some(*length_m),
                by: Some(Fitting::Elbow(Side::Left)),
                turn_rad,
                radius_m: RADIUS_M,
                met: Vec::new(),
            });
            let (sin, cos) = libm::sincos(turn_rad.abs());
            let end = [length_m + RADIUS_M * sin, turn_rad.signum() * RADIUS_M * (1.0 - cos), turn_rad];
            zero = compose(zero, end);
        }
        ducts
    }

    /// Past a branch on the left at 1.5 m, round a ring of 2 m squares, and out of that branch back to where it began.
    fn ring(wrong_rad: &dyn Fn(usize) -> f64) -> Vec<DuctRecord> {
        let mut ducts = driven(&[(3.5, 1.0), (1.5, 1.0), (1.5, 1.0), (1.5, -1.0), (1.5, 0.0)], wrong_rad);
        ducts[0].met.push(Met { fitting: Fitting::Branch(Side::Left), at_m: 1.5 });
        ducts
    }

    fn off(pose: [f64; 3], truth: [f64; 3]) -> f64 {
        let (dx, dy) = (pose[0] - truth[0], pose[1] - truth[1]);
        (dx * dx + dy * dy).sqrt()
    }

    #[test]
    fn a_ring_that_was_driven_rightly_closes_and_stays_where_it_is() {
        let ducts = ring(&|_| 0.0);
        let closure = close(&ducts, 1.0);
        let [closed] = closure.loops[..] else { panic!("{:?}", closure.loops) };
        assert_eq!((closed.ducts, closed.is_opposite), ([0, 4], true));
        assert!(closed.misclosure.iter().all(|off| off.abs() < 1e-9), "{closed:?}");
        for (pose, duct) in closure.first_from_duct.iter().zip(&ducts) {
            assert!(off(*pose, duct.first_from_duct) < 1e-9);
        }
    }

    /// Two corners are each taken for a degree too much: closing the ring takes nearly all of the error out of the last duct, and most of
    /// it out of the corner farthest away.
    #[test]
    fn what_does_not_meet_is_spread_over_the_bends() {
        let (truth, wrong) = (ring(&|_| 0.0), ring(&|bend| if bend < 2 { 1.0_f64.to_radians() } else { 0.0 }));
        let closure = close(&wrong, 1.0);
        let [closed] = closure.loops[..] else { panic!("{:?}", closure.loops) };
        assert_eq!(closed.ducts, [0, 4]);
        assert!((closed.misclosure[2].to_degrees() - 2.0).abs() < 1e-6, "{closed:?}");
        let errors = |poses: &dyn Fn(usize) -> [f64; 3]| {
            (0..5).map(|duct| off(poses(duct), truth[duct].first_from_duct)).collect::<Vec<_>>()
        };
        let (before, after) = (errors(&|duct| wrong[duct].first_from_duct), errors(&|duct| closure.first_from_duct[duct]));
        println!("{before:?} {after:?}");
        assert!(after[4] < 0.25 * before[4], "{before:?} {after:?}");
        let most = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
        assert!(most(&after) < 0.6 * most(&before), "{before:?} {after:?}");
        let heading = closure.first_from_duct[4][2];
        assert!(wrap(heading - truth[4].first_from_duct[2]).abs() < 0.3_f64.to_radians(), "{heading}");
    }

    /// Ducts side by side, half a metre from middle to middle (their walls touch), of other widths, met nowhere, or driven over other
    /// stretches are not one.
    #[test]
    fn what_only_lies_beside_it_is_not_taken_for_it() {
        let beside = driven(&[(2.0, 1.0), (0.0, 1.0), (2.0, 0.0)], &|_| 0.0);
        assert_eq!(close(&beside, 2.0).loops, []);
        let mut other_width = ring(&|_| 0.0);
        other_width[4].width_m = 0.45;
        assert_eq!(close(&other_width, 1.0).loops, []);
        let mut met_nowhere = ring(&|_| 0.0);
        met_nowhere[0].met.clear();
        assert_eq!(close(&met_nowhere, 1.0).loops, []);
        // It turned into the known duct just now.
        let mut just_now = ring(&|_| 0.0);
        just_now[4].to_m = None;
        assert_eq!(close(&just_now, 0.1).loops, []);
    }

    /// A way of curved bends leaves too much in doubt: it might be the duct beside the known one.
    #[test]
    fn what_is_too_far_in_doubt_stays_open() {
        let way: Vec<(f64, f64)> = (0..7).map(|_| (6.0, 1.0)).collect();
        let mut ducts = driven(&way, &|_| 0.0);
        assert_eq!(close(&ducts, 1.0).loops.first().map(|closed| closed.ducts), Some([0, 4]));
        ducts.iter_mut().for_each(|duct| duct.radius_m = 0.75 * WIDTH_M);
        assert_eq!(close(&ducts, 1.0).loops, []);
    }
}
