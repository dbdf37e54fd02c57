//! The closed loop: physics, camera, navigator and wheel controller under one count of ticks.
//!
//! ```text
//! tick      0 . . . . . 6 . . . . . 12 . . . . . . . . . . 40 . . .        (1200 Hz)
//! camera    expose 0                                       expose 1        (30 Hz)
//! navigator    reads 0, decides ...                        command 0 acts
//! wheels    duty        duty        duty                                   (200 Hz)
//! ```
//!
//! A command takes effect one frame after the exposure that it was decided on: the time a real robot needs to read out and
//! think. Nothing passes to the navigator but frame, counts, mount angles and tick.

use std::ops::ControlFlow;

use ductloop_duct::network::{Network, NetworkError};
use ductloop_duct::Transform;
use ductloop_nav::messages::{Command, Frame, Pixels, Sides};
use ductloop_nav::rig::{MountAngles, Rig};
use ductloop_nav::wheel_controller::WheelController;
use ductloop_sensor::renderer::{RenderError, Renderer, View, MAX_LASERS};
use ductloop_sim::ground::Ground;
use ductloop_sim::truth::Truth;
use ductloop_sim::world::{SimError, World};

use nalgebra::Point3;

use crate::fault::Faults;
use crate::pilot::Pilot;
use crate::record::{EndState, FrameRecord, KeyFrames, RunRecord};
use crate::run_hash::RunHash;
use crate::scenario::Scenario;

