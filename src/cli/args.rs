//! What may be typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use ductloop_sensor::optics::Bits;

use super::seeds::{self, Seeds};

/// A physics-simulated, closed-loop testbed for robots that inspect and clean rectangular air ducts.
#[derive(Debug, Parser)]
#[command(
    version,
    propagate_version = true,
    max_term_width = 110,
    after_help = "\
Examples:
  ductloop list                                   the scenarios that are built in
  ductloop run straight                           a run of one; its report is out/straight/report.html
  ductloop new my-duct.toml --from elbow-left     a copy of one to start from
  ductloop run scenarios --junit out/junit.xml    every scenario below a folder, for CI
  ductloop run straight --seeds 1..20 --jobs 2    twenty seeds, two at a time
  ductloop render straight --at-s 2 --truth --out frame.png   what the camera sees, and what is the case
  ductloop check scenarios/*.toml                 are these files right?
  ductloop sweep scenarios/sweeps/duct-width.toml   how wide may the duct be?
  ductloop perceive frame.png --rig scenarios/straight.toml   what the robot would make of a picture

Exit codes:
  0    every verdict passed
  1    a verdict failed
  2    a file or the command line is wrong, or the output cannot be written
  3    a run could not go on
  4    a wall-clock limit was reached
  130  interrupted"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run scenarios: a verdict each, and a folder each with report, tables and pictures
    Run(RunArgs),
    /// Write what the camera sees as PNG, with the truth beside it
    Render(RenderArgs),
    /// Measure how accurate the perception is: a grid of poses, each rendered, read and held against the truth
    Accuracy(super::accuracy::AccuracyArgs),
    /// List the scenarios that are built in, by theme
    List(super::list::ListArgs),
    /// Write a commented scenario file to start from
    New(super::new::NewArgs),
    /// Check scenario files without running them
    Check(CheckArgs),
    /// Print the JSON Schema of scenario files, or of another kind, for editors
    Schema(super::schema::SchemaArgs),
    /// Measure what each part costs on this machine
    Bench(BenchArgs),
    /// Find the sensor's geometry from pixels whose position is known
    Calibrate(super::calibrate::CalibrateArgs),
    /// Find stripes, walls and the robot's place in picture files, photographs too
    Perceive(super::perceive::PerceiveArgs),
    /// Vary scenarios over a design of experiments: thousands of runs, and a table at the end
    Sweep(super::sweep::SweepArgs),
    /// Seek parameters on some ducts, and hold the find against the default on others
    Tune(super::tune::TuneArgs),
}

/// What changes a scenario on its way from file to run.
#[derive(Args, Debug, Default)]
pub(crate) struct OverlayArgs {
    /// Lay a partial scenario file over each scenario (may be given several times)
    #[arg(long, value_name = "FILE")]
    pub(crate) with: Vec<PathBuf>,
    /// Set one field, as in `robot.speed_m_s=0.2` or `duct.run[1].elbow_deg=45` (may be given several times)
    #[arg(long, value_name = "PATH=VALUE")]
    pub(crate) set: Vec<String>,
    /// Feed every random stream from this seed, 0 to 9223372036854775807
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = seeds::seed)]
    pub(crate) seed: Option<u64>,
    /// How images become errors: `robust`, `paper`, or `truth` to steer by the true errors
    #[arg(long, value_name = "PIPELINE")]
    pub(crate) perception: Option<String>,
}

/// How images are made.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct RendererArgs {
    /// What renders
    #[arg(long, value_enum, default_value_t = RendererChoice::Auto)]
    pub(crate) renderer: RendererChoice,
    /// Threads for one run: with 2 or more, physics runs on while a frame is rendered and read, and all but one render.
    /// Results are the same
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

/// What renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RendererChoice {
    /// A hardware graphics adapter if there is one, else the processor; says which on standard error
    Auto,
    /// A graphics adapter, of hardware or software (lavapipe)
    Wgpu,
    /// The processor: the same images to the bit on every x86-64 machine
    Cpu,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop run scenarios/straight.toml                                a file
  ductloop run elbow-left                                             a scenario of the library (`ductloop list`)
  ductloop run straight straight-offset --set robot.speed_m_s=0.2
  ductloop run scenarios --junit out/junit.xml --json > runs.json
  ductloop run scenarios --jobs 4                                     four runs at a time
  ductloop run straight --seeds 1..20 --jobs 2 --at-least 19          twenty seeds, of which one may fail

A run's folder OUT/NAME holds report.html, summary.json, frames.parquet, scenario.toml, manifest.json and frames/*.png.")]
pub(crate) struct RunArgs {
    /// Scenario files, folders (every scenario below them), or names of scenarios below ./scenarios or in the library
    #[arg(required = true, value_name = "FILE|DIR|NAME")]
    pub(crate) inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Run every scenario with each of these seeds, both ends included: `1..20`, `1,5,9`, `1..3,7`
    #[arg(long, value_name = "A..B[,…]", allow_hyphen_values = true, value_parser = Seeds::parse, conflicts_with = "seed")]
    pub(crate) seeds: Option<Seeds>,
    /// A scenario passes when so many of its seeds pass, instead of all of them
    #[arg(
        long, value_name = "K", requires = "seeds", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=Seeds::MOST as i64)
    )]
    pub(crate) at_least: Option<u32>,
    /// Runs that go on at once. Without `--threads` they share the cores. Results and their order are the same
    #[arg(
        long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=1024)
    )]
    pub(crate) jobs: u16,
    #[command(flatten)]
    pub(crate) rendering: RendererArgs,
    /// Folder for the runs' folders; it is made where it is missing
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Write a JUnit file for a CI server; folders above it are made where they are missing
    #[arg(long, value_name = "FILE")]
    pub(crate) junit: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Replace the folder of another scenario's run
    #[arg(long)]
    pub(crate) force: bool,
    /// Steer by a program of one's own, in any language, instead of the robot's own navigator: its command line, split at spaces
    /// outside quotes, without a shell. `docs/navigator-protocol.md` says what it reads and writes
    #[arg(long, value_name = "COMMAND")]
    pub(crate) navigator: Option<String>,
    /// Longest time for one answer of that program; then the run ends with an error
    #[arg(
        long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = positive_seconds, default_value = "10",
        requires = "navigator"
    )]
    pub(crate) navigator_limit_s: f64,
    /// Break a run off after this many seconds of real time
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = positive_seconds)]
    pub(crate) wall_limit_s: Option<f64>,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop render straight --at-s 2 --out frame.png                   and frame.json with the robot's pose
  ductloop render straight --at-s 2 --truth --no-noise                and frame.truth.png, frame.centres.parquet, frame.*.npy
  ductloop render straight --at-s 0,1,2,4 --out sheet.png             a contact sheet
  ductloop render straight --pose 2,0,0.15,30,10,0 --bits 12          any camera pose, without a run

A picture of 10 or 12 bits is a PNG of 16 bits with the values as they are, 0 to 1023 or 4095: most viewers show it dark.")]
pub(crate) struct RenderArgs {
    /// Scenario file, or name of a scenario below ./scenarios or in the library
    #[arg(value_name = "FILE|NAME")]
    pub(crate) input: PathBuf,
    /// Simulated time: the first frame exposed at or after it. Several times, with commas between, give a contact sheet: of the
    /// frames until then, if the run ends before the last of them
    #[arg(
        long, value_name = "SECONDS[,…]", allow_negative_numbers = true, value_delimiter = ',', value_parser = seconds,
        required_unless_present = "pose"
    )]
    pub(crate) at_s: Vec<f64>,
    /// Camera anywhere in the duct instead of on the robot: place in m, then degrees, yaw to the left, pitch down, roll
    #[arg(
        long, value_name = "X,Y,Z,YAW,PITCH,ROLL", allow_hyphen_values = true, value_delimiter = ',', value_parser = number,
        conflicts_with_all = ["at_s", "lines"]
    )]
    pub(crate) pose: Vec<f64>,
    /// Write what is exactly the case in each pixel as well: stripe centres, depth, surface, normal
    #[arg(long)]
    pub(crate) truth: bool,
    /// Leave out everything random: noise of the CCD, unequal pixels, speckle
    #[arg(long)]
    pub(crate) no_noise: bool,
    /// Bits of a grey value, whatever the scenario says
    #[arg(long, value_name = "8|10|12", allow_negative_numbers = true, value_parser = bits)]
    pub(crate) bits: Option<Bits>,
    /// The picture; the robot's pose goes beside it, with the ending .json. Folders above it are made where they are missing
    #[arg(long, value_name = "FILE", default_value = "frame.png")]
    pub(crate) out: PathBuf,
    /// Draw the lines that the navigator found
    #[arg(long)]
    pub(crate) lines: bool,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    #[command(flatten)]
    pub(crate) rendering: RendererArgs,
    /// Print the JSON document on standard output as well
    #[arg(long)]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

#[derive(Args, Debug)]
pub(crate) struct CheckArgs {
    /// Scenario files, folders, or names of scenarios below ./scenarios or in the library
    #[arg(required = true, value_name = "FILE|DIR|NAME")]
    pub(crate) inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Draw the duct's plan to this SVG file; of several scenarios, each to NAME-<scenario>.svg beside it
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) plan: Option<PathBuf>,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

#[derive(Args, Debug)]
pub(crate) struct BenchArgs {
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Frames to time; the median is told
    #[arg(
        long, value_name = "N", default_value_t = 200, allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(10..=100_000)
    )]
    pub(crate) frames: u32,
    /// Threads for the whole loop, and for the processor's renderer where that is timed with more than one
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

impl Command {
    /// The list of results in the document of `run`.
    pub(crate) const RUNS: &'static str = "runs";
    /// The same of `check` and `list`.
    pub(crate) const SCENARIOS: &'static str = "scenarios";

    /// The list of results in its document, if it has one.
    pub(crate) fn list(&self) -> Option<&'static str> {
        match self {
            Self::Run(_) => Some(Self::RUNS),
            Self::Check(_) | Self::List(_) => Some(Self::SCENARIOS),
            Self::Perceive(_) => Some(super::perceive::PerceiveArgs::IMAGES),
            Self::Render(_)
            | Self::New(_)
            | Self::Accuracy(_)
            | Self::Calibrate(_)
            | Self::Schema(_)
            | Self::Bench(_)
            | Self::Sweep(_)
            | Self::Tune(_) => None,
        }
    }

    /// Whether the result is to be one JSON document.
    pub(crate) fn json(&self) -> bool {
        match self {
            Self::Run(args) => args.json,
            Self::Render(args) => args.json,
            Self::Check(args) => args.json,
            Self::List(args) => args.json,
            Self::New(args) => args.json,
            Self::Accuracy(args) => args.json,
            Self::Bench(args) => args.json,
            Self::Calibrate(args) => args.json,
            Self::Perceive(args) => args.json,
            Self::Sweep(args) => args.json(),
            Self::Tune(args) => args.saying.json,
            Self::Schema(_) => false,
        }
    }
}

fn bits(text: &str) -> Result<Bits, String> {
    match text {
        "8" => Ok(Bits::Eight),
        "10" => Ok(Bits::Ten),
        "12" => Ok(Bits::Twelve),
        _ => Err("8, 10 or 12".into()),
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| "a number, as in 0.15".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("a number of seconds, zero or more, as in 2.5".into()),
    }
}

fn positive_seconds(text: &str) -> Result<f64, String> {
    seconds(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "a number of seconds above zero, as in 60".into())
}
