//! `render`: the picture, and the truth beside it.

use serde_json::{Value, json};

use super::workshop::{Workshop, keys, scenario};

#[test]
fn render_writes_the_picture_and_the_truth() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["render", "short.toml", "--at-s", "1.01", "--out", "deep/frame.png", "--json"]).expect(0);
    let picture = image::open(workshop.path("deep/frame.png")).expect("a picture").into_luma8();
    assert_eq!(picture.dimensions(), (640, 480));
    let (least, most) = picture.pixels().fold((255, 0), |(least, most), p| (p.0[0].min(least), p.0[0].max(most)));
    // Black level 8; stripes stand well above it: the nearest walls are 35 degrees off the axis, where cos^4 leaves 0.45 of their light.
    assert!(most > 40 && least < 20, "laser stripes on dim walls: {least} to {most}");

    let truth: Value = serde_json::from_str(&workshop.read("deep/frame.json")).expect("JSON");
    assert_eq!(truth, ran.json());
    // 30 frames a second: the first at or after 1.01 s is number 31.
    assert_eq!((&truth["frame"], &truth["tick"]), (&json!(31), &json!(31 * 40)));
    let distance_m = truth["truth"]["distance_m"].as_f64().expect("a number");
    // From 0.5 m at no more than 0.3 m/s, after a start from rest.
    assert!(distance_m > 0.55 && distance_m < 0.5 + 0.3 * 1.04, "{distance_m}");
    assert_eq!(workshop.names("deep"), ["frame.json", "frame.png"]);
    assert!(!workshop.path("out").exists());

    // The first frame shows the start. Lines, where asked for, are drawn in colour.
    workshop.run(&["render", "short.toml", "--at-s", "0", "--out", "lines.png", "--lines"]).expect(0);
    let lines = image::open(workshop.path("lines.png")).expect("a picture").into_rgb8();
    assert!(lines.pixels().any(|p| p.0[0] != p.0[1] || p.0[1] != p.0[2]));
    let start: Value = serde_json::from_str(&workshop.read("lines.json")).expect("JSON");
    assert_eq!((&start["time_s"], &start["truth"]["speed_m_s"]), (&json!(0.0), &json!(0.0)));
}

#[test]
fn render_refuses_what_it_cannot_do() {
    let workshop = Workshop::new();
    workshop.write("file", "in the way");
    workshop.write("several/a.toml", scenario("a", 1.6));
    workshop.write("several/b.toml", scenario("b", 1.6));
    let cases: &[(&[&str], &[&str])] = &[
        // Past the end of the run, and past the longest that it may take.
        (&["short.toml", "--at-s", "50"], &["--at-s: the run's last frame is that of", "(finished), before 50 s"]),
        (&["short.toml", "--at-s", "1,1e300"], &["--at-s: 1e300 s is later", "60 s at the latest", "time_limit_s"]),
        (&["short.toml", "--at-s", "1", "--out", "frame.jpg"], &["frame.jpg", ".png"]),
        (&["short.toml", "--at-s", "1", "--out", "file/frame.png"], &["--out file/frame.png", "not a folder"]),
        (&["several", "--at-s", "1"], &["several", "one scenario"]),
        (&["short.toml", "--at-s", "0,1", "--truth"], &["--truth", "2 times"]),
        (&["short.toml", "--at-s", "0,1", "--lines"], &["--lines", "2 times"]),
        (&["short.toml", "--at-s", "0", "--bits", "9"], &["--bits", "8, 10 or 12"]),
        (&["short.toml", "--at-s", "0", "--pose", "1,0,0.1,0,0,0"], &["--at-s", "--pose"]),
        (&["short.toml"], &["--at-s"]),
    ];
    for (args, words) in cases {
        let args: Vec<_> = ["render"].iter().chain(*args).copied().collect();
        workshop.run(&args).expect(2).saying(words);
    }
    assert!(!workshop.path("frame.png").exists() && !workshop.path("frame.json").exists());
}

