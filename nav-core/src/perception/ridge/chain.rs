//! Centres of neighbouring columns to chains: a stripe goes on, a speck does not.
//!
//! A chain is followed from column to column by the place that its course so far leads one to expect. It may be curved, as a stripe is
//! behind a lens that distorts, and may miss a few columns; where it bends sharply it ends, and another one begins.

/// A centre in scan coordinates: a place where a filter answered at first, then with what it was fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Column, in pixels along the stripe.
    pub(super) x: usize,
    /// The centre, in pixels across the stripe.
    pub(super) y_px: f64,
    /// Where a filter answered, in whole pixels.
    pub(super) place: u32,
    /// The filter's contrast, in grey values.
    pub(super) contrast: f64,
    /// The stretch of the column that is its own, from the first value to one past the last.
    pub(super) span: [u32; 2],
    /// Its variance if the noise is what was assumed.
    pub(super) variance_px2: f64,
    /// Full width at half maximum, in pixels; of a filter, what it stands for.
    pub(super) fwhm_px: f64,
    /// Height above the background, in grey values.
    pub(super) height: f64,
    /// Squared residuals over their variance, and how many of them were free: none before it is measured.
    pub(super) chi2: f64,
    /// See `chi2`.
    pub(super) freedom: f64,
    /// Whether noise explains what the fit misses the values by.
    pub(super) is_explained: bool,
    /// The chain that it belongs to.
    pub(super) chain: u32,
}

impl Point {
    /// A place where a filter answered, not measured yet.
    pub(super) fn of_place(x: usize, place: usize, span: [usize; 2], contrast: f64, fwhm_px: f64) -> Self {
        Self {
            x,
            y_px: place as f64,
            place: place as u32,
            contrast,
            span: span.map(|y| y as u32),
            variance_px2: 1.0,
            fwhm_px,
            height: contrast,
            chi2: 0.0,
            freedom: 0.0,
            is_explained: false,
            chain: 0,
        }
    }

    /// Whether a Gaussian was fitted.
    pub(super) fn is_measured(&self) -> bool {
        self.freedom > 0.0
    }
}

/// A chain in the making, or made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chain {
    /// Columns of its first and last centre.
    pub(super) x: [usize; 2],
    /// Where its course has led to, in pixels, at its last column.
    y_px: f64,
    /// The course, in pixels a column.
    slope: f64,
    /// How many centres it has.
    pub(super) points: usize,
}

/// How chains are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Following {
    /// Columns that may be missed in a row.
    pub(super) max_gap: usize,
    /// Fewest centres that make a chain.
    pub(super) min_points: usize,
}

/// Steepest course, in pixels a column: stripes run along, not across.
const STEEPEST: f64 = 1.2;
/// How far off its course a centre may be, in pixels.
const OFF_COURSE_PX: f64 = 1.5;
/// What the course may turn by, in pixels a column of gap, once it is known.
const TURN: f64 = 0.15;
/// Centres after which the course is known.
const KNOWN_AFTER: usize = 6;
/// Share of its columns in which a chain must have a centre.
const LEAST_FILLED: f64 = 0.6;
/// What a new centre moves place and course by: an alpha-beta filter of about ten columns' memory.
const ALPHA: f64 = 0.35;
/// See `ALPHA`.
const BETA: f64 = 0.06;

impl Chain {
    fn of(point: &Point) -> Self {
        Self { x: [point.x; 2], y_px: point.y_px, slope: 0.0, points: 1 }
    }

    /// How far a centre is from where the chain is expected, and how far it may be, in pixels.
    fn miss(&self, point: &Point) -> (f64, f64) {
        let ahead = (point.x - self.x[1]) as f64;
        let turn = if self.points < KNOWN_AFTER { STEEPEST } else { TURN };
        ((point.y_px - self.y_px - self.slope * ahead).abs(), OFF_COURSE_PX + turn * ahead)
    }

    fn take(&mut self, point: &Point) {
        let ahead = (point.x - self.x[1]) as f64;
        let expected = self.y_px + self.slope * ahead;
        let off = point.y_px - expected;
        // A young chain learns faster: its first two centres are its course.
        let n = (self.points + 1) as f64;
        let alpha = ALPHA.max((4.0 * n - 2.0) / (n * (n + 1.0)));
        let beta = BETA.max(6.0 / (n * (n + 1.0)));
        self.y_px = expected + alpha.min(1.0) * off;
        self.slope = (self.slope + beta.min(1.0) * off / ahead).clamp(-STEEPEST, STEEPEST);
        self.x[1] = point.x;
        self.points += 1;
    }

    fn is_kept(&self, following: &Following) -> bool {
        let columns = self.x[1] - self.x[0] + 1;
        self.points >= following.min_points && self.points as f64 >= LEAST_FILLED * columns as f64
    }
}

