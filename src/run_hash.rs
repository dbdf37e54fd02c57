//! The hash that says whether two runs were the same to the bit.

use ductloop_nav::messages::{Command, Counts, Tick};
use ductloop_sim::truth::Truth;
use xxhash_rust::xxh3::Xxh3;

/// XXH3-128 over, for each frame: tick, pose (seven f64: position, then quaternion x, y, z, w), image, counts, command. All
/// little-endian, -0 as +0. No times, hosts, names or versions.
#[derive(Clone, Default)]
pub struct RunHash(Xxh3);

impl RunHash {
    /// Adds a frame.
    pub fn frame(&mut self, tick: Tick, truth: &Truth, image: &[u8], counts: Counts, command: &Command) {
        self.0.update(&tick.to_le_bytes());
        let position = truth.world_from_base.translation.vector;
        let rotation = truth.world_from_base.rotation.coords;
        position.iter().chain(rotation.iter()).for_each(|value| self.number(*value));
        self.0.update(image);
        self.0.update(&counts.left.to_le_bytes());
        self.0.update(&counts.right.to_le_bytes());
        let Command { wheel_speed_rad_s, mount, exposure_s, laser_power } = command;
        for value in [wheel_speed_rad_s.left, wheel_speed_rad_s.right, mount.pan_rad, mount.tilt_rad] {
            self.number(value);
        }
        for optional in [exposure_s, laser_power] {
            self.0.update(&[u8::from(optional.is_some())]);
            self.number(optional.unwrap_or(0.0));
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