/// What is asked for changes the picture, not the run.
#[test]
fn noise_and_bits_are_chosen_for_the_picture_alone() {
    let workshop = Workshop::new();
    let open = |name: &str| image::open(workshop.path(name)).expect("a picture");
    let document = |args: &[&str]| {
        let args = [&["render", "short.toml", "--at-s", "0.5", "--json", "--renderer", "cpu"], args].concat();
        workshop.run(&args).expect(0).json()
    };
    let plain = document(&["--out", "plain.png"]);
    assert_eq!(document(&["--out", "clean.png", "--no-noise"]), plain);
    assert_eq!(document(&["--out", "deep.png", "--no-noise", "--bits", "12"]), plain);
    let (noisy, clean) = (open("plain.png").into_luma8(), open("clean.png").into_luma8());
    assert_ne!(noisy, clean);
    let deep = open("deep.png");
    assert_eq!(deep.color(), image::ColorType::L16);
    for (deep, clean) in deep.into_luma16().pixels().zip(clean.pixels()) {
        // The same light in 4095/255 times finer steps: half a step of the coarse ones, and half a fine one.
        let apart = f64::from(deep.0[0]) * 255.0 / 4095.0 - f64::from(clean.0[0]);
        assert!(apart.abs() <= 0.5 + 0.5 * 255.0 / 4095.0 + 1e-9, "{deep:?} {clean:?}");
    }
}

#[test]
fn several_times_make_a_contact_sheet() {
    let workshop = Workshop::new();
    workshop.run(&["render", "short.toml", "--at-s", "1,0,0.5", "--out", "sheet.png"]).expect(0);
    let sheet = image::open(workshop.path("sheet.png")).expect("a picture").into_rgb8();
    // Four places of half the frame's size, words and space between them.
    let (width, height) = sheet.dimensions();
    assert!((640..700).contains(&width) && (480..540).contains(&height), "{width} x {height}");
    let document: Value = serde_json::from_str(&workshop.read("sheet.json")).expect("JSON");
    let frames = document["frames"].as_array().expect("a list");
    assert_eq!(frames.iter().map(|frame| &frame["frame"]).collect::<Vec<_>>(), [&json!(0), &json!(15), &json!(30)]);
}

#[test]
fn the_truth_stands_beside_the_picture() {
    let workshop = Workshop::new();
    workshop.run(&["render", "short.toml", "--at-s", "0", "--out", "a.png", "--truth", "--no-noise"]).expect(0);
    let names = ["a.centres.parquet", "a.depth.npy", "a.json", "a.normal.npy", "a.png", "a.surface.npy", "a.truth.png"];
    assert_eq!(workshop.names(".").iter().filter(|name| name.starts_with("a.")).collect::<Vec<_>>(), names);
    let files = workshop.files(".");
    let depth = &files["a.depth.npy"];
    assert_eq!(depth.len(), 128 + 4 * 640 * 480);
    // Straight ahead from 0.62 m the end is 0.98 m away, and open.
    let at = |file: &str, pixel: usize| f32::from_le_bytes(files[file][128 + 4 * pixel..][..4].try_into().expect("four bytes"));
    assert_eq!(at("a.depth.npy", 240 * 640 + 320), f32::INFINITY);
    // The right-hand wall is 0.25 m away: at the right edge x/z = 319.5 / 378.4, and its normal points to the left.
    let edge = 240 * 640 + 639;
    assert!((at("a.depth.npy", edge) - 0.25 * 378.4 / 319.5).abs() < 1e-4, "{}", at("a.depth.npy", edge));
    assert!((at("a.normal.npy", 3 * edge) + 1.0).abs() < 1e-6);
    assert!(files["a.centres.parquet"].ends_with(b"PAR1"));
    let picture = image::open(workshop.path("a.truth.png")).expect("a picture").into_rgb8();
    assert!(picture.dimensions().0 > 1280 && picture.dimensions().1 > 960);
    // Both lasers' colours are in the first panel.
    for colour in [[230, 159, 0], [86, 180, 233]] {
        let count = picture.enumerate_pixels().filter(|(x, y, p)| *x < 640 && *y > 30 && *y < 500 && p.0 == colour).count();
        assert!(count > 200, "{colour:?}: {count}");
    }
}

