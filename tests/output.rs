//! What a run writes: its folder, table, documents, report and JUnit.
#![cfg(feature = "cli")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, RecordBatch};
use ductloop::ahead_scores::TrueAhead;
use ductloop::output::folder::{FolderError, RunFolder, folder_name};
use ductloop::output::junit::{Case, junit, write_junit};
use ductloop::output::manifest::{AdapterInfo, Manifest};
use ductloop::output::summary::Summary;
use ductloop::output::{FileError, frames, try_whole, words};
use ductloop::record::{EndState, FrameRecord, KeyFrames, RunRecord};
use ductloop::run_files::write_run;
use ductloop::viewpoint::still;
use ductloop::{Command, Counts, GreyImage, Measurement, MountAngles, Scenario, Sides, Verdict, report};
use ductloop_nav::ahead::{Fitting, Outlook, Side};
use ductloop_nav::navigator::{Reason, State};
use ductloop_nav::perception::{StripeLine, Wall, WallMeasurement};
use ductloop_sensor::optics::Bits;
use ductloop_sim::collision::Collisions;
use ductloop_sim::truth::Truth;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

const SCENARIO: &str = r#"
format = 1
kind = "scenario"
name = "made-up"
about = "Half of <b>this</b> & that"
seed = 7
[sensor]
preset = "wide"
[perception]
pipeline = "paper"
[duct]
width_m = 0.5
height_m = 0.3
surface = "galvanised"
run = [{ straight_m = 3.0 }, { elbow_deg = 90, throat_radius_m = 0.375 }, { straight_m = 2.0 }]
[[fault]]
at_s = 2.0
for_s = 0.5
kind = "laser-off"
laser = "low"
[pass]
completed = true
collisions = 0
lateral_rms_mm = 5.0
estimates_valid_min = 0.9
settle_m = 1.0
"#;

fn scenario() -> Scenario {
    Scenario::from_toml_str(SCENARIO).unwrap_or_else(|errors| panic!("{}", errors.render(false)))
}

