//! Random numbers by counter: each is a function of what it is for alone, so that nothing depends on the order of drawing.

/// A number from 0 to below 1, of (seed, index, stream) alone: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014) over the three in turn.
pub(crate) fn uniform(seed: u64, index: u64, stream: u64) -> f64 {
    let mix = |z: u64| {
        let z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    // 53 bits are what an f64 holds.
    (mix(mix(mix(seed) ^ index) ^ stream) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A standard normal number (Box and Muller), of this stream and the next.
#[cfg(feature = "cli")]
pub(crate) fn normal(seed: u64, index: u64, stream: u64) -> f64 {
    let [radius, angle] = [0, 1].map(|half| uniform(seed, index, stream + half));
    (-2.0 * libm::log(1.0 - radius)).sqrt() * libm::cos(std::f64::consts::TAU * angle)
}
