//! `ductloop perceive`: the perception's stages on picture files, photographs too.
//!
//! With a rig they are the robust pipeline's, or the paper's: centres, lines, walls, lateral and heading error. Without one there are
//! stripe centres and straight lines only (`ductloop_nav::perception::ridge`).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use ductloop::bounded_file;
use ductloop::output::write_whole;
use ductloop::photograph::{Channel, LARGEST_BYTES, Photograph};
use ductloop::scenario::{Pipeline, RigFile};
use ductloop::stage_picture::{Overlay, is_overlay, overlay_png};
use ductloop::{Scenario, pilot};
use ductloop_nav::perception::ridge::{Region, Ridge, RidgeParams};
use serde_json::{Value, json};

use super::perceived::{self, Perceived};
use super::picture_files;
use super::problem::{Problem, Problems};
use super::regions::{self, Regions};
use super::streams::{note, print, print_json};
use super::{destination, interrupt};

/// What may be typed.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop perceive frame.png --rig presets/sensor/wide.toml              walls, lateral and heading error
  ductloop perceive frame.png --rig scenarios/straight.toml --pipeline paper
  ductloop perceive photo.jpg --rig low.toml --rig high.toml              a camera and two lasers' planes, from `calibrate --boards`
  ductloop perceive photo.jpg --channel green-excess                      without a rig: stripe centres and lines
  ductloop perceive *.jpg --channel green-excess --rois boards.csv --json > centres.json

Each picture's OUT/NAME.json holds what OUT/NAME.overlay.png shows: centres in the lasers' colours (red: of none), lines beside
their stripes. A rig is a scenario, or a file with its [sensor] tables; what it may leave out: how the camera is mounted (upright, in the
base's origin: the lateral error is then the camera's own), mount angles (0), line (2 mm, 4 mrad), the duct's width ([navigation]
width_m: without it one wall alone gives no lateral error).")]
pub(crate) struct PerceiveArgs {
    /// Pictures: PNG or JPEG, 8 or 16 bits, grey or coloured
    #[arg(required = true, value_name = "IMAGE")]
    pub(crate) images: Vec<PathBuf>,
    /// Camera and lasers: a scenario, or a file with its [sensor] tables, as `calibrate` writes it (may be given several times: later
    /// files are laid over earlier ones). Without it there are stripe centres and lines only
    #[arg(long, value_name = "RIG")]
    pub(crate) rig: Vec<PathBuf>,
    /// Which pipeline reads the pictures; the rig's file says, or `robust`
    #[arg(long, value_enum, requires = "rig")]
    pub(crate) pipeline: Option<PipelineChoice>,
    /// What of a coloured picture is read: grey (luminance), red, green, blue, or red-excess, green-excess, blue-excess (a colour less
    /// the mean of the others: a laser's line on whatever is grey)
    #[arg(long, value_name = "CHANNEL", default_value = "grey", value_parser = channel)]
    pub(crate) channel: Channel,
    /// Look only inside this rectangle, or inside a polygon of three corners or more, in pixels
    #[arg(long, value_name = "U0,V0,U1,V1[,U2,V2…]", allow_hyphen_values = true, conflicts_with = "rois")]
    pub(crate) roi: Option<String>,
    /// The same for each picture: a table with a column `file` and the corners' columns `*_u,*_v`, in the polygon's order
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) rois: Option<PathBuf>,
    /// Bits that grey values of 16-bit pictures have; by default as few of 10, 12 and 16 as hold them all
    #[arg(long, value_name = "10|12|16", allow_negative_numbers = true, value_parser = bits)]
    pub(crate) bits: Option<u16>,
    /// Folder for documents and overlays; it is made where it is missing
    #[arg(long, value_name = "DIR", default_value = "out/perceive")]
    pub(crate) out: PathBuf,
    /// Time the perception: the median of so many repetitions, in the document and in what is said
    #[arg(
        long, value_name = "N", num_args = 0..=1, default_missing_value = "50", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    pub(crate) time: Option<u32>,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Replace files of the results' names that `perceive` did not write
    #[arg(long)]
    pub(crate) force: bool,
}

/// Pipelines that read images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PipelineChoice {
    /// Sub-pixel centres and deviations, robust against what belongs to no stripe
    Robust,
    /// The paper's chain
    Paper,
}

/// The channel of a word.
pub(super) fn channel(word: &str) -> Result<Channel, String> {
    let words = || Channel::ALL.map(Channel::word).join(", ");
    Channel::ALL.into_iter().find(|channel| channel.word() == word).ok_or_else(|| format!("one of {}", words()))
}

