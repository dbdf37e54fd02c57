//! Elementary functions in single precision whose loops vectorise and whose results are the same on every processor.
//!
//! Each is a few additions, multiplications, divisions and roots (which IEEE 754 rounds the same everywhere) and integer operations on
//! the bits, without a branch, a fused multiplication or a call. Coefficients: minimax in the weighted maximum norm (Lawson's
//! iteration on 600 to 1500 Chebyshev nodes, weights for the error stated), rounded to single precision. The errors stated with
//! each function include rounding; the tests hold them against `libm` over the whole domain.
//!
//! The standard library's `f32::min`, `max` and `clamp` leave open which of 0 and -0 they give; [`min`], [`max`] and [`clamp`] do not.

/// The smaller of two numbers; `b` when they are equal or not comparable.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers; `b` when they are equal or not comparable.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `x`, not below `low` nor above `high`; `low` for what is not a number.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    min(max(x, low), high)
}

/// Added to a number below 2^22, it leaves the number's nearest integer in the low bits: 1.5 * 2^23.
const ROUNDER: f32 = 12_582_912.0;

/// The largest integer not above `x`, as a number and as an integer. |x| must be below 2^22. Exact.
#[inline(always)]
pub fn floor(x: f32) -> (f32, i32) {
    let shifted = x + ROUNDER;
    let nearest = shifted - ROUNDER;
    let above = nearest > x;
    let integer = (shifted.to_bits() as i32).wrapping_sub(ROUNDER.to_bits() as i32);
    (nearest - if above { 1.0 } else { 0.0 }, integer - i32::from(above))
}

/// e^x with a relative error below 2e-7 for x from -87 to 88; arguments beyond count as these.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    /// ln 2 in two parts, the first of few bits, so that its multiples are exact.
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    let x = clamp(x, -87.0, 88.0);
    let shifted = x * std::f32::consts::LOG2_E + ROUNDER;
    let n = shifted - ROUNDER;
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    let p = 0.008_368_781 + r * 0.001_381_446_7;
    let p = 0.041_668_393 + r * p;
    let p = 0.166_665_2 + r * p;
    let p = 0.499_999_94 + r * p;
    let power = f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000));
    (1.0 + (r + r * r * p)) * power
}

/// Natural logarithm of a positive normal number, with an error below 1.2e-7 times the result's size, near 1 too.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    // x = m 2^k with m from sqrt(1/2) to sqrt(2).
    let bits = x.to_bits();
    let k = (bits.wrapping_sub(0x3f35_04f3) as i32) >> 23;
    let f = f32::from_bits(bits.wrapping_sub((k << 23) as u32)) - 1.0;
    let p = -0.142_674_86 + f * 0.087_004_356;
    let p = 0.149_147_67 + f * p;
    let p = -0.165_775_85 + f * p;
    let p = 0.199_630_65 + f * p;
    let p = -0.250_013_38 + f * p;
    let p = 0.333_339_1 + f * p;
    let square = f * f;
    let k = k as f32;
    k * LN2_HIGH + (f + (k * LN2_LOW + (square * f * p - 0.5 * square)))
}

/// Sine and cosine of (q + t) quarter turns, q an integer and t from -1/2 to 1/2, each with an error below 1e-7.
#[inline(always)]
pub fn sin_cos_quarters(q: u32, t: f32) -> (f32, f32) {
    let s = t * t;
    let p = 0.079_680_03 + s * -0.004_601_659_3;
    let p = -0.645_963_5 + s * p;
    let sine = t * (1.570_796_4 + s * p);
    let p = 0.253_669_23 + s * (-0.020_860_288 + s * 0.000_904_021_65);
    let cosine = 1.0 + s * (-1.233_700_5 + s * p);
    let odd = q & 1 != 0;
    let (a, b) = if odd { (cosine, sine) } else { (sine, cosine) };
    // Quarters 2 and 3 turn the sine's sign, 1 and 2 the cosine's.
    let sine_sign = (q & 2) << 30;
    let cosine_sign = (q.wrapping_add(1) & 2) << 30;
    (f32::from_bits(a.to_bits() ^ sine_sign), f32::from_bits(b.to_bits() ^ cosine_sign))
}