/// Why a run could not go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The duct cannot be assembled. A scenario that was read or validated never gives this.
    #[error("the duct cannot be assembled: {0}")]
    Network(#[from] NetworkError),
    /// The physics failed.
    #[error("{0}")]
    Sim(#[from] SimError),
    /// There is no image.
    #[error("{0}")]
    Render(#[from] RenderError),
}

/// A navigator that has stopped is given this long to come to rest before the run ends.
const STOPPED_S: f64 = 1.0;

/// Runs a scenario to its end. `watch` sees every frame and its image, and may break the run off.
///
/// # Errors
/// Where the run cannot go on. What was recorded until then is handed to `watch` frame by frame; nothing else is kept.
pub fn run_with(
    scenario: &Scenario,
    pilot: Pilot,
    renderer: &mut dyn Renderer,
    mut watch: impl FnMut(&FrameRecord, &[u8]) -> ControlFlow<()>,
) -> Result<RunRecord, RunError> {
    let mut body = Body::new(scenario)?;
    let Pilot { mut navigator, truth: truth_feed } = pilot;
    let faults = Faults::new(scenario);
    let camera = &scenario.rig.camera;
    let mut image = vec![0; camera.width_px * camera.height_px];
    let mut pending: Option<Command> = None;
    let (mut exposure_s, mut laser_power) = (scenario.exposure_s, 1.0);
    let (mut frames, mut key_frames, mut hash) = (Vec::new(), KeyFrames::default(), RunHash::default());
    let mut stopped_frames = 0;

    let end = loop {
        let tick = body.world.tick();
        let time_s = tick as f64 / f64::from(scenario.rates.physics_hz);
        let active = faults.at(time_s);

        // The command decided on the frame before takes effect now.
        if let Some(command) = pending.take() {
            body.wheels.command(active.wheel_speeds(command.wheel_speed_rad_s));
            body.world.point_mount(command.mount);
            exposure_s = command.exposure_s.unwrap_or(exposure_s);
            laser_power = command.laser_power.unwrap_or(laser_power);
        }

        // Exposure: truth, counts and mount angles belong to the same tick as the image.
        let (truth, counts, mount) = (body.world.truth(), body.world.counts(), body.world.mount());
        if let Some(end) = body.end(&truth, time_s, stopped_frames, scenario) {
            break end;
        }
        let mut view = body.view(&truth, mount, frames.len() as u64, exposure_s, laser_power);
        active.dim(&mut view);
        renderer.render(&view, &mut image)?;
        if let Some(feed) = &truth_feed {
            feed.set(truth.lateral_m, truth.heading_rad, body.width_at(&truth));
        }

        // The navigator reads the frame while the body moves on; its command waits for the next one.
        let frame = Frame { width_px: camera.width_px, height_px: camera.height_px, pixels: Pixels::Grey8(&image) };
        let command = navigator.on_frame(&frame, counts, mount, tick);
        pending = Some(command);

        let report = navigator.report();
        hash.frame(tick, &truth, &image, counts, &command);
        key_frames.offer(frames.len() as u64, &image, report.lines);
        stopped_frames = if report.state == ductloop_nav::navigator::State::Stopped { stopped_frames + 1 } else { 0 };
        let record = FrameRecord {
            frame: frames.len() as u64,
            tick,
            time_s,
            truth,
            collisions: body.world.collisions(),
            counts,
            mount,
            measurement: report.measurement,
            state: report.state,
            lines: report.lines.len(),
            command,
            faults: active.bits(),
        };
        let verdict = watch(&record, &image);
        frames.push(record);
        if verdict.is_break() {
            break EndState::BrokenOff;
        }

        for _ in 0..scenario.rates.ticks_per_frame() {
            body.step()?;
        }
    };
    let truth = body.world.truth();
    Ok(RunRecord {
        frames,
        key_frames,
        end,
        sim_time_s: body.world.tick() as f64 / f64::from(scenario.rates.physics_hz),
        collisions: body.world.collisions(),
        distance_m: truth.distance_m - scenario.start.distance_m,
        run_hash: hash.value(),
    })
}

/// The robot's body in its duct: physics, and the wheel controller that drives it.
struct Body {
    world: World,
    network: Network,
    wheels: WheelController,
    duty: Sides,
    ticks_per_wheel_control: u64,
    finish_m: f64,
    /// The rig as it truly is, and by how much its mount points elsewhere than it reports.
    rig: Rig,
    mount_error: MountAngles,
}

impl Body {
    fn new(scenario: &Scenario) -> Result<Self, RunError> {
        let network = scenario.duct.network()?;
        let ground = Ground::new(scenario.surfaces.iter().map(|s| s.friction).collect());
        let start = scenario.world_from_start(&network);
        let rates = scenario.rates;
        let world = World::new(&network, &scenario.robot, &ground, &start, scenario.rig.mount.rest, rates.physics_hz)?;
        let period_s = 1.0 / f64::from(rates.wheel_control_hz);
        let counts_per_wheel_turn = scenario.robot.drive.counts_per_wheel_turn();
        let rig = scenario.actual_rig();
        let (actual, nominal) = (rig.mount.rest, scenario.rig.mount.rest);
        Ok(Self {
            world,
            wheels: WheelController::new(scenario.wheel_gains(), period_s, counts_per_wheel_turn),
            duty: Sides::default(),
            ticks_per_wheel_control: rates.ticks_per_wheel_control(),
            finish_m: scenario.finish_m(&network),
            network,
            mount_error: MountAngles { pan_rad: actual.pan_rad - nominal.pan_rad, tilt_rad: actual.tilt_rad - nominal.tilt_rad },
            rig,
        })
    }

    /// One physics tick, and the wheel controller's where it is due.
    fn step(&mut self) -> Result<(), SimError> {
        if self.world.tick().is_multiple_of(self.ticks_per_wheel_control) {
            self.duty = self.wheels.tick(self.world.counts());
        }
        self.world.step(self.duty)
    }

    /// What the camera is to see.
    fn view(&self, truth: &Truth, mount: MountAngles, frame: u64, exposure_s: f64, laser_power: f64) -> View {
        View {
            world_from_camera: world_from_camera(&self.rig, &truth.world_from_base, mount, self.mount_error),
            frame,
            exposure_s,
            laser_power: [laser_power; MAX_LASERS],
            headlamp_power: 1.0,
        }
    }

    fn width_at(&self, truth: &Truth) -> f64 {
        self.network.centreline.segment_at(truth.distance_m).width_m
    }

    /// Whether the run is over, and how.
    fn end(&self, truth: &Truth, time_s: f64, stopped_frames: u32, scenario: &Scenario) -> Option<EndState> {
        // A millimetre above the floor, so that a wheel's penetration does not count as having left the duct.
        let base = truth.world_from_base * Point3::new(0.0, 0.0, 1e-3);
        let stopped_s = f64::from(stopped_frames) / f64::from(scenario.rates.camera_hz);
        if truth.distance_m >= self.finish_m {
            Some(EndState::Finished)
        } else if self.network.cell_at(&base, truth.cell).is_none() {
            Some(EndState::Outside)
        } else if stopped_s >= STOPPED_S && truth.speed_m_s.abs() < 1e-3 {
            Some(EndState::Stopped)
        } else if time_s >= scenario.time_limit_s {
            Some(EndState::TimeLimit)
        } else {
            None
        }
    }
}

/// Pose of the camera: of the true rig, whose mount points elsewhere than it reports by `error`.
pub fn world_from_camera(rig: &Rig, world_from_base: &Transform, reported: MountAngles, error: MountAngles) -> Transform {
    let angles = MountAngles { pan_rad: reported.pan_rad + error.pan_rad, tilt_rad: reported.tilt_rad + error.tilt_rad };
    world_from_base * rig.mount.base_from_camera(angles)
}
