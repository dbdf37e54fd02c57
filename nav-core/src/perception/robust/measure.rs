//! A wall's stripe measured column by column, and cleaned of what does not belong to it.

use super::centre::{self, Expected, Fitted, Noise};
use super::chain::Segment;
use super::overexposed;
use super::stripe::{Projector, StripePoint};
use super::view::View;
use nalgebra::Vector3;

/// A centre as measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Column and row in scan coordinates.
    pub(super) x_px: f64,
    pub(super) y_px: f64,
    /// Standard deviation of the row.
    pub(super) sigma_px: f64,
    /// Its ray, and that ray's inverse depth on the laser's plane.
    pub(super) ray: Vector3<f64>,
    pub(super) inverse_depth: f64,
    /// How the ray changes down the column, a pixel.
    pub(super) ray_by_y: Vector3<f64>,
    pub(super) laser: usize,
    /// Thickness of the stripe there (standard deviation), in pixels.
    pub(super) thickness_px: f64,
    /// Deviation of the error that centres of its kind have in common, in pixels.
    pub(super) common_px: f64,
    /// Deviation with which it counts in a plane: as large as makes the mean of many that err alike no surer than it is.
    pub(super) counts_px: f64,
    /// Distance from the row that the wall as proposed predicts.
    pub(super) off_px: f64,
    /// Columns before it in which the stripe was looked for and not found.
    pub(super) misses: u32,
}

/// Where another stripe is: a line in scan coordinates, from x to x, and its thickness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbour {
    pub(super) ends: [[f64; 2]; 2],
    pub(super) sigma_px: f64,
}

impl Neighbour {
    pub(super) fn of(segment: &Segment) -> Self {
        Self { ends: segment.ends, sigma_px: segment.sigma_px }
    }

    /// Its row in column `x`, where it is or nearly is.
    fn row(&self, x: f64) -> Option<f64> {
        let [[x0, y0], [x1, y1]] = self.ends;
        let beyond = BESIDE_PX + 2.0 * self.sigma_px;
        (x >= x0 - beyond && x <= x1 + beyond).then(|| y0 + (y1 - y0) * (x - x0) / (x1 - x0).max(1.0))
    }
}

/// How far beyond its seen ends another stripe is reckoned with, in pixels.
const BESIDE_PX: f64 = 6.0;
/// Nearer than this many standard deviations of both, another stripe moves a centre.
const CROWDED: f64 = 3.0;
/// A stripe stands out of the noise by so many standard deviations of its height.
const LEAST_SNR: f64 = 3.0;
/// A column whose light is no Gaussian has squared residuals larger than the first; where it is used all the same, its middle is as
/// much less sure. Beyond the second there is no stripe.
const MOST_CHI2: [f64; 2] = [4.0, 40.0];
/// A centre may be off the proposed wall's by this, in pixels and in standard deviations of the light.
const GATE: [f64; 2] = [1.2, 0.35];
/// More such columns than this, as a share of the others, are uneven light and not what stands in the way.
const UNEVEN_SHARE: f64 = 0.33;
/// Middles between flanks may be off alike by this share of the light's standard deviation, times the square of the flanks' distance from
/// the middle in standard deviations: chosen so that `incra1`'s errors at 12 and 30 ms, with ghosts, bounce and blooming, are as stated.
const FLANK_SHARE: f64 = 0.02;
/// Over so many columns such errors are alike.
const ALIKE_COLUMNS: f64 = 100.0;
/// Centres of columns whose light is no Gaussian may be off alike by this share of its standard deviation.
const UNLIKE_SHARE: f64 = 0.03;
/// Columns for which a stripe is predicted anew.
const NODE_EVERY: usize = 8;
/// Share of a centre's distance from where it was sought that the next search begins farther on.
const DRIFT_GAIN: f64 = 0.3;
/// Columns for which a bias is worked out anew.
const BIAS_EVERY: usize = 8;
/// Centres farther than this off the stripe's own line, in robust standard deviations, do not belong to it.
const OUTLIER: f64 = 3.5;
/// So many columns in which it was looked for in vain are the end of a piece of a stripe.
const END_COLUMNS: u32 = 4;
/// At its ends a stripe is cut slantwise by the edge of its wall, and meets the stripe on the next: so many columns go, and so many
/// more for a standard deviation of its light.
const GUARD: [f64; 2] = [4.0, 6.0];

