//! The closed loop: physics, camera, navigator and wheel controller under one count of ticks.
//!
//! ```text
//! tick      0 . . . . . 6 . . . . . 12 . . . . . . . . . . 40 . . .        (1200 Hz)
//! camera    expose 0                                       expose 1        (30 Hz)
//! navigator    reads 0, decides ...                        command 0 acts
//! wheels    duty        duty        duty                                   (200 Hz)
//! ```
//!
//! A command sets out one frame after the exposure that it was decided on, the time a real robot needs to read out and think, and
//! takes effect when the link ([`crate::link`]) has carried it: at once, unless a scenario says otherwise. Nothing passes to the
//! navigator but frame, counts, mount angles and tick.

use std::ops::ControlFlow;

use ductloop_duct::network::Network;
use ductloop_nav::messages::{Command, Counts, Tick};
use ductloop_nav::navigator::State;
use ductloop_nav::rig::{MountAngles, Rig};
use ductloop_nav::wheel_controller::scaling::ScalingError;
use ductloop_sensor::renderer::{MAX_LASERS, RenderError, Renderer, View};
use ductloop_sim::ground::Ground;
use ductloop_sim::mount::Gearing;
use ductloop_sim::truth::Truth;
use ductloop_sim::world::{SimError, World};
use nalgebra::Point3;

use crate::ahead_scores::Way;
use crate::controllers::Controllers;
use crate::fault::Faults;
use crate::fault::encoder::FaultyEncoders;
use crate::grey_image::GreyImage;
use crate::head::{Exposure, Head};
use crate::navigator_process::NavigatorError;
use crate::pilot::Pilot;
use crate::record::{EndState, FrameRecord, KeyFrames, RunRecord};
use crate::run_hash::RunHash;
use crate::scenario::{DuctError, MountControl, Scenario};
use crate::stage_scores::{Score, TruthScene, score};
use crate::survey::{Cloud, Notes};
use crate::viewpoint::{motion, world_from_camera};

