#[path = "../tests/common/mod.rs"]
mod common;
use common::*;
use ductloop_nav::messages::Sides;
use ductloop_sim::RobotSpec;
fn main() {
    let robot = RobotSpec::incra1();
    let net = straight(20.0);
    let mut w = world(&net, &robot, &pose(1.0, 0.0, 0.0));
    for _ in 0..1200 {
        w.step(Sides::default()).unwrap();
    }
    let sag = w.truth().world_from_base.translation.z;
    let mut l = SpeedLoop::new();
    l.hold(&mut w, Sides { left: 7.5, right: 7.5 }, 4.0);
    let t = w.truth();
    let d0 = t.distance_m;
    l.hold(&mut w, Sides { left: 7.5, right: 7.5 }, 33.4);
    let e = w.truth();
    print!(
        "sag {:.1} um  speed ratio {:.5} drift {:.4} mm / {:.2} m;",
        sag * 1e6,
        t.speed_m_s / 0.3,
        (e.lateral_m - t.lateral_m - t.heading_rad * (e.distance_m - d0)) * 1e3,
        e.distance_m - d0
    );
    let mut w = world(&net, &robot, &pose(1.0, 0.0, 0.0));
    let t0 = std::time::Instant::now();
    for _ in 0..40000 {
        w.step(Sides { left: 0.2, right: 0.2 }).unwrap();
    }
    print!(" steps/s {:.0};", 40000.0 / t0.elapsed().as_secs_f64());
    for (lw, speeds) in [
        (0.16 / 0.19, (4.0, 6.0)),
        (1.2, (4.0, 6.0)),
        (0.16 / 0.19, (-2.0, 2.0)),
        (0.16 / 0.19, (0.0, 0.2)),
        (0.16 / 0.19, (7.4, 7.6)),
    ] {
        let mut robot = RobotSpec::incra1();
        robot.wheelbase_m = 0.16;
        robot.track_m = 0.16 / lw;
        robot.chassis_m[1] = (robot.track_m - 0.03).min(0.16);
        robot.mast_width_m = 0.03;
        let mut f = fitting(ductloop_duct::fitting::Shape::Straight { length_m: 26.0 });
        f.width_m = 46.0;
        let net = run(&[f]);
        let mut w = world(&net, &robot, &pose(3.0, 0.0, 0.0));
        let mut l = SpeedLoop::new();
        l.hold(&mut w, Sides { left: speeds.0, right: speeds.1 }, 2.0);
        let (mut sum, mut min, mut max, mut n, mut dw) = (0.0, f64::MAX, f64::MIN, 0, 0.0);
        let mut turned = 0.0;
        while turned < std::f64::consts::TAU && n < 10000 {
            l.step(&mut w, Sides { left: speeds.0, right: speeds.1 });
            let t = w.truth();
            sum += t.yaw_rate_rad_s;
            dw += t.wheel_speed_rad_s.right - t.wheel_speed_rad_s.left;
            n += 1;
            min = f64::min(min, t.yaw_rate_rad_s);
            max = f64::max(max, t.yaw_rate_rad_s);
            turned += t.yaw_rate_rad_s / 1200.0;
        }
        let yaw = sum / n as f64;
        let ideal = 0.04 * dw / n as f64 / robot.track_m;
        print!(" | {lw:.2} {speeds:?} {:.4} rip {:.1e}", ideal / yaw / robot.chi(), (max - min) / yaw);
    }
    println!();
}