/// Gives every point its chain. `points` are in the order of their columns, at most one of a chain in each; `open` is room to work in.
pub(super) fn follow(points: &mut [Point], following: &Following, chains: &mut Vec<Chain>, open: &mut Vec<u32>) {
    const FREE: u32 = u32::MAX;
    chains.clear();
    open.clear();
    let mut from = 0;
    while from < points.len() {
        let x = points[from].x;
        let to = from + points[from..].iter().take_while(|point| point.x == x).count();
        let column = &mut points[from..to];
        column.iter_mut().for_each(|point| point.chain = FREE);
        open.retain(|chain| {
            let chain = &chains[*chain as usize];
            // A chain of few centres has no claim to wait long.
            x - chain.x[1] <= 1 + following.max_gap.min(chain.points)
        });
        // The pair that fits best first; of equal ones the longer chain.
        loop {
            let mut best: Option<(f64, usize, u32)> = None;
            for (i, point) in column.iter().enumerate().filter(|(_, point)| point.chain == FREE) {
                for &index in open.iter().filter(|index| chains[**index as usize].x[1] < x) {
                    let (miss, allowed) = chains[index as usize].miss(point);
                    let is_better = best.is_none_or(|(least, _, other)| {
                        miss < least || (miss == least && chains[index as usize].points > chains[other as usize].points)
                    });
                    if miss <= allowed && is_better {
                        best = Some((miss, i, index));
                    }
                }
            }
            let Some((_, i, index)) = best else { break };
            column[i].chain = index;
            chains[index as usize].take(&column[i]);
        }
        for point in column.iter_mut().filter(|point| point.chain == FREE) {
            point.chain = chains.len() as u32;
            open.push(point.chain);
            chains.push(Chain::of(point));
        }
        from = to;
    }
}

/// Takes out the points of chains that have become too short, of points that stand in the order of [`keep`].
pub(super) fn keep_long(points: &mut Vec<Point>, following: &Following, lengths: &mut Vec<u32>) {
    lengths.clear();
    for chain in points.chunk_by(|a, b| a.chain == b.chain) {
        lengths.resize(chain[0].chain as usize + 1, 0);
        lengths[chain[0].chain as usize] = chain.len() as u32;
    }
    points.retain(|point| lengths[point.chain as usize] as usize >= following.min_points);
}

/// Takes out the points of chains that are too short or too sparse, and brings each chain's together, in the order of their columns.
pub(super) fn keep(points: &mut Vec<Point>, chains: &[Chain], following: &Following) {
    points.retain(|point| chains[point.chain as usize].is_kept(following));
    points.sort_unstable_by_key(|point| (point.chain, point.x));
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLLOWING: Following = Following { max_gap: 12, min_points: 20 };

    fn point(x: usize, y_px: f64) -> Point {
        Point { y_px, ..Point::of_place(x, 0, [0, 0], 100.0, 4.0) }
    }

    fn chains_of(points: &mut Vec<Point>) -> Vec<usize> {
        points.sort_by_key(|point| point.x);
        let (mut chains, mut open) = (Vec::new(), Vec::new());
        follow(points, &FOLLOWING, &mut chains, &mut open);
        keep(points, &chains, &FOLLOWING);
        chains.iter().filter(|chain| chain.is_kept(&FOLLOWING)).map(|chain| chain.points).collect()
    }

    #[test]
    fn curved_stripes_with_gaps_are_followed_and_specks_left() {
        let mut points: Vec<Point> = (0..200).filter(|x| x % 50 > 5).map(|x| point(x, 50.0 + 1e-3 * (x * x) as f64)).collect();
        points.extend((0..200).map(|x| point(x, 150.0 - 0.9 * x as f64 + if x % 2 == 0 { 0.2 } else { -0.2 })).take(90));
        // Specks far from both.
        points.extend((0..200).step_by(3).map(|x| point(x, 300.0 + (x * 37 % 101) as f64)));
        assert_eq!(chains_of(&mut points), [90, 176]);
        assert_eq!(points.len(), 266);
        assert!(points.is_sorted_by_key(|point| (point.chain, point.x)));
    }

    #[test]
    fn stripes_that_cross_go_straight_on() {
        let mut points: Vec<Point> = (0..200).map(|x| point(x, 50.0 + 0.5 * x as f64)).collect();
        // Where they are one, one centre is all there is.
        points.retain(|point| point.x.abs_diff(100) > 4);
        points.extend((0..200).map(|x| point(x, 150.0 - 0.5 * x as f64)));
        assert_eq!(chains_of(&mut points), [191, 200]);
        for chain in points.chunk_by(|a, b| a.chain == b.chain) {
            let slope = (chain[chain.len() - 1].y_px - chain[0].y_px) / 199.0;
            assert!((slope.abs() - 0.5).abs() < 1e-9, "{slope}");
        }
    }
}
