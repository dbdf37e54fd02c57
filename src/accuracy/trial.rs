//! One frame: rendered, read by each pipeline, held against the truth.

use ductloop_nav::perception::{StripeLine, Wall};
use ductloop_sensor::renderer::{MAX_LASERS, View};

use super::bound::Bounds;
use super::pose::Pose;
use crate::closed_loop::RunError;
use crate::engine::Engine;
use crate::grey_image::GreyImage;
use crate::pilot::perception;
use crate::scenario::accuracy_file::Poses;
use crate::scenario::{Pipeline, Scenario, Start};
use crate::stage_scores::{Score, StageTruth, TruthScene, score};
use crate::viewpoint::{still, world_from_camera};

/// A frame and what the pipelines made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Cell of the grid.
    pub cell: usize,
    /// Number of the pose in its cell, which is that of its frame.
    pub index: u64,
    /// Where the robot stood.
    pub pose: Pose,
    /// How accurate a reading can be at best.
    pub bounds: Bounds,
    /// What each pipeline made of it, in the order of the file.
    pub readings: Vec<Reading>,
}

/// What a pipeline made of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Which.
    pub pipeline: Pipeline,
    /// Held against the truth.
    pub score: Score,
}

/// Why a frame could not be made.
#[derive(Debug, thiserror::Error)]
#[error("pose {index} of cell {cell} ({pose}): {error}")]
pub struct TrialError {
    /// Cell of the grid.
    pub cell: usize,
    /// Number of the pose.
    pub index: u64,
    /// The pose.
    pub pose: Pose,
    /// What went wrong.
    #[source]
    pub error: RunError,
}

/// A wall is held to account only where it is this far from the camera, in metres: nearest and farthest.
pub const WALL_M: [f64; 2] = [0.15, 0.5];
/// And where it shows so many columns of stripe.
pub const WALL_COLUMNS: usize = 100;

/// Side walls, in the order of tables.
pub const SIDES: [Wall; 2] = [Wall::Left, Wall::Right];

impl Reading {
    /// Whether a wall is near enough and shows enough of the stripes to be measured.
    pub fn counts(&self, wall: Wall) -> bool {
        // The drawn distances come back with rounding.
        const ROUNDING_M: f64 = 1e-9;
        self.score.wall(wall).is_some_and(|wall| {
            wall.columns >= WALL_COLUMNS && (WALL_M[0] - ROUNDING_M..=WALL_M[1] + ROUNDING_M).contains(&wall.camera_distance_m)
        })
    }

    /// Whether any side wall is, so that the frame shows where the robot stands.
    pub fn shows_pose(&self) -> bool {
        SIDES.into_iter().any(|wall| self.counts(wall))
    }

    /// Whether there was an answer: lateral offset and heading.
    pub fn is_answered(&self) -> bool {
        self.score.lateral_error_m.is_some() && self.score.heading_error_rad.is_some()
    }
}

/// Carries out pose number `index` of a cell.
///
/// # Errors
/// Where the camera would stand outside the duct, or too near to its metal.
pub fn trial(
    scenario: &Scenario,
    cell: usize,
    poses: &Poses,
    index: u64,
    pipelines: &[Pipeline],
) -> Result<Trial, Box<TrialError>> {
    let pose = Pose::draw(scenario, poses, scenario.seed, index);
    let own = pose.scenario(scenario);
    let (bounds, readings) =
        read(&own, &pose, index, pipelines).map_err(|error| Box::new(TrialError { cell, index, pose, error }))?;
    Ok(Trial { cell, index, pose, bounds, readings })
}

/// A pose's frame, made again: for those who want to see where a pipeline went wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Again {
    /// The scenario, which starts at the pose.
    pub scenario: Scenario,
    /// The image, to the bit.
    pub image: GreyImage,
    /// The lines that the pipeline found in it.
    pub lines: Vec<StripeLine>,
}

/// Makes the frame of a pose again and has a pipeline read it.
///
/// # Errors
/// As [`trial`].
pub fn again(scenario: &Scenario, poses: &Poses, index: u64, pipeline: Pipeline) -> Result<Again, RunError> {
    let pose = Pose::draw(scenario, poses, scenario.seed, index);
    let mut own = pose.scenario(scenario);
    own.start = Start { distance_m: pose.distance_m, lateral_m: pose.lateral_m, heading_rad: pose.heading_rad };
    own.perception.pipeline = pipeline;
    let exposed = Exposed::of(&own, &pose, index)?;
    let mut perception = perception(&own);
    perception.perceive(&exposed.image.frame(), own.rig.mount.rest);
    let lines = perception.stages().lines.to_vec();
    Ok(Again { scenario: own, image: exposed.image, lines })
}

/// A frame with what there is to know about it.
struct Exposed {
    image: GreyImage,
    scene: TruthScene,
    truth: StageTruth,
    laser_power: [f64; MAX_LASERS],
}

impl Exposed {
    fn of(scenario: &Scenario, pose: &Pose, index: u64) -> Result<Self, RunError> {
        let network = scenario.duct.network()?;
        let scene = TruthScene::new(scenario)?;
        let base = pose.world_from_base(&network.centreline);
        let camera = world_from_camera(scene.rig(), &base, scenario.rig.mount.rest, Default::default());
        let laser_power = scenario.laser_powers(1.0);
        let view = View { frame: index, laser_power, ..still(camera, scenario.first_exposure_s()) };
        let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        Engine::Cpu.renderer(scenario, 1)?.render(&view, image.room())?;
        let truth = scene.of(&base, &camera, network.cells.len() / 2, &laser_power)?;
        Ok(Self { image, scene, truth, laser_power })
    }
}

fn read(scenario: &Scenario, pose: &Pose, index: u64, pipelines: &[Pipeline]) -> Result<(Bounds, Vec<Reading>), RunError> {
    let Exposed { image, scene, truth, laser_power } = Exposed::of(scenario, pose, index)?;
    let read_by = |pipeline: Pipeline| {
        let mut own = scenario.clone();
        own.perception.pipeline = pipeline;
        // A pipeline that remembers frames must not remember another pose's.
        let mut perception = perception(&own);
        let measurement = perception.perceive(&image.frame(), scenario.rig.mount.rest);
        let score = score(&scene, &truth, &perception.stages(), &measurement, pose.lateral_m, pose.heading_rad);
        Reading { pipeline, score }
    };
    let readings: Vec<Reading> = pipelines.iter().map(|pipeline| read_by(*pipeline)).collect();
    let counts = readings.first().map_or([false; 2], |reading| SIDES.map(|wall| reading.counts(wall)));
    Ok((Bounds::of(scenario, &scene, &truth, &laser_power, counts), readings))
}
