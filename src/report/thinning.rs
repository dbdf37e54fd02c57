//! Long series without the points that nobody sees.

/// A point of a series; a missing y is a gap.
pub(super) type Point = (f64, Option<f64>);

/// At most about `room` points: of each group of neighbours the first, the lowest, the highest and the last stay, so that no
/// peak is lost. A gap stays one.
pub(super) fn thin(points: &[Point], room: usize) -> Vec<Point> {
    if points.len() <= room {
        return points.to_vec();
    }
    let group = (4 * points.len()).div_ceil(room);
    let mut kept = Vec::with_capacity(room);
    for piece in points.chunk_by(|a, b| a.1.is_some() == b.1.is_some()) {
        if piece[0].1.is_none() {
            kept.push(piece[0]);
            continue;
        }
        for some in piece.chunks(group) {
            let by_y = |a: &usize, b: &usize| some[*a].1.unwrap_or(0.0).total_cmp(&some[*b].1.unwrap_or(0.0));
            let mut stay = vec![0, some.len() - 1];
            stay.extend((0..some.len()).min_by(by_y));
            stay.extend((0..some.len()).max_by(by_y));
            stay.sort_unstable();
            stay.dedup();
            kept.extend(stay.into_iter().map(|i| some[i]));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_and_gaps_stay() {
        let mut points: Vec<Point> = (0..10_000).map(|i| (f64::from(i), Some(0.0))).collect();
        points[4321].1 = Some(9.0);
        points[4322].1 = Some(-9.0);
        (7000..7100).for_each(|i| points[i].1 = None);
        let thinned = thin(&points, 1000);
        assert!(thinned.len() <= 1000, "{}", thinned.len());
        assert!(thinned.is_sorted_by(|a, b| a.0 < b.0));
        for needed in [points[0], points[4321], points[4322], points[7000], points[9999]] {
            assert!(thinned.contains(&needed), "{needed:?}");
        }
        assert_eq!(thin(&points[..10], 1000), &points[..10]);
    }
}
