//! The drive alone, against the closed forms of a DC motor. The wheels are integrated here: free discs on the drive's torques.

use ductloop_sim::RobotSpec;
use ductloop_sim::drive::{Drive, wheel_spin_inertia};

const HZ: u32 = 1200;
const DT: f64 = 1.0 / HZ as f64;

/// A drive with its two wheels in the air.
struct Bench {
    drive: Drive,
    wheel_inertia: f64,
    wheels: [f64; 2],
}

impl Bench {
    fn new(robot: &RobotSpec) -> Self {
        Self { drive: Drive::new(robot, HZ), wheel_inertia: wheel_spin_inertia(robot), wheels: [0.0; 2] }
    }

    /// One tick; `load` is an outside torque on each wheel.
    fn step(&mut self, duty: f64, load: f64) {
        let torques = self.drive.step(duty, self.wheels);
        for (wheel, torque) in self.wheels.iter_mut().zip(torques) {
            *wheel += DT * (torque + load) / self.wheel_inertia;
        }
    }
}

/// INCRA I without friction or loss.
fn ideal() -> RobotSpec {
    let mut robot = RobotSpec::incra1();
    robot.rolling_resistance = 0.0;
    robot.drive.coulomb_friction_n_m = 0.0;
    robot.drive.gear_efficiency = 1.0;
    robot
}

#[test]
fn a_step_of_voltage_gives_the_closed_form_response() {
    let robot = ideal();
    let motor = &robot.drive;
    // J w' = k i, L i' = V - R i - k w, all at the wheel: k = n k_m, J of rotor and wheels. Two real poles.
    let k = motor.gear_ratio * motor.motor_constant;
    let inertia = motor.gear_ratio * motor.gear_ratio * motor.rotor_inertia_kg_m2 + 2.0 * wheel_spin_inertia(&robot);
    let (r, l) = (motor.resistance_ohm, motor.inductance_h);
    let root = ((r / l) * (r / l) - 4.0 * k * k / (l * inertia)).sqrt();
    let (slow, fast) = ((r / l - root) / 2.0, (r / l + root) / 2.0);
    let steady = 12.0 / k;
    let expected = |t: f64| steady * (1.0 - (fast * libm::exp(-slow * t) - slow * libm::exp(-fast * t)) / (fast - slow));

    let mut bench = Bench::new(&robot);
    let mut worst: f64 = 0.0;
    for tick in 1..=180 {
        bench.step(0.5, 0.0);
        worst = worst.max((bench.drive.speed_rad_s() - expected(f64::from(tick) * DT)).abs() / steady);
    }
    println!("worst error {:.3} % of {steady:.2} rad/s, time constant {:.2} ms", worst * 100.0, 1e3 / slow);
    // A tick is 16 % of the time constant (5.3 ms in the air; 20 ms with the robot's weight). Trapezoids of that width leave
    // x^2 / 12 / e = 0.08 % of the steady speed; the wheels, 14 % of the inertia, lag a fraction of a tick: about as much
    // again. Measured 0.17 %. A first-order method would leave x / 2 / e = 3 %.
    assert!(worst < 3e-3);
    for _ in 0..1200 {
        bench.step(0.5, 0.0);
    }
    // Settled to exp(-50): rounding.
    assert!((bench.drive.speed_rad_s() / steady - 1.0).abs() < 1e-12);
    assert!(bench.wheels.iter().all(|wheel| (wheel / steady - 1.0).abs() < 1e-12));
}

