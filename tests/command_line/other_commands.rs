//! `render`, `check`, `schema`, `bench`.

use std::fs;

use serde_json::{Value, json};

use super::workshop::{Workshop, keys, scenario};

#[test]
fn render_writes_the_picture_and_the_truth() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["render", "short.toml", "--at-s", "1.01", "--out", "deep/frame.png", "--json"]).expect(0);
    let picture = image::open(workshop.path("deep/frame.png")).expect("a picture").into_luma8();
    assert_eq!(picture.dimensions(), (640, 480));
    let (least, most) = picture.pixels().fold((255, 0), |(least, most), p| (p.0[0].min(least), p.0[0].max(most)));
    // Black level 8; stripes stand well above it.
    assert!(most > 60 && least < 20, "laser stripes on dim walls: {least} to {most}");

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
        (&["short.toml", "--at-s", "50"], &["--at-s", "finished", "before 50 s"]),
        (&["short.toml", "--at-s", "1e300"], &["--at-s: this is later", "60 s at the latest"]),
        (&["short.toml", "--at-s", "1", "--out", "frame.jpg"], &["frame.jpg", ".png"]),
        (&["short.toml", "--at-s", "1", "--out", "file/frame.png"], &["--out file/frame.png", "not a folder"]),
        (&["several", "--at-s", "1"], &["several", "one scenario"]),
    ];
    for (args, words) in cases {
        let args: Vec<_> = ["render"].iter().chain(*args).copied().collect();
        workshop.run(&args).expect(2).saying(words);
    }
    assert!(!workshop.path("frame.png").exists() && !workshop.path("frame.json").exists());
}

#[test]
fn check_says_what_a_file_holds_and_runs_nothing() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["check", "short.toml"]).expect(0);
    assert!(ran.stdout.contains("short.toml: ok") && ran.stdout.contains("1.60 m"), "{}", ran.stdout);
    assert_eq!(ran.stderr, "");
    let document = workshop.run(&["check", "short.toml", "--json"]).expect(0).json();
    assert_eq!(keys(&document), ["scenarios", "errors"]);
    assert_eq!(document["scenarios"][0]["length_m"], 1.6);
    assert!(!workshop.path("out").exists());
    // A reader who goes away is no error.
    let ran = std::process::Command::new("sh")
        .arg("-c")
        .arg(format!("{} check short.toml short.toml short.toml | true", env!("CARGO_BIN_EXE_ductloop")))
        .current_dir(workshop.path("."))
        .output()
        .expect("sh");
    assert_eq!(String::from_utf8_lossy(&ran.stderr), "");
}

#[test]
fn the_schema_is_json_and_knows_the_fields() {
    let workshop = Workshop::new();
    let schema = workshop.run(&["schema"]).expect(0).json();
    assert!(schema["$schema"].as_str().expect("a dialect").starts_with("https://json-schema.org/"), "{schema}");
    assert_eq!(schema["properties"]["duct"]["properties"]["width_m"]["type"], "number");
    assert_eq!(schema["properties"]["seed"]["maximum"], i64::MAX);
}

#[test]
fn bench_measures_every_part_that_is_there() {
    let workshop = Workshop::new();
    let document = workshop.run(&["bench", "--frames", "10", "--json"]).expect(0).json();
    assert_eq!(
        keys(&document)[..7],
        ["frame_px", "threads", "render_ms", "perceive_ms", "physics_steps_per_s", "real_time_factor", "host"]
    );
    assert_eq!(document["frame_px"], json!([640, 480]));
    let measured = |value: &Value| value.as_f64().is_some_and(|value| value > 0.0);
    assert!(measured(&document["render_ms"]["wgpu"]) && document["render_ms"]["cpu"].is_null(), "{document}");
    assert!(measured(&document["perceive_ms"]["paper"]) && document["perceive_ms"]["robust"].is_null(), "{document}");
    assert!(measured(&document["physics_steps_per_s"]) && measured(&document["real_time_factor"]["wgpu"]), "{document}");
    assert_eq!(fs::read_dir(workshop.path(".")).expect("a folder").flatten().filter(|e| e.file_name() == "out").count(), 0);
}