/// A run that nobody drove: the base slides along the centreline with a decaying offset of `lateral_m` at first, sees nothing
/// for a while, and scrapes a wall once.
fn made_up(scenario: &Scenario, lateral_m: f64) -> RunRecord {
    let network = scenario.duct.network().expect("the duct of the test is sound");
    let camera = &scenario.rig.camera;
    let (mut frames, mut key_frames) = (Vec::new(), KeyFrames::default());
    let lines = [
        StripeLine { ends_px: [[20.5, 100.0], [300.0, 220.0]], assigned: Some((0, Wall::Left)), points: 200, residual_px: 0.2 },
        StripeLine { ends_px: [[400.0, 210.0], [620.0, 90.0]], assigned: None, points: 30, residual_px: 0.9 },
    ];
    for i in 0..300u64 {
        let time_s = i as f64 / 30.0;
        let distance_m = 0.5 + 0.5 * time_s;
        let lateral_m = lateral_m * libm::exp(-distance_m);
        let blind = i == 0 || (60..75).contains(&i);
        let seen = |value: f64| (!blind).then_some(value);
        let on_path = network.centreline.pose_at(distance_m);
        let truth = Truth {
            world_from_base: on_path * nalgebra::Translation3::new(0.0, lateral_m, 0.0),
            cell: 0,
            fitting: 0,
            segment: 0,
            distance_m,
            lateral_m,
            heading_rad: -0.1 * lateral_m,
            clearance_m: 0.14 - lateral_m.abs(),
            speed_m_s: 0.5,
            yaw_rate_rad_s: 0.0,
            wheel_speed_rad_s: Sides { left: 12.5, right: 12.4 },
            motor_current_a: Sides { left: 0.5, right: 0.4 },
        };
        frames.push(FrameRecord {
            frame: i,
            tick: 40 * i,
            time_s,
            truth,
            width_m: 0.5,
            collisions: Collisions { count: u32::from(i > 200), contact_speed_max_m_s: if i > 200 { 0.02 } else { 0.0 } },
            counts: Counts { left: -3 * i as i64, right: 3 * i as i64 },
            mount: MountAngles { pan_rad: 0.0, tilt_rad: 0.1 },
            body: Default::default(),
            measurement: Measurement {
                lateral_m: seen(lateral_m + 0.001),
                heading_rad: seen(-0.1 * lateral_m),
                width_m: seen(0.501),
                left: seen(0.25).map(|distance_m| WallMeasurement {
                    distance_m,
                    heading_rad: 0.01,
                    points: 321,
                    deviation: None,
                }),
                right: None,
                ..Measurement::default()
            },
            score: Default::default(),
            state: if blind { State::Coasting } else { State::Tracking },
            reason: blind.then_some(Reason::NoWall),
            estimate: None,
            outlook: None,
            true_ahead: None,
            believed_pose: None,
            ducts: 0,
            lines: lines.len(),
            command: Command {
                wheel_speed_rad_s: Sides { left: 12.5, right: 12.5 },
                mount: MountAngles { pan_rad: 0.0, tilt_rad: 0.1 },
                sweep: None,
                exposure_s: (i == 3).then_some(0.004),
                laser_power: None,
            },
            view: still(on_path, 0.004 + 1e-5 * i as f64),
            laser_power: 1.0 + 0.01 * i as f64,
            faults: u32::from(blind),
        });
        let grey = vec![(i % 200) as u16; camera.width_px * camera.height_px];
        let image = GreyImage::of([camera.width_px, camera.height_px], Bits::Eight, &grey).expect("its size");
        key_frames.offer(i, &image, &lines);
    }
    RunRecord {
        frames,
        key_frames,
        end: EndState::Finished,
        sim_time_s: 10.0,
        collisions: Collisions { count: 1, contact_speed_max_m_s: 0.02 },
        distance_m: 5.0,
        notes: Default::default(),
        run_hash: 0xabc,
    }
}

fn manifest() -> Manifest {
    let adapter = AdapterInfo { name: "A".into(), driver: "D 1".into(), backend: "vulkan".into(), software: true };
    Manifest::now(7, "wgpu", Some(adapter), 2)
}

fn files_below(folder: &Path) -> BTreeSet<String> {
    let mut files = BTreeSet::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() {
            files.extend(files_below(&path).into_iter().map(|file| format!("{name}/{file}")));
        } else {
            files.insert(name);
        }
    }
    files
}

fn table_of(bytes: Vec<u8>) -> RecordBatch {
    let reader = ParquetRecordBatchReaderBuilder::try_new(parquet_bytes(bytes)).expect("a Parquet file");
    let rows = usize::try_from(reader.metadata().file_metadata().num_rows()).expect("a number of rows");
    let schema = reader.schema().clone();
    let mut batches = reader.with_batch_size(rows.max(1)).build().expect("a reader");
    batches.next().map_or_else(|| RecordBatch::new_empty(schema), |batch| batch.expect("a batch"))
}

/// `bytes::Bytes` without naming its crate, which only Parquet depends on.
fn parquet_bytes(bytes: Vec<u8>) -> impl parquet::file::reader::ChunkReader + 'static {
    let file = tempfile::tempfile().expect("a temporary file");
    std::io::Write::write_all(&mut &file, &bytes).expect("room for a table");
    file
}

