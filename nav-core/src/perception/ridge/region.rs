//! The part of an image that is looked at.

use crate::perception::scan::Across;

/// A polygon in the image; a place is inside where a ray from it crosses the outline an odd number of times.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    corners_px: Vec<[f64; 2]>,
}

impl Region {
    /// The polygon with these corners (u, v), in pixels, in the order of its outline; `None` for fewer than three, or one that is not
    /// finite.
    pub fn polygon(corners_px: &[[f64; 2]]) -> Option<Self> {
        let is_one = corners_px.len() >= 3 && corners_px.iter().flatten().all(|x| x.is_finite());
        is_one.then(|| Self { corners_px: corners_px.to_vec() })
    }

    /// The rectangle between two corners (u, v), in pixels; `None` where one is not finite.
    pub fn rectangle([u0, v0]: [f64; 2], [u1, v1]: [f64; 2]) -> Option<Self> {
        Self::polygon(&[[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
    }

    /// Its corners (u, v), in pixels.
    pub fn corners_px(&self) -> &[[f64; 2]] {
        &self.corners_px
    }

    /// The inside along one line of pixels across the stripes, as places where it begins and ends by turns, in order, in pixels.
    /// `x_px` is the line's scan coordinate (u for [`Across::V`]).
    pub fn crossings(&self, across: Across, x_px: f64, found: &mut Vec<f64>) {
        found.clear();
        let corner = |i: usize| {
            let [u, v] = self.corners_px[i % self.corners_px.len()];
            across.pixel(u, v)
        };
        for i in 0..self.corners_px.len() {
            let ([x0, y0], [x1, y1]) = (corner(i), corner(i + 1));
            // Half open, so that a corner on the line counts once.
            if (x0 <= x_px) != (x1 <= x_px) {
                found.push(y0 + (x_px - x0) / (x1 - x0) * (y1 - y0));
            }
        }
        found.sort_by(f64::total_cmp);
    }

    /// Which pixels of an image have their centre inside, row by row.
    pub fn mask(&self, width_px: usize, height_px: usize) -> Vec<bool> {
        let mut inside = vec![false; width_px * height_px];
        let mut crossings = Vec::new();
        for (v, row) in inside.chunks_exact_mut(width_px.max(1)).enumerate() {
            self.crossings(Across::U, v as f64, &mut crossings);
            for pair in crossings.chunks_exact(2) {
                let [from, to] = [pair[0], pair[1]].map(|u| u.ceil().clamp(0.0, width_px as f64) as usize);
                row[from..to].fill(true);
            }
        }
        inside
    }

    /// Whether a place is inside; of a rectangle's sides, those at the least u and v belong to it.
    pub fn contains(&self, u_px: f64, v_px: f64) -> bool {
        let mut crossings = Vec::with_capacity(self.corners_px.len());
        self.crossings(Across::U, v_px, &mut crossings);
        crossings.chunks_exact(2).any(|pair| (pair[0]..pair[1]).contains(&u_px))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_rectangle_holds_what_is_between_its_corners() {
        let region = Region::rectangle([30.0, 5.0], [10.0, 20.0]).expect("finite");
        assert!(region.contains(10.0, 5.0) && region.contains(20.0, 12.0) && region.contains(29.9, 19.9));
        assert!(!region.contains(9.9, 12.0) && !region.contains(20.0, 20.1) && !region.contains(31.0, 12.0));
        assert_eq!(Region::polygon(&[[0.0, 0.0], [1.0, 1.0]]), None);
        assert_eq!(Region::rectangle([0.0, f64::NAN], [1.0, 1.0]), None);
    }

    proptest! {
        #[test]
        fn the_mask_is_what_is_inside(corners in prop::collection::vec([-10.0..40.0f64, -10.0..40.0f64], 3..9)) {
            let region = Region::polygon(&corners).expect("finite");
            for (i, inside) in region.mask(30, 20).iter().enumerate() {
                prop_assert_eq!(*inside, region.contains((i % 30) as f64, (i / 30) as f64));
            }
            prop_assert!(region.mask(0, 20).is_empty());
        }

        /// Either axis across, the same inside.
        #[test]
        fn both_axes_agree(
            corners in prop::collection::vec([-50.0..50.0f64, -50.0..50.0f64], 3..9), u in -60.0..60.0f64, v in -60.0..60.0f64,
        ) {
            let region = Region::polygon(&corners).expect("finite");
            let mut crossings = Vec::new();
            region.crossings(Across::V, u, &mut crossings);
            prop_assert_eq!(crossings.len() % 2, 0);
            let inside = crossings.chunks_exact(2).any(|pair| (pair[0]..pair[1]).contains(&v));
            prop_assert_eq!(inside, region.contains(u, v));
        }
    }
}
