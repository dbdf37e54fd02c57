//! A scenario as resolved: every default and preset filled in, SI units, radians.

use ductloop_duct::Transform;
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::centreline::Centreline;
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::{End, Network, Turn};
use ductloop_nav::angle::rotation_about_z;
use ductloop_nav::control::kanayama::KanayamaParams;
use ductloop_nav::control::koh_cho::KohChoParams;
use ductloop_nav::control::limits::Limits;
use ductloop_nav::control::lqr::LqrParams;
use ductloop_nav::control::pure_pursuit::PurePursuitParams;
use ductloop_nav::control::samson::SamsonParams;
use ductloop_nav::control::stanley::StanleyParams;
use ductloop_nav::estimation::EstimationParams;
use ductloop_nav::messages::MountSweep;
use ductloop_nav::perception::paper::PaperParams;
use ductloop_nav::perception::robust::RobustParams;
use ductloop_nav::rig::{MountAngles, Rig};
use ductloop_nav::wheel_controller::board::Arithmetic;
use ductloop_sensor::optics::Optics;
use ductloop_sensor::renderer::MAX_LASERS;
use ductloop_sensor::surface::Look;
use ductloop_sim::spec::RobotSpec;
use nalgebra::{Translation3, Vector3};

use super::criteria::Criteria;
use super::faults::Fault;
use super::layout::DuctError;

/// A run of a robot through a duct, complete.
///
/// Its fields may be changed freely; [`Scenario::validate`] then says whether it still holds together.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name of the run and of its folder.
    pub name: String,
    /// What it is for; may be empty.
    pub about: String,
    /// Feeds every random stream.
    pub seed: u64,
    /// Simulated time after which the run has failed.
    pub time_limit_s: f64,
    /// How often each part acts.
    pub rates: Rates,
    /// The robot's body.
    pub robot: RobotSpec,
    /// Speed along the duct that the navigator holds.
    pub speed_m_s: f64,
    /// The nominal rig, by which the navigator reads images.
    pub rig: Rig,
    /// Power of each laser as a share of nominal, in the order of the lasers, before what the navigator asks; it is not told.
    pub laser_power: Vec<f64>,
    /// How the true rig differs from the nominal one.
    pub rig_error: RigDeviation,
    /// Exposure of every frame, in seconds; `None`: automatic.
    pub exposure_s: Option<f64>,
    /// What automatic exposure aims at.
    pub auto_exposure: AutoExposure,
    /// Light, lens and CCD. Its `exposure_s` is the one for which the peak grey values hold.
    pub optics: Optics,
    /// How images become errors.
    pub perception: Perception,
    /// How wheels and walls become one place.
    pub estimation: Estimation,
    /// How errors become wheel speeds.
    pub control: Control,
    /// The wheel controller.
    pub wheel_control: WheelControl,
    /// The mount and its controller.
    pub mount_control: MountControl,
    /// The link from the command controller to these two.
    pub link: LinkParams,
    /// What the navigator is told of the duct.
    pub navigation: Navigation,
    /// The duct.
    pub duct: Duct,
    /// The surfaces that [`SurfaceId`]s are indices of.
    pub surfaces: Vec<Surface>,
    /// Where the run starts.
    pub start: Start,
    /// Where it ends.
    pub finish: Finish,
    /// What goes wrong on purpose.
    pub faults: Vec<Fault>,
    /// What the run must achieve.
    pub pass: Criteria,
}

/// How often each part acts, in Hz. The second and third divide the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rates {
    /// Physics steps.
    pub physics_hz: u32,
    /// Wheel controller.
    pub wheel_control_hz: u32,
    /// Camera, and with it the command controller.
    pub camera_hz: u32,
}

/// How the true rig differs from the nominal one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigDeviation {
    /// True pan less reported pan, in radians.
    pub pan_rad: f64,
    /// True tilt less reported tilt, in radians.
    pub tilt_rad: f64,
    /// True roll less nominal roll, in radians.
    pub roll_rad: f64,
    /// Turn of each laser's plane about the camera's x axis through its source, in radians, in the order of the lasers.
    pub laser_plane_rad: Vec<f64>,
}

