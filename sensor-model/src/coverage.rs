//! How much of a pixel's blurred light a straight-edged piece of a stripe keeps: soft edges instead of hard ones.
//!
//! A stripe is, near a pixel, a Gaussian ridge of standard deviation s that runs straight through the image; the lens spreads each
//! of its points over a Gaussian of standard deviation p (the pixel's own square counted as a Gaussian of variance 1/12). What
//! arrives at a pixel at distance a from the ridge left from places that are, on the mean, at rho a from the ridge, with
//! rho = s^2 / (s^2 + p^2), straight across from the pixel, and scatter about there by rho p^2 across the ridge and p^2 along it. An
//! edge of the piece, a straight line with unit normal m (inward) at distance e from the pixel, therefore keeps the share
//!
//! ```text
//! Phi(z),  z = (e - (1 - rho) a (m.n)) / (p sqrt(1 - (m.n)^2 (1 - rho)))       n: unit normal of the ridge
//! ```
//!
//! which is exact for one edge. Two edges keep the share of a normal distribution in two variables, whose correlation c is the cosine
//! of the angle between the edges' normals, measured where the scatter is round (the component across the ridge times sqrt(rho)). It is
//! taken as
//!
//! ```text
//! c >= 0:  (1 - k) A B + k min(A, B)             k = |c| (0.64 + 0.36 c^8), near asin(|c|) 2 / pi
//! c <  0:  (1 - k) A B + k max(0, A + B - 1)
//! ```
//!
//! which is exact for square and for parallel edges, and whatever the angle what one side of an edge loses the other side gains:
//! pieces that share an edge add up to the whole. At corners it is right to 0.05. Further edges are taken in one after the other,
//! each with the direction of the narrowest so far; of a piece that is smaller than the blur on all sides that is right to a
//! sixth of the light which the ridge would have.

use nalgebra::{Matrix2, Vector2, Vector3};

/// A straight line in the image, as the vector h: rays (x, y, 1) with h . ray > 0 are inside. Of unit length.
pub type Edge = Vector3<f64>;

/// Standard normal distribution function.
pub fn phi(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Narrowest softness of an edge, in pixels.
pub const SOFT_MIN_PX: f64 = 0.05;

/// The ridge as the edges' formula sees it, at one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ridge {
    /// Distance of the pixel from the ridge, along `normal`, in pixels.
    pub across_px: f64,
    /// Its unit normal in the image.
    pub normal: Vector2<f64>,
    /// rho.
    pub share: f64,
    /// p, in pixels.
    pub blur_px: f64,
}

impl Ridge {
    /// Share of the light that a convex piece with these edges keeps, from 0 to 1. `ray` is the pixel's (x, y, 1),
    /// `rays_per_pixel` the derivative of (x, y) by the pixel.
    pub fn coverage(&self, edges: &[Edge], ray: &Vector3<f64>, rays_per_pixel: &Matrix2<f64>) -> f64 {
        let mut kept = 1.0;
        let mut narrowest = Vector2::zeros();
        for edge in edges {
            let slope = rays_per_pixel.tr_mul(&edge.xy());
            let steepness = slope.norm();
            let (distance, inward) = (edge.dot(ray) / steepness, slope / steepness);
            let facing = inward.dot(&self.normal);
            let along = self.normal.x * inward.y - self.normal.y * inward.x;
            // The normal where the scatter is round; its length is the edge's softness over p.
            let round = Vector2::new(along, facing * self.share.sqrt());
            let length = round.norm();
            let z = (distance - (1.0 - self.share) * self.across_px * facing) / (self.blur_px * length).max(SOFT_MIN_PX);
            let direction = round / length.max(1e-9);
            let share = phi(z);
            let both = together(kept, share, narrowest.dot(&direction));
            if share < kept {
                narrowest = direction;
            }
            kept = both;
        }
        kept
    }
}

