//! `ductloop calibrate`: pixels of known position to the sensor's geometry.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use ductloop::calibrate::boards::{Boards, Centres, Found};
use ductloop::calibrate::gauge::figure;
use ductloop::calibrate::gauge::file::GaugeFile;
use ductloop::calibrate::linear::Applied;
use ductloop::calibrate::model::Fitted;
use ductloop::calibrate::pictures::centres_of_image;
use ductloop::calibrate::points::Points;
use ductloop::calibrate::{camera, matrix};
use ductloop::engine::{Engine, Threads};
use ductloop::output::write_whole;
use ductloop::photograph::Channel;
use ductloop::scenario::Diagnostics;
use ductloop_nav::calibration::model::{Free, LASERS, Scatter};
use ductloop_nav::rig::Camera;
use serde_json::Value;

use super::destination;
use super::problem::Problem;
use super::streams::{note, print, print_json};

/// What may be typed behind `calibrate`.
#[derive(Args, Debug)]
#[command(group(ArgGroup::new("with_camera").args(["model", "boards"]).multiple(true)), after_help = "\
Examples:
  ductloop calibrate right.csv                                 equation 14: the matrix T of one laser, and how well it is known
  ductloop calibrate right.csv --out T.csv                     the same, written as a table
  ductloop calibrate left.csv --apply T.csv --laser left       positions and misses by a given T
  ductloop calibrate right.csv --model left.csv --out rig.toml    one camera and the planes of both lasers instead
  ductloop calibrate centres.csv --boards boards.csv --camera camera.toml --laser green    a laser's plane
  ductloop calibrate *.jpg --boards boards.csv --camera camera.toml --channel green-excess    the same from pictures
  ductloop calibrate --gauge scenarios/gauge/incra1.toml --out figure9.svg                 the paper's experiment, simulated

POINTS.csv has the columns u_px,v_px,x_mm,y_mm,z_mm: pixels, and their positions on a gauge. Others are left alone; lines that
begin with # are comments. At least four points are needed of which no three lie on a line.

BOARDS.csv names pictures: file,n_x,n_y,n_z,d_mm, the board's plane n . x = d in the camera's frame, and q0_u,q0_v to q3_u,q3_v, its
corners, if known. Behind --boards stand these pictures, PNG or JPEG, or tables (*.csv) of stripe centres found in them:
file,u_px,v_px and, if it is known, sigma_px.

What --model and --boards write is laid over a scenario by `--with`, and is a rig for `perceive --rig`.")]
pub(crate) struct CalibrateArgs {
    /// Table of pixels and positions of one laser; with --boards, pictures of a stripe, or tables of its centres
    #[arg(required_unless_present = "gauge", value_name = "POINTS.csv")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Carry out an experiment with a simulated block gauge: rendered, found, calibrated, tested
    #[arg(long, value_name = "GAUGE.toml", conflicts_with_all = ["inputs", "apply", "model", "boards", "laser", "camera"])]
    pub(crate) gauge: Option<PathBuf>,
    /// Triangulate with the T of this file instead of solving for one
    #[arg(long, value_name = "T.csv", conflicts_with_all = ["model", "boards"])]
    pub(crate) apply: Option<PathBuf>,
    /// Fit camera and planes to these points and to another laser's (may be given several times); files name the lasers
    #[arg(long, value_name = "OTHER.csv", conflicts_with = "boards")]
    pub(crate) model: Vec<PathBuf>,
    /// Fit a laser's plane to its stripe on boards of known pose
    #[arg(long, value_name = "BOARDS.csv", requires = "camera")]
    pub(crate) boards: Option<PathBuf>,
    /// What of a coloured picture is read, with --boards: grey, red, green, blue, or red-excess, green-excess, blue-excess
    #[arg(long, value_name = "CHANNEL", default_value = "grey", requires = "boards", value_parser = super::perceive::channel)]
    pub(crate) channel: Channel,
    /// File with the camera, in [sensor.camera] or [camera]; --model starts from INCRA I's if there is none
    #[arg(long, value_name = "CAMERA.toml", requires = "with_camera")]
    pub(crate) camera: Option<PathBuf>,
    /// What --model may change of the camera
    #[arg(long, value_enum, value_name = "WHAT[,…]", value_delimiter = ',', requires = "model")]
    pub(crate) free: Vec<Freed>,
    /// Standard deviation of a pixel, for --model
    #[arg(long, value_name = "PX", default_value_t = 1.0, requires = "model", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) sigma_px: f64,
    /// Standard deviation of a position, for --model
    #[arg(long, value_name = "MM", default_value_t = 0.5, requires = "model", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) sigma_mm: f64,
    /// The laser's name: which T of the file of --apply, and how it is written
    #[arg(long, value_name = "NAME", conflicts_with = "model")]
    pub(crate) laser: Option<String>,
    /// Write T as a table, for --apply; with --model or --boards, the rig or the plane as TOML, for `run --with`;
    /// with --gauge, the paper's figure 9 as SVG
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// What of a camera a fit may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Freed {
    /// The focal length
    Focal,
    /// The principal point
    Centre,
    /// Radial distortion of r^2
    K1,
    /// Radial distortion of r^4
    K2,
}

