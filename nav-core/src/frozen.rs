//! A camera that has stopped and gives the same frame again and again.
//!
//! Two exposures never agree in every pixel: there is shot and read noise in each. So a frame that is the same to the bit as the one
//! before is no exposure. A few in a row may be a driver that repeats one; more are a camera that is frozen, and what it shows is no longer
//! so. An image without noise proves nothing: in a straight duct it may well be the same, though the robot moves.

use crate::messages::{Frame, Pixels};

/// Counts frames that are the same.
#[derive(Clone, Debug, Default)]
pub struct FrozenCamera {
    last: Option<u64>,
    repeated: u64,
}

/// Every so many pixels are looked at; a prime, so that they are spread over all columns.
const STRIDE: usize = 101;

impl FrozenCamera {
    /// How many frames in a row were the same as the one before them, this one included.
    pub fn look(&mut self, frame: &Frame<'_>) -> u64 {
        let print = fingerprint(frame);
        self.repeated = if self.last == Some(print) { self.repeated + 1 } else { 0 };
        self.last = Some(print);
        self.repeated
    }
}

/// FNV-1a (Fowler, Noll, Vo) over every [`STRIDE`]th pixel.
fn fingerprint(frame: &Frame<'_>) -> u64 {
    let add = |hash: u64, value: u16| (hash ^ u64::from(value)).wrapping_mul(0x0000_0100_0000_01b3);
    let start = 0xcbf2_9ce4_8422_2325;
    match frame.pixels {
        Pixels::Grey8(values) => values.iter().step_by(STRIDE).fold(start, |hash, value| add(hash, u16::from(*value))),
        Pixels::Grey16(values) => values.iter().step_by(STRIDE).fold(start, |hash, value| add(hash, *value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_frames_that_are_the_same_in_a_row_count() {
        let images: Vec<Vec<u8>> = (0..2_u8).map(|value| vec![value; 64 * 48]).collect();
        let mut camera = FrozenCamera::default();
        let seen: Vec<u64> =
            [0, 0, 0, 1, 1, 0].iter().map(|image: &usize| camera.look(&Frame::grey8(64, 48, &images[*image]))).collect();
        assert_eq!(seen, [0, 1, 2, 0, 1, 0]);
    }
}
