//! A picture file as the perception takes it: one grey value a pixel out of a PNG or a JPEG of 8 or 16 bits, grey or coloured.

use std::borrow::Cow;
use std::io::Cursor;

use ductloop_nav::messages::Frame;
use ductloop_nav::perception::ridge::Region;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};

mod whole_jpeg;

/// Most bytes of a picture's file.
pub const LARGEST_BYTES: u64 = 512 << 20;
/// Most columns and rows of a picture, as of a rig's camera.
pub const LARGEST_PX: usize = 8192;

/// Grey values of a picture, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    width_px: usize,
    height_px: usize,
    values: Values,
    max_dn: u16,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    Grey8(Vec<u8>),
    Grey16(Vec<u16>),
}

/// What of a coloured picture is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Luminance: 0.2126 red + 0.7152 green + 0.0722 blue (ITU-R BT.709).
    #[default]
    Grey,
    /// Red alone.
    Red,
    /// Green alone.
    Green,
    /// Blue alone.
    Blue,
    /// Red less the mean of green and blue: a red laser on whatever is grey.
    RedExcess,
    /// Green less the mean of red and blue.
    GreenExcess,
    /// Blue less the mean of red and green.
    BlueExcess,
}

/// Why a file cannot be read as a picture.
#[derive(Debug, thiserror::Error)]
pub enum PhotographError {
    /// It is neither a PNG nor a JPEG, or a broken one.
    #[error("cannot be read as PNG or JPEG: {0}")]
    Picture(#[from] ImageError),
    /// A JPEG whose end is missing. Decoders fill in grey for what is not there.
    #[error("cut short: the end of the JPEG is missing")]
    CutShort,
    /// It has no colours.
    #[error("the picture is grey: it has no `{0}`")]
    Grey(&'static str),
    /// Its values are larger than the largest one that was said.
    #[error("it has a value of {value}, more than the {max_dn} that its bits hold")]
    TooBright {
        /// Such a value.
        value: u16,
        /// The largest one that was said.
        max_dn: u16,
    },
}

impl Channel {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Grey, Self::Red, Self::Green, Self::Blue, Self::RedExcess, Self::GreenExcess, Self::BlueExcess];

    /// The word for it on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Grey => "grey",
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
            Self::RedExcess => "red-excess",
            Self::GreenExcess => "green-excess",
            Self::BlueExcess => "blue-excess",
        }
    }

    /// Which of red, green and blue the others are taken from, for an excess.
    fn excess_of(self) -> Option<usize> {
        match self {
            Self::RedExcess => Some(0),
            Self::GreenExcess => Some(1),
            Self::BlueExcess => Some(2),
            _ => None,
        }
    }
}