/// A stripe to be measured, and what it is measured with.
pub(super) struct Search<'a> {
    pub(super) view: &'a View<'a>,
    pub(super) projector: &'a Projector,
    /// The wall as proposed, m . p = 1.
    pub(super) m: &'a Vector3<f64>,
    pub(super) laser: usize,
    /// From which column and to which.
    pub(super) columns: [usize; 2],
    pub(super) neighbours: &'a [Neighbour],
    pub(super) noise: &'a Noise,
}

impl Search<'_> {
    /// Appends the stripe's centres to `points`; `room` is to work in. Columns whose light is no Gaussian are left out (another stripe
    /// crosses, a wall ends), unless so many are that the wall's light must be uneven all along.
    pub(super) fn measure(&self, room: &mut Vec<f64>, points: &mut Vec<Point>) {
        let first = points.len();
        let mut tally = self.follow(MOST_CHI2[0], room, points);
        let count = points.len() - first;
        if f64::from(tally.unlike) > UNEVEN_SHARE * count as f64 {
            points.truncate(first);
            tally = self.follow(MOST_CHI2[1], room, points);
        }
        clean(points, first, tally.misses);
    }

    /// One pass over the columns, appending a centre for each whose squared residuals are `most_chi2` at most.
    fn follow(&self, most_chi2: f64, room: &mut Vec<f64>, points: &mut Vec<Point>) -> Tally {
        let Self { view, projector, m, laser, columns: [from, to], neighbours, noise } = *self;
        let mut guess_px = projector.size[1] as f64 / 2.0;
        let mut amplitude: Option<f64> = None;
        let mut bias = (usize::MAX, [0.0; 2]);
        let mut tally = Tally::default();
        let mut slope = None;
        // How far the stripe runs off the proposed wall's: the search begins there.
        let mut drift_px = 0.0;
        let mut nodes: (usize, Option<[StripePoint; 2]>) = (usize::MAX, None);
        for x in from..to {
            // Predicted every few columns, in between on straight lines.
            if nodes.0 != x / NODE_EVERY {
                let first = x - x % NODE_EVERY;
                let node = |x: usize, guess_px: f64| projector.stripe(laser, m, x as f64, guess_px);
                let pair = node(first, guess_px).and_then(|a| Some([a, node(first + NODE_EVERY, a.y_px)?]));
                nodes = (x / NODE_EVERY, pair);
            }
            let Some([a, b]) = nodes.1 else { continue };
            guess_px = b.y_px;
            let share = (x % NODE_EVERY) as f64 / NODE_EVERY as f64;
            let stripe =
                Predicted { y_px: a.y_px + share * (b.y_px - a.y_px), sigma_px: a.sigma_px + share * (b.sigma_px - a.sigma_px) };
            let sigma = stripe.sigma_px;
            let crowded = neighbours.iter().any(|other| {
                other.row(x as f64).is_some_and(|row| (row - stripe.y_px).abs() < CROWDED * (sigma + other.sigma_px))
            });
            if crowded {
                continue;
            }
            let height = amplitude.unwrap_or_else(|| standing(view, x, &stripe));
            let sought = Expected { y_px: stripe.y_px + drift_px, sigma_px: sigma, amplitude: height, slope };
            let near = |y_px: f64| (y_px - stripe.y_px).abs() <= GATE[0] + GATE[1] * sigma;
            let stands = |found: &Fitted| found.amplitude >= LEAST_SNR * found.amplitude_sigma && near(found.y_px);
            let found = centre::fit(view, x, &sought, noise, room).filter(stands);
            let measured = if let Some(found) = found.filter(|found| found.chi2 <= MOST_CHI2[0]) {
                slope = Some(found.slope);
                // The height goes into the variances: smoothed, so that a column's own noise does not choose its weights.
                amplitude = Some(amplitude.map_or(found.amplitude, |before| before + 0.2 * (found.amplitude - before)));
                let (y_px, sigma_px) = (found.y_px, found.sigma_px);
                Some(Centre { y_px, sigma_px, cubic: found.cubic, common_px: 0.0, counts_px: sigma_px })
            } else if let Some(found) =
                overexposed::middle(view, x, sought.y_px, sigma, noise, room).filter(|found| near(found.y_px))
            {
                let cubic = found.half_width * found.half_width;
                // The fainter the flanks, the more of them is stray light, blooming and the wall's own slant.
                let common_px = FLANK_SHARE * cubic * sigma;
                let (y_px, sigma_px) = (found.y_px, found.sigma_px);
                let counts_px = (sigma_px * sigma_px + ALIKE_COLUMNS * common_px * common_px).sqrt();
                Some(Centre { y_px, sigma_px, cubic, common_px, counts_px })
            } else {
                tally.unlike += u32::from(found.is_some_and(|found| found.chi2 <= MOST_CHI2[1]));
                found.filter(|found| found.chi2 <= most_chi2).map(|found| {
                    let (y_px, sigma_px) = (found.y_px, found.sigma_px * found.chi2.sqrt());
                    // Here the sums over neighbours tell how alike they err.
                    Centre { y_px, sigma_px, cubic: found.cubic, common_px: UNLIKE_SHARE * sigma, counts_px: sigma_px }
                })
            };
            let Some(found) = measured else {
                tally.misses += 1;
                continue;
            };
            drift_px += DRIFT_GAIN * (found.y_px - stripe.y_px - drift_px);
            if bias.0 != x / BIAS_EVERY {
                bias = (x / BIAS_EVERY, unevenness(projector, m, laser, &stripe, x as f64));
            }
            let [linear, cubic] = bias.1;
            let y_px = found.y_px - sigma * (linear + cubic * found.cubic);
            let ray = projector.ray(x as f64, y_px);
            points.push(Point {
                x_px: x as f64,
                y_px,
                sigma_px: found.sigma_px,
                inverse_depth: projector.lasers[laser].inverse_plane.dot(&ray),
                ray_by_y: projector.ray_by_scan(&ray)[1],
                ray,
                laser,
                thickness_px: sigma,
                common_px: found.common_px,
                counts_px: found.counts_px,
                off_px: y_px - stripe.y_px,
                misses: tally.misses,
            });
        }
        tally
    }
}

