//! The controllers on the body: a loop that fits its integers, a silence longer than a frame, a swing that the mount can follow.

use std::f64::consts::TAU;

use ductloop_nav::wheel_controller::board::WheelBoard;

use super::Cross;

impl Cross<'_> {
    pub(super) fn controllers(&mut self) {
        self.wheel_control();
        self.silence();
        self.sweep();
    }

    /// The loop can be had in 16-bit integers.
    fn wheel_control(&mut self) {
        if !self.checked.is_sound(&["robot", "rates", "control.wheel_bandwidth_rad_s", "wheel_control"]) {
            return;
        }
        if let Err(error) = WheelBoard::new(&self.scenario.wheel_board()) {
            self.wrong(
                &["rates.wheel_control_hz", "robot.drive.counts_per_motor_turn", "wheel_control.arithmetic", "wheel_control"],
                format!("the wheel controller cannot reckon in 16-bit integers: {error}"),
                "another `rates.wheel_control_hz` or `robot.drive.counts_per_motor_turn`, or `wheel_control.arithmetic = \"float\"`"
                    .to_owned(),
            );
        }
    }

    /// Wheels must not be slowed down between two commands.
    fn silence(&mut self) {
        let path = "wheel_control.silence_s";
        let (silence_s, frame_s) = (self.scenario.wheel_control.silence_s, 1.0 / f64::from(self.scenario.rates.camera_hz));
        if self.checked.is_sound(&[path, "rates.camera_hz"]) && silence_s <= frame_s {
            let message = format!("`{path}` is {silence_s} s, but a command comes only every {frame_s:.4} s");
            self.wrong(&[path, "rates.camera_hz"], message, "longer than a frame: five frames leave room for losses".to_owned());
        }
    }

    /// A swing no faster than the mount. Its fastest is 2 pi amplitude / period, its largest acceleration (2 pi / period)^2 amplitude.
    fn sweep(&mut self) {
        if !self.checked.is_sound(&["robot.mount_rate_rad_s", "mount_control"]) {
            return;
        }
        let control = &self.scenario.mount_control;
        let (amplitude, period_s) = (control.sweep.amplitude, control.sweep.period_s);
        let most_rad = amplitude.pan_rad.abs().max(amplitude.tilt_rad.abs());
        let rate_s = TAU * most_rad / self.scenario.robot.mount_rate_rad_s;
        let acceleration_s = control.acceleration_rad_s2.map_or(0.0, |limit| TAU * (most_rad / limit).sqrt());
        let shortest_s = rate_s.max(acceleration_s);
        if period_s < shortest_s {
            let message = format!("the mount cannot follow a swing of {:.1} degrees in {period_s} s", most_rad.to_degrees());
            let help = format!("a smaller amplitude, or a period of {:.3} s or more", (shortest_s * 1e3).ceil() / 1e3);
            let paths = ["mount_control.sweep_period_s", "mount_control.sweep_pan_deg", "mount_control.sweep_tilt_deg"];
            self.wrong(&paths, message, help);
        }
    }
}