#[test]
fn the_table_has_a_row_a_frame_and_reads_back_to_the_bit() {
    let (scenario, blind) = (scenario(), 16);
    let run = made_up(&scenario, 0.05);
    let table = table_of(frames::parquet(&run.frames).expect("a table"));
    assert_eq!(table.num_rows(), run.frames.len());
    let column = |name: &str| table.column_by_name(name).unwrap_or_else(|| panic!("no column {name}"));
    let numbers = |name: &str| column(name).as_primitive::<Float64Type>();
    for (i, frame) in run.frames.iter().enumerate() {
        let base = &frame.truth.world_from_base;
        assert_eq!(column("frame").as_primitive::<UInt64Type>().value(i), frame.frame);
        assert_eq!(column("tick").as_primitive::<UInt64Type>().value(i), frame.tick);
        assert_eq!(column("counts_left").as_primitive::<Int64Type>().value(i), frame.counts.left);
        assert_eq!(column("collisions").as_primitive::<UInt32Type>().value(i), frame.collisions.count);
        assert_eq!(column("faults").as_primitive::<UInt32Type>().value(i), frame.faults);
        assert_eq!(column("state").as_string::<i32>().value(i), frames::state_word(frame.state));
        let why = column("state_reason").as_string::<i32>();
        assert_eq!(why.is_valid(i).then(|| why.value(i)), frame.reason.map(ductloop::reason_words::reason_word));
        for (name, value) in [
            ("time_s", frame.time_s),
            ("x_m", base.translation.x),
            ("qz", base.rotation.k),
            ("lateral_m", frame.truth.lateral_m),
            ("wheel_speed_right_rad_s", frame.truth.wheel_speed_rad_s.right),
            ("command_right_rad_s", frame.command.wheel_speed_rad_s.right),
            ("tilt_rad", frame.mount.tilt_rad),
            ("exposure_s", frame.view.exposure_s),
            ("laser_power", frame.laser_power),
        ] {
            assert_eq!(numbers(name).value(i).to_bits(), value.to_bits(), "{name} of frame {i}");
        }
        for (name, value) in [
            ("lateral_estimate_m", frame.measurement.lateral_m),
            ("left_wall_distance_m", frame.measurement.left.map(|wall| wall.distance_m)),
            ("right_wall_distance_m", None),
            ("command_exposure_s", frame.command.exposure_s),
        ] {
            let there = numbers(name).is_valid(i).then(|| numbers(name).value(i));
            assert_eq!(there, value, "{name} of frame {i}");
        }
    }
    assert_eq!(column("left_wall_points").null_count(), blind);
}

#[test]
fn a_run_of_no_frames_has_the_same_columns() {
    let scenario = scenario();
    let full = table_of(frames::parquet(&made_up(&scenario, 0.0).frames).expect("a table"));
    let empty = table_of(frames::parquet(&[]).expect("a table"));
    assert_eq!((empty.num_rows(), empty.schema().fields()), (0, full.schema().fields()));
}

#[test]
fn the_summary_is_the_documented_json() {
    let scenario = scenario();
    let summary = Summary::of(&scenario, &made_up(&scenario, 0.05), "wgpu", Some(2.5));
    let text = summary.to_json().expect("JSON");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["run_hash"], "00000000000000000000000000000abc");
    assert_eq!((&json["format"], &json["verdict"], &json["seed"]), (&1.into(), &"fail".into(), &7.into()));
    assert_eq!(json["reasons"][0]["metric"], "collisions");
    assert_eq!(json["metrics"]["real_time_factor"], 4.0);
    // The fields' order is part of what is documented, so the text is read.
    let places = |names: &[&str]| names.iter().map(|name| text.find(&format!("\"{name}\":"))).collect::<Vec<_>>();
    let outer = places(&["format", "scenario", "verdict", "reasons", "seed", "renderer", "run_hash", "metrics", "ahead"]);
    assert!(outer.iter().all(Option::is_some) && outer.is_sorted(), "{text}");
    let metrics = words::METRICS.map(|words| words.metric);
    let inner = places(&metrics);
    assert!(inner.iter().all(Option::is_some) && inner.is_sorted(), "{text}");
    assert_eq!(json["metrics"].as_object().map(|metrics| metrics.len()), Some(metrics.len()));
    assert_eq!(json.as_object().map(|summary| summary.len()), Some(9));

    let broken = summary.broken_off(Verdict::Error, "the graphics device was lost");
    let json: serde_json::Value = serde_json::from_str(&broken.to_json().expect("JSON")).expect("JSON");
    assert_eq!((&json["verdict"], &json["run_hash"]), (&"error".into(), &serde_json::Value::Null));
    assert_eq!(json["message"], "the graphics device was lost");
}

