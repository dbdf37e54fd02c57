//! Turning on the spot with the load shifted forward, against the balance of four Coulomb contacts, solved two ways.

mod common;

use std::f64::consts::TAU;

use common::{HZ, SpeedLoop, pose, room, with_aspect, world};
use ductloop_nav::messages::Sides;
use ductloop_sim::RobotSpec;

/// Wheels at -w and w with w r = 1 m/s.
struct Contacts {
    wheelbase_m: f64,
    track_m: f64,
    /// Share of the weight on the front axle.
    front: f64,
}

impl Contacts {
    /// Power lost in the contacts over mu m g when the robot turns at `yaw` about a point `ahead` of its middle. The forces are
    /// its derivatives, so they balance where it is smallest; it is convex in (yaw, yaw ahead), and where a wheel does not slip
    /// it has an edge, which is static friction.
    fn power(&self, yaw: f64, sideways: f64) -> f64 {
        [(0.5, self.front / 2.0), (-0.5, (1.0 - self.front) / 2.0)]
            .into_iter()
            .map(|(place, share)| {
                // Of a right wheel; the left one's is the mirror image. Ahead: rolling 1 m/s less what the floor goes by.
                let along = yaw * self.track_m / 2.0 - 1.0;
                let across = yaw * place * self.wheelbase_m + sideways;
                2.0 * share * (along * along + across * across).sqrt()
            })
            .sum()
    }

    /// Nested golden-section search, to 1e-9 of the range. Returns the yaw rate.
    fn balanced_yaw(&self) -> f64 {
        let widest = 2.0 / self.track_m;
        let over_sideways = |yaw: f64| smallest(-widest, widest, |sideways| self.power(yaw, sideways));
        smallest(0.0, widest, |yaw| over_sideways(yaw).1).0
    }

    /// chi by that search.
    fn chi_by_search(&self) -> f64 {
        2.0 / self.track_m / self.balanced_yaw()
    }

    /// chi in closed form: with the instant centre f behind the front axle and b ahead of the rear one, f + b = L, both balances
    /// hold for chi = 1 + 4 f b / W^2 and N_f^2 (1 + 4 f^2/W^2) = N_r^2 (1 + 4 b^2/W^2), N_f and N_r the axles' loads. Once
    /// N_f / N_r reaches sqrt(1 + 4 L^2/W^2), f is 0: the front wheels roll without slip, and chi is 1.
    fn chi_closed(&self) -> f64 {
        let (l, w) = (self.wheelbase_m / self.track_m, 1.0);
        let rear = 1.0 - self.front;
        let excess = |f: f64| (self.front * self.front) * (w + 4.0 * f * f) - (rear * rear) * (w + 4.0 * (l - f) * (l - f));
        if excess(0.0) >= 0.0 {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, l);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if excess(middle) < 0.0 { low = middle } else { high = middle }
        }
        1.0 + 4.0 * low * (l - low)
    }
}

/// Where a convex function of one variable is smallest, and how small.
fn smallest(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    for _ in 0..60 {
        let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if of(a) < of(b) { high = b } else { low = a }
    }
    let at = (low + high) / 2.0;
    (at, of(at))
}

fn contacts(robot: &RobotSpec) -> Contacts {
    let [front_n, rear_n] = robot.wheel_loads_n();
    Contacts { wheelbase_m: robot.wheelbase_m, track_m: robot.track_m, front: front_n / (front_n + rear_n) }
}

/// chi of the simulated robot over one full turn.
fn simulated(robot: &RobotSpec) -> f64 {
    let mut world = world(&room(), robot, &pose(4.0, 0.0, 0.3));
    let mut hold = SpeedLoop::new();
    let wheels = Sides { left: -2.0, right: 2.0 };
    hold.hold(&mut world, wheels, 2.0);
    let (mut turned, mut ideal) = (0.0, 0.0);
    while turned < TAU {
        hold.step(&mut world, wheels);
        let truth = world.truth();
        turned += truth.yaw_rate_rad_s / f64::from(HZ);
        let speed = truth.wheel_speed_rad_s;
        ideal += robot.wheel_radius_m * (speed.right - speed.left) / robot.track_m / f64::from(HZ);
        assert!(world.tick() < 60 * u64::from(HZ));
    }
    ideal / turned
}

fn loaded(aspect: f64, front: f64) -> RobotSpec {
    let mut robot = with_aspect(aspect);
    robot.centre_of_mass_m[0] = (front - 0.5) * robot.wheelbase_m;
    robot
}

#[test]
fn search_and_closed_form_agree_with_each_other_and_with_the_published_table() {
    // Published for L/W = 2/3, to three digits.
    for (front, published) in [(0.5, 1.444), (0.55, 1.395), (0.6, 1.210)] {
        let contacts = contacts(&loaded(2.0 / 3.0, front));
        let (searched, closed) = (contacts.chi_by_search(), contacts.chi_closed());
        println!("chi at {:.0} % in front: search {searched:.5}, closed form {closed:.5}, published {published}", 100.0 * front);
        // Near its smallest value a function changes by the square: the search resolves the root of a double's 1e-16.
        assert!((searched - closed).abs() < 1e-6);
        assert!((closed - published).abs() < 0.0006);
    }
    // Where the front wheels have stopped slipping. The published 1.003 at 65 % is above what the four contacts allow by 0.3 %,
    // as friction that needs some slip to act would be.
    for front in [0.626, 0.65, 0.7] {
        let contacts = contacts(&loaded(2.0 / 3.0, front));
        assert_eq!(contacts.chi_closed(), 1.0);
        assert!((contacts.chi_by_search() - 1.0).abs() < 1e-6);
    }
    // N_f / N_r = 5/3.
    assert!(contacts(&loaded(2.0 / 3.0, 0.624)).chi_closed() > 1.001);
}

#[test]
fn a_load_shifted_forward_turns_easier() {
    for (aspect, front) in [
        (2.0 / 3.0, 0.5),
        (2.0 / 3.0, 0.55),
        (2.0 / 3.0, 0.6),
        (2.0 / 3.0, 0.65),
        (2.0 / 3.0, 0.7),
        (0.16 / 0.19, 0.45),
        (0.16 / 0.19, 0.6),
        (1.2, 0.6),
    ] {
        let robot = loaded(aspect, front);
        let closed = contacts(&robot).chi_closed();
        let chi = simulated(&robot);
        println!("chi at L/W {aspect:.3}, {:.0} % in front: {chi:.4}, closed form {closed:.4}", front * 100.0);
        // Asked for: 3 %. Measured: 0.04 to 0.09 %, and 0.25 % at 60 % and 2/3, where chi falls steeply with the load's place (by
        // 6 % from 60 to 61 %) and the loads are those of wheels that sink in.
        assert!((chi / closed - 1.0).abs() < 5e-3);
    }
}