/// What automatic exposure aims at and may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AutoExposure {
    /// Brightness of the stripes' peaks above their background, in DN of 8 bits
    /// ([`ductloop_nav::exposure::Brightness::peak_dn`]).
    pub target_dn: f64,
    /// Shortest and longest exposure, in seconds.
    pub exposure_s: [f64; 2],
    /// Least and most laser power, as shares of nominal.
    pub laser_power: [f64; 2],
}

/// How images become errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Perception {
    /// Which way.
    pub pipeline: Pipeline,
    /// Parameters of the paper's chain. Its `duct_width_m` does not count: [`Navigation::width_m`] does.
    pub paper: PaperParams,
    /// Parameters of the robust pipeline. Its `duct_width_m` does not count either.
    pub robust: RobustParams,
}

/// A way from images to errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Pipeline {
    /// Sub-pixel centres, walls and deviations, robust against what does not belong to a stripe.
    Robust,
    /// The paper's chain.
    Paper,
    /// The true errors, without looking at any image.
    Truth,
}

/// How wheels and walls become one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimation {
    /// Which way.
    pub kind: EstimatorKind,
    /// Parameters of the filter.
    pub params: EstimationParams,
}

/// A way from wheels and walls to a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorKind {
    /// A Kalman filter.
    Kalman,
    /// The last measurement, carried on by the wheels.
    None,
}

/// How errors become wheel speeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Control {
    /// Which law.
    pub law: Law,
    /// Limits that hold for every law. Its `effective_track_m` does not count: the robot's own measures do.
    pub limits: Limits,
    /// Parameters of Koh and Cho's law; of the printed one the first alone.
    pub koh_cho: KohChoParams,
    /// Parameters of pure pursuit.
    pub pure_pursuit: PurePursuitParams,
    /// Parameters of Stanley's law.
    pub stanley: StanleyParams,
    /// Parameters of Kanayama's law.
    pub kanayama: KanayamaParams,
    /// Parameters of Samson's law.
    pub samson: SamsonParams,
    /// Weights of the linear-quadratic regulator.
    pub lqr: LqrParams,
    /// Bandwidth that the wheel controller's gains are chosen for, in rad/s.
    pub wheel_bandwidth_rad_s: f64,
}

/// A path-tracking law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// Koh and Cho's, bounded where the printed one is not.
    #[default]
    KohCho,
    /// Koh and Cho's as printed.
    KohChoPrinted,
    /// Pure pursuit.
    PurePursuit,
    /// That of the robot Stanley.
    Stanley,
    /// Kanayama's.
    Kanayama,
    /// Samson's, in chained form.
    Samson,
    /// A linear-quadratic regulator.
    Lqr,
}

/// The wheel controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelControl {
    /// What it reckons in.
    pub arithmetic: Arithmetic,
    /// Bits of the PWM register.
    pub pwm_bits: u32,
    /// Largest motor current, in A.
    pub current_limit_a: f64,
    /// Largest motor voltage, in V; `None`: the supply.
    pub voltage_limit_v: Option<f64>,
    /// Longest time without a command before it slows the wheels down, in seconds.
    pub silence_s: f64,
    /// Deceleration of the wheels' rims then, in m/s2.
    pub ramp_m_s2: f64,
    /// Longest time that a wheel may be off its set-point before the motors are cut off, in seconds.
    pub follow_s: f64,
}

/// The mount and its controller. Play and encoders are the same for pan and tilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountControl {
    /// Largest angular acceleration, in rad/s2; `None`: none is kept to.
    pub acceleration_rad_s2: Option<f64>,
    /// Play between motor and camera, in radians.
    pub backlash_rad: f64,
    /// Angle of one encoder count, in radians; 0: the angle as it is.
    pub encoder_step_rad: f64,
    /// The swing that it keeps up about what is commanded; amplitudes of 0 hold it.
    pub sweep: MountSweep,
}

impl MountControl {
    /// The swing that it keeps up, if it is to swing.
    pub fn standing_sweep(&self) -> Option<MountSweep> {
        (self.sweep.amplitude != MountAngles::default()).then_some(self.sweep)
    }
}

/// A link: what is said on it arrives late, twice or never.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkParams {
    /// Time on the way, in seconds.
    pub latency_s: f64,
    /// Longest time beyond that, in seconds.
    pub jitter_s: f64,
    /// Probability of a loss.
    pub loss: f64,
    /// Probability that a packet comes twice.
    pub repeat: f64,
}

