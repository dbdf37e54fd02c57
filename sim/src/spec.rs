//! The numbers that make the robot's body. The paper gives none of them: every value of [`RobotSpec::incra1`] is an
//! assumption, chosen so that the robot fits a 0.3 m duct and turns on the spot in a 0.5 m one.

use crate::drive::GRAVITY_M_S2;

/// The body: chassis, wheels, drive, encoders. Lengths in metres, base frame (on the floor, midway between the wheels).
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// Mass of the whole robot, wheels included, in kg.
    pub mass_kg: f64,
    /// Distance L between front and rear axles.
    pub wheelbase_m: f64,
    /// Distance W between the middles of left and right wheels.
    pub track_m: f64,
    /// Wheel radius.
    pub wheel_radius_m: f64,
    /// Wheel width.
    pub wheel_width_m: f64,
    /// Mass of one wheel, in kg.
    pub wheel_mass_kg: f64,
    /// Length, width, height of the chassis box.
    pub chassis_m: [f64; 3],
    /// x of the chassis' front end.
    pub nose_m: f64,
    /// Height of the chassis' underside above the floor.
    pub ground_clearance_m: f64,
    /// Height of the robot's highest point, the camera's mast, above the floor.
    pub highest_m: f64,
    /// x of the mast's axis. The mast stands on the chassis, on the robot's midplane.
    pub mast_x_m: f64,
    /// Width of the mast, which is square.
    pub mast_width_m: f64,
    /// Centre of mass in the base frame, (x, z); it lies on the robot's midplane.
    pub centre_of_mass_m: [f64; 2],
    /// Torsional stiffness of the mechanical link from a side's motor to each of its wheels, seen at the wheel, in N m/rad.
    /// The simulation holds at most (wheel inertia) (physics rate)^2, 138 N m/rad for INCRA I at 1200 Hz.
    pub link_stiffness_n_m_rad: f64,
    /// Play (backlash) of each of those links, seen at the wheel, in rad: a wheel turns half of it either way against the gear,
    /// and the two wheels of a side the whole of it either way against each other. 0 is none.
    pub link_slack_rad: f64,
    /// Radial compliance of a wheel, in m/N: how much nearer the axle comes to the floor for each newton of load. 0 is a rigid
    /// wheel. Across and around, wheels stay rigid; around, [`RobotSpec::link_stiffness_n_m_rad`] can stand for link and tyre in
    /// series.
    pub wheel_compliance_m_n: f64,
    /// Damping of compliant wheels, as a share of what would be critical for a quarter of the robot's mass.
    pub wheel_damping_ratio: f64,
    /// Coefficient of rolling resistance: torque that opposes rolling, as a share of wheel load times wheel radius.
    pub rolling_resistance: f64,
    /// Friction coefficient of chassis, mast and wheel flanks on walls and solids.
    pub body_friction: f64,
    /// Fastest turn of the mount, pan and tilt each, in rad/s.
    pub mount_rate_rad_s: f64,
    /// The drive of each side.
    pub drive: DriveSpec,
}

/// A side's DC servo motor with gear and encoder.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveSpec {
    /// Supply, in V: full duty puts this on the motor.
    pub supply_v: f64,
    /// Winding resistance, in ohm.
    pub resistance_ohm: f64,
    /// Winding inductance, in H.
    pub inductance_h: f64,
    /// Torque constant in N m/A, which is also the back-EMF constant in V s/rad.
    pub motor_constant: f64,
    /// Rotor inertia, in kg m2.
    pub rotor_inertia_kg_m2: f64,
    /// Motor turns for one wheel turn.
    pub gear_ratio: f64,
    /// Share of the motor's torque that the gear passes on while driving. While braking, the gear loses as much again, which
    /// brakes too.
    pub gear_efficiency: f64,
    /// Coulomb friction of gear and bearings, seen at the wheel, in N m.
    pub coulomb_friction_n_m: f64,
    /// Encoder counts for one motor turn (lines times four).
    pub counts_per_motor_turn: u32,
}

impl RobotSpec {
    /// INCRA I, as assumed here.
    pub fn incra1() -> Self {
        Self {
            mass_kg: 5.0,
            wheelbase_m: 0.16,
            track_m: 0.19,
            wheel_radius_m: 0.040,
            wheel_width_m: 0.025,
            wheel_mass_kg: 0.12,
            chassis_m: [0.26, 0.16, 0.05],
            nose_m: 0.16,
            ground_clearance_m: 0.025,
            highest_m: 0.175,
            mast_x_m: 0.12,
            mast_width_m: 0.04,
            centre_of_mass_m: [0.0, 0.055],
            link_stiffness_n_m_rad: 100.0,
            link_slack_rad: 0.0,
            wheel_compliance_m_n: 0.0,
            wheel_damping_ratio: 0.1,
            rolling_resistance: 0.01,
            body_friction: 0.3,
            mount_rate_rad_s: 2.0,
            drive: DriveSpec {
                supply_v: 24.0,
                resistance_ohm: 2.3,
                inductance_h: 0.24e-3,
                motor_constant: 0.0233,
                rotor_inertia_kg_m2: 1.1e-6,
                gear_ratio: 33.0,
                gear_efficiency: 0.75,
                coulomb_friction_n_m: 0.01,
                counts_per_motor_turn: 2000,
            },
        }
    }

    /// Effective track over geometric track of an ideal skid steer, chi = 1 + (L/W)^2: four point contacts, isotropic Coulomb
    /// friction, centre of mass in the middle.
    pub fn chi(&self) -> f64 {
        let ratio = self.wheelbase_m / self.track_m;
        1.0 + ratio * ratio
    }

    /// Speed of the wheels' rims at full duty and without any load or friction, in m/s: supply over back-EMF constant.
    pub fn unloaded_speed_m_s(&self) -> f64 {
        self.drive.supply_v / (self.drive.motor_constant * self.drive.gear_ratio) * self.wheel_radius_m
    }

    /// Weight on a front and on a rear wheel at rest on a level floor, in N.
    pub fn wheel_loads_n(&self) -> [f64; 2] {
        let half_n = self.mass_kg * GRAVITY_M_S2 / 2.0;
        let front = 0.5 + self.centre_of_mass_m[0] / self.wheelbase_m;
        [half_n * front, half_n * (1.0 - front)]
    }

    /// Metres along the floor for one encoder count.
    pub fn metres_per_count(&self) -> f64 {
        std::f64::consts::TAU * self.wheel_radius_m / (self.drive.gear_ratio * f64::from(self.drive.counts_per_motor_turn))
    }
}

impl DriveSpec {
    /// Encoder counts for one turn of a wheel.
    pub fn counts_per_wheel_turn(&self) -> f64 {
        self.gear_ratio * f64::from(self.counts_per_motor_turn)
    }
}
