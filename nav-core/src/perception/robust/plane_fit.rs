//! The plane of a wall from all centres of its stripes, and its covariance.
//!
//! A centre whose row is off by e pixels is off the wall m . p = 1 by
//!
//! n . r / o - m . r = l . r = (l . r') e,  l = n / o - m,
//!
//! so in pixels e = l . r / (l . r'), whose derivative by m is -r / (l . r') with r taken on the stripe (e = 0). Weighted by the
//! centres' deviations, least squares over m (Gauss-Newton) is the maximum-likelihood estimate. Two things more are known. Walls stand
//! upright (floors and ceilings lie level), up to a small lean: prior conditions on m. And all centres of a stripe
//! may be off by one common error (light that is not as even as assumed, a filter that is not as symmetric): an unknown of its own for
//! each stripe, with a prior deviation, eliminated from the normal equations (Schur complement). Where the centres scatter more than
//! they say, or err alike over runs of columns, they are taken for as much less sure.

use nalgebra::{Matrix3, Vector3};

use super::super::Wall;
use super::measure::Point;
use super::proposal::{MOST_LASERS, Upright};
use super::stripe::Projector;

/// What is known beforehand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Priors {
    /// Standard deviation of a wall's lean, in radians.
    pub(super) lean_rad: f64,
    /// Standard deviation of the floor's height below the camera, in metres.
    pub(super) floor_m: f64,
    /// Standard deviation of a stripe's common error: in pixels, and as a share of its thickness (standard deviation).
    pub(super) offset: [f64; 2],
}

/// A wall's plane, m . p = 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) m: Vector3<f64>,
    pub(super) covariance: Matrix3<f64>,
    /// Centres of each laser's stripe.
    pub(super) counts: [usize; MOST_LASERS],
    /// Chi-square of the stripes' common errors and the lean against their priors, allowing for centres that scatter more than they
    /// say: how well the stripes of two lasers agree.
    pub(super) disagreement: f64,
}

/// Times that the weights, which hang on the plane, are renewed.
const ROUNDS: usize = 3;

/// Normal equations of one stripe.
#[derive(Clone, Copy, Debug)]
struct Stripe {
    mm: Matrix3<f64>,
    mo: Vector3<f64>,
    oo: f64,
    bm: Vector3<f64>,
    bo: f64,
    rest: f64,
    count: usize,
    thickness: f64,
    common: f64,
}

impl Default for Stripe {
    fn default() -> Self {
        Self {
            mm: Matrix3::zeros(),
            mo: Vector3::zeros(),
            oo: 0.0,
            bm: Vector3::zeros(),
            bo: 0.0,
            rest: 0.0,
            count: 0,
            thickness: 0.0,
            common: 0.0,
        }
    }
}

/// Fits `wall` to `points`, beginning at `m`. `None` where they do not span a plane.
pub(super) fn fit(
    wall: Wall,
    start: &Vector3<f64>,
    points: &[Point],
    projector: &Projector,
    upright: &Upright,
    priors: &Priors,
) -> Option<Plane> {
    let mut m = *start;
    for _ in 1..ROUNDS {
        m = solve(&add_up(&m, points, projector), &prior(wall, &m, upright, priors), upright, priors, 1.0)?.m;
    }
    let (stripes, prior) = (add_up(&m, points, projector), prior(wall, &m, upright, priors));
    let first = solve(&stripes, &prior, upright, priors, 1.0)?;
    // Both hold the centres' own scatter. What is known beforehand is as sure as before.
    let excess = scatter(&stripes, &first).max(likeness(&first, points, projector));
    let Solved { m, covariance, disagreement, .. } =
        if excess > 1.0 { solve(&stripes, &prior, upright, priors, excess)? } else { first };
    Some(Plane { m, covariance, counts: stripes.map(|stripe| stripe.count), disagreement })
}

/// A plane that the normal equations give.
struct Solved {
    m: Vector3<f64>,
    covariance: Matrix3<f64>,
    disagreement: f64,
    /// Each stripe's common error, in pixels: what its residuals are off by.
    offsets: [f64; MOST_LASERS],
}

