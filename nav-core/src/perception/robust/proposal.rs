//! Which segments are which laser's stripes on which wall.
//!
//! A segment taken for the stripe of a laser holds the wall m . p = 1 to m . r = n . r / o at each of its points (see
//! [`super::stripe`]): two conditions. A wall that stands upright has two unknowns left, a level one (floor, ceiling) has one. So
//! one segment alone proposes an upright wall for each laser, and says whether it can be on a level one; two segments of two lasers
//! that propose the *same* wall are hardly there by chance. That agreement, tested by its chi-square, is what a wall is believed on.

use nalgebra::{Matrix2, Matrix2x3, Point3, Vector2, Vector3};

use super::super::Wall;
use super::chain::Segment;
use super::stripe::{Projector, StripePoint};
use crate::rig::Transform;

/// Limits of what a wall can be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest heading of the robot relative to a side wall, in radians.
    pub(super) max_heading_rad: f64,
    /// Least and greatest distance of a wall from the camera, in metres.
    pub(super) distance_m: [f64; 2],
}

/// The robot's directions, seen from the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upright {
    pub(super) base_from_camera: Transform,
    /// Up, and two level directions.
    pub(super) up: Vector3<f64>,
    level: [Vector3<f64>; 2],
    /// Height of the camera above the floor, in metres.
    pub(super) height_m: f64,
}

/// A wall that some segments propose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proposal {
    pub(super) wall: Wall,
    /// m of m . p = 1.
    pub(super) m: Vector3<f64>,
    /// Blocks of the segments that agree, a laser.
    pub(super) support: [usize; MOST_LASERS],
    /// Bits of the segments that agree.
    pub(super) segments: u64,
    /// Whether one laser's stripe alone is enough for it.
    pub(super) lone: bool,
    /// Mean square of the logarithm of their thickness over the expected one.
    thickness: f64,
    /// The nearest and the farthest of what they show of this wall, in the camera frame: what a wall ahead would hide.
    reach: [Vector3<f64>; 2],
}

/// What one segment, taken for one laser, says of an upright wall: normal equations, and the wall that it alone proposes.
#[derive(Clone, Copy, Debug)]
struct Reading {
    segment: usize,
    laser: usize,
    wall: Wall,
    information: Matrix2<f64>,
    right: Vector2<f64>,
    rest: f64,
    /// Logarithm of measured over expected thickness.
    thickness: f64,
    /// What it alone proposes.
    m: Vector3<f64>,
}

/// Lasers of a rig at most.
pub(super) const MOST_LASERS: usize = 4;
/// A segment's points are taken to scatter by this, and its line to be off by that, in pixels, whatever its residuals say.
const POINT_SIGMA_PX: f64 = 0.35;
const LINE_SIGMA_PX: f64 = 0.2;
/// Chi-square over two degrees of freedom beyond which two segments do not propose the same wall: four standard deviations, and
/// room for a rig that is a little off.
const AGREE_CHI2: f64 = 25.0;
/// A segment belongs to a wall if both its ends lie this near the stripe that the wall would show, in pixels.
const NEAR_PX: f64 = 1.5;
/// Both grow with the stripe's thickness, by this share of its standard deviation.
const THICK_SHARE: f64 = 0.1;
/// How far a stripe may be thicker or thinner than expected, as a factor.
const THICKNESS_FACTOR: f64 = 1.7;
/// Standard deviation of the logarithm of a segment's thickness over the expected one.
const THICKNESS_SIGMA: f64 = 0.2;
/// Share of a wall's distance beyond it at which something seen contradicts it.
const HIDDEN_SHARE: f64 = 0.1;
/// Light below the floor is none of this duct's, in metres.
const BELOW_FLOOR_M: f64 = 0.02;

impl Upright {
    pub(super) fn new(base_from_camera: Transform) -> Self {
        let back = base_from_camera.rotation.inverse();
        Self {
            base_from_camera,
            up: back * Vector3::z(),
            level: [back * Vector3::x(), back * Vector3::y()],
            height_m: base_from_camera.translation.vector.z,
        }
    }

