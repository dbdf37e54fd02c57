//! What the loop derives from a scenario's fields.

use ductloop_duct::Transform;
use ductloop_duct::network::Network;
use ductloop_nav::angle::rotation_about_z;
use ductloop_nav::messages::Tick;
use ductloop_nav::wheel_controller::{WheelGains, WheelLimits};
use ductloop_sim::spec::RobotSpec;
use nalgebra::Vector3;
use serde_json::Value;

use crate::scenario::{Bound, Measured, Rates, Scenario};

impl Rates {
    /// Physics ticks from one frame to the next.
    pub fn ticks_per_frame(&self) -> Tick {
        Tick::from(self.physics_hz / self.camera_hz)
    }

    /// Physics ticks from one call of the wheel controller to the next.
    pub fn ticks_per_wheel_control(&self) -> Tick {
        Tick::from(self.physics_hz / self.wheel_control_hz)
    }
}

impl Scenario {
    /// Pose of the base when the run begins.
    pub fn world_from_start(&self, network: &Network) -> Transform {
        let on_path = network.centreline.pose_at(self.start.distance_m);
        let beside = Transform::from_parts(
            Vector3::new(0.0, self.start.lateral_m, 0.0).into(),
            rotation_about_z(self.start.heading_rad).into(),
        );
        on_path * beside
    }

    /// Gains of the wheel loop, from what is known of motor and load.
    pub fn wheel_gains(&self) -> WheelGains {
        let drive = &self.robot.drive;
        let full_speed_rad_s = drive.supply_v / (drive.motor_constant * drive.gear_ratio);
        WheelGains::from_bandwidth(self.control.wheel_bandwidth_rad_s, full_speed_rad_s, drive_time_constant_s(&self.robot))
    }

    /// Limits of the wheel loop, in duty.
    pub fn wheel_limits(&self) -> WheelLimits {
        let (drive, control) = (&self.robot.drive, &self.wheel_control);
        WheelLimits {
            duty: control.voltage_limit_v.map_or(1.0, |limit_v| (limit_v / drive.supply_v).min(1.0)),
            current_duty: control.current_limit_a * drive.resistance_ohm / drive.supply_v,
        }
    }
}

/// Time constant of a side's motor with half the robot to move: R J / k^2, with J at the motor's shaft.
fn drive_time_constant_s(robot: &RobotSpec) -> f64 {
    let drive = &robot.drive;
    let load = robot.mass_kg / 2.0 * robot.wheel_radius_m * robot.wheel_radius_m / (drive.gear_ratio * drive.gear_ratio);
    drive.resistance_ohm * (drive.rotor_inertia_kg_m2 + load) / (drive.motor_constant * drive.motor_constant)
}

impl Measured<'_> {
    /// The value as JSON; null where nothing was measured.
    pub fn to_json(self) -> Value {
        match self {
            Self::Number(value) => value.into(),
            Self::Flag(value) => value.into(),
            Self::Word(value) => value.into(),
            Self::Nothing => Value::Null,
        }
    }
}

impl Bound {
    /// The bound as JSON.
    pub fn to_json(&self) -> Value {
        match self {
            Self::AtMost(value) | Self::AtLeast(value) => (*value).into(),
            Self::Is(value) => (*value).into(),
            Self::Word(value) => value.as_str().into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// INCRA I's drive as its sources state it: 1.25 m/s unloaded, time constant 20 ms.
    #[test]
    fn the_wheel_loop_is_tuned_for_the_drive_as_it_is() {
        let robot = RobotSpec::incra1();
        assert!((drive_time_constant_s(&robot) - 0.020).abs() < 5e-4);
        let text = "format = 1\nkind = \"scenario\"\nname = \"t\"\n[sensor]\npreset = \"wide\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
                    run = [{ straight_m = 6.0 }]\n";
        let scenario = Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{wrong}"));
        let gains = scenario.wheel_gains();
        let unloaded_m_s = robot.wheel_radius_m / gains.feed_forward_s_rad;
        assert!((unloaded_m_s - 1.25).abs() < 0.005, "{unloaded_m_s}");
        // Both poles at w: 1 + K kp = 2 w tau, K ki = w^2 tau.
        let (w, tau, k) = (60.0, drive_time_constant_s(&robot), 1.0 / gains.feed_forward_s_rad);
        assert!((1.0 + k * gains.proportional_s_rad - 2.0 * w * tau).abs() < 1e-12);
        assert!((k * gains.integral_1_rad - w * w * tau).abs() < 1e-9);
    }

    /// The preset and the library's own INCRA I are one robot.
    #[test]
    fn the_preset_is_the_robot_that_the_physics_was_checked_with() {
        let text = "format = 1\nkind = \"scenario\"\nname = \"t\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n[duct]\n\
                    width_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 6.0 }]\n";
        let scenario = Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{wrong}"));
        assert_eq!(scenario.robot, RobotSpec::incra1());
    }
}
