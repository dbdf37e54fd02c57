//! `check`, `schema`, `bench`.

use std::fs;

use serde_json::{Value, json};

use super::workshop::{NO_ADAPTER, Workshop, keys};

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
    assert_eq!(workshop.run(&["schema", "--kind", "scenario"]).expect(0).json(), schema);
    let of = |kind: &str| workshop.run(&["schema", "--kind", kind]).expect(0).json();
    assert_eq!(of("accuracy")["properties"]["poses"]["properties"]["count"]["type"], "integer");
    assert_eq!(of("gauge")["properties"]["gauge"]["properties"]["window_px"]["maximum"], 200);
    assert_eq!(of("sweep")["properties"]["design"]["default"], "grid");
    assert_eq!(of("study")["properties"]["optimiser"]["default"], "cma-es");
    workshop.run(&["schema", "--kind", "recipe"]).expect(2).saying(&["recipe", "scenario, accuracy, sweep, study, gauge"]);
}

#[test]
fn bench_measures_every_part_that_is_there() {
    let workshop = Workshop::new();
    let document = workshop.run(&["bench", "--frames", "10", "--json"]).expect(0).json();
    let agreed = ["frame_px", "threads", "render_ms", "perceive_ms", "physics_steps_per_s", "real_time_factor", "host"];
    assert_eq!(keys(&document)[..7], agreed);
    assert_eq!(keys(&document)[7..], ["adapter", "render_reflections_ms", "render_full_ms", "render_threads_ms"]);
    assert_eq!(document["frame_px"], json!([640, 480]));
    let measured = |value: &Value| value.as_f64().is_some_and(|value| value > 0.0);
    for pair in ["render_ms", "render_reflections_ms", "render_full_ms", "real_time_factor"] {
        assert!(measured(&document[pair]["cpu"]) && measured(&document[pair]["wgpu"]), "{pair}: {document}");
    }
    let threads = &document["render_threads_ms"];
    assert!(measured(&threads["cpu"]) && measured(&threads["cpu_full"]), "{document}");
    assert!(measured(&document["perceive_ms"]["paper"]) && measured(&document["perceive_ms"]["robust"]), "{document}");
    assert!(measured(&document["physics_steps_per_s"]), "{document}");
    assert_eq!(fs::read_dir(workshop.path(".")).expect("a folder").flatten().filter(|e| e.file_name() == "out").count(), 0);

    // Without an adapter the rest is measured all the same.
    let ran = workshop.run_with(&NO_ADAPTER, &["bench", "--frames", "10", "--threads", "1", "--json"]).expect(0);
    let document = ran.json();
    assert!(measured(&document["render_ms"]["cpu"]) && measured(&document["real_time_factor"]["cpu"]), "{document}");
    for pair in ["render_ms", "render_reflections_ms", "render_full_ms", "real_time_factor"] {
        assert!(document[pair]["wgpu"].is_null(), "{pair}: {document}");
    }
    assert_eq!((&document["adapter"], &document["threads"]), (&Value::Null, &json!(1)));
}
