//! Which robots can be built, and which ducts they fit.

use crate::spec::{DriveSpec, RobotSpec};

/// More play than this is a broken link: a tenth of a turn or so.
const LARGEST_SLACK_RAD: f64 = 0.6;

/// A number of the robot that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} is {value}; {rule}")]
pub struct SpecError {
    /// Name of the field of [`RobotSpec`], or `drive.` and the field of [`DriveSpec`].
    pub field: &'static str,
    /// Its value.
    pub value: f64,
    /// What would be right.
    pub rule: String,
}

fn check(field: &'static str, value: f64, holds: bool, rule: impl FnOnce() -> String) -> Result<(), SpecError> {
    // A comparison with NaN is false: "holds" must be phrased as what is right.
    if holds && value.is_finite() { Ok(()) } else { Err(SpecError { field, value, rule: rule() }) }
}

fn positive(field: &'static str, value: f64) -> Result<(), SpecError> {
    check(field, value, value > 0.0, || "it must be positive and finite".into())
}

fn not_negative(field: &'static str, value: f64) -> Result<(), SpecError> {
    check(field, value, value >= 0.0, || "it must be zero or more, and finite".into())
}

impl RobotSpec {
    /// Checks that the robot can be built.
    ///
    /// # Errors
    /// The first field that cannot be.
    pub fn validate(&self) -> Result<(), SpecError> {
        let [length_m, width_m, height_m] = self.chassis_m;
        for (field, value) in [
            ("mass_kg", self.mass_kg),
            ("wheelbase_m", self.wheelbase_m),
            ("track_m", self.track_m),
            ("wheel_radius_m", self.wheel_radius_m),
            ("wheel_width_m", self.wheel_width_m),
            ("wheel_mass_kg", self.wheel_mass_kg),
            ("chassis_m[0]", length_m),
            ("chassis_m[1]", width_m),
            ("chassis_m[2]", height_m),
            ("ground_clearance_m", self.ground_clearance_m),
            ("mast_width_m", self.mast_width_m),
            ("link_stiffness_n_m_rad", self.link_stiffness_n_m_rad),
            ("mount_rate_rad_s", self.mount_rate_rad_s),
        ] {
            positive(field, value)?;
        }
        not_negative("rolling_resistance", self.rolling_resistance)?;
        not_negative("wheel_damping_ratio", self.wheel_damping_ratio)?;
        not_negative("body_friction", self.body_friction)?;
        self.check_layout()?;
        self.check_mass()?;
        self.check_give()?;
        self.drive.validate()
    }

    fn check_layout(&self) -> Result<(), SpecError> {
        let [length_m, width_m, height_m] = self.chassis_m;
        let diameter_m = 2.0 * self.wheel_radius_m;
        check("wheelbase_m", self.wheelbase_m, self.wheelbase_m > diameter_m, || {
            format!("front and rear wheels overlap: it must be more than the wheels' diameter, {diameter_m:.4} m")
        })?;
        check("track_m", self.track_m, self.track_m > self.wheel_width_m, || {
            format!("left and right wheels overlap: it must be more than the wheels' width, {:.4} m", self.wheel_width_m)
        })?;
        let between_m = self.track_m - self.wheel_width_m;
        let beside_wheels = self.ground_clearance_m < diameter_m
            && self.nose_m > -self.wheelbase_m / 2.0 - self.wheel_radius_m
            && self.nose_m - length_m < self.wheelbase_m / 2.0 + self.wheel_radius_m;
        check("chassis_m[1]", width_m, width_m <= between_m || !beside_wheels, || {
            format!("the chassis reaches into the wheels: at most {between_m:.4} m fits between them")
        })?;
        let (front_m, rear_m) = (self.nose_m - self.mast_width_m / 2.0, self.nose_m - length_m + self.mast_width_m / 2.0);
        check("mast_x_m", self.mast_x_m, (rear_m..=front_m).contains(&self.mast_x_m), || {
            format!("the mast must stand on the chassis: from {rear_m:.4} to {front_m:.4} m")
        })?;
        check("mast_width_m", self.mast_width_m, self.mast_width_m <= width_m, || {
            format!("the mast must stand on the chassis: at most {width_m:.4} m")
        })?;
        let roof_m = self.ground_clearance_m + height_m;
        check("highest_m", self.highest_m, self.highest_m > roof_m && self.highest_m >= diameter_m, || {
            format!("it must be above the chassis' roof at {roof_m:.4} m and no lower than the wheels' {diameter_m:.4} m")
        })
    }

    fn check_mass(&self) -> Result<(), SpecError> {
        let wheels_kg = 4.0 * self.wheel_mass_kg;
        check("mass_kg", self.mass_kg, self.mass_kg > wheels_kg, || {
            format!("it includes the four wheels: it must be more than {wheels_kg:.4} kg")
        })?;
        let [x_m, z_m] = self.centre_of_mass_m;
        let half_m = self.wheelbase_m / 2.0;
        check("centre_of_mass_m[0]", x_m, x_m.abs() < half_m, || {
            format!("the robot tips over: it must lie between the axles, within {half_m:.4} m either way")
        })?;
        // Below this the chassis alone would have its centre of mass under the floor.
        let lowest_m = wheels_kg * self.wheel_radius_m / self.mass_kg;
        check("centre_of_mass_m[1]", z_m, z_m > lowest_m && z_m < self.highest_m, || {
            format!("it must lie above {lowest_m:.4} m (the wheels' share) and below the highest point")
        })
    }

