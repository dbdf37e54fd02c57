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
use ductloop_nav::messages::{Command, Counts, Sides};
use ductloop_nav::navigator::{Navigator, State};
use ductloop_nav::rig::{MountAngles, Rig};
use ductloop_nav::wheel_controller::WheelController;
use ductloop_sensor::renderer::{MAX_LASERS, RenderError, Renderer, View};
use ductloop_sim::ground::Ground;
use ductloop_sim::truth::Truth;
use ductloop_sim::world::{SimError, World};
use nalgebra::Point3;

use crate::fault::Faults;
use crate::grey_image::GreyImage;
use crate::pilot::{Pilot, TruthFeed};
use crate::record::{EndState, FrameRecord, KeyFrames, RunRecord};
use crate::run_hash::RunHash;
use crate::scenario::Scenario;
use crate::stage_scores::{TruthScene, score};
use crate::viewpoint::{motion, world_from_camera};

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

/// A run that could not go on, with what it had come to.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct RunFailure {
    /// Why.
    #[source]
    pub error: RunError,
    /// Its frames until then; `None` if it never began.
    pub record: Option<Box<RunRecord>>,
}

impl<E: Into<RunError>> From<E> for RunFailure {
    fn from(error: E) -> Self {
        Self { error: error.into(), record: None }
    }
}

/// How a run is carried out. Nothing of it bears on the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// One thing after the other.
    Alone,
    /// A frame is rendered and read while the physics runs on to the next: its command is not due before.
    Overlapped,
}

/// A navigator that has stopped is given this long to come to rest before the run ends.
const STOPPED_S: f64 = 1.0;

/// Runs a scenario to its end. `watch` sees every frame and its image, and may break the run off.
///
/// # Errors
/// Where the run cannot go on, with the frames until then.
pub fn run_with(
    scenario: &Scenario,
    pilot: Pilot,
    renderer: &mut dyn Renderer,
    pace: Pace,
    mut watch: impl FnMut(&FrameRecord, &GreyImage) -> ControlFlow<()>,
) -> Result<RunRecord, RunFailure> {
    let mut run = ClosedLoop::new(scenario, pilot, renderer, pace)?;
    loop {
        match run.frame(&mut watch) {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(end)) => return Ok(run.record(end)),
            Err(error) => return Err(RunFailure { error, record: Some(Box::new(run.record(EndState::Failed))) }),
        }
    }
}

/// A run in progress.
struct ClosedLoop<'a> {
    scenario: &'a Scenario,
    faults: Faults,
    pace: Pace,
    body: Body,
    head: Head<'a>,
    /// What frames truly show; nothing of it reaches the navigator.
    scene: TruthScene,
    /// The command decided on the last frame: takes effect at the next.
    pending: Option<Command>,
    exposure_s: f64,
    laser_power: f64,
    stopped_frames: u32,
    frames: Vec<FrameRecord>,
    key_frames: KeyFrames,
    hash: RunHash,
}

impl<'a> ClosedLoop<'a> {
    fn new(scenario: &'a Scenario, pilot: Pilot, renderer: &'a mut dyn Renderer, pace: Pace) -> Result<Self, RunError> {
        Ok(Self {
            scenario,
            faults: Faults::new(scenario),
            pace,
            body: Body::new(scenario)?,
            head: Head::new(scenario, pilot, renderer),
            scene: TruthScene::new(scenario)?,
            pending: None,
            exposure_s: scenario.first_exposure_s(),
            laser_power: 1.0,
            stopped_frames: 0,
            frames: Vec::new(),
            key_frames: KeyFrames::default(),
            hash: RunHash::default(),
        })
    }