impl Photograph {
    /// Reads the bytes of a PNG or JPEG file.
    ///
    /// `max_dn` is the value at which a pixel is full; `None`: 255 for 8 bits, and for 16 the least of 1023, 4095 and 65 535 that holds
    /// every value. An excess, which may be negative, is kept whole: half of it above mid grey, so that a height of 10 in it is an excess
    /// of 20.
    ///
    /// # Errors
    /// See [`PhotographError`]. A picture of more than [`LARGEST_PX`] columns or rows is one.
    pub fn decode(bytes: &[u8], channel: Channel, max_dn: Option<u16>) -> Result<Self, PhotographError> {
        let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(ImageError::IoError)?;
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(LARGEST_PX as u32), Some(LARGEST_PX as u32));
        reader.limits(limits);
        let is_jpeg = reader.format() == Some(ImageFormat::Jpeg);
        let picture = reader.decode()?;
        if is_jpeg && !whole_jpeg::has_end(bytes) {
            return Err(PhotographError::CutShort);
        }
        let (width_px, height_px) = (picture.width() as usize, picture.height() as usize);
        if channel.excess_of().is_some() && !picture.color().has_color() {
            return Err(PhotographError::Grey(channel.word()));
        }
        let (values, full) = match picture {
            DynamicImage::ImageLuma8(grey) => (Values::Grey8(grey.into_raw()), 255),
            DynamicImage::ImageLuma16(grey) => {
                let values = grey.into_raw();
                let full = fullest(&values);
                (Values::Grey16(values), full)
            }
            DynamicImage::ImageLumaA8(_) => (Values::Grey8(picture.into_luma8().into_raw()), 255),
            DynamicImage::ImageLumaA16(_) => {
                let values = picture.into_luma16().into_raw();
                let full = fullest(&values);
                (Values::Grey16(values), full)
            }
            DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) => {
                of_colours(picture.into_rgb8().as_raw(), channel, max_dn.unwrap_or(255))
            }
            _ => {
                let colours = picture.into_rgb16().into_raw();
                let full = max_dn.unwrap_or_else(|| fullest(&colours));
                of_colours(&colours, channel, full)
            }
        };
        let max_dn = max_dn.filter(|_| channel.excess_of().is_none()).unwrap_or(full);
        let photograph = Self { width_px, height_px, values, max_dn };
        match photograph.brightest() {
            value if value > max_dn => Err(PhotographError::TooBright { value, max_dn }),
            _ => Ok(photograph),
        }
    }

    /// Columns and rows.
    pub fn size_px(&self) -> [usize; 2] {
        [self.width_px, self.height_px]
    }

    /// The value at which a pixel is full.
    pub fn max_dn(&self) -> u16 {
        self.max_dn
    }

    /// As a perception gets it.
    pub fn frame(&self) -> Frame<'_> {
        let frame = match &self.values {
            Values::Grey8(values) => Frame::grey8(self.width_px, self.height_px, values),
            Values::Grey16(values) => Frame::grey16(self.width_px, self.height_px, values, self.max_dn),
        };
        Frame { max_dn: self.max_dn, ..frame }
    }

    /// Darkens all that is outside a region to the darkest value inside, so that no perception finds anything there.
    pub fn keep_only(&mut self, region: &Region) {
        let (width_px, height_px) = (self.width_px, self.height_px);
        match &mut self.values {
            Values::Grey8(values) => keep(values, width_px, height_px, region),
            Values::Grey16(values) => keep(values, width_px, height_px, region),
        }
    }

    /// In 8 bits, for the eye: the largest value becomes 255.
    pub fn to_8_bits(&self) -> Cow<'_, [u8]> {
        let max = u32::from(self.max_dn.max(1));
        match &self.values {
            Values::Grey8(values) if max == 255 => Cow::Borrowed(values),
            Values::Grey8(values) => Cow::Owned(values.iter().map(|v| (u32::from(*v) * 255 / max).min(255) as u8).collect()),
            Values::Grey16(values) => Cow::Owned(values.iter().map(|v| (u32::from(*v) * 255 / max).min(255) as u8).collect()),
        }
    }

    fn brightest(&self) -> u16 {
        match &self.values {
            Values::Grey8(values) => values.iter().copied().max().unwrap_or_default().into(),
            Values::Grey16(values) => values.iter().copied().max().unwrap_or_default(),
        }
    }
}

/// The largest value of a camera that delivers these in 16 bits.
fn fullest(values: &[u16]) -> u16 {
    let brightest = values.iter().copied().max().unwrap_or_default();
    [1023, 4095].into_iter().find(|full| brightest <= *full).unwrap_or(u16::MAX)
}