/// Angle of the vector (x, y) with x >= 0 and not both 0, from -pi/2 to pi/2, with an error below 2e-7.
#[inline(always)]
pub fn angle(y: f32, x: f32) -> f32 {
    let (low, high, steep) = angle_parts(y, x);
    angle_of(y, steep, low / high)
}

/// The smaller and the larger of |y| and x >= 0, and whether |y| is the larger: for those who have the quotient from a division
/// that they need anyway, and pass it to [`angle_of`].
#[inline(always)]
pub fn angle_parts(y: f32, x: f32) -> (f32, f32, bool) {
    let rise = y.abs();
    (min(rise, x), max(rise, x), rise > x)
}

/// The angle whose tangent, or (where it is `steep`) cotangent, is `t` from 0 to 1, with the sign of `y`.
#[inline(always)]
pub fn angle_of(y: f32, steep: bool, t: f32) -> f32 {
    let s = t * t;
    let p = -0.016_068_779 + s * 0.002_849_925;
    let p = 0.042_691_782 + s * p;
    let p = -0.075_043_19 + s * p;
    let p = 0.106_409_47 + s * p;
    let p = -0.142_036_48 + s * p;
    let p = 0.199_926_2 + s * p;
    let p = -0.333_330_72 + s * p;
    let small = t + t * s * p;
    let size = if steep { std::f32::consts::FRAC_PI_2 - small } else { small };
    f32::from_bits(size.to_bits() | (y.to_bits() & 0x8000_0000))
}

/// Argument beyond which [`phi`] is 0 or 1 but for 2e-7.
pub const PHI_END: f32 = 5.25;

/// Standard normal distribution function, with an error below 3e-7.
#[inline(always)]
pub fn phi(z: f32) -> f32 {
    let (p, q) = phi_parts(z);
    clamp(0.5 + p / q, 0.0, 1.0)
}

/// (phi(high) - phi(low)) / width for high >= low, with an error below 4e-7 / width; with a single division.
#[inline(always)]
pub fn phi_between(low: f32, high: f32, width: f32) -> f32 {
    let (p0, q0) = phi_parts(low);
    let (p1, q1) = phi_parts(high);
    max((p1 * q0 - p0 * q1) / (q0 * q1 * width), 0.0)
}

/// Numerator and denominator of phi(z) - 1/2.
#[inline(always)]
fn phi_parts(z: f32) -> (f32, f32) {
    let z = clamp(z, -PHI_END, PHI_END);
    let s = z * z;
    let p = 3.274_888_3e-4 + s * 6.044_54e-6;
    let p = 0.005_606_171_7 + s * p;
    let p = 0.398_941_87 + s * (0.050_793_193 + s * p);
    let q = 1.174_655e-4 + s * 5.152_334_7e-7;
    let q = 0.002_781_031_7 + s * q;
    let q = 1.0 + s * (0.293_979_73 + s * (0.038_061_302 + s * q));
    (z * p, q)
}

