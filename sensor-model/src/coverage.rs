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
//! which is exact for square and for parallel edges, and whatever the angle what one side of an edge loses the other side gains: pieces that share an
//! edge add up to the whole. Further edges are taken in one after the other, each with the direction of the narrowest so far.

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