/// One value a pixel out of three, red, green and blue, and the largest that it can have.
fn of_colours<T: Copy + Into<u16>>(colours: &[T], channel: Channel, full: u16) -> (Values, u16) {
    let pixels = colours.chunks_exact(3).map(|pixel| [0, 1, 2].map(|k| i64::from(pixel[k].into())));
    let full_dn = i64::from(full);
    let (values, max_dn): (Vec<u16>, u16) = if let Some(k) = channel.excess_of() {
        // From -2 to 2 times the largest value, moved up by 2, and coarser only where 16 bits would not hold it.
        let coarser = i64::from((4 * u32::from(full)).div_ceil(u32::from(u16::MAX)).max(1));
        let twice_excess = |pixel: [i64; 3]| 3 * pixel[k] - pixel.iter().sum::<i64>() + 2 * full_dn;
        (pixels.map(|pixel| in_16_bits(twice_excess(pixel) / coarser)).collect(), in_16_bits(4 * full_dn / coarser))
    } else {
        let value = |[red, green, blue]: [i64; 3]| match channel {
            Channel::Red => red,
            Channel::Green => green,
            Channel::Blue => blue,
            _ => (2126 * red + 7152 * green + 722 * blue + 5000) / 10_000,
        };
        (pixels.map(|pixel| in_16_bits(value(pixel))).collect(), full)
    };
    if max_dn <= 255 && values.iter().all(|value| *value <= 255) {
        return (Values::Grey8(values.iter().map(|value| *value as u8).collect()), max_dn);
    }
    (Values::Grey16(values), max_dn)
}

fn in_16_bits(value: i64) -> u16 {
    value.clamp(0, i64::from(u16::MAX)) as u16
}

