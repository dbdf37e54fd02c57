//! What the tick's length does to a manoeuvre: speed up, turn left, turn right, on given duties (no controller).

mod common;

use common::{pose, room};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, World};

/// Where the robot is after 3 s: x, y in m, heading in rad.
fn manoeuvre(physics_hz: u32) -> [f64; 3] {
    let ground = Ground::uniform(0.7);
    let start = pose(3.0, 0.0, 0.0);
    let mut world =
        World::new(&room(), &RobotSpec::incra1(), &ground, &start, MountAngles::default(), physics_hz).expect("world");
    for _ in 0..physics_hz / 2 {
        world.step(Sides::default()).expect("finite");
    }
    for (duty, seconds) in [((0.3, 0.3), 1), ((0.2, 0.4), 1), ((0.4, 0.2), 1)] {
        for _ in 0..seconds * physics_hz {
            world.step(Sides { left: duty.0, right: duty.1 }).expect("finite");
        }
    }
    let truth = world.truth();
    [truth.world_from_base.translation.x, truth.world_from_base.translation.y, truth.heading_rad]
}

#[test]
fn a_finer_tick_changes_little_and_the_next_finer_less() {
    let poses = [1200, 2400, 4800].map(manoeuvre);
    let apart = |a: [f64; 3], b: [f64; 3]| {
        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
        ((dx * dx + dy * dy).sqrt(), (a[2] - b[2]).abs())
    };
    let travelled = poses[2][0] - 3.0;
    let (coarse, fine) = (apart(poses[0], poses[1]), apart(poses[1], poses[2]));
    for (name, (metres, radians)) in [("1200 and 2400 Hz", coarse), ("2400 and 4800 Hz", fine)] {
        println!("{name}: {:.3} mm and {:.3} mrad apart after {travelled:.3} m", metres * 1e3, radians * 1e3);
    }
    // Measured: 0.31 mm and 0.52 mrad, then 0.11 mm and 0.37 mrad. Contacts stiffen with the rate, so the robot itself changes as
    // well as the error, and the heading, the difference of two turns of 5 degrees each, need not halve. Asked for is nothing;
    // three times what is measured, and less for the finer pair, would show a method that does not converge.
    assert!(coarse.0 < 1e-3 && coarse.1 < 1.5e-3);
    assert!(fine.0 < coarse.0 && fine.1 < coarse.1);
}
