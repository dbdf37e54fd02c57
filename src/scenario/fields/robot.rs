//! The robot's body.

use super::field::Slot;
use super::{Field, Kind, TableRow};
use crate::scenario::presets;

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("robot", "The robot: its speed, and its body as a preset gives it, field by field to be overridden."),
    TableRow::new("robot.drive", "The DC servo motor, gear and encoder that drive each side."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::new("robot.preset", Kind::Word(presets::ROBOTS), Slot::Fixed("\"none\""))
        .default("\"incra1\"")
        .about("Where the body's numbers come from; with \"none\" all of them must be given."),
    Field::number("robot.speed_m_s", 0.01, 1.2, |s| &mut s.speed_m_s)
        .unit("m/s")
        .default("0.3")
        .about("Speed along the duct that the navigator holds."),
    Field::number("robot.mass_kg", 0.1, 200.0, |s| &mut s.robot.mass_kg)
        .unit("kg")
        .preset()
        .about("Mass of the whole robot, wheels included."),
    Field::number("robot.wheelbase_m", 0.02, 2.0, |s| &mut s.robot.wheelbase_m)
        .unit("m")
        .preset()
        .about("Distance between front and rear axles."),
    Field::number("robot.track_m", 0.02, 2.0, |s| &mut s.robot.track_m)
        .unit("m")
        .preset()
        .about("Distance between the middles of left and right wheels."),
    Field::number("robot.wheel_radius_m", 0.005, 0.5, |s| &mut s.robot.wheel_radius_m)
        .unit("m")
        .preset()
        .about("Radius of a wheel."),
    Field::number("robot.wheel_width_m", 0.001, 0.5, |s| &mut s.robot.wheel_width_m)
        .unit("m")
        .preset()
        .about("Width of a wheel."),
    Field::number("robot.wheel_mass_kg", 0.001, 20.0, |s| &mut s.robot.wheel_mass_kg)
        .unit("kg")
        .preset()
        .about("Mass of one wheel."),
    Field::numbers("robot.chassis_m", 3, 0.01, 3.0, |s| &mut s.robot.chassis_m)
        .unit("m")
        .preset()
        .about("Length, width and height of the chassis."),
    Field::number("robot.nose_m", 0.0, 3.0, |s| &mut s.robot.nose_m)
        .unit("m")
        .preset()
        .about("How far the chassis' front end is ahead of the base, the point midway between the wheels."),
    Field::number("robot.ground_clearance_m", 0.001, 1.0, |s| &mut s.robot.ground_clearance_m)
        .unit("m")
        .preset()
        .about("Height of the chassis' underside above the floor."),
    Field::number("robot.highest_m", 0.01, 2.0, |s| &mut s.robot.highest_m)
        .unit("m")
        .preset()
        .about("Height of the robot's highest point above the floor."),
    Field::number("robot.mast_x_m", -3.0, 3.0, |s| &mut s.robot.mast_x_m)
        .unit("m")
        .preset()
        .about("How far the axis of the mast, which carries the camera, is ahead of the base."),
    Field::number("robot.mast_width_m", 0.001, 1.0, |s| &mut s.robot.mast_width_m)
        .unit("m")
        .preset()
        .about("Width of the mast, which is square."),
    Field::numbers("robot.centre_of_mass_m", 2, -1.0, 1.0, |s| &mut s.robot.centre_of_mass_m)
        .unit("m")
        .preset()
        .about("Centre of mass ahead of the base and above the floor, [x, z]."),
    Field::number("robot.link_stiffness_n_m_rad", 0.1, 1e5, |s| &mut s.robot.link_stiffness_n_m_rad)
        .unit("N m/rad")
        .preset()
        .about("Torsional stiffness of the link from a side's motor to each of its wheels, seen at the wheel."),
    Field::number("robot.link_slack_rad", 0.0, 0.6, |s| &mut s.robot.link_slack_rad)
        .unit("rad")
        .default("0.0")
        .about("Play of that link, seen at the wheel: how far the wheel turns before the gear holds it."),
    Field::number("robot.wheel_compliance_m_n", 0.0, 0.01, |s| &mut s.robot.wheel_compliance_m_n)
        .unit("m/N")
        .default("0.0")
        .about("How far a newton of load presses a wheel in; 0 is a rigid wheel."),
    Field::number("robot.wheel_damping_ratio", 0.0, 2.0, |s| &mut s.robot.wheel_damping_ratio)
        .default("0.1")
        .about("Damping of wheels that give, as a share of what would be critical for a quarter of the robot."),
    Field::number("robot.rolling_resistance", 0.0, 0.5, |s| &mut s.robot.rolling_resistance)
        .preset()
        .about("Torque that opposes rolling, as a share of wheel load times wheel radius."),
    Field::number("robot.body_friction", 0.0, 2.0, |s| &mut s.robot.body_friction)
        .preset()
        .about("Coefficient of friction of chassis, mast and wheel flanks on walls."),
    Field::number("robot.mount_rate_rad_s", 0.001, 100.0, |s| &mut s.robot.mount_rate_rad_s)
        .unit("rad/s")
        .preset()
        .about("Fastest turn of the mount, pan and tilt each."),
    Field::number("robot.drive.supply_v", 1.0, 100.0, |s| &mut s.robot.drive.supply_v)
        .unit("V")
        .preset()
        .about("Supply: full duty puts this on the motor."),
    Field::number("robot.drive.resistance_ohm", 0.01, 100.0, |s| &mut s.robot.drive.resistance_ohm)
        .unit("ohm")
        .preset()
        .about("Resistance of the winding."),
    Field::number("robot.drive.inductance_h", 1e-7, 0.1, |s| &mut s.robot.drive.inductance_h)
        .unit("H")
        .preset()
        .about("Inductance of the winding."),
    Field::number("robot.drive.motor_constant", 1e-4, 10.0, |s| &mut s.robot.drive.motor_constant)
        .unit("N m/A")
        .preset()
        .about("Torque constant, which is also the back-EMF constant in V s/rad."),
    Field::number("robot.drive.rotor_inertia_kg_m2", 1e-9, 0.01, |s| &mut s.robot.drive.rotor_inertia_kg_m2)
        .unit("kg m2")
        .preset()
        .about("Moment of inertia of the rotor."),
    Field::number("robot.drive.gear_ratio", 1.0, 1000.0, |s| &mut s.robot.drive.gear_ratio)
        .preset()
        .about("Motor turns for one wheel turn."),
    Field::number("robot.drive.gear_efficiency", 0.05, 1.0, |s| &mut s.robot.drive.gear_efficiency)
        .preset()
        .about("Share of the motor's torque that the gear passes on while driving."),
    Field::number("robot.drive.coulomb_friction_n_m", 0.0, 10.0, |s| &mut s.robot.drive.coulomb_friction_n_m)
        .unit("N m")
        .preset()
        .about("Dry friction of gear and bearings, seen at the wheel."),
    Field::count("robot.drive.counts_per_motor_turn", 4, 1_000_000, |s| &mut s.robot.drive.counts_per_motor_turn)
        .preset()
        .about("Encoder counts for one motor turn: lines times four."),
];