/// Nothing of an earlier frame stands beside a new picture; what is not of `render` is nobody's to take away.
#[test]
fn the_truth_of_an_earlier_picture_goes() {
    let workshop = Workshop::new();
    let render =
        |args: &[&str]| workshop.run(&[&["render", "short.toml", "--at-s", "0", "--out", "a.png"], args].concat()).expect(0);
    let theirs = ["a.depth.npy", "a.depth.npy.bak", "b.truth.png"];
    theirs.iter().for_each(|name| workshop.write(name, "somebody else's"));
    render(&[]);
    assert_eq!(workshop.read("a.depth.npy"), "somebody else's");
    render(&["--truth"]);
    assert_ne!(workshop.files(".")["a.depth.npy"], b"somebody else's");
    let ran = render(&[]);
    let ours = ["a.truth.png", "a.centres.parquet", "a.depth.npy", "a.surface.npy", "a.normal.npy"];
    ours.iter().for_each(|name| assert!(ran.stderr.contains(&format!("removed {name}: it was the truth of")), "{}", ran.stderr));
    let left: Vec<_> = workshop.names(".").into_iter().filter(|name| name.starts_with(['a', 'b'])).collect();
    assert_eq!(left, ["a.depth.npy.bak", "a.json", "a.png", "b.truth.png"]);
    // A sheet as well takes away what a frame had beside it.
    render(&["--truth"]);
    workshop.run(&["render", "short.toml", "--at-s", "0,0.1", "--out", "a.png", "--quiet"]).expect(0);
    assert!(!workshop.path("a.truth.png").exists());
}

#[test]
fn a_camera_can_be_anywhere_in_the_duct() {
    let workshop = Workshop::new();
    let pose = ["render", "short.toml", "--out", "p.png", "--truth", "--pose"];
    let document = workshop.run(&[&pose[..], &["0.8,0.1,0.15,90,0,0", "--json"]].concat()).expect(0).json();
    assert_eq!(keys(&document), ["format", "scenario", "seed", "camera"]);
    assert_eq!(document["camera"]["position_m"], json!([0.8, 0.1, 0.15]));
    // Yaw is to the left: the left wall, 0.15 m away, squarely.
    let depth = &workshop.files(".")["p.depth.npy"];
    let middle = f32::from_le_bytes(depth[128 + 4 * (240 * 640 + 320)..][..4].try_into().expect("four bytes"));
    assert!((middle - 0.15).abs() < 1e-6, "{middle}");
    for (pose_text, words) in [
        ("0.8,0.6,0.15,0,0,0", "is outside the duct"),
        // In the wall, and a millimetre before it.
        ("0.8,0.25,0.1,90,0,0", "in the duct but nearer than 2 mm"),
        ("0.8,0.249,0.1,60,0,0", "in the duct but nearer than 2 mm"),
        // What a right one looks like: the robot's own.
        ("0.8,0.6,0.15,0,0,0", "`--pose 0.620,0.000,0.100,0.0,0.0,0.0` at the start"),
        ("0.8,0,0.1,360.5,0,0", "yaw is 360.5 degrees; it must be from -360 to 360"),
        ("0.8,0,0.1,0,0,-1e9", "roll is -1000000000 degrees"),
        // No message has three hundred digits.
        ("0.8,0,0.1,0,1e300,0", "pitch is 1e300 degrees"),
        ("-1e300,0,0.1,0,0,0", "the camera at (-1.000e300, 0.000, 0.100) m"),
        ("1,2,3", "six numbers"),
        ("a,0,0,0,0,0", "a number"),
    ] {
        workshop.run(&[&pose[..], &[pose_text]].concat()).expect(2).saying(&["--pose", words]);
    }
}

#[test]
fn frames_until_the_end_of_the_run_are_written() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["render", "short.toml", "--at-s", "1,40,45", "--out", "sheet.png", "--json"]).expect(2);
    let ran = ran.saying(&[
        "--at-s: the run's last frame is that of",
        "(finished), before 40 s and 45 s; the frames until then are written",
    ]);
    let document = ran.json();
    assert_eq!(keys(&document), ["format", "frames", "errors"]);
    assert_eq!(document["frames"].as_array().map(Vec::len), Some(1));
    assert_eq!((&document["frames"][0]["frame"], &document["errors"][0]["file"]), (&json!(30), &json!("--at-s")));
    // A sheet, as it was asked for, with the one frame; and its document.
    let sheet = image::open(workshop.path("sheet.png")).expect("a picture").into_luma8();
    assert!(sheet.dimensions().0 < 640, "{:?}", sheet.dimensions());
    let written: Value = serde_json::from_str(&workshop.read("sheet.json")).expect("JSON");
    assert_eq!((keys(&written), &written["frames"]), (vec!["format", "frames"], &document["frames"]));
}

