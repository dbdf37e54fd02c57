//! One side's drive: DC motor, gear, and the links from the gear to the side's front and rear wheel.
//!
//! All angles and torques below are seen at the wheel unless they are named after the motor. The rotor is a state of its own
//! (inertia n^2 J at the wheel), tied to each wheel by a torsional spring with damping, so the two wheels of a side turn
//! together and the encoder reads the motor, not a wheel.
//!
//! Within a tick:
//! - the winding's current is exact for a constant voltage and rotor speed (its time constant L/R is shorter than a tick), and
//!   the torque is that of the tick's mean current, at the tick's mean speed (second order in the tick);
//! - friction (Coulomb, rolling resistance, the gear's load-dependent loss) opposes the speed at the *end* of the tick and is
//!   at most what stops the rotor there: it holds at standstill exactly, and it never drives;
//! - the links are stable for every stiffness and rate: a stiffness beyond what the rate can hold is brought down to that.
//!
//! The supply may be weak (a share of it reaches the motor; the winding stays closed, so the motor brakes as ever) or the winding
//! open (strength 0: no current flows, the motor neither drives nor brakes, and friction alone stops it; the little energy in
//! the inductance is gone within the tick).
//!
//! Assumptions: the gear's loss is (1 - efficiency) of the motor's torque whether it drives or
//! brakes; rolling resistance is taken at the robot's static load and, like bearing friction, from the chassis (its reaction
//! on the chassis, 0.1 N of wheel load for INCRA I, is not real).

use crate::links::Links;
use crate::spec::{DriveSpec, RobotSpec};

/// Standard gravity, in m/s2.
pub const GRAVITY_M_S2: f64 = 9.806_65;

/// State of one side's drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    spec: DriveSpec,
    links: Links,
    /// Rotor inertia at the wheel, n^2 J.
    inertia_kg_m2: f64,
    /// Speed-independent friction at the wheel: Coulomb and rolling resistance.
    friction_n_m: f64,
    dt_s: f64,
    /// exp(-dt R/L): what is left of the current's transient at the end of a tick.
    transient_end: f64,
    /// Mean of exp(-t R/L) over a tick.
    transient_mean: f64,
    current_a: f64,
    angle_rad: f64,
    speed_rad_s: f64,
    /// Share of the supply that reaches the motor; 0 is an open winding.
    strength: f64,
}

/// Spin inertia of a wheel: a uniform disc, in kg m2.
pub fn wheel_spin_inertia(robot: &RobotSpec) -> f64 {
    0.5 * robot.wheel_mass_kg * robot.wheel_radius_m * robot.wheel_radius_m
}

/// A rotor speed after a tick and the torques that led there, for one assumed direction of motion.
struct Balance {
    /// Torque times sign: driving forward is positive. In N m.
    numerator: f64,
    /// In N m s/rad.
    denominator: f64,
}

impl Drive {
    /// A drive at rest, for a physics rate of `physics_hz`.
    pub fn new(robot: &RobotSpec, physics_hz: u32) -> Self {
        let spec = robot.drive.clone();
        let dt_s = 1.0 / f64::from(physics_hz);
        let wheel_inertia = wheel_spin_inertia(robot);
        let ticks_per_time_constant = spec.inductance_h / (spec.resistance_ohm * dt_s);
        let transient_end = libm::exp(-1.0 / ticks_per_time_constant);
        let rolling_n_m = robot.rolling_resistance * robot.mass_kg * GRAVITY_M_S2 / 2.0 * robot.wheel_radius_m;
        Self {
            links: Links::new(robot.link_stiffness_n_m_rad, robot.link_slack_rad, wheel_inertia, dt_s),
            inertia_kg_m2: spec.gear_ratio * spec.gear_ratio * spec.rotor_inertia_kg_m2,
            friction_n_m: spec.coulomb_friction_n_m + rolling_n_m,
            dt_s,
            transient_end,
            transient_mean: ticks_per_time_constant * -libm::expm1(-1.0 / ticks_per_time_constant),
            current_a: 0.0,
            angle_rad: 0.0,
            speed_rad_s: 0.0,
            strength: 1.0,
            spec,
        }
    }

    /// From now on so much of the supply reaches the motor, clamped to [0, 1]; 0 opens the winding.
    pub fn set_strength(&mut self, strength: f64) {
        self.strength = strength.clamp(0.0, 1.0);
    }

    fn is_open(&self) -> bool {
        self.strength == 0.0
    }

