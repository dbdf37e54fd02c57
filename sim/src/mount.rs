//! The pan-tilt mount: it goes where it is pointed, no faster than its rate limit.

use ductloop_nav::rig::MountAngles;

/// Where the mount points and where it is going.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanTilt {
    actual: MountAngles,
    commanded: MountAngles,
    rate_rad_s: f64,
}

impl PanTilt {
    /// A mount at rest. `rate_rad_s` limits pan and tilt each.
    pub fn new(rest: MountAngles, rate_rad_s: f64) -> Self {
        Self { actual: rest, commanded: rest, rate_rad_s }
    }

    /// Where to go from now on.
    pub fn point(&mut self, to: MountAngles) {
        self.commanded = to;
    }

    /// Lets `dt_s` seconds pass.
    pub fn step(&mut self, dt_s: f64) {
        let most = self.rate_rad_s * dt_s;
        let toward = |from: f64, to: f64| if (to - from).abs() <= most { to } else { from + most.copysign(to - from) };
        self.actual.pan_rad = toward(self.actual.pan_rad, self.commanded.pan_rad);
        self.actual.tilt_rad = toward(self.actual.tilt_rad, self.commanded.tilt_rad);
    }

    /// Where it points. Its own sensors read the same: they are taken as perfect.
    pub fn angles(&self) -> MountAngles {
        self.actual
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_arrives_when_the_rate_limit_lets_it_and_stays() {
        let mut mount = PanTilt::new(MountAngles { pan_rad: -0.1, tilt_rad: 0.2 }, 2.0);
        mount.point(MountAngles { pan_rad: 0.4, tilt_rad: 0.1 });
        for _ in 0..100 {
            mount.step(1e-3);
        }
        // 0.1 s at 2 rad/s: 0.2 rad of the 0.5 rad of pan, all of the 0.1 rad of tilt. 100 additions of 2e-3: 1e-14 rounding.
        assert!((mount.angles().pan_rad - 0.1).abs() < 1e-12);
        assert_eq!(mount.angles().tilt_rad, 0.1);
        for _ in 0..151 {
            mount.step(1e-3);
        }
        assert_eq!(mount.angles(), MountAngles { pan_rad: 0.4, tilt_rad: 0.1 });
    }
}