#[test]
fn a_run_leaves_one_whole_folder_and_nothing_of_the_run_before() {
    let out = tempfile::tempdir().expect("a temporary folder");
    let scenario = scenario();
    let toml = scenario.to_toml();
    let run = made_up(&scenario, 0.05);
    let summary = Summary::of(&scenario, &run, "wgpu", None);
    let prepare = || RunFolder::prepare(out.path(), "made-up", &toml, false).expect("a folder that can be written");

    let folder = prepare();
    assert!(files_below(out.path()).is_empty() && fs::read_dir(out.path()).expect("a folder").next().is_none());
    write_run(&folder, &scenario, &run, &summary, &manifest()).expect("a folder");
    let expected = files_below(folder.path());
    for file in [
        "scenario.toml",
        "manifest.json",
        "frames.parquet",
        "summary.json",
        "survey.json",
        "report.html",
        "frames/000000-lines.png",
    ] {
        assert!(expected.contains(file), "{file} is missing from {expected:?}");
    }
    assert_eq!(expected.iter().filter(|file| file.starts_with("frames/")).count(), 12);
    let resolved = fs::read_to_string(folder.path().join("scenario.toml")).expect("a scenario");
    assert_eq!(Scenario::from_toml_str(&resolved).expect("a scenario"), scenario);

    // A file of an earlier version of the program does not survive beside new ones.
    fs::write(folder.path().join("frames/old.png"), "old").expect("a file");
    write_run(&prepare(), &scenario, &run, &summary, &manifest()).expect("a folder");
    assert_eq!(files_below(folder.path()), expected);
    let names: Vec<_> = fs::read_dir(out.path()).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    assert_eq!(names, ["made-up"], "nothing else is left beside the folder");
}

#[test]
fn a_run_that_is_given_up_leaves_the_folder_as_it_was() {
    let out = tempfile::tempdir().expect("a temporary folder");
    let folder = RunFolder::prepare(out.path(), "x", "a = 1", false).expect("a folder");
    folder.write("scenario.toml", b"a = 1").expect("a file");
    folder.write("frames/1.png", b"1").expect("a file");
    folder.publish().expect("a folder");
    let again = RunFolder::prepare(out.path(), "x", "a = 1", false).expect("a folder");
    again.write("frames/2.png", b"2").expect("a file");
    assert_eq!(files_below(&out.path().join("x")), BTreeSet::from(["frames/1.png".into(), "scenario.toml".into()]));
    drop(again);
    assert_eq!(files_below(out.path()), BTreeSet::from(["x/frames/1.png".into(), "x/scenario.toml".into()]));
}

#[test]
fn only_the_same_scenario_replaces_a_folder_and_nothing_else_is_touched() {
    let out = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| out.path().join(name);
    let prepare = |name: &str, force| RunFolder::prepare(out.path(), name, "a = 1", force);
    for (name, file) in [("other", "scenario.toml"), ("letters", "love.txt")] {
        fs::create_dir(at(name)).expect("a folder");
        fs::write(at(name).join(file), "a = 2").expect("a file");
    }
    fs::create_dir(at("empty")).expect("a folder");
    fs::write(at("file"), "").expect("a file");
    let before = files_below(out.path());

    let other = prepare("other", false).expect_err("another scenario's folder");
    assert!(matches!(other, FolderError::OtherScenario(_)) && other.to_string().contains("--force"), "{other}");
    prepare("other", true).expect("--force replaces another scenario's folder");
    prepare("empty", false).expect("an empty folder may be filled");
    for force in [false, true] {
        let letters = prepare("letters", force).expect_err("not a run's folder");
        assert!(matches!(letters, FolderError::NotARun(_)), "{letters}");
        assert!(matches!(prepare("file", force), Err(FolderError::NotAFolder(_))));
    }
    for name in ["", ".", "..", "a/b", ".hidden"] {
        assert!(matches!(prepare(name, false), Err(FolderError::Name(_))), "{name}");
    }
    assert_eq!(files_below(out.path()), before);
}

