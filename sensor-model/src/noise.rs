//! Random numbers by counter: each is a function of (seed, stream, frame, place) alone, so frames may be made in any order, on
//! any engine, in any parts.
//!
//! A key of two words is mixed from (seed, stream, frame); a renderer then needs one [`draw`]`(counter, key)` of 32 bits:
//!
//! ```text
//! x = counter ^ key[0];  x ^= x >> 16;  x *= 0x7feb352d;  x ^= (x >> 15) ^ key[1];  x *= 0x846ca68b;  x ^= x >> 16
//! ```
//!
//! Places are numbered `8192 row + column` ([`place`]), whatever the image's width: images are 8192 pixels wide at most. A drawn
//! number gives *two* normal numbers by Box and Muller (1958), [`normals`]: the upper 20 bits are the radius, the lower 12 the angle.
//! In each sixteen places of a row the first eight take the pairs' cosines, the last eight their sines:
//!
//! ```text
//! normal(p) = normals(draw(((p >> 4) << 3) | (p & 7), key))[(p >> 3) & 1]
//! ```
//!
//! | stream | counter | used for |
//! |---|---|---|
//! | `Gain` | pair of a pixel, frame 0 | photo-response non-uniformity: gain = max(1 + PRNU N, 0) |
//! | `Dark` | pair of a pixel, frame 0 | dark signal non-uniformity: DSNU N electrons |
//! | `Hot`, `HotRate` | pixel, frame 0 | which pixels are hot, and how hot ([`hot_pixels`]) |
//! | `Shot` | pair of a pixel, each frame | shot, dark and read noise, one normal number of the summed variance |
//! | `Speckle` | pair of a node of the grain's lattice, each frame | speckle of the lasers' light ([`grain`]) |
//!
//! Shot noise is a normal number whose variance is the electrons' (Poisson's law from some twenty electrons on; below, the read
//! noise hides the difference). Speckle is a gamma distribution of mean 1 (Goodman, Speckle Phenomena in Optics, section 4.6:
//! intensity integrated over a pixel), made from a normal number by the cube of Wilson and Hilferty (1931), exact in mean and
//! variance within 0.4 %. Its normal number is that of the pixel where a grain is one pixel; with larger grains it is interpolated
//! between the nodes of a lattice of that spacing and keeps its variance ([`grain`]).
//!
//! Spangle is not the sensor's: it stays on its sheet, and neither seed nor frame is in it ([`spangle_node`]).

/// A named sequence of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Gain of a pixel.
    Gain = 1,
    /// Shot and read noise of a pixel in a frame.
    Shot = 2,
    /// Speckle at a node of the grain's lattice in a frame.
    Speckle = 3,
    /// Dark value of a pixel.
    Dark = 4,
    /// Whether a pixel is hot.
    Hot = 5,
    /// How hot.
    HotRate = 6,
}

/// Key of a stream in a frame.
pub type Key = [u32; 2];

/// Places in a row, of which an image uses the first: the widest image that a rig may have.
pub const ROW_PLACES: u32 = 8192;

/// A bijection of 32-bit numbers in which every input bit moves every output bit (C. Wellons, lowbias32, bias 0.17).
pub fn finalise(x: u32) -> u32 {
    draw(x, [0, 0])
}