/// The largest value of so many bits.
fn bits(text: &str) -> Result<u16, String> {
    match text {
        "10" => Ok(1023),
        "12" => Ok(4095),
        "16" => Ok(u16::MAX),
        _ => Err("10, 12 or 16".into()),
    }
}

/// Carries it out: every file is read and checked before the first result is written.
///
/// # Errors
/// What cannot be read or does not fit the rig; a file that cannot be written.
pub(crate) fn command(args: &PerceiveArgs) -> Result<u8, Problem> {
    let job = prepare(args)?;
    interrupt::listen();
    let mut documents = Vec::new();
    for image in &args.images {
        if interrupt::requested() {
            note("interrupted: what is written so far is whole");
            return Ok(super::INTERRUPTED);
        }
        let region = job.regions.of(image);
        let photograph = job.open(image).map_err(|problem| problem.with_code(Problem::CANNOT_GO_ON))?;
        let perceived = job.perceive(photograph.clone(), region.as_ref(), args.time);
        let [document_file, overlay_file] = results(args, image);
        let document = perceived::document(image, &overlay_file, &photograph, args.channel, job.scenario(), &perceived);
        let cannot_go_on = |path: &Path, error: &dyn std::fmt::Display| {
            Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(path.display().to_string())
        };
        let overlay = Overlay { centres: &perceived.centres, lines: &perceived.lines, region: region.as_ref() };
        let png = overlay_png(photograph.size_px(), &photograph.to_8_bits(), &overlay);
        let png = png.map_err(|error| cannot_go_on(&overlay_file, &error))?;
        for (path, bytes) in [(&overlay_file, png), (&document_file, format!("{document:#}\n").into_bytes())] {
            write_whole(path, &bytes).map_err(|error| cannot_go_on(path, &error))?;
        }
        if !args.json && !args.quiet {
            print(&perceived::words(image, &overlay_file, &perceived))?;
        }
        documents.push(document);
    }
    if args.json {
        print_json(&json!({"images": documents, "errors": []}))?;
    }
    Ok(0)
}

/// What all pictures share.
struct Job<'a> {
    args: &'a PerceiveArgs,
    /// The rig, with the pipeline that was asked for.
    rig: Option<RigFile>,
    regions: Regions,
}

/// Reads everything that is named, and finds all that is wrong with it.
fn prepare(args: &PerceiveArgs) -> Result<Job<'_>, Problem> {
    let mut problems = Problems::default();
    let mut take = |result: Result<(), Problem>| {
        if let Err(problem) = result {
            problems.note(problem);
        }
    };
    let mut job = Job { args, rig: None, regions: Regions::Whole };
    take(args.rig.first().map_or(Ok(()), |_| {
        let mut rig = Scenario::read_rig(&args.rig).map_err(|wrong| Problem::in_files(vec![wrong]))?;
        let pipeline = &mut rig.scenario.perception.pipeline;
        *pipeline = match args.pipeline {
            Some(PipelineChoice::Robust) => Pipeline::Robust,
            Some(PipelineChoice::Paper) => Pipeline::Paper,
            // Whoever steers by the truth has none of it here.
            None if *pipeline == Pipeline::Truth => Pipeline::Robust,
            None => *pipeline,
        };
        job.rig = Some(rig);
        Ok(())
    }));
    take(regions::read(args.roi.as_deref(), args.rois.as_deref()).map(|regions| job.regions = regions));
    let named = || args.images.iter().chain(&args.rig).chain(&args.rois);
    let files: Vec<PathBuf> = args.images.iter().flat_map(|image| results(args, image)).collect();
    // All go to one folder, so one stands for those that are not there, or are plain files; the others may lead elsewhere.
    let is_plain = |file: &&PathBuf| file.symlink_metadata().map_or(true, |found| found.is_file());
    let (plain, others): (Vec<&PathBuf>, Vec<&PathBuf>) = files.iter().partition(is_plain);
    take(
        destination::folder("--out", &args.out)
            .and_then(|()| plain.into_iter().take(1).chain(others).try_for_each(|file| destination::file("--out", file))),
    );
    for file in &files {
        let is_ours = |()| if args.force { Ok(()) } else { is_ours_to_replace(file) };
        take(destination::is_no_input("--out", file, named()).and_then(is_ours));
    }
    let mut names: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    for image in &args.images {
        if let Some(other) = names.insert(stem(image), image) {
            let message = format!("its results would be called as those of {}", other.display());
            let problem = Problem::new(Problem::WRONG_INPUT, message).about(image.display().to_string());
            take(Err(problem.help("read them in two calls, with an --out each")));
        }
        take(job.open(image).and_then(|photograph| job.fits(image, &photograph)));
    }
    problems.or(job)
}