    /// Lets one tick pass. `duty` of the supply, clamped to [-1, 1], is on the motor; the wheels, front and rear, turn at
    /// `wheel_rad_s` relative to the chassis. Returns the torque on each wheel, forward positive, in N m; the chassis takes the
    /// opposite of their sum.
    pub fn step(&mut self, duty: f64, wheel_rad_s: [f64; 2]) -> [f64; 2] {
        self.links.twist(self.dt_s, self.speed_rad_s, wheel_rad_s);
        let volts = duty.clamp(-1.0, 1.0) * self.spec.supply_v * self.strength;
        let before = self.speed_rad_s;
        let mut after = self.speed_after(volts, wheel_rad_s);
        while self.links.part(after, wheel_rad_s) {
            after = self.speed_after(volts, wheel_rad_s);
        }
        let mean = 0.5 * (before + after);
        self.current_a = if self.is_open() {
            0.0
        } else {
            let steady = self.steady_current(volts, mean);
            steady + (self.current_a - steady) * self.transient_end
        };
        self.speed_rad_s = after;
        self.angle_rad += self.dt_s * mean;
        self.links.torques(after, wheel_rad_s)
    }

    fn steady_current(&self, volts: f64, wheel_side_rad_s: f64) -> f64 {
        (volts - self.spec.motor_constant * self.spec.gear_ratio * wheel_side_rad_s) / self.spec.resistance_ohm
    }

    /// Mean current over a tick that ends at `after`.
    fn mean_current(&self, volts: f64, after: f64) -> f64 {
        if self.is_open() {
            return 0.0;
        }
        let steady = self.steady_current(volts, 0.5 * (self.speed_rad_s + after));
        steady + (self.current_a - steady) * self.transient_mean
    }

    fn speed_after(&self, volts: f64, wheel_rad_s: [f64; 2]) -> f64 {
        let before = self.speed_rad_s;
        if before != 0.0 {
            let moving = self.balance(volts, wheel_rad_s, before.signum(), self.mean_current(volts, before));
            let after = moving.numerator / moving.denominator;
            if after * before > 0.0 {
                return after;
            }
        }
        // At rest, or passing through it within this tick: which way, if any, do the torques overcome friction?
        let at_rest = self.mean_current(volts, 0.0);
        let forward = self.balance(volts, wheel_rad_s, 1.0, at_rest);
        if forward.numerator > 0.0 {
            return forward.numerator / forward.denominator;
        }
        let backward = self.balance(volts, wheel_rad_s, -1.0, at_rest);
        if backward.numerator < 0.0 {
            return backward.numerator / backward.denominator;
        }
        0.0
    }

    /// n^2 J (after - before)/dt = motor torque - friction - links, solved for `after`, when the rotor ends up moving in
    /// `direction` and the current has the sign of `current_a`.
    fn balance(&self, volts: f64, wheel_rad_s: [f64; 2], direction: f64, current_a: f64) -> Balance {
        let driving = direction * current_a >= 0.0;
        let loss = 1.0 - self.spec.gear_efficiency;
        let passed = if driving { 1.0 - loss } else { 1.0 + loss };
        let torque_per_a = passed * self.spec.gear_ratio * self.spec.motor_constant;
        // The mean current is linear in `after`: its value at after = 0, and its slope.
        let at_rest = self.mean_current(volts, 0.0);
        let slope = if self.is_open() {
            0.0
        } else {
            (1.0 - self.transient_mean) * self.spec.motor_constant * self.spec.gear_ratio / (2.0 * self.spec.resistance_ohm)
        };
        Balance {
            numerator: self.inertia_kg_m2 * self.speed_rad_s / self.dt_s + torque_per_a * at_rest
                - self.links.torque_at_rest(wheel_rad_s)
                - direction * self.friction_n_m,
            denominator: self.inertia_kg_m2 / self.dt_s + torque_per_a * slope + self.links.torque_per_speed(),
        }
    }

    /// Current in the winding at the end of the tick, in A.
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Energy of rotor, links and winding, in J, with the wheels, front and rear, at these speeds after the tick.
    pub fn energy_j(&self, wheel_rad_s: [f64; 2]) -> f64 {
        let rotor = 0.5 * self.inertia_kg_m2 * self.speed_rad_s * self.speed_rad_s;
        let winding = 0.5 * self.spec.inductance_h * self.current_a * self.current_a;
        rotor + self.links.energy_j(self.dt_s, self.speed_rad_s, wheel_rad_s) + winding
    }

    /// Angle of the motor's shaft since the start, divided by the gear ratio, in radians.
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Speed of the motor's shaft divided by the gear ratio, in rad/s.
    pub fn speed_rad_s(&self) -> f64 {
        self.speed_rad_s
    }
}
