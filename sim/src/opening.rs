//! What is left of a face when its portals are cut out of it.

use ductloop_duct::cell::{Face, Plane};
use nalgebra::Point3;

/// Pieces narrower than this are rounding, not sheet metal.
const SLIVER_M: f64 = 1e-6;

/// The closed parts of a face as convex outlines, anticlockwise seen from outside the cell; none where one portal covers it.
pub fn closed_parts(face: &Face) -> Vec<Vec<Point3<f64>>> {
    let mut parts = vec![face.outline.clone()];
    for portal in &face.portals {
        parts = parts.iter().flat_map(|part| cut_out(part, &portal.edges)).collect();
    }
    parts
}

/// A convex outline without the convex opening that `edges` bound: at most one piece beside each edge.
fn cut_out(outline: &[Point3<f64>], edges: &[Plane]) -> Vec<Vec<Point3<f64>>> {
    let mut rest = outline.to_vec();
    let mut pieces = Vec::new();
    for edge in edges {
        pieces.extend(clip(&rest, |p| edge.distance(p)));
        match clip(&rest, |p| -edge.distance(p)) {
            Some(inside) => rest = inside,
            // Wholly beside this edge: the opening does not reach this outline.
            None => return vec![outline.to_vec()],
        }
    }
    pieces
}

/// The part of a convex outline where `side` is positive; `None` if it is a sliver.
fn clip(outline: &[Point3<f64>], side: impl Fn(&Point3<f64>) -> f64) -> Option<Vec<Point3<f64>>> {
    if outline.iter().all(|p| side(p) < SLIVER_M) {
        return None;
    }
    let mut kept = Vec::with_capacity(outline.len() + 1);
    for (i, a) in outline.iter().enumerate() {
        let b = &outline[(i + 1) % outline.len()];
        let (sa, sb) = (side(a), side(b));
        if sa >= 0.0 {
            kept.push(*a);
        }
        if sa * sb < 0.0 {
            kept.push(a + (b - a) * (sa / (sa - sb)));
        }
    }
    Some(kept)
}

#[cfg(test)]
mod tests {
    use ductloop_duct::cell::{Beyond, Cell, Portal, Side, SurfaceId};
    use nalgebra::{Point2, Vector3};

    use super::*;

    /// The wall y = -1 of a box 4 m long and 2 m high.
    fn wall() -> Face {
        let plan = [[0.0, -1.0], [4.0, -1.0], [4.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point2::new(x, y));
        Cell::prism(&plan, 2.0, &[Side::Wall; 4], SurfaceId(0), 0).faces[2].clone()
    }

    fn area(outline: &[Point3<f64>]) -> f64 {
        let sum = (1..outline.len() - 1)
            .fold(Vector3::zeros(), |sum, i| sum + (outline[i] - outline[0]).cross(&(outline[i + 1] - outline[0])));
        sum.norm() / 2.0
    }

    fn opening(face: &Face, x: [f64; 2], z: [f64; 2]) -> Portal {
        let at = |x, z| Point3::new(x, -1.0, z);
        Portal::new(&face.plane, vec![at(x[0], z[0]), at(x[1], z[0]), at(x[1], z[1]), at(x[0], z[1])], Beyond::Outside)
    }

    #[test]
    fn pieces_cover_the_face_without_its_openings() {
        // Rounding only: the areas are sums of products of short binary fractions.
        let total = |face: &Face| closed_parts(face).iter().map(|part| area(part)).sum::<f64>();
        let mut face = wall();
        assert!((total(&face) - 8.0).abs() < 1e-12);
        face.portals = vec![opening(&face, [1.0, 2.0], [0.0, 1.5])];
        assert!((total(&face) - 6.5).abs() < 1e-12);
        face.portals.push(opening(&face, [2.5, 3.5], [0.5, 1.5]));
        assert!((total(&face) - 5.5).abs() < 1e-12);
        for part in closed_parts(&face) {
            let middle = part.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / part.len() as f64;
            assert!(!face.portals.iter().any(|portal| portal.contains(&middle.into())));
        }
    }

    #[test]
    fn a_portal_over_the_whole_face_leaves_nothing() {
        let mut face = wall();
        face.portals = vec![Portal::new(&face.plane, face.outline.clone(), Beyond::Outside)];
        assert_eq!(closed_parts(&face), Vec::<Vec<_>>::new());
    }
}