    fn check_give(&self) -> Result<(), SpecError> {
        let slack = self.link_slack_rad;
        check("link_slack_rad", slack, (0.0..=LARGEST_SLACK_RAD).contains(&slack), || {
            format!("it must be from 0 to {LARGEST_SLACK_RAD} rad")
        })?;
        // Loads lie between the axles by now. A wheel flattened further is no wheel, and a chassis so low rests on the floor.
        let deepest_m = (self.wheel_radius_m / 4.0).min(self.ground_clearance_m / 2.0);
        let most_m_n = deepest_m / self.wheel_loads_n().into_iter().fold(0.0, f64::max);
        let compliance = self.wheel_compliance_m_n;
        check("wheel_compliance_m_n", compliance, (0.0..=most_m_n).contains(&compliance), || {
            format!(
                "it must be from 0 to {most_m_n:.3e} m/N: its load may press a wheel in by a quarter of its radius and by half of the \
                 ground clearance, here {deepest_m:.4} m"
            )
        })
    }

    /// Smallest width and height of a straight duct that the robot fits into, in metres, touching.
    pub fn smallest_duct_m(&self) -> [f64; 2] {
        [(self.track_m + self.wheel_width_m).max(self.chassis_m[1]), self.highest_m]
    }

    /// Diameter of the circle that the robot sweeps turning on the spot about the middle of its wheels, in metres.
    pub fn turning_circle_m(&self) -> f64 {
        let [length_m, width_m, _] = self.chassis_m;
        let reach = |x: f64, y: f64| (x * x + y * y).sqrt();
        let chassis_m = reach(self.nose_m.abs().max((self.nose_m - length_m).abs()), width_m / 2.0);
        let wheels_m = reach(self.wheelbase_m / 2.0 + self.wheel_radius_m, (self.track_m + self.wheel_width_m) / 2.0);
        2.0 * chassis_m.max(wheels_m)
    }
}

impl DriveSpec {
    fn validate(&self) -> Result<(), SpecError> {
        for (field, value) in [
            ("drive.supply_v", self.supply_v),
            ("drive.resistance_ohm", self.resistance_ohm),
            ("drive.inductance_h", self.inductance_h),
            ("drive.motor_constant", self.motor_constant),
            ("drive.rotor_inertia_kg_m2", self.rotor_inertia_kg_m2),
            ("drive.gear_ratio", self.gear_ratio),
            ("drive.counts_per_motor_turn", f64::from(self.counts_per_motor_turn)),
        ] {
            positive(field, value)?;
        }
        not_negative("drive.coulomb_friction_n_m", self.coulomb_friction_n_m)?;
        let share = self.gear_efficiency;
        check("drive.gear_efficiency", share, share > 0.0 && share <= 1.0, || "it must be above 0 and at most 1".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn incra1_can_be_built_and_is_as_large_as_its_numbers_say() {
        let robot = RobotSpec::incra1();
        assert_eq!(robot.validate(), Ok(()));
        // Sums and products of decimal fractions: rounding only.
        let [width_m, height_m] = robot.smallest_duct_m();
        assert!((width_m - 0.215).abs() < 1e-12 && (height_m - 0.175).abs() < 1e-12);
        // The nose's corner is the farthest point: 2 sqrt(0.16^2 + 0.08^2).
        assert!((robot.turning_circle_m() - 0.357_770_876_4).abs() < 1e-9);
    }

    #[test]
    fn each_impossible_number_is_named() {
        type Spoil = fn(&mut RobotSpec);
        let cases: [(&str, Spoil); 19] = [
            ("mass_kg", |r| r.mass_kg = 0.0),
            ("mass_kg", |r| r.mass_kg = 0.4),
            ("wheelbase_m", |r| r.wheelbase_m = 0.07),
            ("track_m", |r| r.track_m = 0.02),
            ("chassis_m[1]", |r| r.chassis_m[1] = 0.18),
            ("highest_m", |r| r.highest_m = 0.07),
            ("highest_m", |r| r.highest_m = f64::NAN),
            ("mast_x_m", |r| r.mast_x_m = 0.15),
            ("centre_of_mass_m[0]", |r| r.centre_of_mass_m[0] = -0.09),
            ("centre_of_mass_m[1]", |r| r.centre_of_mass_m[1] = 0.001),
            ("wheel_mass_kg", |r| r.wheel_mass_kg = 0.0),
            ("link_slack_rad", |r| r.link_slack_rad = -0.01),
            ("link_slack_rad", |r| r.link_slack_rad = 1.0),
            // A quarter of 40 mm under 12.3 N is 0.82 mm/N.
            ("wheel_compliance_m_n", |r| r.wheel_compliance_m_n = 0.9e-3),
            ("wheel_compliance_m_n", |r| r.wheel_compliance_m_n = f64::NAN),
            ("wheel_damping_ratio", |r| r.wheel_damping_ratio = -0.1),
            ("drive.rotor_inertia_kg_m2", |r| r.drive.rotor_inertia_kg_m2 = 0.0),
            ("drive.gear_efficiency", |r| r.drive.gear_efficiency = 1.2),
            ("drive.resistance_ohm", |r| r.drive.resistance_ohm = f64::INFINITY),
        ];
        for (field, spoil) in cases {
            let mut robot = RobotSpec::incra1();
            spoil(&mut robot);
            let error = robot.validate().expect_err(field);
            assert_eq!(error.field, field, "{error}");
        }
    }
}
