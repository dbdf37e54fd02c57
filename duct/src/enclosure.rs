//! Whether something stands wholly inside the ducts.

use nalgebra::{Point3, Vector3};

use crate::cell::{Beyond, Plane, Solid};
use crate::network::Network;

/// How far a solid may reach into sheet metal and still count as touching it, in metres: rounding of a long chain of transforms.
const TOUCHING_M: f64 = 1e-6;

/// Sheet metal or open end of less than this within a solid is rounding, in square metres.
const SLIVER_M2: f64 = 1e-9;

impl Network {
    /// Whether a solid, given in the world frame, lies wholly inside: it may touch walls and may reach from one cell into the next, but
    /// neither into sheet metal nor out of an open end.
    ///
    /// A convex body is inside if a point of it is and none of the network's boundary is within it.
    pub fn encloses(&self, solid: &Solid) -> bool {
        let sum: Vector3<f64> = solid.corners.iter().map(|corner| corner.coords).sum();
        let middle = Point3::from(sum / solid.corners.len() as f64);
        let inner: Vec<Plane> =
            solid.planes.iter().map(|plane| Plane { offset_m: plane.offset_m - TOUCHING_M, ..*plane }).collect();
        let reached = self.cells.iter().filter(|cell| cell.is_reached_by(solid));
        let crosses_boundary = reached.flat_map(|cell| &cell.faces).any(|face| {
            let within = clipped(face.outline.clone(), &inner);
            let passages = face.portals.iter().filter(|portal| matches!(portal.beyond, Beyond::Cell(_)));
            let passable: f64 = passages.map(|portal| area_m2(&clipped(within.clone(), &portal.edges))).sum();
            area_m2(&within) - passable > SLIVER_M2
        });
        self.cell_at(&middle, 0).is_some() && !crosses_boundary
    }
}

/// The part of a convex outline on the inner side of all these planes.
fn clipped(mut outline: Vec<Point3<f64>>, planes: &[Plane]) -> Vec<Point3<f64>> {
    for plane in planes {
        let mut kept = Vec::with_capacity(outline.len() + 1);
        for (i, a) in outline.iter().enumerate() {
            let b = &outline[(i + 1) % outline.len()];
            let (from, to) = (plane.distance(a), plane.distance(b));
            if from <= 0.0 {
                kept.push(*a);
            }
            if (from <= 0.0) != (to <= 0.0) {
                kept.push(a + (b - a) * (from / (from - to)));
            }
        }
        outline = kept;
    }
    outline
}

fn area_m2(outline: &[Point3<f64>]) -> f64 {
    let Some(first) = outline.first() else { return 0.0 };
    outline.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first))).sum::<Vector3<f64>>().norm() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transform;
    use crate::cell::SurfaceId;
    use crate::fitting::{Fitting, Shape};
    use crate::network::End;

    fn fitting(shape: Shape) -> Fitting {
        Fitting { shape, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) }
    }

    /// A straight of 2 m, a square turn to the left, a straight.
    fn network(exit: End) -> Network {
        let straight = fitting(Shape::Straight { length_m: 2.0 });
        let turn = fitting(Shape::MitredElbow { angle_rad: std::f64::consts::FRAC_PI_2 });
        Network::from_run(&[straight, turn, straight], End::Cap, exit).expect("the fittings fit")
    }

    fn holds(network: &Network, at: [f64; 3], size_m: [f64; 3]) -> bool {
        let stand = Transform::translation(at[0], at[1], at[2]);
        network.encloses(&Solid::cuboid(&stand, Vector3::from(size_m), SurfaceId(0)))
    }

    #[test]
    fn a_box_may_touch_walls_and_cross_joints() {
        let network = network(End::Cap);
        for (at, size_m) in [
            ([1.0, 0.0, 0.0], [0.1, 0.1, 0.1]),
            // From wall to wall and from floor to ceiling, against the entry's cap.
            ([0.05, 0.0, 0.0], [0.1, 0.5, 0.3]),
            // Over the joint and the mitre's wedges, into its outer corner.
            ([2.25, 0.0, 0.0], [0.5, 0.5, 0.3]),
        ] {
            assert!(holds(&network, at, size_m), "{at:?} {size_m:?}");
        }
    }

    #[test]
    fn a_corner_of_the_duct_may_not_be_in_the_box() {
        // Askew past the turn's inner corner (2, 0.25), 14 mm from its middle: all corners of the box are in the ducts.
        let askew = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_4);
        let stand = Transform::from_parts(Vector3::new(2.01, 0.24, 0.0).into(), askew);
        for (width_m, fits) in [(0.026, true), (0.03, false)] {
            let solid = Solid::cuboid(&stand, Vector3::new(0.4, width_m, 0.1), SurfaceId(0));
            assert_eq!(network(End::Cap).encloses(&solid), fits, "{width_m}");
        }
    }

    #[test]
    fn a_box_that_reaches_into_metal_or_out_of_an_end_is_not_inside() {
        let closed = network(End::Cap);
        // The second straight goes on along y from (2.25, 0.25) to (2.25, 2.25).
        for (at, size_m) in [
            ([1.0, 0.2001, 0.0], [0.1, 0.1, 0.1]),
            ([1.0, 0.0, 0.2001], [0.1, 0.1, 0.1]),
            ([1.0, 0.0, -0.001], [0.1, 0.1, 0.1]),
            ([0.04, 0.0, 0.0], [0.1, 0.1, 0.1]),
            ([1.0, 5.0, 0.0], [0.1, 0.1, 0.1]),
            // Walls pass through it without an edge of theirs in it.
            ([1.0, 0.0, 0.1], [0.1, 2.0, 0.1]),
        ] {
            assert!(!holds(&closed, at, size_m), "{at:?} {size_m:?}");
        }
        let at_the_exit = ([2.25, 2.2, 0.0], [0.1, 0.2, 0.1]);
        assert!(!holds(&closed, at_the_exit.0, at_the_exit.1));
        assert!(!holds(&network(End::Open), at_the_exit.0, at_the_exit.1), "an open end is no place to stand in");
        assert!(holds(&network(End::Open), [2.25, 2.1, 0.0], [0.1, 0.2, 0.1]));
    }
}
