//! A chain of centres to straight lines: split where it is farthest from straight, until what remains is.
//!
//! Splitting is that of Ramer (1972) and of Douglas and Peucker (1973), judged by what a line fitted by least squares leaves beside what
//! noise explains. Each line is fitted with Huber's weights: a few centres that something else has moved do not turn it.

use super::chain::Point;

/// A straight part of a chain, in scan coordinates: y = slope (x - x0) + y0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Its points, from the first to one past the last.
    pub(super) points: [usize; 2],
    middle: [f64; 2],
    slope: f64,
    /// RMS distance of its points along y, in pixels.
    pub(super) residual_px: f64,
}

/// What noise of one column on the other explains of a line's residual is multiplied by this before a chain is called bent.
const BENT: f64 = 1.5;
/// A line that leaves no more than this, in pixels, is straight.
const STRAIGHT_PX: f64 = 0.35;
/// A part that cannot be split further and leaves more than this, in pixels, is no line.
const CROOKED_PX: f64 = 1.0;
/// Share of its columns in which a line must have a centre.
const LEAST_FILLED: f64 = 0.5;
/// Huber's bound, in standard deviations.
const HUBER: f64 = 1.5;
/// A stripe's edge is never better known than this, in pixels: weights stay even.
const LEAST_SIGMA_PX: f64 = 0.05;
const REFITS: usize = 4;

impl Segment {
    /// y at x.
    pub(super) fn at(&self, x_px: f64) -> f64 {
        self.middle[1] + self.slope * (x_px - self.middle[0])
    }
}

/// Splits each chain of `points`, which stand together and in the order of their columns. `todo` is room to work in.
pub(super) fn split(points: &[Point], min_points: usize, segments: &mut Vec<Segment>, todo: &mut Vec<[usize; 2]>) {
    segments.clear();
    let mut from = 0;
    for chain in points.chunk_by(|a, b| a.chain == b.chain) {
        todo.clear();
        todo.push([from, from + chain.len()]);
        from += chain.len();
        // The first part on top, so that lines come in the order of their columns.
        while let Some([first, end]) = todo.pop() {
            let part = &points[first..end];
            let Some(line) = fit(part, first) else { continue };
            let is_straight = line.residual_px <= STRAIGHT_PX.max(BENT * noise_px(part));
            match bend(part, min_points).filter(|_| !is_straight) {
                Some(at) => todo.extend([[first + at, end], [first, first + at]]),
                // Where stripes run into each other, or hardly a centre is left, there is no line, and centres on none are none.
                None => segments.extend((line.residual_px <= CROOKED_PX && is_filled(part)).then_some(line)),
            }
        }
    }
}

fn is_filled(points: &[Point]) -> bool {
    let columns = points.last().zip(points.first()).map_or(1, |(last, first)| last.x - first.x + 1);
    points.len() as f64 >= LEAST_FILLED * columns as f64
}

/// Scatter of neighbours about each other, in pixels: what is left of it when the course is taken out.
fn noise_px(points: &[Point]) -> f64 {
    let square = |three: &[Point]| {
        let second = three[0].y_px - 2.0 * three[1].y_px + three[2].y_px;
        second * second / 6.0
    };
    let n = points.len().saturating_sub(2).max(1) as f64;
    (points.windows(3).map(square).sum::<f64>() / n).sqrt()
}

/// The point farthest from the chord between the means of both ends, if both parts are long enough.
fn bend(points: &[Point], min_points: usize) -> Option<usize> {
    const END: usize = 5;
    let n = points.len();
    if n < 2 * min_points.max(END) {
        return None;
    }
    let mean = |part: &[Point]| {
        let n = part.len() as f64;
        (part.iter().map(|p| p.x as f64).sum::<f64>() / n, part.iter().map(|p| p.y_px).sum::<f64>() / n)
    };
    let ((x0, y0), (x1, y1)) = (mean(&points[..END]), mean(&points[n - END..]));
    let off = |p: &Point| (p.y_px - y0 - (y1 - y0) * (p.x as f64 - x0) / (x1 - x0)).abs();
    let farthest = (0..n).max_by(|a, b| off(&points[*a]).total_cmp(&off(&points[*b])))?;
    Some(farthest.clamp(min_points, n - min_points))
}

