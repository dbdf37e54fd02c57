//! Coasting: no energy from nowhere, whatever the wheels do.

mod common;

use common::{GRIP, HZ, SpeedLoop, ideal, pose, room, slope, world};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Disturbance, Ground, RobotSpec, World};

fn dead() -> Disturbance {
    Disturbance { motor_strength: Sides { left: 0.0, right: 0.0 }, ..Disturbance::default() }
}

/// Coasts for 2 s. Largest gain over the least energy before it, in the first quarter second and after it, and the energy at the
/// start and at the end, in J.
fn coast(world: &mut World, hz: u32) -> ([f64; 2], f64, f64) {
    world.disturb(dead());
    let start = world.energy_j();
    let mut gains = [0.0_f64; 2];
    for (ticks, gain) in [hz / 4, 2 * hz - hz / 4].into_iter().zip(&mut gains) {
        let mut least = world.energy_j();
        for _ in 0..ticks {
            world.step(Sides::default()).expect("finite");
            let energy = world.energy_j();
            *gain = gain.max(energy - least);
            least = least.min(energy);
        }
    }
    (gains, start, world.energy_j())
}

#[test]
fn coasting_never_gains_energy() {
    let with = |change: fn(&mut RobotSpec)| {
        let mut robot = ideal();
        change(&mut robot);
        robot
    };
    for (name, robot, hz) in [
        ("lossless", ideal(), HZ),
        ("lossless at 4800 Hz", ideal(), 4800),
        ("INCRA I", RobotSpec::incra1(), HZ),
        ("play of 0.05 rad", with(|r| r.link_slack_rad = 0.05), HZ),
        ("wheels that give", with(|r| r.wheel_compliance_m_n = 1e-4), HZ),
    ] {
        for wheels in [[7.5, 7.5], [3.0, 8.0], [-4.0, 4.0]] {
            let start = pose(3.0, 0.0, 0.0);
            let mut world =
                World::new(&room(), &robot, &Ground::uniform(GRIP), &start, MountAngles::default(), hz).expect("world");
            let mut hold = SpeedLoop::new();
            let mut drive = |world: &mut World, wheels: Sides, seconds: f64| {
                (0..(seconds * f64::from(hz)) as u32).for_each(|_| hold.step(world, wheels));
                world.energy_j()
            };
            // What is there at rest: the height that the robot has left after it has sunk in.
            let at_rest = drive(&mut world, Sides::default(), 0.5);
            drive(&mut world, Sides { left: wheels[0], right: wheels[1] }, 2.0);
            let (gains, start, end) = coast(&mut world, hz);
            let (start, end) = (start - at_rest, end - at_rest);
            println!(
                "energy of {name}, wheels at {wheels:?}: {start:.5} J, after 2 s of coasting {end:.5} J, gained {:.1e}, later {:.1e} J",
                gains[0], gains[1]
            );
            // When the turning stops, what contacts and joints have stored under the friction's pull comes back, which is not
            // counted: 0.46 mJ at 1200 Hz, and a sixteenth, 0.028 mJ, at 4800, where they are sixteen times stiffer. Later a
            // few uJ where teeth meet, and what compliant wheels store in their springs.
            let elastic_j = 0.6e-3 * f64::from(HZ * HZ) / f64::from(hz * hz);
            assert!(gains[0] < elastic_j && gains[1] < 1e-5 && end < start + 1e-5, "{gains:?} J");
        }
    }
}

#[test]
fn rolling_down_a_slope_turns_height_into_speed_and_nothing_else() {
    let mut world = world(&room(), &ideal(), &pose(7.0, 0.0, 0.0));
    world.set_gravity(slope(0.1));
    world.disturb(dead());
    for _ in 0..HZ / 4 {
        world.step(Sides::default()).expect("finite");
    }
    let (before, from) = (world.energy_j(), world.truth().world_from_base.translation.vector);
    for _ in 0..HZ {
        world.step(Sides::default()).expect("finite");
    }
    let fell_j = 5.0 * 9.806_65 * libm::sin(0.1) * (from.x - world.truth().world_from_base.translation.vector.x);
    let lost = before - world.energy_j();
    println!("energy lost while rolling down: {lost:.2e} J of {fell_j:.4} J, closed form 0");
    assert!(lost.abs() < 0.01 * fell_j);
}