fn keep<T: Copy + Ord>(values: &mut [T], width_px: usize, height_px: usize, region: &Region) {
    let inside: Vec<bool> = region.mask(width_px, height_px);
    let darkest = values.iter().zip(&inside).filter(|(_, inside)| **inside).map(|(value, _)| *value).min();
    let Some(darkest) = darkest.or_else(|| values.iter().copied().min()) else { return };
    values.iter_mut().zip(inside).filter(|(_, inside)| !inside).for_each(|(value, _)| *value = darkest);
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgb, codecs::jpeg::JpegEncoder, codecs::png::PngEncoder};
    use proptest::prelude::*;

    fn png(picture: &DynamicImage) -> Vec<u8> {
        let mut bytes = Vec::new();
        picture.write_with_encoder(PngEncoder::new(&mut bytes)).expect("a PNG");
        bytes
    }

    fn values(photograph: &Photograph) -> Vec<u16> {
        match &photograph.values {
            Values::Grey8(values) => values.iter().map(|value| u16::from(*value)).collect(),
            Values::Grey16(values) => values.clone(),
        }
    }

    fn colourful() -> DynamicImage {
        let colours = [[200, 10, 20], [0, 255, 0], [90, 90, 90], [255, 0, 255]];
        DynamicImage::from(ImageBuffer::from_fn(2, 2, |x, y| Rgb(colours[(x + 2 * y) as usize].map(|c: u8| c))))
    }

    #[test]
    fn channels_are_what_they_say() {
        let bytes = png(&colourful());
        let of = |channel| values(&Photograph::decode(&bytes, channel, None).expect("a picture"));
        assert_eq!(of(Channel::Red), [200, 0, 90, 255]);
        assert_eq!(of(Channel::Green), [10, 255, 90, 0]);
        assert_eq!(of(Channel::Blue), [20, 0, 90, 255]);
        assert_eq!(of(Channel::Grey), [51, 182, 90, 73]);
        // Twice the excess about 510.
        assert_eq!(of(Channel::GreenExcess), [510 - 200, 1020, 510, 0]);
        assert_eq!(of(Channel::RedExcess), [510 + 370, 255, 510, 765]);
        let excess = Photograph::decode(&bytes, Channel::BlueExcess, None).expect("a picture");
        assert_eq!((excess.max_dn(), excess.frame().dn_per_dn8()), (1020, 4.0));
    }

    #[test]
    fn sixteen_bits_tell_how_many_of_them_count() {
        let of = |values: [u16; 4], max_dn| {
            let picture: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_raw(2, 2, values.to_vec()).expect("four values");
            Photograph::decode(&png(&picture.into()), Channel::Grey, max_dn)
        };
        for (brightest, max_dn) in [(1023, 1023), (1024, 4095), (4096, u16::MAX)] {
            let photograph = of([0, 1, 2, brightest], None).expect("a picture");
            assert_eq!((photograph.max_dn(), values(&photograph)), (max_dn, vec![0, 1, 2, brightest]));
        }
        assert_eq!(of([0, 1, 2, 700], Some(4095)).expect("a picture").max_dn(), 4095);
        assert!(matches!(of([0, 1, 2, 1024], Some(1023)), Err(PhotographError::TooBright { value: 1024, max_dn: 1023 })));
        assert!(matches!(
            Photograph::decode(&png(&DynamicImage::new_luma8(3, 3)), Channel::GreenExcess, None),
            Err(PhotographError::Grey("green-excess"))
        ));
    }

    #[test]
    fn a_region_is_all_that_stays() {
        let picture: ImageBuffer<Luma<u8>, _> = ImageBuffer::from_fn(40, 30, |x, y| Luma([(3 * x + y) as u8]));
        let mut photograph = Photograph::decode(&png(&picture.clone().into()), Channel::Grey, None).expect("a picture");
        let region = Region::rectangle([10.0, 5.0], [20.0, 12.0]).expect("finite");
        photograph.keep_only(&region);
        for (i, value) in values(&photograph).iter().enumerate() {
            let (u, v) = (i % 40, i / 40);
            let inside = region.contains(u as f64, v as f64);
            assert_eq!(*value, if inside { (3 * u + v) as u16 } else { 35 }, "{u} {v}");
        }
        // A region beside the picture leaves nothing.
        photograph.keep_only(&Region::rectangle([100.0, 5.0], [120.0, 12.0]).expect("finite"));
        assert!(values(&photograph).iter().all(|value| *value == 35));
    }

    /// Half a JPEG decodes, the rest of it grey.
    #[test]
    fn a_jpeg_that_is_cut_short_is_refused() {
        let mut whole = Vec::new();
        let picture = ImageBuffer::from_fn(160, 120, |x, y| Luma([(x * y % 251) as u8]));
        DynamicImage::from(picture).write_with_encoder(JpegEncoder::new(&mut whole)).expect("a JPEG");
        assert!(Photograph::decode(&whole, Channel::Grey, None).is_ok());
        // A quarter of the file is its header.
        for percent in [50, 80, 99] {
            let cut = Photograph::decode(&whole[..whole.len() * percent / 100], Channel::Grey, None);
            assert!(matches!(cut, Err(PhotographError::CutShort | PhotographError::Picture(_))), "{percent}: {cut:?}");
        }
    }

    /// A header may promise more than there is memory.
    #[test]
    fn too_large_pictures_are_refused() {
        let mut bytes = png(&DynamicImage::new_luma8(3, 3));
        bytes[16..20].copy_from_slice(&(LARGEST_PX as u32 + 1).to_be_bytes());
        assert!(matches!(Photograph::decode(&bytes, Channel::Grey, None), Err(PhotographError::Picture(_))));
    }

    proptest! {
        /// Random bytes, and pictures with random bytes in them: an error or a picture, no panic.
        #[test]
        fn any_bytes_are_a_picture_or_an_error(
            noise in prop::collection::vec(any::<u8>(), 0..300), at in 0.0..1.0f64, which in 0..3u8, channel in 0..7usize,
        ) {
            let mut bytes = match which {
                0 => Vec::new(),
                1 => png(&colourful().resize_exact(16, 16, image::imageops::FilterType::Nearest)),
                _ => {
                    let mut bytes = Vec::new();
                    let picture = colourful().resize_exact(16, 16, image::imageops::FilterType::Nearest);
                    picture.write_with_encoder(JpegEncoder::new(&mut bytes)).expect("a JPEG");
                    bytes
                }
            };
            let at = (at * bytes.len() as f64) as usize;
            bytes.splice(at..at, noise);
            if let Ok(photograph) = Photograph::decode(&bytes, Channel::ALL[channel], None) {
                let [width, height] = photograph.size_px();
                prop_assert_eq!(values(&photograph).len(), width * height);
            }
        }
    }
}