    /// Which wall the plane m . p = 1 is, if it stands upright.
    pub(super) fn side(&self, m: &Vector3<f64>) -> Wall {
        let in_base = self.base_from_camera.rotation * m;
        if in_base.x > in_base.y.abs() {
            Wall::Ahead
        } else if in_base.y > 0.0 {
            Wall::Left
        } else {
            Wall::Right
        }
    }

    /// Whether the robot's heading against this upright wall is one that a robot in a duct can have.
    fn plausible(&self, m: &Vector3<f64>, wall: Wall, limits: &Limits) -> bool {
        let in_base = self.base_from_camera.rotation * m;
        let toward = match wall {
            Wall::Ahead => in_base.x,
            _ => in_base.y.abs(),
        };
        let distance_m = 1.0 / m.norm();
        toward >= libm::cos(limits.max_heading_rad) * m.norm()
            && (limits.distance_m[0]..=limits.distance_m[1]).contains(&distance_m)
    }
}

/// Finds walls, with room to work in.
#[derive(Clone, Debug, Default)]
pub(super) struct Proposer {
    readings: Vec<Reading>,
}

impl Proposer {
    /// The walls that the segments propose, the best supported first; each of the five at most once.
    pub(super) fn find(
        &mut self,
        segments: &[Segment],
        projector: &Projector,
        upright: &Upright,
        limits: &Limits,
        proposals: &mut Vec<Proposal>,
    ) {
        proposals.clear();
        self.readings.clear();
        for (index, segment) in segments.iter().enumerate() {
            for laser in 0..projector.lasers.len().min(MOST_LASERS) {
                self.readings.extend(read(index, segment, laser, projector, upright, limits));
            }
        }
        let mut taken = 0u64;
        loop {
            let mut best: Option<(f64, Proposal)> = None;
            let mut offer = |proposal: Proposal| {
                let score = score(&proposal);
                let hidden = proposals.iter().any(|known| hides(known, &proposal));
                if !hidden && best.as_ref().is_none_or(|(most, _)| score > *most) {
                    best = Some((score, proposal));
                }
            };
            let open = |wall: Wall, proposals: &[Proposal]| proposals.iter().all(|p| p.wall != wall);
            for (i, a) in self.readings.iter().enumerate().filter(|(_, a)| open(a.wall, proposals) && taken >> a.segment & 1 == 0)
            {
                for b in &self.readings[i + 1..] {
                    let pair = a.wall == b.wall && a.laser != b.laser && a.segment != b.segment && taken >> b.segment & 1 == 0;
                    if let Some(m) = pair.then(|| agree(a, b, upright)).flatten()
                        && upright.side(&m) == a.wall
                        && upright.plausible(&m, a.wall, limits)
                    {
                        offer(gather(a.wall, m, segments, taken, projector, upright));
                    }
                }
            }
            for (_, segment) in segments.iter().enumerate().filter(|(index, _)| taken >> index & 1 == 0) {
                for laser in 0..projector.lasers.len().min(MOST_LASERS) {
                    if let Some((wall, m)) = level(segment, laser, projector, upright, limits)
                        && open(wall, proposals)
                    {
                        offer(gather(wall, m, segments, taken, projector, upright));
                    }
                }
            }
            let Some((_, found)) = best.filter(|(score, p)| *score > 0.0 && p.segments != 0) else { break };
            taken |= found.segments;
            proposals.push(found);
            if proposals.len() == Wall::ALL.len() {
                break;
            }
        }
    }