/// That a result which would be replaced is one of `perceive`: `render` writes documents of its own beside frames, by the same name, and
/// the picture may be anybody's.
fn is_ours_to_replace(file: &Path) -> Result<(), Problem> {
    if !file.is_file() || is_ours(file) {
        return Ok(());
    }
    let message = "it is there already, and `perceive` did not write it".to_owned();
    Err(destination::refused("--out", file, message).help("choose another place, or `--force` to replace it"))
}

/// Whether `perceive` wrote a file: a document has its keys, a picture its mark.
fn is_ours(file: &Path) -> bool {
    const OURS: [&str; 4] = ["file", "centres", "lines", "overlay"];
    let Ok(bytes) = bounded_file::read(file, LARGEST_BYTES) else { return false };
    if file.extension().is_some_and(|ending| ending == "json") {
        let there = serde_json::from_slice::<Value>(&bytes);
        return there.is_ok_and(|there| OURS.iter().all(|key| there.get(key).is_some()));
    }
    is_overlay(&bytes)
}

/// Files of a picture's results: the document and the overlay.
fn results(args: &PerceiveArgs, image: &Path) -> [PathBuf; 2] {
    [".json", ".overlay.png"].map(|ending| {
        let mut name = stem(image).into_os_string();
        name.push(ending);
        args.out.join(name)
    })
}

/// What a picture's results are called.
fn stem(image: &Path) -> PathBuf {
    image.file_stem().map_or_else(|| PathBuf::from("image"), PathBuf::from)
}

impl Job<'_> {
    fn scenario(&self) -> Option<&Scenario> {
        self.rig.as_ref().map(|rig| &rig.scenario)
    }

    fn open(&self, image: &Path) -> Result<Photograph, Problem> {
        picture_files::read(image, self.args.channel, self.args.bits)
    }

    /// Whether a picture is one of the rig's camera, and has a region if the pictures have regions.
    fn fits(&self, image: &Path, photograph: &Photograph) -> Result<(), Problem> {
        let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message).about(image.display().to_string());
        let [width, height] = photograph.size_px();
        if let Some(scenario) = self.scenario() {
            let camera = &scenario.rig.camera;
            if [camera.width_px, camera.height_px] != [width, height] {
                let rig = self.args.rig.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", ");
                let message = format!(
                    "the picture has {width} x {height} pixels, the camera of {rig} {} x {}",
                    camera.width_px, camera.height_px
                );
                return Err(
                    wrong(message).help("a picture as the camera delivers it, neither cropped nor scaled; or that camera's rig")
                );
            }
        }
        let Some(region) = self.regions.of(image) else {
            return match self.regions {
                Regions::Whole => Ok(()),
                _ => Err(wrong("there is no row for it in the table of --rois".into())
                    .help("its column `file` holds the picture's name")),
            };
        };
        if region.mask(width, height).iter().any(|inside| *inside) {
            return Ok(());
        }
        Err(wrong(format!("its region lies beside it: the picture has {width} x {height} pixels"))
            .help("corners are u,v in pixels"))
    }

    fn perceive(&self, mut photograph: Photograph, region: Option<&Region>, time: Option<u32>) -> Perceived {
        let timed = |run: &mut dyn FnMut()| {
            run();
            let mut times: Vec<f64> = (0..time.unwrap_or(0))
                .map(|_| {
                    let started = Instant::now();
                    run();
                    started.elapsed().as_secs_f64() * 1e3
                })
                .collect();
            times.sort_by(f64::total_cmp);
            times.get(times.len() / 2).copied()
        };
        let Some(RigFile { scenario, width_m }) = &self.rig else {
            let mut ridge = Ridge::new(RidgeParams::default());
            let perceive_ms = timed(&mut || {
                ridge.extract(&photograph.frame(), region);
            });
            return Perceived::of_ridge(&ridge, perceive_ms);
        };
        if let Some(region) = region {
            photograph.keep_only(region);
        }
        let mut perception = pilot::perception(scenario);
        let mut measured = None;
        let perceive_ms = timed(&mut || measured = Some(perception.perceive(&photograph.frame(), scenario.rig.mount.rest)));
        Perceived::of_stages(perception.stages(), measured.unwrap_or_default(), perceive_ms).with_width(*width_m)
    }
}

impl PerceiveArgs {
    /// The list of results in its document.
    pub(crate) const IMAGES: &'static str = "images";
}