    /// One frame period, from one exposure to the next.
    fn frame(
        &mut self,
        watch: &mut impl FnMut(&FrameRecord, &GreyImage) -> ControlFlow<()>,
    ) -> Result<ControlFlow<EndState>, RunError> {
        let tick = self.body.world.tick();
        let time_s = self.body.time_s();
        let active = self.faults.at(time_s);

        // The command decided on the frame before takes effect now.
        if let Some(command) = self.pending.take() {
            self.body.wheels.command(active.wheel_speeds(command.wheel_speed_rad_s));
            self.body.world.point_mount(command.mount);
            self.exposure_s = command.exposure_s.unwrap_or(self.exposure_s);
            self.laser_power = command.laser_power.unwrap_or(self.laser_power);
        }

        // Exposure: truth, counts and mount angles belong to the same tick as the image.
        let (truth, counts, mount) = (self.body.world.truth(), self.body.world.counts(), self.body.world.mount());
        let collisions = self.body.world.collisions();
        if let Some(end) = self.end(&truth) {
            return Ok(ControlFlow::Break(end));
        }
        let mut view = self.body.view(
            &truth,
            mount,
            self.frames.len() as u64,
            self.exposure_s,
            self.scenario.laser_powers(self.laser_power),
        );
        active.dim(&mut view);
        let faults = active.bits();

        // The navigator reads the frame while the body moves on; its command waits for the next one.
        let (head, body) = (&mut self.head, &mut self.body);
        let width_m = body.width_at(&truth);
        let mut look = || head.look(&view, &truth, width_m, counts, mount, tick);
        let ticks = self.scenario.rates.ticks_per_frame();
        // What the frame truly shows, for the scores: a camera outside the duct fails in `look`, which says so.
        let scene = &self.scene;
        let shown =
            || scene.of(&truth.world_from_base, &view.world_from_camera, truth.cell, &view.laser_power).unwrap_or_default();
        let (command, moved, shown) = match self.pace {
            Pace::Alone => (look(), body.advance(ticks), shown()),
            Pace::Overlapped => std::thread::scope(|scope| {
                let looking = scope.spawn(look);
                let (moved, shown) = (body.advance(ticks), shown());
                (looking.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), moved, shown)
            }),
        };
        let command = command?;
        self.pending = Some(command);

        let report = self.head.navigator.report();
        let (frame, image) = (self.frames.len() as u64, &self.head.image);
        self.hash.frame(tick, &truth, image, counts, &command);
        self.key_frames.offer(frame, image, report.stages.lines);
        self.stopped_frames = if report.state == State::Stopped { self.stopped_frames + 1 } else { 0 };
        let score = score(&self.scene, &shown, &report.stages, &report.measurement, truth.lateral_m, truth.heading_rad);
        let record = FrameRecord {
            frame,
            tick,
            time_s,
            truth,
            width_m,
            collisions,
            counts,
            mount,
            measurement: report.measurement,
            score,
            state: report.state,
            reason: report.reason,
            estimate: report.estimate,
            lines: report.stages.lines.len(),
            command,
            laser_power: self.laser_power,
            view,
            faults,
        };
        let verdict = watch(&record, image);
        self.frames.push(record);
        moved?;
        Ok(verdict.map_break(|()| EndState::BrokenOff))
    }

    /// Whether the run is over, and how.
    fn end(&self, truth: &Truth) -> Option<EndState> {
        let stopped_s = f64::from(self.stopped_frames) / f64::from(self.scenario.rates.camera_hz);
        if truth.distance_m >= self.body.finish_m {
            Some(EndState::Finished)
        } else if self.body.is_outside(truth) {
            Some(EndState::Outside)
        } else if stopped_s >= STOPPED_S && truth.speed_m_s.abs() < 1e-3 {
            Some(EndState::Stopped)
        } else if self.body.time_s() >= self.scenario.time_limit_s {
            Some(EndState::TimeLimit)
        } else {
            None
        }
    }

    fn record(self, end: EndState) -> RunRecord {
        // After a failure the world may hold anything; the last frame's truth is good.
        let truth = match (end, self.frames.last()) {
            (EndState::Failed, Some(last)) => last.truth,
            _ => self.body.world.truth(),
        };
        RunRecord {
            frames: self.frames,
            key_frames: self.key_frames,
            end,
            sim_time_s: self.body.time_s(),
            collisions: self.body.world.collisions(),
            distance_m: truth.distance_m - self.scenario.start.distance_m,
            run_hash: self.hash.value(),
        }
    }
}