    /// A side wall of which one laser's stripe alone is seen, where a wall that is known (`parallel`) or the stripe's thickness tells
    /// which laser it is. Not those in `taken`.
    pub(super) fn lone(
        &self,
        wall: Wall,
        taken: u64,
        parallel: Option<&Vector3<f64>>,
        segments: &[Segment],
        projector: &Projector,
        upright: &Upright,
    ) -> Option<Proposal> {
        let mut best: Option<Proposal> = None;
        for reading in self.readings.iter().filter(|r| r.wall == wall && taken >> r.segment & 1 == 0) {
            let heading = |m: &Vector3<f64>| {
                let in_base = upright.base_from_camera.rotation * m;
                libm::atan(in_base.x / in_base.y)
            };
            let fits = |r: &Reading| {
                !segments[r.segment].is_full
                    && r.thickness.abs() < LONE_THICKNESS
                    && parallel.is_none_or(|m| (heading(m) - heading(&r.m)).abs() < LONE_HEADING_RAD)
            };
            let others = self.readings.iter().filter(|r| r.segment == reading.segment && r.laser != reading.laser);
            let rivals = others.filter(|r| parallel.is_none() || r.wall != wall || fits(r)).count();
            if !fits(reading) || rivals > 0 || segments[reading.segment].blocks < LONE_BLOCKS {
                continue;
            }
            let found = gather(wall, reading.m, segments, taken, projector, upright);
            // Another stripe that could be the second of this wall, and is not where it would have to be, contradicts it.
            let contradicted = self.readings.iter().any(|other| {
                other.wall == wall
                    && other.laser != reading.laser
                    && (taken | found.segments) >> other.segment & 1 == 0
                    && segments[other.segment].blocks >= LONE_BLOCKS / 2
            });
            if !contradicted && found.segments != 0 && best.is_none_or(|b| total(&b) < total(&found)) {
                best = Some(Proposal { lone: true, ..found });
            }
        }
        best
    }
}

/// What a lone stripe must be: so long, so thick (as a logarithm), so nearly parallel to the wall across.
const LONE_BLOCKS: usize = 16;
const LONE_THICKNESS: f64 = 0.25;
const LONE_HEADING_RAD: f64 = 0.035;

fn total(proposal: &Proposal) -> usize {
    proposal.support.iter().sum()
}

/// How well a wall is supported: by all segments on it, and most by those of a second laser; the less, the less its stripes are as
/// thick as they should be. Of walls in one direction the nearer hides the farther, which can only be seen mirrored in it.
fn score(proposal: &Proposal) -> f64 {
    let mut support = proposal.support;
    support.sort_unstable_by_key(|blocks| std::cmp::Reverse(*blocks));
    let (first, second) = (support[0] as f64, support[1] as f64);
    let level = matches!(proposal.wall, Wall::Floor | Wall::Ceiling);
    // A level wall is tested by one condition of each segment on it; an upright one by those of the second alone.
    let agreed = if level { 0.5 * first + second } else { first.min(second) * 3.0 };
    let distance_m = 1.0 / proposal.m.norm();
    let alike = libm::exp(-0.5 * proposal.thickness / (THICKNESS_SIGMA * THICKNESS_SIGMA));
    (first + second + 2.0 * agreed) * alike / (1.0 + distance_m)
}

/// Whether one of two walls hides what is seen of the other: nothing is seen beyond a wall ahead.
fn hides(a: &Proposal, b: &Proposal) -> bool {
    let beyond = |ahead: &Proposal, other: &Proposal| {
        ahead.wall == Wall::Ahead && other.reach.iter().any(|point| ahead.m.dot(point) > 1.0 + HIDDEN_SHARE)
    };
    beyond(a, b) || beyond(b, a)
}

fn read(
    index: usize,
    segment: &Segment,
    laser: usize,
    projector: &Projector,
    upright: &Upright,
    limits: &Limits,
) -> Option<Reading> {
    let inverse_plane = projector.lasers[laser].inverse_plane;
    let thick = THICK_SHARE * segment.sigma_px;
    let variance = POINT_SIGMA_PX * POINT_SIGMA_PX * 2.0 / segment.blocks as f64 + LINE_SIGMA_PX * LINE_SIGMA_PX + thick * thick;
    let level = Matrix2x3::from_rows(&[upright.level[0].transpose(), upright.level[1].transpose()]);
    let (mut information, mut right, mut rest) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
    for ray in &segment.rays {
        let by_y = inverse_plane.dot(&projector.ray_by_scan(ray)[1]);
        let weight = 1.0 / (by_y * by_y * variance);
        let inverse_depth = inverse_plane.dot(ray);
        let row: Vector2<f64> = level * ray;
        information += row * row.transpose() * weight;
        right += row * (weight * inverse_depth);
        rest += weight * inverse_depth * inverse_depth;
    }
    let found = information.try_inverse()? * right;
    let m = level.transpose() * found;
    let wall = upright.side(&m);
    if !upright.plausible(&m, wall, limits) {
        return None;
    }
    let thickness = fits(segment, laser, &m, projector, upright)?;
    Some(Reading { segment: index, laser, wall, information, right, rest, thickness, m })
}