/// Carries it out.
///
/// # Errors
/// Files that cannot be read or written, and points that determine nothing.
pub(crate) fn command(args: &CalibrateArgs) -> Result<u8, Problem> {
    if let Some(out) = &args.out {
        destination::file("--out", out)?;
        let CalibrateArgs { inputs, apply, model, boards, camera, gauge, .. } = args;
        let read = inputs.iter().chain(model).chain(apply).chain(boards).chain(camera).chain(gauge);
        destination::is_no_input("--out", out, read)?;
    }
    if let Some(gauge) = &args.gauge {
        return of_gauge(args, gauge);
    }
    if let Some(boards) = &args.boards {
        return of_boards(args, boards);
    }
    let [input] = args.inputs.as_slice() else {
        let many = Problem::new(Problem::WRONG_INPUT, format!("{} tables of points are given: one is wanted", args.inputs.len()));
        return Err(many.help("other lasers' tables follow `--model`, each behind its own"));
    };
    if !args.model.is_empty() {
        return of_model(args, input);
    }
    let points = Points::read(input).map_err(in_file)?;
    let applied = match &args.apply {
        Some(file) => Applied::apply(matrix::read(file, args.laser.as_deref()).map_err(in_file)?, &points),
        None => Applied::solve(&points).map_err(in_file)?,
    };
    let name = args.laser.clone().unwrap_or_else(|| stem(input));
    finish(args, &applied.to_json(&points), &applied.to_text(&points), || matrix::to_csv(&name, &applied.t))
}

fn of_model(args: &CalibrateArgs, input: &Path) -> Result<u8, Problem> {
    let files: Vec<&Path> = std::iter::once(input).chain(args.model.iter().map(PathBuf::as_path)).collect();
    if files.len() > LASERS {
        let message = format!("{} lasers: a rig has {LASERS} at most", files.len());
        return Err(Problem::new(Problem::WRONG_INPUT, message).about("--model"));
    }
    let mut tables: Vec<(String, Points)> = Vec::new();
    for file in files {
        let name = stem(file);
        if tables.iter().any(|(other, _)| *other == name) {
            let twice = Problem::new(Problem::WRONG_INPUT, format!("two tables are of a laser `{name}`"));
            return Err(twice.about(file.display().to_string()).help("the files' names are the lasers'"));
        }
        tables.push((name, Points::read(file).map_err(in_file)?));
    }
    let camera = args.camera.as_deref().map_or(Ok(camera::incra1()), read_camera)?;
    let has = |what| args.free.contains(&what);
    let free = Free { focal: has(Freed::Focal), centre: has(Freed::Centre), k1: has(Freed::K1), k2: has(Freed::K2) };
    let stated = Scatter { pixel_px: args.sigma_px, position_mm: args.sigma_mm };
    let fitted = Fitted::fit(&tables, &camera, free, stated).map_err(in_file)?;
    finish(args, &fitted.to_json(&tables), &fitted.to_text(), || fitted.to_toml())
}

fn of_boards(args: &CalibrateArgs, boards: &Path) -> Result<u8, Problem> {
    // clap has made sure that there is one.
    let camera = args.camera.as_deref().map_or(Ok(camera::incra1()), read_camera)?;
    let boards = Boards::read(boards).map_err(in_file)?;
    let is_table = |path: &&PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    let (tables, pictures): (Vec<_>, Vec<_>) = args.inputs.iter().partition(is_table);
    let mut centres = Centres::read(&tables, &boards).map_err(in_file)?;
    for picture in pictures {
        let found = centres_of_image(picture, &camera, &boards, args.channel).map_err(in_file)?;
        centres.extend(found, &boards);
    }
    let laser = args.laser.as_deref().unwrap_or("laser");
    let found = Found::fit(&camera, boards, centres, laser).map_err(in_file)?;
    finish(args, &found.to_json(), &found.to_text(), || found.to_toml())
}

fn of_gauge(args: &CalibrateArgs, gauge: &Path) -> Result<u8, Problem> {
    let file = GaugeFile::read(gauge).map_err(in_file)?;
    // On the processor: the same figures on every machine.
    let result = ductloop::calibrate::gauge::run(&file, &Engine::Cpu, Threads::here().all)
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(gauge.display().to_string()))?;
    finish(args, &result.to_json(), &result.to_text(), || figure::svg(&result))
}

/// Writes the file and tells the result.
fn finish(args: &CalibrateArgs, document: &Value, text: &str, file: impl FnOnce() -> String) -> Result<u8, Problem> {
    if let Some(out) = &args.out {
        let lost = |error| Problem::new(Problem::CANNOT_GO_ON, format!("{error}")).about(out.display().to_string());
        write_whole(out, file().as_bytes()).map_err(lost)?;
        note(&format!("written: {}", out.display()));
    }
    if args.json {
        print_json(document)?
    } else {
        print(text)?
    }
    Ok(0)
}

fn read_camera(path: &Path) -> Result<Camera, Problem> {
    camera::read(path).map_err(in_file)
}

fn in_file(diagnostics: Diagnostics) -> Problem {
    Problem::in_files(vec![diagnostics])
}

/// A file's name without folder and ending.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (1e-6..=1e6).contains(value));
    value.ok_or_else(|| "a number above zero, as in 0.5".into())
}