/// A time between the last frame and the run's end is one that no frame comes after.
#[test]
fn a_time_after_the_last_frame_is_told_by_that_frame() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["render", "short.toml", "--at-s", "50"]).expect(2);
    let last = ran.stderr.split("that of ").nth(1).and_then(|rest| rest.split(' ').next()).expect(&ran.stderr).to_owned();
    let last_s: f64 = last.parse().expect("seconds");
    workshop.run(&["render", "short.toml", "--at-s", &format!("{}", last_s - 5e-4)]).expect(0);
    let next = format!("{}", last_s + 0.03);
    let words = format!("the run's last frame is that of {last} s (finished), before {next} s");
    workshop.run(&["render", "short.toml", "--at-s", &next]).expect(2).saying(&[&words]);
}

#[test]
fn times_that_fall_on_one_frame_are_told() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["render", "short.toml", "--at-s", "0,0.001,0,0.03", "--json"]).expect(0);
    let ran =
        ran.saying(&["0 s and 0 s fall on one frame, that of 0.000 s", "0.001 s and 0.03 s fall on one frame, that of 0.033 s"]);
    assert_eq!(ran.json()["frames"].as_array().map(Vec::len), Some(2));
    let ran = workshop.run(&["render", "short.toml", "--at-s", "0,0", "--quiet"]).expect(0);
    assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
}

/// The same as a run that is killed while it writes.
#[test]
#[cfg(target_os = "linux")]
fn what_a_killed_call_has_left_goes_with_the_next() {
    let workshop = Workshop::new();
    let call = ["render", "short.toml", "--at-s", "0", "--out", "pictures/a.png", "--truth"];
    workshop.run(&call).expect(0);
    let whole = workshop.names("pictures");
    let begun = |names: &[String]| names.iter().any(|name| name.starts_with(".a.") && name.contains(".tmp-"));
    // Whether a file is caught half written is chance: it is tried until one is.
    let mut caught = false;
    for _ in 0..200 {
        let mut running = workshop.start(&call);
        while !caught && running.is_alive() {
            caught = begun(&workshop.names("pictures"));
        }
        if caught {
            running.signal("KILL");
            running.wait();
            caught = begun(&workshop.names("pictures"));
        }
        if caught {
            break;
        }
    }
    assert!(caught, "no call was killed while it wrote");
    workshop.run(&call).expect(0);
    assert_eq!(workshop.names("pictures"), whole);
}

/// A camera so near the ceiling that the upper laser, 60 mm above it, is beyond.
#[test]
fn a_laser_outside_the_duct_is_told_before_anything_runs() {
    let workshop = Workshop::new();
    let dark = ["--set", "sensor.camera.position_in_base_m=[0.12, 0.0, 0.25]"];
    let with = |args: &[&'static str]| workshop.run(&[args, &dark].concat());
    let words = "warning: short.toml: at the start the source of laser `high` is outside the duct";
    let checked = with(&["check", "short.toml", "--json"]).expect(0).saying(&[words]).json();
    assert_eq!(checked["scenarios"][0]["warnings"].as_array().map(Vec::len), Some(1), "{checked}");
    assert_eq!(with(&["check", "short.toml", "--quiet"]).expect(0).stderr, "");
    // It says so before the run, and then runs.
    let ran = with(&["run", "short.toml", "--set", "time_limit_s=0.1"]).expect(1).saying(&[words]);
    assert!(ran.stderr.find("warning") < ran.stderr.find("rendering with"), "{}", ran.stderr);
    with(&["render", "short.toml", "--at-s", "0,0.1"]).expect(0).saying(&["at 0.000 s, 0.100 s the source of laser `high`"]);
    with(&["render", "short.toml", "--pose", "0.8,0,0.25,0,0,0"]).expect(0).saying(&["here the source of laser `high`"]);
    let sound = workshop.run(&["check", "short.toml", "--json"]).expect(0);
    assert_eq!((sound.stderr.as_str(), &sound.json()["scenarios"][0]["warnings"]), ("", &json!([])));
}