/// The number that a key has at a counter: [`finalise`], with one word of the key going in before it and one in its middle, so that
/// two frames whose first words are near do not draw the same numbers in another order.
#[inline(always)]
pub fn draw(counter: u32, key: Key) -> u32 {
    let mut x = counter ^ key[0];
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= (x >> 15) ^ key[1];
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Key of a stream in a frame: the mixing of `SplitMix64` (Steele, Lea and Flood 2014) of the three, upper half first.
pub fn key(seed: u64, stream: Stream, frame: u64) -> Key {
    let mix = |x: u64| {
        let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    let mixed = mix(mix(mix(seed) ^ stream as u64) ^ frame);
    [(mixed >> 32) as u32, mixed as u32]
}

/// Number of a pixel, or of a node of a lattice.
#[inline(always)]
pub fn place(column: u32, row: u32) -> u32 {
    row * ROW_PLACES + column
}

/// Counter of the pair that a place shares with the place eight before or after it.
#[inline(always)]
pub fn pair(place: u32) -> u32 {
    ((place >> 4) << 3) | (place & 7)
}

/// Two independent normal numbers of mean 0 and variance 1 (Box and Muller 1958): r cos(a), r sin(a) with
/// r^2 = -2 ln((upper 20 bits + 1/2) / 2^20), a = 2 pi (lower 12 bits + 1/2) / 2^12. None exceeds 5.4.
pub fn normals(bits: u32) -> [f64; 2] {
    let radius = (-2.0 * libm::log((f64::from(bits >> 12) + 0.5) / f64::from(1 << 20))).sqrt();
    let (s, c) = libm::sincos(std::f64::consts::TAU * (f64::from(bits & 0xfff) + 0.5) / f64::from(1 << 12));
    [radius * c, radius * s]
}

/// The normal number of a place.
pub fn normal(place: u32, key: Key) -> f64 {
    normals(draw(pair(place), key))[(place >> 3) as usize & 1]
}

/// Factor that speckle of this contrast puts on a pixel's laser light, from a normal number: gamma-distributed after Wilson and
/// Hilferty (Proc. Natl. Acad. Sci. 17, 1931), whose cube is a few per cent too skew at contrast 1.
pub fn speckle(contrast: f64, normal: f64) -> f64 {
    let [constant, slope] = speckle_terms(contrast);
    let root = (constant + slope * normal).max(0.0);
    root * root * root
}

/// (constant, slope) of the linear function of a normal number whose cube is the speckle's factor.
pub fn speckle_terms(contrast: f64) -> [f64; 2] {
    [1.0 - contrast * contrast / 9.0, contrast / 3.0]
}

/// Where a column (or row) lies in the lattice of the speckle's grain: the node at or before it, and the weights of that node and the next.
///
/// The normal number of pixel (u, v) is the sum over the four nodes about it of `weight_u weight_v normal(place(i, j))`; each pair of
/// weights is a smoothstep and its rest over the root of the sum of their squares, so the sum has variance 1 everywhere.
pub fn grain(at_px: usize, spacing_px: f64) -> (u32, [f64; 2]) {
    let at = at_px as f64 / spacing_px;
    let node = at.floor();
    let share = at - node;
    let smooth = share * share * (3.0 - 2.0 * share);
    let length = ((1.0 - smooth) * (1.0 - smooth) + smooth * smooth).sqrt();
    (node as u32, [(1.0 - smooth) / length, smooth / length])
}

/// Gains of an image's pixels, row by row, of mean 1 and standard deviation `prnu`.
///
/// None is below 0, which a normal number may ask for from `prnu` = 0.185 on (1 / 5.4): light would be taken away, and shot
/// noise would be the root of a negative number.
pub fn gains(seed: u64, prnu: f64, width_px: usize, height_px: usize) -> impl Iterator<Item = f64> {
    let key = key(seed, Stream::Gain, 0);
    places(width_px, height_px).map(move |p| (1.0 + prnu * normal(p, key)).max(0.0))
}

/// Dark values of an image's pixels, row by row, in electrons, of mean 0 and standard deviation `dsnu_e`.
pub fn dark_values(seed: u64, dsnu_e: f64, width_px: usize, height_px: usize) -> impl Iterator<Item = f64> {
    let key = key(seed, Stream::Dark, 0);
    places(width_px, height_px).map(move |p| dsnu_e * normal(p, key))
}

/// The hot pixels among an image's, as (column, row, electrons a second): each is hot with the probability `share`, and how hot is
/// distributed exponentially with the mean `mean_e_s`.
pub fn hot_pixels(
    seed: u64,
    share: f64,
    mean_e_s: f64,
    width_px: usize,
    height_px: usize,
) -> impl Iterator<Item = (usize, usize, f64)> {
    let [hot, rate] = [Stream::Hot, Stream::HotRate].map(|stream| key(seed, stream, 0));
    let uniform = |bits: u32| (f64::from(bits) + 0.5) / 4_294_967_296.0;
    places(width_px, height_px)
        .filter(move |p| uniform(draw(*p, hot)) < share)
        .map(move |p| ((p % ROW_PLACES) as usize, (p / ROW_PLACES) as usize, -mean_e_s * libm::log(uniform(draw(p, rate)))))
}

/// The places of an image's pixels, row by row.
fn places(width_px: usize, height_px: usize) -> impl Iterator<Item = u32> {
    (0..height_px as u32).flat_map(move |row| (0..width_px as u32).map(move |column| place(column, row)))
}

/// The nearly normal number of node (i, j) of a sheet's spangle: the sum of the four bytes of
/// `finalise((i * 0x8da6b343) ^ (j * 0xd8163841) ^ finalise(sheet))`, less 510, over [`SPANGLE_STEP`]. Mean 0, variance 1, none
/// beyond 3.46.
#[inline(always)]
pub fn spangle_node(i: i32, j: i32, sheet_bits: u32) -> i32 {
    let x = draw((i as u32).wrapping_mul(0x8da6_b343) ^ (j as u32).wrapping_mul(0xd816_3841) ^ sheet_bits, [0, 0]);
    let halves = (x & 0x00ff_00ff) + ((x >> 8) & 0x00ff_00ff);
    ((halves & 0xffff) + (halves >> 16)) as i32 - 510
}

/// Standard deviation of the sum of four bytes: 2 sqrt((256^2 - 1) / 12).
pub const SPANGLE_STEP: f64 = 147.800_541_270_997_2;

/// Mean square of the spangle noise's derivative along s or t. Between two nodes the noise is cos(theta) a + sin(theta) b with
/// tan(theta) = q / (1 - q), q = 3 p^2 - 2 p^3; this is the mean of (d theta / d p)^2.
pub const SPANGLE_SLOPE2: f64 = 3.372_178;

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

    /// The normal numbers of an image's pixels in a frame.
    fn field(frame: u64) -> impl Iterator<Item = f64> {
        let key = key(7, Stream::Shot, frame);
        places(640, 480).map(move |p| normal(p, key))
    }

    #[test]
    fn normals_have_mean_0_variance_1_and_no_correlation() {
        for frame in [0, 1, 2, 1 << 40] {
            let (n, mean, variance) = moments(field(frame));
            assert!(mean.abs() < 4.0 / n.sqrt(), "frame {frame}: mean {mean}");
            assert!((variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "frame {frame}: variance {variance}");
            // Neighbours in a row, partners of a pair, neighbours in a column; and the next frame's.
            for lag in [1, 8, 640] {
                let (n, covariance, _) = moments(field(frame).zip(field(frame).skip(lag)).map(|(a, b)| a * b));
                assert!(covariance.abs() < 4.0 / n.sqrt(), "frame {frame}, lag {lag}: {covariance}");
            }
            let (n, frames, _) = moments(field(frame).zip(field(frame + 1)).map(|(a, b)| a * b));
            assert!(frames.abs() < 4.0 / n.sqrt());
        }
    }

    /// The variance of each pixel over many frames: keys, too, are mixed.
    #[test]
    fn a_pixel_varies_from_frame_to_frame_as_pixels_do() {
        for p in [0, 8, place(639, 479)] {
            let (n, mean, variance) = moments((0..100_000).map(|frame| normal(p, key(3, Stream::Shot, frame))));
            assert!(mean.abs() < 4.0 / n.sqrt() && (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
        }
    }

    #[test]
    fn speckle_has_mean_1_and_the_contrast_asked_for() {
        for contrast in [0.12, 0.3, 1.0] {
            let (n, mean, variance) = moments(field(3).map(|normal| speckle(contrast, normal)));
            // 0.4 % is what the cube's distribution lacks at contrast 1; the rest is the sample's.
            assert!((mean - 1.0).abs() < 0.004 + 4.0 * contrast / n.sqrt(), "{contrast}: mean {mean}");
            assert!((variance.sqrt() / contrast - 1.0).abs() < 0.004 + 8.0 / n.sqrt(), "{contrast}: {}", variance.sqrt());
            // Twice the contrast is a gamma distribution's; the cube's is up to 3 % more, the rest is the sample's.
            let cube = |x: f64| x * x * x;
            let (_, third, _) = moments(field(3).map(|normal| cube(speckle(contrast, normal) - mean)));
            let skewness = third / cube(variance.sqrt());
            println!("{contrast}: skewness {skewness}");
            assert!((skewness / (2.0 * contrast) - 1.0).abs() < 0.033 + 0.02, "{contrast}: skewness {skewness}");
        }
    }

    #[test]
    fn a_grain_of_one_pixel_is_the_pixels_own_number_and_larger_ones_keep_the_variance() {
        assert_eq!(grain(17, 1.0), (17, [1.0, 0.0]));
        for (spacing, at) in [(1.5, 10), (2.0, 7), (3.7, 100)] {
            let (node, [a, b]) = grain(at, spacing);
            assert_eq!(f64::from(node), (at as f64 / spacing).floor());
            assert!((a * a + b * b - 1.0).abs() < 1e-15 && a >= 0.0 && b >= 0.0);
        }
    }

    #[test]
    fn no_gain_is_negative() {
        // With this seed and 0.2, the gain of one of the first pixels would be below 0.
        let (seed, column) = NEGATIVE;
        let asked = 1.0 + 0.2 * normal(column, key(seed, Stream::Gain, 0));
        assert!(asked < 0.0, "this pixel's gain would be {asked}");
        assert_eq!(gains(seed, 0.2, 1000, 1).nth(column as usize), Some(0.0));
        assert!(gains(seed, 0.2, 1000, 1).all(|gain| gain >= 0.0));
    }

    #[test]
    fn hot_pixels_are_as_many_and_as_hot_as_asked_for() {
        let (share, mean) = (0.01, 500.0);
        let (n, found, _) = moments(hot_pixels(9, share, mean, 640, 480).map(|(.., rate)| rate));
        // Binomial and exponential: standard deviations sqrt(n) and mean / sqrt(n).
        let expected = share * 640.0 * 480.0;
        assert!((n - expected).abs() < 4.0 * expected.sqrt(), "{n} pixels");
        assert!((found - mean).abs() < 4.0 * mean / n.sqrt(), "mean {found}");
        assert!(hot_pixels(9, 0.0, mean, 640, 480).next().is_none());
    }

    #[test]
    fn spangle_has_mean_0_and_variance_1() {
        let bits = finalise(5);
        let nodes = (-250..250).flat_map(|i| (-250..250).map(move |j| f64::from(spangle_node(i, j, bits)) / SPANGLE_STEP));
        let (n, mean, variance) = moments(nodes);
        assert!(mean.abs() < 4.0 / n.sqrt() && (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{mean} {variance}");
    }

    /// A seed and a column whose gain at 0.2 would be negative, found by trying seeds in turn.
    const NEGATIVE: (u64, u32) = (7834, 58);

    /// A lattice's weights are flat at its nodes, so that no kink shows where they are, and halfway both nodes count alike.
    #[test]
    fn a_grain_goes_smoothly_from_node_to_node() {
        let weight = |at: usize| grain(at, 1000.0).1;
        // A smoothstep rises by three times the square of the share of the way.
        for (at, next) in [(1, 3e-6), (10, 3e-4)] {
            assert!((weight(at)[1] / next - 1.0).abs() < 0.01, "{:?}", weight(at));
            assert!((weight(1000 - at)[0] / next - 1.0).abs() < 0.01, "{:?}", weight(1000 - at));
        }
        let [a, b] = weight(500);
        assert!((a - b).abs() < 1e-15);
    }
}