/// Why a run could not go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The duct cannot be assembled. A scenario that was read or validated never gives this.
    #[error("the duct cannot be assembled: {0}")]
    Network(#[from] DuctError),
    /// The physics failed.
    #[error("{0}")]
    Sim(#[from] SimError),
    /// The wheel controller cannot be had in integers. A scenario that was read or validated never gives this.
    #[error("the wheel controller cannot reckon in 16-bit integers: {0}")]
    WheelControl(#[from] ScalingError),
    /// There is no image.
    #[error("{0}")]
    Render(#[from] RenderError),
    /// A navigator that is a program of its own has failed.
    #[error("{0}")]
    Navigator(#[from] NavigatorError),
    /// A navigator commanded what nothing can be told.
    #[error("the navigator's command cannot be carried out on the frame of tick {tick}: {what}")]
    Command {
        /// Which number, and its bounds.
        what: String,
        /// Tick of the frame's exposure.
        tick: Tick,
    },
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

/// A navigator that has stopped, or wheels brought down for want of commands, is given this long to come to rest before the run ends.
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
    watch: impl FnMut(&FrameRecord, &GreyImage) -> ControlFlow<()>,
) -> Result<RunRecord, RunFailure> {
    let scene = TruthScene::new(scenario)?;
    ClosedLoop::new(scenario, pilot, renderer, pace, Some(scene))?.finish(watch)
}

/// The same on one thread, without scores of the stages of perception and without a cloud of points, which no metric needs.
///
/// # Errors
/// As [`run_with`].
pub fn run_unscored(
    scenario: &Scenario,
    pilot: Pilot,
    renderer: &mut dyn Renderer,
    watch: impl FnMut(&FrameRecord, &GreyImage) -> ControlFlow<()>,
) -> Result<RunRecord, RunFailure> {
    ClosedLoop::new(scenario, pilot, renderer, Pace::Alone, None)?.finish(watch)
}

/// A run in progress.
struct ClosedLoop<'a> {
    scenario: &'a Scenario,
    faults: Faults,
    pace: Pace,
    body: Body,
    head: Head<'a>,
    /// What frames truly show; nothing of it reaches the navigator. `None` where the stages are not scored.
    scene: Option<TruthScene>,
    /// What lies along the path, which what the navigator names is held against.
    way: Way,
    /// The command decided on the last frame: takes effect at the next.
    pending: Option<Command>,
    exposure_s: f64,
    laser_power: f64,
    stopped_frames: u32,
    frames: Vec<FrameRecord>,
    key_frames: KeyFrames,
    notes: Notes,
    hash: RunHash,
}

impl<'a> ClosedLoop<'a> {
    fn new(
        scenario: &'a Scenario,
        pilot: Pilot,
        renderer: &'a mut dyn Renderer,
        pace: Pace,
        scene: Option<TruthScene>,
    ) -> Result<Self, RunError> {
        let body = Body::new(scenario)?;
        let world_from_first = body.network.centreline.pose_at(scenario.start.distance_m);
        Ok(Self {
            scenario,
            faults: Faults::new(scenario),
            pace,
            notes: scene.as_ref().map_or_else(Notes::default, |_| Notes::with_cloud(Cloud::new(world_from_first))),
            way: Way::new(scenario, &body.network),
            body,
            head: Head::new(scenario, pilot, renderer),
            scene,
            pending: None,
            exposure_s: scenario.first_exposure_s(),
            laser_power: 1.0,
            stopped_frames: 0,
            frames: Vec::new(),
            key_frames: KeyFrames::default(),
            hash: RunHash::default(),
        })
    }

    fn finish(mut self, mut watch: impl FnMut(&FrameRecord, &GreyImage) -> ControlFlow<()>) -> Result<RunRecord, RunFailure> {
        loop {
            match self.frame(&mut watch) {
                Ok(ControlFlow::Continue(())) => {}
                Ok(ControlFlow::Break(end)) => return Ok(self.record(end)),
                Err(error) => return Err(RunFailure { error, record: Some(Box::new(self.record(EndState::Failed))) }),
            }
        }
    }

    /// One frame period, from one exposure to the next.
    fn frame(
        &mut self,
        watch: &mut impl FnMut(&FrameRecord, &GreyImage) -> ControlFlow<()>,
    ) -> Result<ControlFlow<EndState>, RunError> {
        let tick = self.body.world.tick();
        let time_s = self.body.time_s();
        let active = self.faults.at(time_s);

        // The command decided on the frame before sets out now, and takes effect as soon as the link has carried it.
        if let Some(command) = self.pending.take() {
            let wheel_speeds = active.wheel_speeds(command.wheel_speed_rad_s);
            self.body.controllers.send(tick, wheel_speeds, &command, active.link_is_up());
            self.exposure_s = command.exposure_s.unwrap_or(self.exposure_s);
            self.laser_power = command.laser_power.unwrap_or(self.laser_power);
        }

        // Exposure: truth, counts and mount angles belong to the same tick as the image.
        let (truth, counts) = (self.body.world.truth(), self.body.counts());
        let mount = active.mount_read(self.body.world.mount_reading());
        let camera = self.body.world.mount();
        let body_record = self.body.controllers.record(camera);
        let collisions = self.body.world.collisions();
        if let Some(end) = self.end(&truth) {
            return Ok(ControlFlow::Break(end));
        }
        let mut view = self.body.view(
            &truth,
            camera,
            self.frames.len() as u64,
            self.exposure_s,
            self.scenario.laser_powers(self.laser_power),
        );
        active.dim(&mut view);
        let faults = active.bits();

        // The navigator reads the frame while the body moves on; its command waits for the next one.
        let (head, body) = (&mut self.head, &mut self.body);
        let width_m = body.width_at(&truth);
        let true_errors = [truth.lateral_m, truth.heading_rad, width_m];
        let exposure = Exposure { view: &view, truth: true_errors, counts, mount, tick };
        let mut look = || head.look(&exposure, &active);
        let faults_of_the_run = &self.faults;
        let ticks = self.scenario.rates.ticks_per_frame();
        // What the frame truly shows, for the scores: a camera outside the duct fails in `look`, which says so.
        let scene = self.scene.as_ref();
        let shown = || {
            let scene = scene?;
            let shown = scene.of(&truth.world_from_base, &view.world_from_camera, truth.cell, &view.laser_power);
            Some((scene, shown.unwrap_or_default()))
        };
        let (command, moved, shown) = match self.pace {
            Pace::Alone => (look(), body.advance(ticks, faults_of_the_run), shown()),
            Pace::Overlapped => std::thread::scope(|scope| {
                let looking = scope.spawn(look);
                let (moved, shown) = (body.advance(ticks, faults_of_the_run), shown());
                (looking.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), moved, shown)
            }),
        };
        // Where no frame arrived nothing is said to the body, which goes on as it was told last.
        let decided = command?;
        self.pending = decided;
        let command = decided.or(self.frames.last().map(|frame| frame.command)).unwrap_or(Command::stop(mount));

        let report = self.head.report(decided.is_some());
        let (frame, image) = (self.frames.len() as u64, self.head.image());
        self.hash.frame(tick, &truth, image, counts, &command);
        self.key_frames.offer(frame, image, report.stages.lines);
        self.notes.take(&report);
        let stopped = report.state == State::Stopped || self.body.controllers.are_down();
        self.stopped_frames = if stopped { self.stopped_frames + 1 } else { 0 };
        // What was made of another frame is not held against this one.
        let score = match &shown {
            Some((scene, shown)) if self.head.is_fresh() => {
                score(scene, shown, &report.stages, &report.measurement, truth.lateral_m, truth.heading_rad)
            }
            _ => Score::default(),
        };
        let record = FrameRecord {
            frame,
            tick,
            time_s,
            truth,
            width_m,
            collisions,
            counts,
            mount,
            body: body_record,
            measurement: report.measurement,
            score,
            state: report.state,
            reason: report.reason,
            estimate: report.estimate,
            outlook: report.outlook,
            true_ahead: self.way.ahead(&truth),
            believed_pose: report.pose,
            ducts: report.ducts.len(),
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
            notes: self.notes,
            run_hash: self.hash.value(),
        }
    }
}

/// The robot's body in its duct: physics, and the controllers that drive its wheels and its mount.
struct Body {
    world: World,
    network: Network,
    controllers: Controllers,
    /// None where no fault touches encoders.
    encoders: Option<FaultyEncoders>,
    ticks_per_s: f64,
    finish_m: f64,
    axle_height_m: f64,
    /// The rig as it truly is, and by how much its mount points elsewhere than it reports.
    rig: Rig,
    mount_error: MountAngles,
    /// Where the camera pointed on its mount a tick ago: from it follows how fast it turns.
    mount_before: MountAngles,
}

impl Body {
    fn new(scenario: &Scenario) -> Result<Self, RunError> {
        let network = scenario.duct.network()?;
        let ground = Ground::new(scenario.surfaces.iter().map(|s| s.friction).collect());
        let start = scenario.world_from_start(&network);
        let rates = scenario.rates;
        let mut world = World::new(&network, &scenario.robot, &ground, &start, scenario.rig.mount.rest, rates.physics_hz)?;
        let MountControl { backlash_rad, encoder_step_rad, .. } = scenario.mount_control;
        world.fit_mount(Gearing { backlash_rad, encoder_step_rad });
        let rig = scenario.actual_rig();
        let (actual, nominal) = (rig.mount.rest, scenario.rig.mount.rest);
        Ok(Self {
            world,
            controllers: Controllers::new(scenario)?,
            encoders: scenario.faults.iter().any(|fault| fault.kind.is_of_encoders()).then(|| FaultyEncoders::new(scenario.seed)),
            ticks_per_s: f64::from(rates.physics_hz),
            finish_m: scenario.finish_m(&network),
            axle_height_m: scenario.robot.wheel_radius_m,
            network,
            mount_error: MountAngles { pan_rad: actual.pan_rad - nominal.pan_rad, tilt_rad: actual.tilt_rad - nominal.tilt_rad },
            rig,
            mount_before: scenario.rig.mount.rest,
        })
    }

    fn time_s(&self) -> f64 {
        self.world.tick() as f64 / self.ticks_per_s
    }

    /// What the encoders read.
    fn counts(&self) -> Counts {
        self.encoders.as_ref().map_or_else(|| self.world.counts(), FaultyEncoders::read)
    }

    /// Physics ticks, and the controllers' where they are due.
    fn advance(&mut self, ticks: u64, faults: &Faults) -> Result<(), SimError> {
        for _ in 0..ticks {
            self.mount_before = self.world.mount();
            let counts = self.counts();
            let duty = self.controllers.tick(&mut self.world, counts);
            if !faults.is_empty() {
                self.world.disturb(faults.at(self.time_s()).disturbance());
            }
            self.world.step(duty)?;
            if let Some(encoders) = &mut self.encoders {
                encoders.count(self.world.counts(), self.world.tick(), &faults.at(self.world.tick() as f64 / self.ticks_per_s));
            }
        }
        Ok(())
    }

    fn is_outside(&self, truth: &Truth) -> bool {
        // At the axles' height: over a crest the base itself, between the wheels' contacts, sinks below the floor.
        let middle = truth.world_from_base * Point3::new(0.0, 0.0, self.axle_height_m);
        self.network.cell_at(&middle, truth.cell).is_none()
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