/// Solves for the plane, the centres' variances taken `excess` times as large as they say.
fn solve(
    stripes: &[Stripe; MOST_LASERS],
    (prior_information, prior_right): &(Matrix3<f64>, Vector3<f64>),
    upright: &Upright,
    priors: &Priors,
    excess: f64,
) -> Option<Solved> {
    let (mut information, mut right) = (*prior_information, *prior_right);
    for stripe in stripes.iter().filter(|stripe| stripe.count > 0) {
        let oo = stripe.oo / excess + offset_weight(stripe, priors);
        information += stripe.mm / excess - stripe.mo * stripe.mo.transpose() / (oo * excess * excess);
        right += stripe.bm / excess - stripe.mo * (stripe.bo / (oo * excess * excess));
    }
    let scale = information.trace();
    if !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    let covariance = (information / scale).cholesky()?.inverse() / scale;
    let m = covariance * right;
    if !m.iter().all(|value| value.is_finite()) {
        return None;
    }
    // Squares of the prior conditions: those of the floor's height have a constant, sure, besides.
    let constant = prior_right.norm() / upright.height_m;
    let mut disagreement = m.dot(&(prior_information * m)) - 2.0 * m.dot(prior_right) + constant;
    let mut offsets = [0.0; MOST_LASERS];
    for (stripe, offset) in stripes.iter().zip(&mut offsets).filter(|(stripe, _)| stripe.count > 0) {
        let weight = offset_weight(stripe, priors);
        *offset = (stripe.bo - stripe.mo.dot(&m)) / excess / (stripe.oo / excess + weight);
        disagreement += *offset * *offset * weight;
    }
    Some(Solved { m, covariance, disagreement, offsets })
}

fn offset_weight(stripe: &Stripe, priors: &Priors) -> f64 {
    let sigma = priors.offset[0] + (priors.offset[1] * stripe.thickness + stripe.common) / stripe.count as f64;
    1.0 / (sigma * sigma)
}

fn add_up(m: &Vector3<f64>, points: &[Point], projector: &Projector) -> [Stripe; MOST_LASERS] {
    let mut stripes = [Stripe::default(); MOST_LASERS];
    for point in points {
        let stripe = &mut stripes[point.laser];
        let by_y = (projector.lasers[point.laser].inverse_plane - m).dot(&point.ray_by_y);
        // Off the stripe as m has it, in pixels; and the ray of the stripe there. Taken at the measured ray instead, the noise of
        // the row would stand on both sides and draw l, which multiplies it, toward zero.
        let off_px = (point.inverse_depth - m.dot(&point.ray)) / by_y;
        let row = (point.ray - point.ray_by_y * off_px) / by_y;
        let value = row.dot(m) + off_px;
        let weight = 1.0 / (point.counts_px * point.counts_px);
        stripe.mm += row * row.transpose() * weight;
        stripe.mo += row * weight;
        stripe.oo += weight;
        stripe.bm += row * (weight * value);
        stripe.bo += weight * value;
        stripe.rest += weight * value * value;
        stripe.count += 1;
        stripe.thickness += point.thickness_px;
        stripe.common += point.common_px;
    }
    stripes
}

/// Normal equations of what is known of a wall beforehand: its lean, as conditions linear in m.
fn prior(wall: Wall, m: &Vector3<f64>, upright: &Upright, priors: &Priors) -> (Matrix3<f64>, Vector3<f64>) {
    let weight = 1.0 / (priors.lean_rad * priors.lean_rad * m.norm_squared());
    let upward = upright.up * upright.up.transpose();
    let level = Matrix3::identity() - upward;
    match wall {
        Wall::Left | Wall::Right | Wall::Ahead => (upward * weight, Vector3::zeros()),
        Wall::Ceiling => (level * weight, Vector3::zeros()),
        Wall::Floor => {
            // The robot stands on it: the point below the camera, at -height up, is on the floor.
            let below = upright.up * -upright.height_m;
            let sure = (upright.height_m / priors.floor_m) * (upright.height_m / priors.floor_m);
            (level * weight + below * below.transpose() * sure, below * sure)
        }
    }
}

/// Chi-square of the residuals, common errors left out, over their degrees of freedom; 1 or more.
fn scatter(stripes: &[Stripe; MOST_LASERS], solved: &Solved) -> f64 {
    let (m, mut chi2, mut freedom) = (&solved.m, 0.0, -3.0);
    for (stripe, offset) in stripes.iter().zip(&solved.offsets) {
        let squares = m.dot(&(stripe.mm * m)) - 2.0 * m.dot(&stripe.bm) + stripe.rest;
        chi2 += squares - 2.0 * offset * (stripe.bo - stripe.mo.dot(m)) + offset * offset * stripe.oo;
        freedom += stripe.count as f64;
    }
    (chi2 / freedom.max(1.0)).max(1.0)
}

