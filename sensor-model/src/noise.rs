//! Random numbers by counter: each is a function of (seed, stream, frame, pixel) alone, so frames may be made in any order, on
//! any engine.
//!
//! | stream | one number | used for |
//! |---|---|---|
//! | `Gain` | a pixel, for all frames | photo-response non-uniformity |
//! | `Radius`, `Angle` | a pixel and frame | Box and Muller's pair of normal numbers: the first is shot and read noise, the second speckle |
//!
//! A key is mixed on the CPU from (seed, stream, frame); a renderer then needs one round of [`finalise`] a number:
//! `finalise(pixel ^ key)`, pixel = row * width + column.
//!
//! Shot noise is a normal number whose variance is the electrons' (Poisson's law from some twenty electrons on; below, the read
//! noise hides the difference). Read noise is independent of it, so both are one normal number of the summed variance.
//! Speckle is a gamma distribution of mean 1 (Goodman, Speckle Phenomena in Optics, section 4.6: intensity integrated over a
//! pixel), made from a normal number by the cube of Wilson and Hilferty (1931), exact in mean and variance within 0.4 %.

/// A named sequence of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Gain of a pixel.
    Gain = 1,
    /// Radius of Box and Muller's pair.
    Radius = 2,
    /// Angle of Box and Muller's pair.
    Angle = 3,
    /// Angle of the pair whose radius is `Gain`.
    GainAngle = 4,
}

/// A bijection of 32-bit numbers in which every input bit moves every output bit (C. Wellons, lowbias32, bias 0.17).
pub fn finalise(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Key of a stream in a frame: the mixing of `SplitMix64` (Steele, Lea and Flood 2014) of the three, folded to 32 bits.
pub fn key(seed: u64, stream: Stream, frame: u64) -> u32 {
    let mix = |x: u64| {
        let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    let mixed = mix(mix(mix(seed) ^ stream as u64) ^ frame);
    (mixed >> 32) as u32 ^ mixed as u32
}

/// Two independent normal numbers of mean 0 and variance 1 (Box and Muller 1958) from two 32-bit numbers, of which the upper 24
/// bits count: none exceeds 5.9.
pub fn normals(radius_bits: u32, angle_bits: u32) -> [f64; 2] {
    const STEP: f64 = 1.0 / (1 << 24) as f64;
    let radius = (-2.0 * libm::log((f64::from(radius_bits >> 8) + 0.5) * STEP)).sqrt();
    let (s, c) = libm::sincos(std::f64::consts::TAU * f64::from(angle_bits >> 8) * STEP);
    [radius * c, radius * s]
}

/// Factor that speckle of this contrast puts on a pixel's laser light, from a normal number.
pub fn speckle(contrast: f64, normal: f64) -> f64 {
    let [constant, slope] = speckle_terms(contrast);
    let root = (constant + slope * normal).max(0.0);
    root * root * root
}

/// (constant, slope) of the linear function of a normal number whose cube is the speckle's factor.
pub fn speckle_terms(contrast: f64) -> [f64; 2] {
    [1.0 - contrast * contrast / 9.0, contrast / 3.0]
}

/// Gains of the first `pixels` pixels, of mean 1 and standard deviation `prnu`.
///
/// None is below 0, which a normal number may ask for from `prnu` = 0.17 on (1 / 5.9): light would be taken away, and shot
/// noise would be the root of a negative number. At the most that `prnu` may be, 0.2, three pixels in ten million are cut.
pub fn gains(seed: u64, prnu: f64, pixels: usize) -> impl Iterator<Item = f64> {
    let (radius, angle) = (key(seed, Stream::Gain, 0), key(seed, Stream::GainAngle, 0));
    (0..pixels as u32).map(move |pixel| {
        let [normal, _] = normals(finalise(pixel ^ radius), finalise(pixel ^ angle));
        (1.0 + prnu * normal).max(0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of n numbers, with their standard errors sqrt(v / n) and v sqrt(2 / n) bounding the tests by four.
    fn moments(values: impl Iterator<Item = f64>) -> (f64, f64, f64) {
        let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for v in values {
            n += 1.0;
            sum += v;
            squares += v * v;
        }
        let mean = sum / n;
        (n, mean, squares / n - mean * mean)
    }

    fn pairs(frame: u64) -> impl Iterator<Item = [f64; 2]> {
        let (r, a) = (key(7, Stream::Radius, frame), key(7, Stream::Angle, frame));
        (0..300_000u32).map(move |p| normals(finalise(p ^ r), finalise(p ^ a)))
    }

    #[test]
    fn normals_have_mean_0_variance_1_and_no_correlation() {
        for frame in [0, 1, 2, 1 << 40] {
            for part in 0..2 {
                let (n, mean, variance) = moments(pairs(frame).map(|p| p[part]));
                assert!(mean.abs() < 4.0 / n.sqrt(), "frame {frame}: mean {mean}");
                assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "frame {frame}: variance {variance}");
            }
            let (n, covariance, _) = moments(pairs(frame).map(|p| p[0] * p[1]));
            assert!(covariance.abs() < 4.0 / n.sqrt());
            let (n, neighbours, _) = moments(pairs(frame).zip(pairs(frame).skip(1)).map(|(a, b)| a[0] * b[0]));
            assert!(neighbours.abs() < 4.0 / n.sqrt());
            let (n, frames, _) = moments(pairs(frame).zip(pairs(frame + 1)).map(|(a, b)| a[0] * b[0]));
            assert!(frames.abs() < 4.0 / n.sqrt());
        }
    }

    #[test]
    fn speckle_has_mean_1_and_the_contrast_asked_for() {
        for contrast in [0.12, 0.3, 1.0] {
            let (n, mean, variance) = moments(pairs(3).map(|p| speckle(contrast, p[1])));
            // 0.4 % is what the cube's distribution lacks at contrast 1; the rest is the sample's.
            assert!((mean - 1.0).abs() < 0.004 + 4.0 * contrast / n.sqrt(), "{contrast}: mean {mean}");
            assert!((variance.sqrt() / contrast - 1.0).abs() < 0.004 + 8.0 / n.sqrt(), "{contrast}: {}", variance.sqrt());
        }
    }

    #[test]
    fn no_gain_is_negative() {
        // The seed is one of those for which an early pixel's normal number is below -5.
        let (seed, pixel) = (1061, 421);
        let drawn = |stream| finalise(pixel as u32 ^ key(seed, stream, 0));
        let [normal, _] = normals(drawn(Stream::Gain), drawn(Stream::GainAngle));
        assert!(1.0 + 0.2 * normal < -0.05, "this pixel's normal number is {normal}");
        let gains: Vec<f64> = gains(seed, 0.2, 1000).collect();
        assert_eq!(gains[pixel], 0.0);
        assert!(gains.iter().enumerate().all(|(other, gain)| other == pixel || *gain > 0.0));
    }
}