/// What two edges keep that alone keep the shares `a` and `b` and whose normals have this cosine.
fn together(a: f64, b: f64, cosine: f64) -> f64 {
    let c2 = cosine * cosine;
    let weight = cosine.abs() * (0.64 + 0.36 * (c2 * c2) * (c2 * c2));
    let parallel = if cosine < 0.0 { (a + b - 1.0).max(0.0) } else { a.min(b) };
    a * b + weight * (parallel - a * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pixel at the origin of a plane that is measured in pixels: a ray (x, y, 1) is the place (x, y).
    const PIXEL: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

    /// A ridge of standard deviation `sigma_px` whose normal is at an angle, at a distance from the pixel, and a lens' blur.
    #[derive(Clone, Copy, Debug)]
    struct Case {
        sigma_px: f64,
        blur_px: f64,
        angle: f64,
        across_px: f64,
    }

    impl Case {
        fn normal(&self) -> Vector2<f64> {
            let (s, c) = libm::sincos(self.angle);
            Vector2::new(c, s)
        }

        fn kept(&self, edges: &[Edge]) -> f64 {
            let (own, blur) = (self.sigma_px * self.sigma_px, self.blur_px * self.blur_px);
            let share = own / (own + blur);
            let ridge = Ridge { across_px: self.across_px, normal: self.normal(), share, blur_px: self.blur_px };
            ridge.coverage(edges, &PIXEL, &Matrix2::identity())
        }

        /// The same by adding up what comes from each place: the ridge's light there times the lens' share that reaches the pixel.
        fn added_up(&self, edges: &[Edge]) -> f64 {
            const STEPS: i32 = 60;
            const REACH: f64 = 5.0;
            let step = REACH * self.blur_px / f64::from(STEPS);
            let (mut kept, mut all) = (0.0, 0.0);
            for i in -STEPS..=STEPS {
                for j in -STEPS..=STEPS {
                    let place = Vector2::new(f64::from(i) * step, f64::from(j) * step);
                    let off = (self.across_px + self.normal().dot(&place)) / self.sigma_px;
                    let light = libm::exp(-off * off / 2.0 - place.norm_squared() / (2.0 * self.blur_px * self.blur_px));
                    all += light;
                    // Of the square about the place, roughly the share that each edge leaves inside.
                    let inside = |edge: &Edge| {
                        (0.5 + edge.dot(&Vector3::new(place.x, place.y, 1.0)) / (edge.xy().norm() * step)).clamp(0.0, 1.0)
                    };
                    kept += light * edges.iter().map(inside).product::<f64>();
                }
            }
            kept / all
        }
    }

    fn cases() -> impl Iterator<Item = Case> {
        [(0.4, 0.66), (1.2, 0.66), (3.0, 0.8), (0.8, 4.0)].into_iter().flat_map(|(sigma_px, blur_px)| {
            [0.0, 0.7, 2.0].into_iter().flat_map(move |angle| {
                [-1.5, 0.0, 0.6].into_iter().map(move |across| Case {
                    sigma_px,
                    blur_px,
                    angle,
                    across_px: across * (sigma_px * sigma_px + blur_px * blur_px).sqrt(),
                })
            })
        })
    }

    /// A line whose inward normal is at an angle, `distance_px` from the pixel, which is inside where that is positive.
    fn edge(angle: f64, distance_px: f64) -> Edge {
        let (s, c) = libm::sincos(angle);
        Vector3::new(c, s, distance_px).normalize()
    }

    /// The largest difference over all cases and all turns of a shape; distances are in blurs.
    fn worst(shape: &[(f64, f64)]) -> f64 {
        let mut worst = 0.0_f64;
        for case in cases() {
            for turn in 0..6 {
                let turned: Vec<_> = shape
                    .iter()
                    .map(|(angle, off)| edge(angle + f64::from(turn) * std::f64::consts::FRAC_PI_3, off * case.blur_px))
                    .collect();
                worst = worst.max((case.kept(&turned) - case.added_up(&turned)).abs());
            }
        }
        worst
    }

    #[test]
    fn one_edge_is_exact() {
        for off in [-1.0, -0.3, 0.0, 0.8] {
            let found = worst(&[(0.0, off)]);
            // The sum's own error: its places are a twelfth of the blur apart.
            assert!(found < 4e-3, "{off}: {found}");
        }
    }

    #[test]
    fn a_thin_piece_between_parallel_edges_is_exact() {
        use std::f64::consts::PI;
        for (off, thickness) in [(-0.5, 1.0), (0.0, 0.3), (0.4, 0.2), (0.1, 2.0)] {
            let found = worst(&[(0.0, off), (PI, thickness - off)]);
            assert!(found < 4e-3, "{off} {thickness}: {found}");
        }
    }

    #[test]
    fn corners_are_right_to_a_few_hundredths() {
        use std::f64::consts::PI;
        for between in [0.4, 0.9, 1.3, PI / 2.0, 1.9, 2.4, 2.9] {
            for offs in [[0.0, 0.0], [0.3, -0.4], [-0.5, -0.5], [1.0, 0.2]] {
                let found = worst(&[(0.0, offs[0]), (between, offs[1])]);
                assert!(found < 0.05, "{between} {offs:?}: {found}");
            }
        }
    }

    #[test]
    fn pieces_smaller_than_the_blur_are_right_to_a_sixth() {
        use std::f64::consts::PI;
        // A square, a thin bar, a slanted four-sided piece, a triangle.
        let pieces: [&[(f64, f64)]; 4] = [
            &[(0.0, 0.7), (PI / 2.0, 0.7), (PI, 0.7), (-PI / 2.0, 0.7)],
            &[(0.0, 0.2), (PI / 2.0, 1.5), (PI, 0.2), (-PI / 2.0, 0.8)],
            &[(0.0, 0.5), (1.2, 0.9), (PI, 0.6), (-1.7, 0.8)],
            &[(0.3, 0.5), (2.4, 0.5), (-1.8, 0.5)],
        ];
        for piece in pieces {
            let found = worst(piece);
            assert!(found < 1.0 / 6.0, "{piece:?}: {found}");
        }
    }

    /// What one side of an edge loses the other gains, whatever other edges there are.
    #[test]
    fn pieces_that_share_an_edge_add_up() {
        for case in cases() {
            for between in [0.3, 1.0, 2.0, 2.8] {
                let outer = [edge(0.0, 0.6 * case.blur_px)];
                let shared = edge(between, 0.2 * case.blur_px);
                let one = case.kept(&[outer[0], shared]);
                let other = case.kept(&[outer[0], -shared]);
                assert!((one + other - case.kept(&outer)).abs() < 1e-12, "{case:?} {between}");
            }
        }
    }
}