/// What the navigator is told of the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigation {
    /// The duct's width, the paper's `W_d`, in metres: where it begins, or all along.
    pub width_m: f64,
    /// Whether that holds all along, in metres: `None` where the width is measured. If it is a number, it is `width_m`.
    pub fixed_width_m: Option<f64>,
    /// Longest time without sight of a wall before the robot stops, in seconds.
    pub coast_s: f64,
    /// So many frames in a row that are the same as the one before are a frozen camera; 0: whatever comes is believed.
    pub frozen_frames: u32,
}

/// The duct: fittings joined one after the other, and branches of them; and the way through it.
#[derive(Clone, Debug, PartialEq)]
pub struct Duct {
    /// Inside width where it begins, in metres.
    pub width_m: f64,
    /// Inside height where it begins, in metres.
    pub height_m: f64,
    /// What a fitting is made of unless it says otherwise.
    pub surface: SurfaceId,
    /// The fittings from entry to exit.
    pub run: Vec<Piece>,
    /// What begins at the ports of fittings elsewhere.
    pub branches: Vec<Branch>,
    /// The way through it.
    pub route: Route,
    /// How the beginning is finished.
    pub entry: End,
    /// How the end is finished.
    pub exit: End,
    /// Height of the flange beads at the joints, in metres; 0 for none.
    pub bead_m: f64,
    /// Their width along the duct, in metres.
    pub bead_width_m: f64,
    /// What stands in it.
    pub objects: Vec<Object>,
}

/// Something that stands in the duct.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// What reports call it; may be empty.
    pub name: String,
    /// What it is.
    pub shape: ObjectShape,
    /// Where its middle is along the centreline, in metres.
    pub at_m: f64,
    /// How far its middle is to the left of the centreline, in metres.
    pub left_m: f64,
    /// How far its bottom is above the floor, in metres.
    pub above_m: f64,
    /// Turn about the vertical against the centreline, anticlockwise positive, in radians.
    pub turned_rad: f64,
    /// What it is made of.
    pub surface: SurfaceId,
}

/// The shape of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectShape {
    /// A box.
    Box {
        /// Its size along the duct, across it and upright, in metres, before it is turned.
        size_m: [f64; 3],
    },
}

/// A run of fittings that begins at a port of another one.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// The port where it begins: "tee-1.left".
    pub from: String,
    /// Its fittings.
    pub run: Vec<Piece>,
    /// The port that its end meets; `None`: it ends freely.
    pub to: Option<String>,
    /// How its end is finished.
    pub end: End,
}

/// The way through a network.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// What to do at each junction and each dead end.
    pub turns: Vec<Turn>,
    /// Whether the way goes through every branch instead.
    pub explore: bool,
    /// How far before the end of a duct it turns back, in metres.
    pub turn_back_m: f64,
}

/// A fitting of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// What it is called; empty: what it is, and its number among those.
    pub name: String,
    /// How its port `left` is finished if nothing is joined to it.
    pub left_end: End,
    /// How its port `right` is finished if nothing is joined to it.
    pub right_end: End,
    /// What it is.
    pub shape: Shape,
    /// What it is made of.
    pub surface: SurfaceId,
}

/// A surface: what it looks like and how it grips.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The name by which scenarios speak of it.
    pub name: String,
    /// What it looks like.
    pub look: Look,
    /// Coefficient of friction between wheel and surface.
    pub friction: f64,
}

/// Where the base stands when the run begins, at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Distance along the centreline, in metres.
    pub distance_m: f64,
    /// Offset from the centreline, left positive, in metres.
    pub lateral_m: f64,
    /// Heading against the centreline, anticlockwise positive, in radians.
    pub heading_rad: f64,
}

/// The line that completes the run when the base passes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// Its distance from the end of the centreline, in metres.
    pub before_end_m: f64,
}

impl Pipeline {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Robust, Self::Paper, Self::Truth];

    /// The pipeline that a word names.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|pipeline| pipeline.word() == word)
    }

    /// The word for it in a scenario.
    pub fn word(self) -> &'static str {
        match self {
            Self::Robust => "robust",
            Self::Paper => "paper",
            Self::Truth => "truth",
        }
    }
}

