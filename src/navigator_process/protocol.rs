//! Messages to and from a navigator's program: `docs/navigator-protocol.md`.
//!
//! Every message is its length (u32, of what follows), its kind (u8), and its body. All numbers are little-endian.

use ductloop_nav::messages::{Command, Counts, Frame, Pixels, Sides, Tick};
use ductloop_nav::navigator::State;
use ductloop_nav::rig::MountAngles;

use crate::command_check;

/// Version of the protocol.
pub(super) const VERSION: u32 = 1;
/// The longest message that a navigator may send.
pub(super) const MAX_ANSWER: u32 = 65_536;

/// To the navigator: what it may know, as JSON.
pub(super) const HELLO: u8 = 1;
/// From the navigator: it is ready, as JSON.
pub(super) const READY: u8 = 2;
/// To the navigator: a frame.
pub(super) const FRAME: u8 = 3;
/// From the navigator: a command.
pub(super) const COMMAND: u8 = 4;
/// To the navigator: the run is over.
pub(super) const END: u8 = 5;

/// Bytes of a command's body.
const COMMAND_LEN: usize = 72;

/// What a navigator answers to a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Answer {
    pub(super) command: Command,
    pub(super) lateral_m: Option<f64>,
    pub(super) heading_rad: Option<f64>,
    pub(super) state: State,
}

/// A message with this kind and body.
pub(super) fn message(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(5 + body.len());
    bytes.extend(u32::try_from(body.len() + 1).unwrap_or(u32::MAX).to_le_bytes());
    bytes.push(kind);
    bytes.extend(body);
    bytes
}

/// A frame's message.
pub(super) fn frame(frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Vec<u8> {
    let mut body = Vec::with_capacity(52 + 2 * frame.width_px * frame.height_px);
    body.extend(tick.to_le_bytes());
    body.extend(counts.left.to_le_bytes());
    body.extend(counts.right.to_le_bytes());
    body.extend(mount.pan_rad.to_le_bytes());
    body.extend(mount.tilt_rad.to_le_bytes());
    // A camera has at most some thousand pixels a side.
    body.extend(u32::try_from(frame.width_px).unwrap_or(u32::MAX).to_le_bytes());
    body.extend(u32::try_from(frame.height_px).unwrap_or(u32::MAX).to_le_bytes());
    body.extend(frame.max_dn.to_le_bytes());
    match frame.pixels {
        Pixels::Grey8(values) => {
            body.extend([1, 0]);
            body.extend(values);
        }
        Pixels::Grey16(values) => {
            body.extend([2, 0]);
            body.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
    }
    message(FRAME, &body)
}

/// Reads a command's body.
pub(super) fn answer(body: &[u8]) -> Result<Answer, String> {
    if body.len() != COMMAND_LEN {
        return Err(format!("a command's body has {COMMAND_LEN} bytes, this one {}", body.len()));
    }
    let mut numbers = [0.0; 8];
    for (number, bytes) in numbers.iter_mut().zip(body.chunks_exact(8)) {
        let mut eight = [0; 8];
        eight.copy_from_slice(bytes);
        *number = f64::from_le_bytes(eight);
    }
    let [left, right, pan_rad, tilt_rad, exposure_s, laser_power, lateral_m, heading_rad] = numbers;
    let told = |name: &str, value: f64, least: f64, most: f64| match value {
        value if value.is_nan() => Ok(None),
        value if (least..=most).contains(&value) => Ok(Some(value)),
        value => Err(format!("{name} is {value}, neither NaN nor within {least} to {most}")),
    };
    let turn = std::f64::consts::TAU;
    let command = Command {
        wheel_speed_rad_s: Sides { left, right },
        mount: MountAngles { pan_rad, tilt_rad },
        exposure_s: told("the exposure", exposure_s, 1e-6, 1.0)?,
        laser_power: told("the laser power", laser_power, 0.0, 1.0)?,
        sweep: None,
    };
    command_check::check(&command)?;
    let state = match body[64] {
        0 => State::Unknown,
        1 => State::Tracking,
        2 => State::Coasting,
        3 => State::Stopped,
        4 => State::Degraded,
        other => return Err(format!("{other} is no state")),
    };
    Ok(Answer {
        command,
        lateral_m: told("the lateral error", lateral_m, -1e3, 1e3)?,
        heading_rad: told("the heading error", heading_rad, -turn, turn)?,
        state,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layout of the document, spelt out.
    #[test]
    fn a_frame_is_laid_out_as_documented() {
        let pixels = [1_u16, 0x0203, 1023, 0];
        let image = Frame::grey16(2, 2, &pixels, 1023);
        let bytes = frame(&image, Counts { left: -2, right: 3 }, MountAngles { pan_rad: 0.5, tilt_rad: -0.25 }, 0x0102);
        assert_eq!(bytes.len(), 4 + 1 + 52 + 8);
        assert_eq!(bytes[..5], [61, 0, 0, 0, 3]);
        assert_eq!(bytes[5..13], [2, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[13..21], [0xfe, 255, 255, 255, 255, 255, 255, 255]);
        assert_eq!(bytes[29..37], 0.5_f64.to_le_bytes());
        assert_eq!(bytes[45..57], [2, 0, 0, 0, 2, 0, 0, 0, 0xff, 3, 2, 0]);
        assert_eq!(bytes[57..], [1, 0, 3, 2, 0xff, 3, 0, 0]);
    }

    fn body(numbers: [f64; 8], state: u8) -> Vec<u8> {
        let mut body: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        body.extend([state, 0, 0, 0, 0, 0, 0, 0]);
        body
    }

    #[test]
    fn commands_are_read_and_nonsense_is_named() {
        let nan = f64::NAN;
        let good = answer(&body([1.0, 2.0, 0.1, -0.1, nan, 0.5, 0.01, nan], 1)).expect("a command");
        assert_eq!(good.command.wheel_speed_rad_s, Sides { left: 1.0, right: 2.0 });
        assert_eq!((good.command.exposure_s, good.command.laser_power), (None, Some(0.5)));
        assert_eq!((good.lateral_m, good.heading_rad, good.state), (Some(0.01), None, State::Tracking));
        for (numbers, state, named) in [
            ([nan, 0.0, 0.0, 0.0, nan, nan, nan, nan], 1, "left wheels"),
            ([0.0, f64::INFINITY, 0.0, 0.0, nan, nan, nan, nan], 1, "right wheels"),
            ([0.0, 0.0, 0.0, 0.0, -1.0, nan, nan, nan], 1, "exposure"),
            ([0.0, 0.0, 0.0, 0.0, nan, 7.0, nan, nan], 1, "laser power"),
            ([0.0, 0.0, 0.0, 0.0, nan, nan, nan, nan], 9, "no state"),
        ] {
            let wrong = answer(&body(numbers, state)).expect_err(named);
            assert!(wrong.contains(named), "{wrong}");
        }
        assert!(answer(&[0; 71]).is_err());
    }
}