/// The two normal numbers of a drawn number, as [`crate::noise::normals`], with an error below 2e-6.
#[inline(always)]
pub fn normals(bits: u32) -> (f32, f32) {
    let share = ((bits >> 12) as i32 as f32 + 0.5) * (1.0 / (1 << 20) as f32);
    let radius = (-2.0 * ln(share)).sqrt();
    let turn = (bits & 0xfff) + 512;
    let quarter = ((turn & 0x3ff) as i32 as f32 - 511.5) * (1.0 / 1024.0);
    let (sine, cosine) = sin_cos_quarters(turn >> 10, quarter);
    (radius * cosine, radius * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest |found(x) - exact(x)| over `steps` places from `low` to `high`.
    fn worst(low: f32, high: f32, steps: u32, error: impl Fn(f32) -> f64) -> f64 {
        let at = |i: u32| low + (high - low) * (i as f32 / steps as f32);
        (0..=steps).map(|i| error(at(i))).fold(0.0, f64::max)
    }

    #[test]
    fn exponentials() {
        let relative = |x: f32| (f64::from(exp(x)) / libm::exp(f64::from(x)) - 1.0).abs();
        let found = worst(-87.0, 88.0, 2_000_000, relative).max(worst(-1.0, 1.0, 1_000_000, relative));
        assert!(found < 2e-7, "{found}");
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-1e9), exp(-87.0));
    }

    #[test]
    fn logarithms() {
        let relative = |x: f32| (f64::from(ln(x)) / libm::log(f64::from(x)) - 1.0).abs();
        // Every argument that a normal number asks for, and both sides of 1.
        let drawn = (0..1 << 20).map(|k| relative((k as f32 + 0.5) / (1 << 20) as f32)).fold(0.0, f64::max);
        let found = worst(1e-30, 1e-3, 100_000, relative).max(worst(1.001, 1e6, 1_000_000, relative)).max(drawn);
        assert!(found < 1.2e-7, "{found}");
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn sines_and_cosines() {
        let mut found = 0.0_f64;
        for q in 0..5 {
            found = found.max(worst(-0.5, 0.5, 200_000, |t| {
                let (s, c) = sin_cos_quarters(q, t);
                let (exact_s, exact_c) = libm::sincos((f64::from(q) + f64::from(t)) * std::f64::consts::FRAC_PI_2);
                (f64::from(s) - exact_s).abs().max((f64::from(c) - exact_c).abs())
            }));
        }
        assert!(found < 1e-7, "{found}");
    }

    #[test]
    fn angles() {
        let error =
            |x: f32| worst(-8.0, 8.0, 100_000, |y| (f64::from(angle(y, x)) - libm::atan2(f64::from(y), f64::from(x))).abs());
        let found = [1e-6, 0.1, 0.9, 1.0, 3.0, 100.0].map(error).into_iter().fold(0.0, f64::max);
        assert!(found < 2e-7, "{found}");
        assert_eq!(angle(-1.0, 0.0), -std::f32::consts::FRAC_PI_2);
    }

    #[test]
    fn the_normal_distribution() {
        let found = worst(-8.0, 8.0, 2_000_000, |z| (f64::from(phi(z)) - crate::coverage::phi(f64::from(z))).abs());
        assert!(found < 3e-7, "{found}");
        assert!(worst(-8.0, 8.0, 100_000, |z| (f64::from(phi(z)) + f64::from(phi(-z)) - 1.0).abs()) < 1.3e-7);
        assert_eq!(phi(0.0), 0.5);
        assert!((0.0..2e-7).contains(&phi(-1e9)) && (1.0 - 2e-7..=1.0).contains(&phi(1e9)));
    }

    #[test]
    fn parts_of_the_normal_distribution() {
        for width in [1.0_f32, 0.1, 1e-3] {
            let found = worst(-7.0, 7.0, 1_000_000, |low| {
                let high = low + width;
                let exact = crate::coverage::phi(f64::from(high)) - crate::coverage::phi(f64::from(low));
                (f64::from(phi_between(low, high, 1.0)) - exact).abs()
            });
            assert!(found < 4e-7, "{width}: {found}");
        }
    }

    #[test]
    fn floors() {
        for x in [-3.0, -2.5, -0.0, 0.0, 0.49, 0.5, 0.99, 1.0, 1.5, 2.5, 4_000_000.3, -4_000_000.3, 1e-30, -1e-30] {
            assert_eq!(floor(x), (x.floor(), x.floor() as i32), "{x}");
        }
    }

    #[test]
    fn normal_numbers() {
        let mut found = 0.0_f64;
        for i in 0..4_000_000u32 {
            let bits = crate::noise::finalise(i);
            let (a, b) = normals(bits);
            let [exact_a, exact_b] = crate::noise::normals(bits);
            found = found.max((f64::from(a) - exact_a).abs()).max((f64::from(b) - exact_b).abs());
        }
        assert!(found < 2e-6, "{found}");
    }
}