/// By how much the centres' errors weigh more than they say, because neighbours err alike: light that is uneven over many columns
/// (spangles, dirt) moves them together, and their mean is then no better than that of a few. The squared sums of runs of columns over
/// what independent errors would give, for runs of several lengths; the greatest that chance does not explain.
fn likeness(solved: &Solved, points: &[Point], projector: &Projector) -> f64 {
    let m = &solved.m;
    let mut most: f64 = 1.0;
    for length in RUNS {
        let (mut squares, mut runs, mut at) = (0.0, 0.0, 0);
        while at < points.len() {
            let first = points[at];
            let last = |p: &Point| p.laser == first.laser && p.x_px - first.x_px < length;
            let (mut sum, mut count) = (0.0, 0.0);
            while at < points.len() && last(&points[at]) {
                let point = &points[at];
                let by_y = (projector.lasers[point.laser].inverse_plane - m).dot(&point.ray_by_y);
                let off_px = (point.inverse_depth - m.dot(&point.ray)) / by_y - solved.offsets[point.laser];
                sum += off_px / point.counts_px;
                count += 1.0;
                at += 1;
            }
            squares += sum * sum / count;
            runs += 1.0;
        }
        // Five unknowns are fitted to two stripes.
        let freedom = runs - 5.0;
        if freedom >= 3.0 {
            let ratio = squares / freedom;
            let by_chance = 1.0 + 4.0 * (2.0_f64 / freedom).sqrt();
            if ratio > by_chance {
                most = most.max(ratio);
            }
        }
    }
    most
}

/// Columns of the runs.
const RUNS: [f64; 3] = [6.0, 18.0, 54.0];

#[cfg(test)]
mod tests {
    use super::super::test_rig::rig;
    use super::*;

    const SIGMA_PX: f64 = 0.1;
    const PRIORS: Priors = Priors { lean_rad: 0.0035, floor_m: 0.002, offset: [0.05, 0.0] };

    /// Fits the left wall, 0.25 m from the camera, to stripes whose centres are off by `error(laser, column)`, in pixels.
    fn fitted(error: impl Fn(usize, usize) -> f64) -> Plane {
        let (rig, wall) = (rig(), Vector3::new(-4.0, 0.0, 0.0));
        let projector = Projector::new(&rig, 0.6, 0.8);
        let upright = Upright::new(rig.mount.base_from_camera(rig.mount.rest));
        let mut points = Vec::new();
        for laser in 0..2 {
            for x in 20..220 {
                let stripe = projector.stripe(laser, &wall, x as f64, 240.0).expect("a stripe");
                let y_px = stripe.y_px + error(laser, x);
                let ray = projector.ray(x as f64, y_px);
                points.push(Point {
                    x_px: x as f64,
                    y_px,
                    sigma_px: SIGMA_PX,
                    ray,
                    inverse_depth: projector.lasers[laser].inverse_plane.dot(&ray),
                    ray_by_y: projector.ray_by_scan(&ray)[1],
                    laser,
                    thickness_px: stripe.sigma_px,
                    common_px: 0.0,
                    counts_px: SIGMA_PX,
                    off_px: 0.0,
                    misses: 0,
                });
            }
        }
        fit(Wall::Left, &wall, &points, &projector, &upright, &PRIORS).expect("a plane")
    }

    /// As large as stated, and of another sign at each column.
    fn white(x: usize) -> f64 {
        if x.is_multiple_of(2) { SIGMA_PX } else { -SIGMA_PX }
    }

    #[test]
    fn without_errors_the_plane_is_the_wall() {
        let plane = fitted(|_, _| 0.0);
        assert!((plane.m - Vector3::new(-4.0, 0.0, 0.0)).norm() < 1e-9, "{:?}", plane.m);
        assert!(plane.disagreement < 1e-9);
    }

    /// An error that a stripe's centres have in common is allowed for once, by its own prior: it is no sign that neighbours err alike.
    #[test]
    fn a_common_error_does_not_count_twice() {
        let (even, offset) = (fitted(|_, x| white(x)), fitted(|laser, x| white(x) + [0.05, 0.05][laser]));
        let ratio = offset.covariance.trace() / even.covariance.trace();
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }

    /// Errors that are the same over 25 columns count as those of so many fewer centres.
    #[test]
    fn errors_that_neighbours_share_make_the_plane_less_sure() {
        let (even, alike) = (fitted(|_, x| white(x)), fitted(|_, x| white(x / 25)));
        let ratio = alike.covariance.trace() / even.covariance.trace();
        // Up to 25 times, less what the priors know.
        assert!((2.0..25.0).contains(&ratio), "{ratio}");
    }
}