/// The upright wall that two readings share, if they do.
fn agree(a: &Reading, b: &Reading, upright: &Upright) -> Option<Vector3<f64>> {
    let right = a.right + b.right;
    let found = (a.information + b.information).try_inverse()? * right;
    let chi2 = a.rest + b.rest - found.dot(&right);
    (chi2 <= AGREE_CHI2).then(|| upright.level[0] * found[0] + upright.level[1] * found[1])
}

/// The level wall that a segment may be on.
fn level(
    segment: &Segment,
    laser: usize,
    projector: &Projector,
    upright: &Upright,
    limits: &Limits,
) -> Option<(Wall, Vector3<f64>)> {
    let inverse_plane = projector.lasers[laser].inverse_plane;
    let mut height = 0.0;
    // The weights hang on the plane, a little: twice suffices.
    for _ in 0..2 {
        let (mut information, mut right) = (0.0, 0.0);
        for ray in &segment.rays {
            let by_y = (inverse_plane - upright.up * height).dot(&projector.ray_by_scan(ray)[1]);
            let weight = 1.0 / (by_y * by_y).max(1e-12);
            let along = upright.up.dot(ray);
            information += weight * along * along;
            right += weight * along * inverse_plane.dot(ray);
        }
        height = right / information;
    }
    if !height.is_finite() || !(limits.distance_m[0]..=limits.distance_m[1]).contains(&(1.0 / height.abs())) {
        return None;
    }
    let m = upright.up * height;
    let wall = if height > 0.0 { Wall::Ceiling } else { Wall::Floor };
    if wall == Wall::Floor && (-1.0 / height - upright.height_m).abs() > 2.0 * BELOW_FLOOR_M {
        return None;
    }
    let near = segment.ends.iter().all(|end| near(end, laser, &m, projector));
    (near && fits(segment, laser, &m, projector, upright).is_some()).then_some((wall, m))
}

fn near([x, y]: &[f64; 2], laser: usize, m: &Vector3<f64>, projector: &Projector) -> bool {
    let within = |stripe: StripePoint| (stripe.y_px - y).abs() <= NEAR_PX + THICK_SHARE * stripe.sigma_px;
    projector.stripe(laser, m, *x, *y).is_some_and(within)
}

/// Whether a segment can be the stripe of this laser on this wall: lit, above the floor, as thick as that. The logarithm of its
/// thickness over the expected one; of an overexposed one 0, unless it is too thin.
fn fits(segment: &Segment, laser: usize, m: &Vector3<f64>, projector: &Projector, upright: &Upright) -> Option<f64> {
    let mut expected = 0.0;
    for [x, y] in &segment.ends {
        let stripe = projector.stripe(laser, m, *x, *y)?;
        let in_base: Point3<f64> = upright.base_from_camera * stripe.point;
        if in_base.z < -BELOW_FLOOR_M {
            return None;
        }
        expected += stripe.sigma_px / 2.0;
    }
    // The blocks smear a stripe that runs at a slope over four columns.
    let [[x0, y0], [x1, y1]] = segment.ends;
    let slope = (y1 - y0) / (x1 - x0).max(1.0);
    let expected = (expected * expected + 16.0 / 12.0 * slope * slope).sqrt();
    let ratio = libm::log(segment.sigma_px / expected);
    if segment.is_full {
        // Cut off at its top it seems thicker than it is: that it is thick says nothing.
        return (ratio >= -libm::log(THICKNESS_FACTOR)).then_some(ratio.min(0.0));
    }
    (ratio.abs() <= libm::log(THICKNESS_FACTOR)).then_some(ratio)
}

