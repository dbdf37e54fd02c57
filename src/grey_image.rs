//! A camera image, of 8 bits a value or of more.

use std::borrow::Cow;
use std::ops::Range;

use ductloop_nav::messages::{Frame, Pixels};
use ductloop_nav::rig::Camera;
use ductloop_sensor::optics::Bits;
use ductloop_sensor::renderer::ImageMut;

/// Grey values, row by row from the top left.
#[derive(Debug, PartialEq, Eq)]
pub struct GreyImage {
    width_px: usize,
    height_px: usize,
    bits: Bits,
    values: Values,
}

#[derive(Debug, PartialEq, Eq)]
enum Values {
    Grey8(Vec<u8>),
    Grey16(Vec<u16>),
}

impl GreyImage {
    /// A black image of a camera whose CCD has so many bits.
    pub fn black(camera: &Camera, bits: Bits) -> Self {
        let Camera { width_px, height_px, .. } = *camera;
        let pixels = width_px * height_px;
        let values = if bits == Bits::Eight { Values::Grey8(vec![0; pixels]) } else { Values::Grey16(vec![0; pixels]) };
        Self { width_px, height_px, bits, values }
    }

    /// An image of these grey values; `None` where they are not as many as `size_px` (columns, rows) says, or too large for the
    /// bits.
    pub fn of(size_px: [usize; 2], bits: Bits, values: &[u16]) -> Option<Self> {
        let [width_px, height_px] = size_px;
        if values.len() != width_px * height_px || values.iter().any(|value| u32::from(*value) > bits.max_dn()) {
            return None;
        }
        let values = match bits {
            Bits::Eight => Values::Grey8(values.iter().map(|value| *value as u8).collect()),
            Bits::Ten | Bits::Twelve => Values::Grey16(values.to_vec()),
        };
        Some(Self { width_px, height_px, bits, values })
    }

    /// Columns and rows.
    pub fn size_px(&self) -> [usize; 2] {
        [self.width_px, self.height_px]
    }

    /// Bits of a grey value.
    pub fn bits(&self) -> Bits {
        self.bits
    }

    /// The grey values.
    pub fn pixels(&self) -> Pixels<'_> {
        match &self.values {
            Values::Grey8(values) => Pixels::Grey8(values),
            Values::Grey16(values) => Pixels::Grey16(values),
        }
    }

    /// As a navigator gets it.
    pub fn frame(&self) -> Frame<'_> {
        let [width_px, height_px] = self.size_px();
        // 4095 at most.
        Frame { width_px, height_px, pixels: self.pixels(), max_dn: self.bits.max_dn() as u16 }
    }

    /// Room for a renderer.
    pub fn room(&mut self) -> ImageMut<'_> {
        match &mut self.values {
            Values::Grey8(values) => ImageMut::Grey8(values),
            Values::Grey16(values) => ImageMut::Grey16(values),
        }
    }

    /// Multiplies the light of the pixels in `columns` and `rows` (as far as they are in the image) by a factor of (column, row): what
    /// their value is above `black_dn`, in DN of 8 bits.
    pub fn scale_light(&mut self, black_dn: f64, [columns, rows]: [Range<usize>; 2], factor: impl Fn(usize, usize) -> f64) {
        let (width_px, max_dn) = (self.width_px, f64::from(self.bits.max_dn()));
        let black = black_dn * max_dn / 255.0;
        for v in rows.start..rows.end.min(self.height_px) {
            for u in columns.start..columns.end.min(width_px) {
                let scaled = |value: f64| (black + (value - black) * factor(u, v)).round().clamp(0.0, max_dn);
                match &mut self.values {
                    Values::Grey8(values) => values[v * width_px + u] = scaled(f64::from(values[v * width_px + u])) as u8,
                    Values::Grey16(values) => values[v * width_px + u] = scaled(f64::from(values[v * width_px + u])) as u16,
                }
            }
        }
    }

    /// Hands over all bytes in order, those of 16-bit values little-endian.
    pub fn bytes(&self, mut take: impl FnMut(&[u8])) {
        match &self.values {
            Values::Grey8(values) => take(values),
            Values::Grey16(values) => {
                let mut bytes = [0; 2048];
                for chunk in values.chunks(bytes.len() / 2) {
                    for (pair, value) in bytes.chunks_exact_mut(2).zip(chunk) {
                        pair.copy_from_slice(&value.to_le_bytes());
                    }
                    take(&bytes[..2 * chunk.len()]);
                }
            }
        }
    }

    /// The image in 8 bits, for the eye: the largest value becomes 255.
    pub fn to_8_bits(&self) -> Cow<'_, [u8]> {
        match &self.values {
            Values::Grey8(values) => Cow::Borrowed(values),
            Values::Grey16(values) => {
                let max = self.bits.max_dn();
                Cow::Owned(values.iter().map(|v| ((u32::from(*v).min(max) * 255 + max / 2) / max) as u8).collect())
            }
        }
    }
}