impl EstimatorKind {
    /// The word for it in a scenario.
    pub fn word(self) -> &'static str {
        match self {
            Self::Kalman => "kalman",
            Self::None => "none",
        }
    }
}

impl Law {
    /// All of them, the default first.
    pub const ALL: [Self; 7] =
        [Self::KohCho, Self::KohChoPrinted, Self::PurePursuit, Self::Stanley, Self::Kanayama, Self::Samson, Self::Lqr];

    /// The words for them in a scenario, in the same order.
    pub const WORDS: [&'static str; 7] = ["koh-cho", "koh-cho-printed", "pure-pursuit", "stanley", "kanayama", "samson", "lqr"];

    /// The word for it in a scenario.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// The law of that word.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.word() == word)
    }
}

/// The word for how an end is finished.
pub(super) fn end_word(end: End) -> &'static str {
    match end {
        End::Open => "open",
        End::Cap => "cap",
    }
}

impl std::default::Default for Route {
    fn default() -> Self {
        Self { turns: Vec::new(), explore: false, turn_back_m: 0.6 }
    }
}

impl Piece {
    /// A fitting without a name, its free ports capped.
    pub fn new(shape: Shape, surface: SurfaceId) -> Self {
        Self { name: String::new(), left_end: End::Cap, right_end: End::Cap, shape, surface }
    }
}

impl Duct {
    /// All fittings, those of branches too, with their cross-sections; none if the fittings' ports cannot be told.
    pub fn fittings(&self) -> Vec<Fitting> {
        self.layout().map(|layout| layout.pieces.iter().map(|piece| piece.fitting).collect()).unwrap_or_default()
    }

    /// The network that the fittings make, with the beads at its joints and with what stands in it. Its centreline is the route's.
    ///
    /// # Errors
    /// None for a scenario that was read or that [`Scenario::validate`] accepts.
    pub fn network(&self) -> Result<Network, DuctError> {
        let layout = self.layout()?;
        let mut network = Network::assemble(&layout.pieces, &layout.joins, &layout.ends)?;
        let start = (0, PortName::In);
        let explored;
        let turns = if self.route.explore {
            explored = network.exploration(start);
            &explored
        } else {
            &self.route.turns
        };
        network.centreline = network.path(turns, start, self.route.turn_back_m)?;
        if self.bead_m > 0.0 {
            network.add_beads(self.bead_m, self.bead_width_m, self.surface);
        }
        for object in &self.objects {
            network.add_solid(&object.solid(&network.centreline));
        }
        Ok(network)
    }
}

impl Object {
    /// The object in the world.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn solid(&self, centreline: &Centreline) -> Solid {
        let stand =
            Transform::from_parts(Translation3::new(0.0, self.left_m, self.above_m), rotation_about_z(self.turned_rad).into());
        let ObjectShape::Box { size_m } = self.shape;
        Solid::cuboid(&(centreline.pose_at(self.at_m) * stand), Vector3::from(size_m), self.surface)
    }
}

impl Scenario {
    /// The true rig, which makes the images: the nominal one with its deviation.
    pub fn actual_rig(&self) -> Rig {
        let RigDeviation { pan_rad, tilt_rad, roll_rad, laser_plane_rad } = &self.rig_error;
        let rig = self.rig.clone().with_mount_error(*pan_rad, *tilt_rad, *roll_rad);
        let turned = laser_plane_rad.iter().enumerate().take(self.rig.lasers.len()).filter(|(_, angle)| **angle != 0.0);
        turned.fold(rig, |rig, (index, angle)| rig.with_plane_turned(index, *angle))
    }

    /// Power of each laser where the navigator asks for `asked`, as shares of nominal. One that has no power of its own has that.
    pub fn laser_powers(&self, asked: f64) -> [f64; MAX_LASERS] {
        std::array::from_fn(|laser| self.laser_power.get(laser).map_or(asked, |power| power * asked))
    }

    /// Exposure of the first frame, in seconds; of every frame, unless it is automatic.
    pub fn first_exposure_s(&self) -> f64 {
        self.exposure_s.unwrap_or(self.optics.exposure_s)
    }

    /// Distance of the finish line along the centreline of `network`, in metres.
    pub fn finish_m(&self, network: &Network) -> f64 {
        network.centreline.length_m() - self.finish.before_end_m
    }
}
