//! The hash that says whether two runs were the same to the bit.

use ductloop_nav::messages::{Command, Counts, MountSweep, Tick};
use ductloop_sim::truth::Truth;
use xxhash_rust::xxh3::Xxh3;

use crate::grey_image::GreyImage;

/// XXH3-128 over, for each frame: tick, pose (seven f64: position, then quaternion x, y, z, w), image (a byte a grey
/// value of 8 bits, two of more), counts, command (a swing of the mount only where there is one). All little-endian, -0 as +0. No times, hosts, names or versions.
#[derive(Clone, Default)]
pub struct RunHash(Xxh3);

impl RunHash {
    /// Adds a frame.
    pub fn frame(&mut self, tick: Tick, truth: &Truth, image: &GreyImage, counts: Counts, command: &Command) {
        self.0.update(&tick.to_le_bytes());
        let position = truth.world_from_base.translation.vector;
        let rotation = truth.world_from_base.rotation.coords;
        position.iter().chain(rotation.iter()).for_each(|value| self.number(*value));
        image.bytes(|bytes| self.0.update(bytes));
        self.0.update(&counts.left.to_le_bytes());
        self.0.update(&counts.right.to_le_bytes());
        let Command { wheel_speed_rad_s, mount, sweep, exposure_s, laser_power } = command;
        for value in [wheel_speed_rad_s.left, wheel_speed_rad_s.right, mount.pan_rad, mount.tilt_rad] {
            self.number(value);
        }
        for optional in [exposure_s, laser_power] {
            self.0.update(&[u8::from(optional.is_some())]);
            self.number(optional.unwrap_or(0.0));
        }
        // Nothing where nothing swings.
        if let Some(MountSweep { amplitude, period_s }) = sweep {
            self.0.update(b"sweep");
            for value in [amplitude.pan_rad, amplitude.tilt_rad, *period_s] {
                self.number(value);
            }
        }
    }

    /// The hash of all frames so far.
    pub fn value(&self) -> u128 {
        self.0.digest128()
    }

    fn number(&mut self, value: f64) {
        // Adding zero turns -0 into +0 and leaves every other number as it is.
        self.0.update(&(value + 0.0).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use ductloop_nav::messages::Sides;
    use ductloop_nav::rig::MountAngles;
    use ductloop_sensor::optics::Bits;
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};

    use super::*;

    #[derive(Clone)]
    struct Given {
        tick: Tick,
        pose: Isometry3<f64>,
        image: Vec<u16>,
        bits: Bits,
        counts: Counts,
        command: Command,
    }

    fn given() -> Given {
        Given {
            tick: 40,
            pose: Isometry3::from_parts(Translation3::new(1.0, 0.0, 3.0), UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3)),
            image: vec![1, 2, 3],
            bits: Bits::Eight,
            counts: Counts { left: 5, right: 6 },
            command: Command {
                wheel_speed_rad_s: Sides { left: 7.0, right: 8.0 },
                mount: MountAngles { pan_rad: 0.1, tilt_rad: 0.2 },
                sweep: None,
                exposure_s: Some(0.004),
                laser_power: None,
            },
        }
    }

    fn swing(pan_rad: f64, tilt_rad: f64, period_s: f64) -> Option<MountSweep> {
        Some(MountSweep { amplitude: MountAngles { pan_rad, tilt_rad }, period_s })
    }

    fn image(given: &Given) -> GreyImage {
        GreyImage::of([3, 1], given.bits, &given.image).expect("three values")
    }

    fn hash(given: &Given) -> u128 {
        let truth = Truth {
            world_from_base: given.pose,
            cell: 0,
            fitting: 0,
            segment: 0,
            distance_m: 0.0,
            lateral_m: 0.0,
            heading_rad: 0.0,
            clearance_m: 0.0,
            speed_m_s: 0.0,
            yaw_rate_rad_s: 0.0,
            wheel_speed_rad_s: Sides::default(),
            motor_current_a: Sides::default(),
        };
        let mut hash = RunHash::default();
        hash.frame(given.tick, &truth, &image(given), given.counts, &given.command);
        hash.value()
    }

    #[test]
    fn every_field_counts_and_the_sign_of_zero_does_not() {
        let changes: [fn(&mut Given); 22] = [
            |g| g.tick += 1,
            |g| g.pose.translation.x += 1e-9,
            |g| g.pose.translation.y += 1e-9,
            |g| g.pose.translation.z += 1e-9,
            |g| g.pose.rotation = UnitQuaternion::from_euler_angles(0.1 + 1e-9, 0.2, 0.3),
            |g| g.image[1] ^= 1,
            |g| g.bits = Bits::Ten,
            |g| g.counts.left += 1,
            |g| g.counts.right += 1,
            |g| g.command.wheel_speed_rad_s.left += 1e-9,
            |g| g.command.wheel_speed_rad_s.right += 1e-9,
            |g| g.command.mount.pan_rad += 1e-9,
            |g| g.command.mount.tilt_rad += 1e-9,
            |g| g.command.sweep = swing(0.1, 0.2, 3.0),
            |g| g.command.sweep = swing(0.11, 0.2, 3.0),
            |g| g.command.sweep = swing(0.1, 0.21, 3.0),
            |g| g.command.sweep = swing(0.1, 0.2, 3.1),
            |g| g.command.exposure_s = Some(0.005),
            |g| g.command.exposure_s = None,
            |g| g.command.laser_power = Some(0.0),
            |g| g.command.laser_power = Some(0.5),
            |g| (g.counts.left, g.counts.right) = (6, 5),
        ];
        let mut seen = std::collections::BTreeSet::from([hash(&given())]);
        for (i, change) in changes.iter().enumerate() {
            let mut other = given();
            change(&mut other);
            assert!(seen.insert(hash(&other)), "change {i} leaves the hash as it was, or makes it another change's");
        }
        let mut negative = given();
        negative.pose.translation.y = -0.0;
        assert_eq!(hash(&negative), hash(&given()));
    }
}