/// What a pass over the columns met.
#[derive(Clone, Copy, Default)]
struct Tally {
    /// Columns without a centre.
    misses: u32,
    /// Columns with a stripe that is no Gaussian and has no flanks either.
    unlike: u32,
}

/// A column's middle, whichever way it was found.
struct Centre {
    y_px: f64,
    sigma_px: f64,
    /// See [`Fitted::cubic`].
    cubic: f64,
    common_px: f64,
    counts_px: f64,
}

/// Where a stripe is expected in a column, and how thick.
struct Predicted {
    y_px: f64,
    sigma_px: f64,
}

/// Height of what stands at a stripe's place above the least of its column there.
fn standing(view: &View<'_>, x: usize, stripe: &Predicted) -> f64 {
    let reach = 3.0 * stripe.sigma_px + 2.0;
    let row = |y: f64| y.clamp(0.0, view.size[1] as f64) as usize;
    let (mut least, mut most) = (f64::INFINITY, 1.0);
    view.column(x, row(stripe.y_px - reach), row(stripe.y_px + reach), |_, value| {
        least = f64::min(least, value);
        most = f64::max(most, value);
    });
    (most - least).max(1.0)
}

/// How a stripe's light departs from an even Gaussian about its middle, as coefficients of t/s and (t/s)^3: across the stripe the
/// wall comes nearer, so that the light falls more squarely and is narrower and the pixels see more of it. A matt wall is assumed.
fn unevenness(projector: &Projector, m: &Vector3<f64>, laser: usize, stripe: &Predicted, x: f64) -> [f64; 2] {
    let log_light = |t: f64| projector.log_light(laser, m, x, stripe.y_px + t);
    let odd = |t: f64| (log_light(t) - log_light(-t)) / 2.0;
    let (near, far) = (odd(stripe.sigma_px), odd(2.0 * stripe.sigma_px));
    let cubic = (far - 2.0 * near) / 6.0;
    [near - cubic, cubic]
}