/// All segments that lie on a wall.
fn gather(wall: Wall, m: Vector3<f64>, segments: &[Segment], taken: u64, projector: &Projector, upright: &Upright) -> Proposal {
    let mut proposal =
        Proposal { wall, m, support: [0; MOST_LASERS], segments: 0, lone: false, thickness: 0.0, reach: [Vector3::zeros(); 2] };
    let mut range = [0.0, f64::INFINITY];
    for (index, segment) in segments.iter().enumerate().filter(|(index, _)| taken >> index & 1 == 0) {
        for laser in 0..projector.lasers.len().min(MOST_LASERS) {
            if !segment.ends.iter().all(|end| near(end, laser, &m, projector)) {
                continue;
            }
            let Some(thickness) = fits(segment, laser, &m, projector, upright) else { continue };
            proposal.support[laser] += segment.blocks;
            proposal.segments |= 1 << index;
            proposal.thickness += segment.blocks as f64 * thickness * thickness;
            for ray in &segment.rays {
                let inverse_depth = m.dot(ray);
                if inverse_depth > range[0] {
                    (range[0], proposal.reach[0]) = (inverse_depth, ray / inverse_depth);
                }
                if inverse_depth < range[1] {
                    (range[1], proposal.reach[1]) = (inverse_depth, ray / inverse_depth);
                }
            }
            break;
        }
    }
    proposal.thickness /= (total(&proposal) as f64).max(1.0);
    proposal
}

#[cfg(test)]
mod tests {
    use super::super::test_rig::rig;
    use super::*;

    const LEFT: [f64; 3] = [-4.0, 0.0, 0.0];

    /// What is taken for a wall on the stripe of laser `low` on the left wall alone, 0.25 m from the camera, `thicker` than it should be.
    fn alone(is_full: bool, thicker: f64, parallel: Option<&Vector3<f64>>) -> Option<Proposal> {
        let rig = rig();
        let (projector, m) = (Projector::new(&rig, 0.6, 0.8), Vector3::from(LEFT));
        let upright = Upright::new(rig.mount.base_from_camera(rig.mount.rest));
        let limits = Limits { max_heading_rad: 0.6, distance_m: [0.03, 4.0] };
        let at = |x: f64| projector.stripe(0, &m, x, 240.0).map(|stripe| ([x, stripe.y_px], stripe.ray, stripe.sigma_px));
        let [Some(from), Some(to)] = [at(20.0), at(180.0)] else { return None };
        let segment = Segment {
            ends: [from.0, to.0],
            rays: [from.1, to.1],
            blocks: 40,
            sigma_px: thicker * (from.2 + to.2) / 2.0,
            residual_px: 0.1,
            is_full,
        };
        let (mut proposer, mut proposals) = (Proposer::default(), Vec::new());
        proposer.find(&[segment], &projector, &upright, &limits, &mut proposals);
        assert!(proposals.is_empty(), "one stripe, and not alone: {proposals:?}");
        proposer.lone(Wall::Left, 0, parallel, &[segment], &projector, &upright)
    }

    /// A lone stripe is known for its laser's by its thickness. One that is cut off at its top has none to be known by: it seems thicker
    /// than it is, and any laser's stripe could seem so. So it is never taken alone, not even where it is as thick as it should be.
    #[test]
    fn an_overexposed_stripe_is_never_taken_alone() {
        for parallel in [None, Some(Vector3::from(LEFT) * -1.0)] {
            let found = alone(false, 1.0, parallel.as_ref()).expect("as thick as it should be");
            assert!(found.lone && found.support[0] == 40, "{found:?}");
            assert!((found.m - Vector3::from(LEFT)).norm() < 1e-6, "{found:?}");
            for thicker in [1.0, 1.2, 1.6, 3.0] {
                assert!(alone(true, thicker, parallel.as_ref()).is_none(), "full and {thicker} times as thick");
            }
        }
        assert!(alone(false, 1.6, None).is_none(), "not as thick as it should be");
    }
}