#[test]
fn held_wheels_take_the_stall_torque_less_gear_loss_and_friction() {
    let robot = RobotSpec::incra1();
    let mut drive = Drive::new(&robot, HZ);
    let mut torques = [0.0; 2];
    // Slowly, so that nothing swings over: friction would hold the links' twist where the swing left it.
    const TICKS: u32 = 4 * HZ;
    for tick in 1..=TICKS {
        torques = drive.step(0.1 * f64::from(tick) / f64::from(TICKS), [0.0; 2]);
    }
    let motor = &robot.drive;
    let stall_a = 0.1 * motor.supply_v / motor.resistance_ohm;
    let rolling = 0.01 * 5.0 * 9.806_65 / 2.0 * 0.04;
    let expected =
        motor.gear_efficiency * motor.gear_ratio * motor.motor_constant * stall_a - motor.coulomb_friction_n_m - rolling;
    let sum = torques[0] + torques[1];
    println!("stall {stall_a:.4} A, {:.4} A; {expected:.5} N m, {sum:.5} N m", drive.current_a());
    // The twist follows the ramp a few ticks late (a tick is 0.02 % of it) and the rotor's creep, 0.7 mrad/s, is 0.01 % of
    // the back-EMF that would matter.
    assert!((drive.current_a() / stall_a - 1.0).abs() < 1e-3);
    assert!((sum / expected - 1.0).abs() < 5e-3);
    assert_eq!(torques[0], torques[1]);
}

#[test]
fn below_break_away_nothing_moves_at_all() {
    let robot = RobotSpec::incra1();
    let motor = &robot.drive;
    let rolling = 0.01 * 5.0 * 9.806_65 / 2.0 * 0.04;
    let friction = motor.coulomb_friction_n_m + rolling;
    let break_away =
        friction * motor.resistance_ohm / (motor.gear_efficiency * motor.gear_ratio * motor.motor_constant * motor.supply_v);
    for (share, moves) in [(0.99, false), (1.01, true)] {
        for sign in [1.0, -1.0] {
            let mut bench = Bench::new(&robot);
            for _ in 0..1200 {
                bench.step(sign * share * break_away, 0.0);
            }
            assert_eq!(bench.drive.angle_rad() * sign > 0.0, moves);
            assert_eq!(bench.drive.angle_rad() != 0.0, moves);
        }
    }
}

#[test]
fn coasting_stops_without_ever_turning_back() {
    let robot = RobotSpec::incra1();
    let mut bench = Bench::new(&robot);
    for _ in 0..600 {
        bench.step(0.3, 0.0);
    }
    let mut before = bench.drive.speed_rad_s();
    assert!(before > 5.0);
    for _ in 0..1200 {
        bench.step(0.0, 0.0);
        let after = bench.drive.speed_rad_s();
        assert!((0.0..=before).contains(&after), "{before} -> {after}");
        before = after;
    }
    assert_eq!(before, 0.0);
}

#[test]
fn friction_and_loss_only_take_energy() {
    // Duty and loads that cross zero again and again: over any stretch, what the supply and the loads put in is at least what
    // is stored. Kept simple by comparing with the lossless drive's bound: rotor, wheels, links and winding against input.
    let mut robot = RobotSpec::incra1();
    robot.drive.coulomb_friction_n_m = 0.2;
    let motor = robot.drive.clone();
    let reflected = motor.gear_ratio * motor.gear_ratio * motor.rotor_inertia_kg_m2;
    let mut bench = Bench::new(&robot);
    let (mut put_in, mut most_stored): (f64, f64) = (0.0, 0.0);
    for tick in 0..12_000 {
        let t = f64::from(tick) * DT;
        let duty = 0.2 * libm::sin(17.0 * t);
        let load = 0.15 * libm::sin(5.0 * t);
        let (speed, wheels, current) = (bench.drive.speed_rad_s(), bench.wheels, bench.drive.current_a());
        bench.step(duty, load);
        // Trapezoids. Within a tick the current is not linear, hence the margin below.
        put_in += DT * duty * motor.supply_v * 0.5 * (current + bench.drive.current_a());
        put_in += (0..2).map(|i| DT * load * 0.5 * (wheels[i] + bench.wheels[i])).sum::<f64>();
        let speed = bench.drive.speed_rad_s().abs().max(speed.abs());
        let stored =
            0.5 * reflected * speed * speed + bench.wheels.iter().map(|w| 0.5 * bench.wheel_inertia * w * w).sum::<f64>();
        most_stored = most_stored.max(stored);
        assert!(stored <= put_in + 0.02 * most_stored, "at {t:.3} s: stored {stored:.4} J of {put_in:.4} J");
    }
    assert!(put_in > 10.0 * most_stored, "the cycle must move: {put_in} J, {most_stored} J");
}
