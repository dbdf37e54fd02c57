//! The pan-tilt mount: motors that go where they are told, no faster than their rate limit, with an encoder on each; and the play
//! between motor and camera, which no encoder sees.

use ductloop_nav::rig::MountAngles;

/// What stands between a motor and what it turns, and what is read of it. The same for pan and tilt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gearing {
    /// Play: the camera follows only after the motor has turned back by this much, in radians.
    pub backlash_rad: f64,
    /// Angle of one encoder count, in radians; 0 reads the angle itself.
    pub encoder_step_rad: f64,
}

/// Where the mount points and where it is going.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanTilt {
    motor: MountAngles,
    camera: MountAngles,
    commanded: MountAngles,
    rate_rad_s: f64,
    gearing: Gearing,
}

impl PanTilt {
    /// A mount at rest, without play and with perfect encoders. `rate_rad_s` limits pan and tilt each.
    pub fn new(rest: MountAngles, rate_rad_s: f64) -> Self {
        Self { motor: rest, camera: rest, commanded: rest, rate_rad_s, gearing: Gearing::default() }
    }

    /// Puts this gearing between motors and camera, which stands in the middle of the play.
    pub fn fit(&mut self, gearing: Gearing) {
        self.gearing = gearing;
    }

    /// Where its motors are to go from now on.
    pub fn point(&mut self, to: MountAngles) {
        self.commanded = to;
    }

    /// Lets `dt_s` seconds pass. The camera, held by friction, moves only where an end of the play takes it along.
    pub fn step(&mut self, dt_s: f64) {
        let most = self.rate_rad_s * dt_s;
        let toward = |from: f64, to: f64| if (to - from).abs() <= most { to } else { from + most.copysign(to - from) };
        self.motor.pan_rad = toward(self.motor.pan_rad, self.commanded.pan_rad);
        self.motor.tilt_rad = toward(self.motor.tilt_rad, self.commanded.tilt_rad);
        let half = self.gearing.backlash_rad / 2.0;
        // Without play both ends are the motor's angle, to the bit.
        let taken = |camera: f64, motor: f64| camera.max(motor - half).min(motor + half);
        self.camera.pan_rad = taken(self.camera.pan_rad, self.motor.pan_rad);
        self.camera.tilt_rad = taken(self.camera.tilt_rad, self.motor.tilt_rad);
    }

    /// Where the camera points.
    pub fn angles(&self) -> MountAngles {
        self.camera
    }

    /// What the encoders read: the motors' angles to the nearest count.
    pub fn reading(&self) -> MountAngles {
        let step = self.gearing.encoder_step_rad;
        let read = |angle: f64| if step > 0.0 { (angle / step).round() * step } else { angle };
        MountAngles { pan_rad: read(self.motor.pan_rad), tilt_rad: read(self.motor.tilt_rad) }
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

    /// Play of 0.02 rad: turning on, the camera is 0.01 behind the motor; turned back, it stands until the motor has gone 0.02. The
    /// encoder, of 0.003 rad a count, tells the motor's angle.
    #[test]
    fn the_camera_lags_by_the_play_and_the_encoder_does_not_see_it() {
        let mut mount = PanTilt::new(MountAngles::default(), 1.0);
        mount.fit(Gearing { backlash_rad: 0.02, encoder_step_rad: 0.003 });
        let mut go = |pan_rad: f64| {
            mount.point(MountAngles { pan_rad, tilt_rad: 0.0 });
            (0..200).for_each(|_| mount.step(1e-3));
            (mount.angles().pan_rad, mount.reading().pan_rad)
        };
        // Sums of a hundred steps: rounding 1e-14. 0.1 / 0.003 = 33.3 counts, 0.085 / 0.003 = 28.3, 0.07 / 0.003 = 23.3.
        for (to, camera, counts) in [(0.1, 0.09, 33.0), (0.085, 0.09, 28.0), (0.07, 0.08, 23.0)] {
            let (points, reads) = go(to);
            assert!((points - camera).abs() < 1e-12, "{to}: {points}");
            assert!((reads - counts * 0.003).abs() < 1e-12, "{to}: {reads}");
        }
    }
}