/// Drops the centres from `first` on that do not lie on one line with the rest, and those at the ends of its pieces, where the light
/// of the next wall, or a shadow's edge, has part in them. The image's border is no such end, nor is a crossing stripe. `misses` is
/// the count of columns without a centre in all.
fn clean(points: &mut Vec<Point>, first: usize, misses: u32) {
    let mut line = (0.0, 0.0, 0.0);
    let mut limit = f64::INFINITY;
    for _ in 0..4 {
        let kept = |p: &&Point| (p.off_px - line.0 - line.1 * (p.x_px - line.2)).abs() <= limit.max(OUTLIER * p.sigma_px);
        let (mut n, mut x, mut y) = (0.0, 0.0, 0.0);
        points[first..].iter().filter(kept).for_each(|p| (n, x, y) = (n + 1.0, x + p.x_px, y + p.off_px));
        if n < 3.0 {
            points.truncate(first);
            return;
        }
        let (x, y) = (x / n, y / n);
        let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
        points[first..].iter().filter(kept).for_each(|p| {
            let (dx, dy) = (p.x_px - x, p.off_px - y);
            (sxx, sxy, syy) = (sxx + dx * dx, sxy + dx * dy, syy + dy * dy);
        });
        let slope = if sxx > 0.0 { sxy / sxx } else { 0.0 };
        line = (y, slope, x);
        limit = OUTLIER * ((syy - slope * sxy).max(0.0) / n).sqrt();
    }
    let belongs = |p: &Point| (p.off_px - line.0 - line.1 * (p.x_px - line.2)).abs() <= limit.max(OUTLIER * p.sigma_px);
    let mut lost = 0;
    let mut write = first;
    for read in first..points.len() {
        let mut point = points[read];
        if belongs(&point) {
            point.misses += lost;
            points[write] = point;
            write += 1;
        } else {
            lost += 1;
        }
    }
    points.truncate(write);
    trim(points, first, misses + lost);
}

/// Drops the ends of the pieces that misses cut a stripe into.
fn trim(points: &mut Vec<Point>, first: usize, misses: u32) {
    let (mut write, mut from, mut before) = (first, first, 0);
    while from < points.len() {
        let cut = |i: usize| i + 1 < points.len() && points[i + 1].misses - points[i].misses >= END_COLUMNS;
        let to = (from..points.len()).find(|i| cut(*i)).map_or(points.len(), |i| i + 1);
        let after = points.get(to).map_or(misses, |point| point.misses);
        let (start, end) = (points[from], points[to - 1]);
        for i in from..to {
            let point = points[i];
            let guard = GUARD[0] + GUARD[1] * point.thickness_px;
            let inside = (start.misses == before || point.x_px - start.x_px >= guard)
                && (after == end.misses || end.x_px - point.x_px >= guard);
            if inside {
                points[write] = point;
                write += 1;
            }
        }
        // The misses between two pieces belong to both their ends.
        (from, before) = (to, end.misses);
    }
    points.truncate(write);
}
