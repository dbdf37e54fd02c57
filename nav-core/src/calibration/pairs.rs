//! Pixels whose position in space is known, and which sets of them determine nothing.

use nalgebra::{Matrix3, Vector3};

/// A pixel of a stripe and where on the gauge it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Column and row (u, v), in pixels.
    pub pixel_px: [f64; 2],
    /// Position in the gauge's frame, in millimetres.
    pub position_mm: [f64; 3],
}

/// Why a set of pairs determines no T. Points are numbered from zero.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PairsError {
    /// Eleven unknowns, three equations a point.
    #[error("{0} points are too few: four are needed, no three of them on a line")]
    TooFew(usize),
    /// A coordinate that is no number, or too large to be squared.
    #[error("point {0} has a coordinate that is not finite, or beyond 1e9")]
    NotFinite(usize),
    /// Two points share a pixel: one of them says nothing, or contradicts the other.
    #[error("points {0} and {1} are at the same pixel")]
    Repeated(usize, usize),
    /// All of them, or all but one, lie on a line.
    #[error("{}", on_a_line(*space, *but))]
    Collinear {
        /// Where: their positions in space, or else their pixels in the image.
        space: bool,
        /// The one beside the line.
        but: Option<usize>,
    },
}

/// Largest coordinate, in pixels or millimetres: its square, and sums of squares, still have all their digits' room.
const MOST: f64 = 1e9;
/// Points that lie within this share of their spread along a line lie on it: 0.4 px in an image of 400.
const STRAIGHT: f64 = 1e-3;

fn on_a_line(space: bool, but: Option<usize>) -> String {
    let place = if space { "positions" } else { "pixels" };
    let which = but.map_or(String::from("all points"), |point| format!("all points but number {point}"));
    format!("the {place} of {which} lie on a line: four are needed of which no three do")
}

impl PairsError {
    /// The points that it is about, the first to be mended first; empty for the set as a whole.
    pub fn points(&self) -> Vec<usize> {
        match self {
            Self::TooFew(_) => Vec::new(),
            Self::NotFinite(point) => vec![*point],
            Self::Repeated(first, second) => vec![*second, *first],
            Self::Collinear { but, .. } => but.iter().copied().collect(),
        }
    }
}

/// Checks that pairs determine T as far as geometry tells; what noise then leaves of it, the condition number says.
///
/// Four points, no three on a line, are enough, and there are four such points in every set that does not lie on one line but
/// for a single point: two off any line and two on it. (The paper asks for four that are "not on a same plane"; but all points
/// of a laser lie on its plane.) Positions may repeat: one place measured twice is a better mean.
///
/// # Errors
/// The first reason found.
pub fn check(pairs: &[Pair]) -> Result<(), PairsError> {
    let coordinates = |pair: &Pair| [pair.pixel_px.as_slice(), &pair.position_mm].concat();
    let sound = |pair: &Pair| coordinates(pair).iter().all(|x| x.abs() <= MOST);
    if let Some(point) = pairs.iter().position(|pair| !sound(pair)) {
        return Err(PairsError::NotFinite(point));
    }
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    let by_pixel = |a: &usize, b: &usize| {
        let ([au, av], [bu, bv]) = (pairs[*a].pixel_px, pairs[*b].pixel_px);
        au.total_cmp(&bu).then(av.total_cmp(&bv)).then(a.cmp(b))
    };
    order.sort_by(by_pixel);
    if let Some(twins) = order.windows(2).find(|two| pairs[two[0]].pixel_px == pairs[two[1]].pixel_px) {
        return Err(PairsError::Repeated(twins[0], twins[1]));
    }
    if pairs.len() < 4 {
        return Err(PairsError::TooFew(pairs.len()));
    }
    let pixels: Vec<_> = pairs.iter().map(|pair| Vector3::new(pair.pixel_px[0], pair.pixel_px[1], 0.0)).collect();
    let positions: Vec<_> = pairs.iter().map(|pair| Vector3::from(pair.position_mm)).collect();
    for (space, points) in [(false, pixels), (true, positions)] {
        if let Some(but) = line_through_all_but_one(&points) {
            return Err(PairsError::Collinear { space, but });
        }
    }
    Ok(())
}

/// Whether all points, or all but the one that is named, lie on a line.
fn line_through_all_but_one(points: &[Vector3<f64>]) -> Option<Option<usize>> {
    let count = points.len() as f64;
    let middle = points.iter().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = points.iter().map(|point| (point - middle) * (point - middle).transpose()).sum();
    if is_line(&scatter) {
        return Some(None);
    }
    // Without one point the others' middle moves too; both follow from the whole in closed form.
    let without = |point: &Vector3<f64>| {
        let away = point - middle;
        scatter - away * away.transpose() * (count / (count - 1.0))
    };
    points.iter().position(|point| is_line(&without(point))).map(Some)
}

/// Whether points with this scatter matrix spread along one direction only, if at all.
fn is_line(scatter: &Matrix3<f64>) -> bool {
    let mut spread: [f64; 3] = scatter.symmetric_eigenvalues().into();
    spread.sort_by(|a, b| b.total_cmp(a));
    spread[1] <= STRAIGHT * STRAIGHT * spread[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(u: f64, v: f64, x: f64, y: f64, z: f64) -> Pair {
        Pair { pixel_px: [u, v], position_mm: [x, y, z] }
    }

    fn square() -> Vec<Pair> {
        vec![
            pair(10.0, 10.0, 0.0, 0.0, 500.0),
            pair(300.0, 20.0, 100.0, 0.0, 500.0),
            pair(20.0, 280.0, 0.0, 100.0, 400.0),
            pair(310.0, 300.0, 100.0, 100.0, 400.0),
        ]
    }

    #[test]
    fn a_square_is_enough() {
        assert_eq!(check(&square()), Ok(()));
    }

    #[test]
    fn each_reason_names_its_points() {
        let with = |index: usize, changed: Pair| {
            let mut pairs = square();
            pairs[index] = changed;
            check(&pairs).expect_err("refused")
        };
        assert_eq!(check(&square()[..3]), Err(PairsError::TooFew(3)));
        assert_eq!(with(2, pair(f64::NAN, 280.0, 0.0, 100.0, 400.0)), PairsError::NotFinite(2));
        assert_eq!(with(1, pair(300.0, 20.0, f64::INFINITY, 0.0, 500.0)), PairsError::NotFinite(1));
        assert_eq!(with(3, pair(10.0, 10.0, 100.0, 100.0, 400.0)), PairsError::Repeated(0, 3));
        assert_eq!(with(3, pair(10.0, 10.0, 100.0, 100.0, 400.0)).points(), [3, 0]);
        // Between the first two: then the third stands alone beside a line.
        let beside = with(3, pair(155.0, 15.0, 70.0, 100.0, 450.0));
        assert_eq!(beside, PairsError::Collinear { space: false, but: Some(2) });
        assert_eq!(with(3, pair(310.0, 300.0, 50.0, 0.0, 500.0)), PairsError::Collinear { space: true, but: Some(2) });
        assert!(beside.to_string().contains("all points but number 2"), "{beside}");
        let line: Vec<_> = (0..9).map(f64::from).map(|t| pair(10.0 * t, 5.0 * t, t, t * t, 3.0 * t)).collect();
        assert_eq!(check(&line), Err(PairsError::Collinear { space: false, but: None }));
        let one_place: Vec<_> = square().iter().map(|p| Pair { position_mm: [1.0, 2.0, 3.0], ..*p }).collect();
        assert_eq!(check(&one_place), Err(PairsError::Collinear { space: true, but: None }));
    }
}