/// The line through points of one chain, the first of which is number `first`; `None` for fewer than three.
fn fit(points: &[Point], first: usize) -> Option<Segment> {
    if points.len() < 3 {
        return None;
    }
    let mut line = Segment { points: [first, first + points.len()], middle: [0.0; 2], slope: 0.0, residual_px: f64::INFINITY };
    for _ in 0..REFITS {
        // The first time every point counts by its own deviation alone.
        let weight = |p: &Point| {
            let sigma = LEAST_SIGMA_PX.max(p.variance_px2.sqrt()).max(line.residual_px.min(1.0));
            let off = (p.y_px - line.at(p.x as f64)).abs() / sigma;
            let bound = if line.residual_px.is_finite() && off > HUBER { HUBER / off } else { 1.0 };
            bound / (sigma * sigma)
        };
        let mut total = [0.0; 3];
        for p in points {
            let w = weight(p);
            total = [total[0] + w, total[1] + w * p.x as f64, total[2] + w * p.y_px];
        }
        let middle = [total[1] / total[0], total[2] / total[0]];
        let (mut xx, mut xy) = (0.0, 0.0);
        for p in points {
            let (w, dx) = (weight(p), p.x as f64 - middle[0]);
            xx += w * dx * dx;
            xy += w * dx * (p.y_px - middle[1]);
        }
        if xx <= 0.0 {
            return None;
        }
        (line.middle, line.slope) = (middle, xy / xx);
        let off = |p: &Point| p.y_px - line.at(p.x as f64);
        let squares = points.iter().map(|p| off(p) * off(p)).sum::<f64>();
        line.residual_px = (squares / points.len() as f64).sqrt();
    }
    Some(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(y: impl Fn(f64) -> f64) -> Vec<Point> {
        let wobble = |x: usize| if x.is_multiple_of(2) { 0.1 } else { -0.1 };
        let point =
            |x: usize| Point { y_px: y(x as f64) + wobble(x), variance_px2: 0.01, ..Point::of_place(x, 0, [0, 0], 100.0, 4.0) };
        (0..200).map(point).collect()
    }

    fn lines(points: &[Point]) -> Vec<Segment> {
        let (mut segments, mut todo) = (Vec::new(), Vec::new());
        split(points, 20, &mut segments, &mut todo);
        segments
    }

    #[test]
    fn a_straight_chain_is_one_line_and_a_kink_two() {
        let straight = lines(&points(|x| 30.0 + 0.25 * x));
        assert_eq!(straight.len(), 1, "{straight:?}");
        assert!((straight[0].at(100.0) - 55.0).abs() < 0.02 && (straight[0].residual_px - 0.1).abs() < 0.01, "{straight:?}");
        let kinked = lines(&points(|x| 30.0 + 0.3 * (x - 120.0).max(0.0)));
        assert_eq!(kinked.len(), 2, "{kinked:?}");
        assert!(kinked[0].points[1].abs_diff(120) <= 3 && kinked[0].points[1] == kinked[1].points[0], "{kinked:?}");
    }

    #[test]
    fn crooked_and_sparse_chains_are_no_lines() {
        assert_eq!(lines(&points(|x| 30.0 + 4.0 * (x / 7.0).fract())), []);
        let mut sparse = points(|x| 30.0 + 0.25 * x);
        sparse.retain(|p| p.x.is_multiple_of(3));
        assert_eq!(lines(&sparse), []);
    }

    #[test]
    fn a_few_strays_do_not_turn_a_line() {
        let mut points = points(|x| 30.0 + 0.25 * x);
        points[195..].iter_mut().for_each(|p| p.y_px += 1.2);
        let line = lines(&points)[0];
        // Least squares alone would be off by 0.1 px at the end.
        assert!((line.at(199.0) - 79.75).abs() < 0.05, "{line:?}: {}", line.at(199.0));
    }
}