/// The robot's head: the camera, and the navigator behind it.
struct Head<'a> {
    renderer: &'a mut dyn Renderer,
    navigator: Box<dyn Navigator>,
    truth: Option<TruthFeed>,
    image: GreyImage,
}

impl<'a> Head<'a> {
    fn new(scenario: &Scenario, pilot: Pilot, renderer: &'a mut dyn Renderer) -> Self {
        let image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        let Pilot { navigator, truth } = pilot;
        Self { renderer, navigator, truth, image }
    }

    /// Exposes a frame and has the navigator decide on it.
    fn look(
        &mut self,
        view: &View,
        truth: &Truth,
        width_m: f64,
        counts: Counts,
        mount: MountAngles,
        tick: u64,
    ) -> Result<Command, RenderError> {
        self.renderer.render(view, self.image.room())?;
        if let Some(feed) = &self.truth {
            feed.set(truth.lateral_m, truth.heading_rad, width_m);
        }
        Ok(self.navigator.on_frame(&self.image.frame(), counts, mount, tick))
    }
}

/// The robot's body in its duct: physics, and the wheel controller that drives it.
struct Body {
    world: World,
    network: Network,
    wheels: WheelController,
    duty: Sides,
    ticks_per_s: f64,
    ticks_per_wheel_control: u64,
    finish_m: f64,
    /// The rig as it truly is, and by how much its mount points elsewhere than it reports.
    rig: Rig,
    mount_error: MountAngles,
    /// Where the mount reported to point a tick ago: from it follows how fast it turns.
    mount_before: MountAngles,
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
            ticks_per_s: f64::from(rates.physics_hz),
            ticks_per_wheel_control: rates.ticks_per_wheel_control(),
            finish_m: scenario.finish_m(&network),
            network,
            mount_error: MountAngles { pan_rad: actual.pan_rad - nominal.pan_rad, tilt_rad: actual.tilt_rad - nominal.tilt_rad },
            rig,
            mount_before: scenario.rig.mount.rest,
        })
    }

    fn time_s(&self) -> f64 {
        self.world.tick() as f64 / self.ticks_per_s
    }

    /// Physics ticks, and the wheel controller's where they are due.
    fn advance(&mut self, ticks: u64) -> Result<(), SimError> {
        for _ in 0..ticks {
            if self.world.tick().is_multiple_of(self.ticks_per_wheel_control) {
                self.duty = self.wheels.tick(self.world.counts());
            }
            self.mount_before = self.world.mount();
            self.world.step(self.duty)?;
        }
        Ok(())
    }

    fn is_outside(&self, truth: &Truth) -> bool {
        // A millimetre above the floor, so that a wheel's penetration does not count as having left the duct.
        let base = truth.world_from_base * Point3::new(0.0, 0.0, 1e-3);
        self.network.cell_at(&base, truth.cell).is_none()
    }

    /// What the camera is to see.
    fn view(&self, truth: &Truth, mount: MountAngles, frame: u64, exposure_s: f64, laser_power: [f64; MAX_LASERS]) -> View {
        let rate = |now: f64, before: f64| (now - before) * self.ticks_per_s;
        let rates = MountAngles {
            pan_rad: rate(mount.pan_rad, self.mount_before.pan_rad),
            tilt_rad: rate(mount.tilt_rad, self.mount_before.tilt_rad),
        };
        let error = self.mount_error;
        let angles = MountAngles { pan_rad: mount.pan_rad + error.pan_rad, tilt_rad: mount.tilt_rad + error.tilt_rad };
        View {
            world_from_camera: world_from_camera(&self.rig, &truth.world_from_base, mount, error),
            motion: motion(truth, &self.rig.mount, angles, rates),
            frame,
            exposure_s,
            laser_power,
            headlamp_power: 1.0,
        }
    }

    fn width_at(&self, truth: &Truth) -> f64 {
        self.network.centreline.segment_at(truth.distance_m).width_m
    }
}