#[test]
fn what_cannot_be_written_is_found_beforehand_and_nothing_is_left() {
    let out = tempfile::tempdir().expect("a temporary folder");
    fs::write(out.path().join("file"), "").expect("a file");
    let beneath_a_file = RunFolder::prepare(&out.path().join("file/out"), "x", "", false).expect_err("no folder");
    assert!(beneath_a_file.to_string().contains("file/out"), "{beneath_a_file}");
    let long = "n".repeat(300);
    assert!(RunFolder::prepare(&out.path().join("new/deep"), &long, "", false).is_err());
    RunFolder::prepare(&out.path().join("new/deep"), "x", "", false).expect("a folder that can be made");
    assert_eq!(files_below(out.path()), BTreeSet::from(["file".into()]));
    assert!(!out.path().join("new").exists(), "folders made for the trial are gone");
}

#[test]
fn the_report_needs_nothing_but_itself_and_says_why() {
    let scenario = scenario();
    let run = made_up(&scenario, 0.05);
    let summary = Summary::of(&scenario, &run, "wgpu", None);
    let page = report::html(&scenario, &run, &summary, &manifest()).expect("a page");
    for part in [
        "Collisions: 1, first at 6.7 s; it must be at most 0.",
        "Half of &lt;b&gt;this&lt;&#x2f;b&gt; &amp; that",
        "fault: laser low off",
        "collision at 6.7 s",
        "00000000000000000000000000000abc",
        "ductloop run scenario.toml --renderer wgpu",
        "not seen",
    ] {
        // Slashes may be escaped or not; both show the same.
        assert!(page.contains(part) || page.contains(&part.replace("&#x2f;", "/")), "{part} is missing");
    }
    assert_eq!(page.matches("data:image/png;base64,").count(), KeyFrames::COUNT);
    for foreign in ["http:", "https:", "<script", "<link", "@import", "NaN", "inf "] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}

