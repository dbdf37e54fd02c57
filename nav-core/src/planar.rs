//! Poses in the plane: along, to the left, heading, in metres and radians.

use crate::angle::wrap;

/// The pose `b` of a frame that has the pose `a`.
pub fn compose(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = libm::sincos(a[2]);
    [a[0] + cos * b[0] - sin * b[1], a[1] + sin * b[0] + cos * b[1], wrap(a[2] + b[2])]
}

/// The other way round: of two frames, the second one's pose in the first to the first one's in the second.
pub fn inverse([x, y, heading_rad]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = libm::sincos(heading_rad);
    [-cos * x - sin * y, sin * x - cos * y, -heading_rad]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter to the left: what is ahead there is to the left here; and back again.
    #[test]
    fn frames_are_chained_and_turned_round() {
        let turned = [1.0, 2.0, std::f64::consts::FRAC_PI_2];
        let at = compose(turned, [3.0, 0.5, 0.1]);
        let expected = [0.5, 5.0, std::f64::consts::FRAC_PI_2 + 0.1];
        assert!(at.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{at:?}");
        let back = compose(inverse(turned), at);
        assert!(back.iter().zip([3.0, 0.5, 0.1]).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
    }
}