impl Clone for GreyImage {
    fn clone(&self) -> Self {
        let values = match &self.values {
            Values::Grey8(values) => Values::Grey8(values.clone()),
            Values::Grey16(values) => Values::Grey16(values.clone()),
        };
        Self { values, ..*self }
    }

    /// Uses the memory that is there: a steady run copies images without allocating.
    fn clone_from(&mut self, source: &Self) {
        match (&mut self.values, &source.values) {
            (Values::Grey8(here), Values::Grey8(there)) => here.clone_from(there),
            (Values::Grey16(here), Values::Grey16(there)) => here.clone_from(there),
            _ => return *self = source.clone(),
        }
        (self.width_px, self.height_px, self.bits) = (source.width_px, source.height_px, source.bits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(bits: Bits, fill: impl Fn(usize) -> u16) -> GreyImage {
        let values: Vec<u16> = (0..50 * 41).map(fill).collect();
        GreyImage::of([50, 41], bits, &values).expect("so many values, none too large")
    }

    #[test]
    fn what_does_not_fit_is_no_image() {
        assert_eq!(GreyImage::of([2, 2], Bits::Eight, &[1, 2, 3]), None);
        assert_eq!(GreyImage::of([2, 1], Bits::Ten, &[1023, 1024]), None);
        assert_eq!(GreyImage::of([2, 1], Bits::Eight, &[255, 256]), None);
    }

    #[test]
    fn bytes_are_little_endian_and_complete() {
        let deep = image(Bits::Twelve, |i| i as u16);
        let mut bytes = Vec::new();
        deep.bytes(|part| bytes.extend_from_slice(part));
        assert_eq!(bytes, (0..50 * 41).flat_map(|i: u16| [i as u8, (i >> 8) as u8]).collect::<Vec<_>>());
        let mut bytes = Vec::new();
        image(Bits::Eight, |i| i as u16 % 256).bytes(|part| bytes.extend_from_slice(part));
        assert_eq!(bytes, (0..50 * 41).map(|i: u16| i as u8).collect::<Vec<_>>());
    }

    #[test]
    fn eight_bits_for_the_eye_span_the_whole_range() {
        for bits in [Bits::Ten, Bits::Twelve] {
            let max = bits.max_dn() as u16;
            let deep = image(bits, |i| [0, max / 2, max][i % 3]);
            assert_eq!(deep.to_8_bits()[..3], [0, 127, 255], "{bits:?}");
            assert_eq!(deep.frame().max_dn, max);
        }
    }

    #[test]
    fn copies_are_equal_whatever_was_there_before() {
        let (eight, twelve) = (image(Bits::Eight, |i| i as u16 % 256), image(Bits::Twelve, |i| i as u16));
        for source in [&eight, &twelve] {
            for target in [&eight, &twelve] {
                let mut copy = target.clone();
                copy.clone_from(source);
                assert_eq!(&copy, source);
            }
        }
    }
}