/// A duct that ends with a cap, which is named an elbow, and then what it is.
#[test]
fn the_report_shows_what_lay_ahead() {
    let text = "format = 1\nkind = \"scenario\"\nname = \"ahead\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nexit = \"cap\"\n\
                run = [{ straight_m = 6.0 }]\n";
    let capped = Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{wrong}"));
    let mut run = made_up(&scenario(), 0.0);
    run.frames.truncate(100);
    for (number, frame) in run.frames.iter_mut().enumerate() {
        let distance_m = 2.0 - 0.016 * number as f64;
        let fitting = Fitting::DeadEnd;
        frame.true_ahead = Some(TrueAhead { thing: 0, fitting, distance_m, is_in_reach: true, is_inside: false });
        let fitting = if number < 60 { Fitting::Elbow(Side::Left) } else { Fitting::DeadEnd };
        frame.outlook = Some(Outlook { fitting, distance_m, ..Outlook::default() });
    }
    let summary = Summary::of(&capped, &run, "cpu", None);
    let page = report::html(&capped, &run, &summary, &manifest()).expect("a page");
    for part in [
        "What lay ahead, and what it was named",
        "<title>dead-end named dead-end: 1 of 1</title>",
        "<title>dead-end named elbow-left: 60 of 100</title>",
        "class=\"is-elbow-left\"",
        "straight-1.out",
        "0 false alarms",
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    // Nothing lay ahead: no section.
    let plain = scenario();
    let run = made_up(&plain, 0.05);
    let page = report::html(&plain, &run, &Summary::of(&plain, &run, "cpu", None), &manifest()).expect("a page");
    assert!(!page.contains("What lay ahead"));
}

#[test]
fn every_run_has_a_report_even_one_that_never_began() {
    let scenario = scenario();
    let mut run = made_up(&scenario, 0.0);
    run.frames.clear();
    run.key_frames = KeyFrames::default();
    run.sim_time_s = 0.0;
    let summary = Summary::of(&scenario, &run, "wgpu", None).broken_off(Verdict::Error, "the device was lost");
    let page = report::html(&scenario, &run, &summary, &manifest()).expect("a page");
    assert!(page.contains("The device was lost") && page.contains("The run could not go on."));
    assert!(!page.contains("NaN"));
}

#[test]
fn junit_tells_failure_error_and_limit_apart() {
    let scenario = scenario();
    let run = made_up(&scenario, 0.05);
    let failed = Summary::of(&scenario, &run, "wgpu", Some(1.5));
    let passed = Summary { verdict: Verdict::Pass, reasons: Vec::new(), ..failed.clone() };
    let lost = failed.clone().broken_off(Verdict::Error, "lost \u{1b}[31m<device>");
    let late = failed.clone().broken_off(Verdict::Timeout, "the wall-clock limit of 2 s was reached");
    let reasons = failed.reasons.iter().map(|reason| words::reason(&scenario, &failed.metrics, reason)).collect();
    let report = Some("out/made-up/report.html".as_ref());
    let case = |summary, name| Case { summary, name, reasons: Vec::new(), report, allowed: None };
    let cases = [case(&passed, "a"), Case { reasons, ..case(&failed, "b") }, case(&lost, "c"), case(&late, "d")];
    let text = junit(&cases).expect("XML");
    assert!(text.contains(r#"<testsuite name="ductloop" tests="4" skipped="0" errors="2" failures="1" time="6.000">"#), "{text}");
    assert!(
        text.contains(r#"<failure message="Collisions: 1, first at 6.7 s; it must be at most 0." type="verdict">"#),
        "{text}"
    );
    assert!(text.contains(r#"<error message="lost &lt;device&gt;" type="error">"#), "{text}");
    assert!(text.contains(r#"type="timeout""#) && text.contains("out/made-up/report.html"), "{text}");
    assert!(text.contains("least clearance: "), "{text}");

    // An allowance covers failures, and nothing else.
    let covered = cases.clone().map(|case| Case { allowed: Some("allowed, as 9 of 10 passed"), ..case });
    let skipped = junit(&covered).expect("XML");
    assert!(skipped.contains(r#"tests="4" skipped="1" errors="2" failures="0""#), "{skipped}");
    let words =
        r#"<skipped message="allowed, as 9 of 10 passed: Collisions: 1, first at 6.7 s; it must be at most 0." type="allowed">"#;
    assert!(skipped.contains(words), "{skipped}");

    let out = tempfile::tempdir().expect("a temporary folder");
    let path = out.path().join("deep/junit.xml");
    write_junit(&path, &cases).expect("a file");
    assert_eq!(fs::read_to_string(&path).expect("a file"), text);
    try_whole(&path).expect("a file that may be replaced");
    try_whole(&out.path().join("new/junit.xml")).expect("a folder that can be made");
    for path in ["deep", "deep/junit.xml/x.xml"] {
        try_whole(&out.path().join(path)).expect_err("a folder, and a file beneath a file");
    }
    assert!(!out.path().join("new").exists());
    assert_eq!(files_below(out.path()), BTreeSet::from(["deep/junit.xml".into()]));
    assert!(matches!(write_junit(&out.path().join("deep"), &cases), Err(FileError::NotAFile("a folder"))));
}

#[test]
fn names_tell_changed_scenarios_apart() {
    let scenario = scenario();
    let changed = Scenario { seed: 8, ..scenario.clone() };
    let name = |scenario: &Scenario| folder_name(&scenario.name, true, scenario.seed, &scenario.to_toml());
    assert!(name(&scenario).starts_with("made-up-s7-") && name(&changed).starts_with("made-up-s8-"));
    assert_ne!(name(&scenario)[11..], name(&changed)[11..]);
}
