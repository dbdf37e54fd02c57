//! Verdicts, exit codes, and what a run hands to people and to programs.

use std::fs;

use quick_junit::{NonSuccessKind, Report, TestCaseStatus};
use serde_json::{Value, json};

use super::workshop::{Workshop, keys};

/// A criterion that no run meets: the distance takes longer.
const TOO_SOON: &str = "pass.sim_time_s=0.5";

#[test]
fn a_run_that_passes_exits_0_and_leaves_its_folder() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["run", "short.toml"]).expect(0).saying(&["rendering with "]);
    assert!(ran.stdout.contains("short") && ran.stdout.contains("pass"), "{}", ran.stdout);
    assert!(ran.stdout.trim_end().ends_with("out/short/report.html"), "{}", ran.stdout);
    workshop.assert_whole("short");
    assert_eq!(workshop.names("out"), ["short"]);

    let silent = workshop.run(&["run", "short.toml", "--quiet"]).expect(0);
    assert_eq!((silent.stdout.as_str(), silent.stderr.as_str()), ("", ""));
}

#[test]
fn a_criterion_that_does_not_hold_exits_1_and_is_named() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["run", "short.toml", "--set", TOO_SOON]).expect(1);
    assert!(ran.stdout.contains("fail") && ran.stdout.contains("at most 0.5"), "{}", ran.stdout);
    // So does the simulated time's end.
    let ran = workshop.run(&["run", "short.toml", "--set", "time_limit_s=0.5", "--json"]).expect(1);
    let run = &ran.json()["runs"][0];
    assert_eq!(run["metrics"]["end_state"], "time-limit");
    assert_eq!(run["reasons"][0]["metric"], "completed");
    assert_eq!(workshop.names("out").len(), 2, "a failed run leaves its folder too");
}

#[test]
fn a_wall_clock_limit_exits_4() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["run", "short.toml", "--wall-limit-s", "0.05", "--json"]).expect(4);
    let run = &ran.json()["runs"][0];
    assert_eq!((&run["verdict"], &run["run_hash"], &run["reasons"]), (&json!("timeout"), &Value::Null, &json!([])));
    assert!(run["message"].as_str().expect("words").contains("0.05 s"), "{run}");
    workshop.assert_whole("short");
    // A limit beyond what a clock counts is none.
    workshop.run(&["run", "short.toml", "--wall-limit-s", "1e30"]).expect(0);
}

#[test]
fn a_call_exits_with_the_highest_code_of_its_runs() {
    let workshop = Workshop::new();
    workshop.write("failing.toml", super::workshop::scenario("failing", 1.6) + "sim_time_s = 0.5\n");
    let ran = workshop.run(&["run", "failing.toml", "short.toml", "--json"]).expect(1);
    let verdicts: Vec<_> = ran.json()["runs"].as_array().expect("runs").iter().map(|run| run["verdict"].clone()).collect();
    assert_eq!(verdicts, ["fail", "pass"]);
}

/// The order of the summary's fields is part of the format: people read it.
#[test]
fn the_document_has_the_agreed_fields_in_the_agreed_order() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["run", "short.toml", "--set", TOO_SOON, "--json", "--renderer", "cpu"]).expect(1);
    let ran = ran.saying(&["short", "fail"]);
    let document = ran.json();
    assert_eq!(keys(&document), ["runs", "errors"]);
    assert_eq!(document["errors"], json!([]));
    let run = &document["runs"][0];
    assert_eq!(keys(run), ["format", "scenario", "verdict", "reasons", "seed", "renderer", "run_hash", "metrics", "ahead"]);
    assert_eq!(keys(&run["reasons"][0]), ["metric", "value", "bound", "at_s"]);
    assert_eq!(run["reasons"][0]["bound"], 0.5);
    let metrics = [
        "completed",
        "end_state",
        "stop_reason",
        "distance_m",
        "sim_time_s",
        "wall_time_s",
        "real_time_factor",
        "lateral_rms_m",
        "lateral_max_m",
        "heading_rms_rad",
        "heading_max_rad",
        "lateral_estimate_rms_m",
        "heading_estimate_rms_rad",
        "filtered_lateral_rms_m",
        "filtered_log_loss",
        "estimates_valid",
        "collisions",
        "contact_speed_max_m_s",
        "min_clearance_m",
        "junctions_taken",
        "survey_drift_share",
        "survey_length_error_max",
        "survey_width_error_max_m",
        "survey_deposits_missed",
        "survey_deposits_false",
        "survey_deposit_error_max_m",
        "ahead_fittings",
        "ahead_named_share",
        "ahead_detection_widths_min",
        "ahead_latency_max_s",
        "ahead_distance_error_max_m",
        "ahead_false_alarms",
        "control_effort",
    ];
    assert_eq!(keys(&run["metrics"]), metrics);
    assert_eq!((&run["format"], &run["seed"], &run["renderer"]), (&json!(1), &json!(1), &json!("cpu")));
    let hash = run["run_hash"].as_str().expect("a hash");
    assert!(hash.len() == 32 && hash.bytes().all(|digit| digit.is_ascii_hexdigit()), "{hash}");
    // The folder says the same.
    let [folder] = &workshop.names("out")[..] else { panic!("one folder") };
    let summary: Value = serde_json::from_str(&workshop.read(&format!("out/{folder}/summary.json"))).expect("JSON");
    assert_eq!((&summary, keys(&summary["metrics"])), (run, keys(&run["metrics"])));
}

#[test]
fn junit_tells_failure_error_and_limit_apart() {
    let workshop = Workshop::new();
    let junit = |name: &str| {
        let report = Report::deserialize_from_str(&workshop.read(name)).expect("JUnit");
        report.test_suites.into_iter().flat_map(|suite| suite.test_cases).collect::<Vec<_>>()
    };
    let kind = |status: &TestCaseStatus| match status {
        TestCaseStatus::NonSuccess { kind, ty, message, .. } => {
            let text = |words: &Option<quick_junit::XmlString>| words.as_ref().map_or(String::new(), |w| w.as_str().to_owned());
            Some((*kind, text(ty), text(message)))
        }
        _ => None,
    };
    workshop.write("failing.toml", super::workshop::scenario("failing", 1.6) + "sim_time_s = 0.5\n");
    workshop.run(&["run", "short.toml", "failing.toml", "--junit", "deep/er/junit.xml"]).expect(1);
    let cases = junit("deep/er/junit.xml");
    assert_eq!(cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>(), ["short", "failing"]);
    assert_eq!(kind(&cases[0].status), None);
    let (failure, ty, message) = kind(&cases[1].status).expect("a failure");
    assert_eq!((failure, ty.as_str()), (NonSuccessKind::Failure, "verdict"));
    assert!(message.contains("at most 0.5"), "{message}");
    // A report that was written is named, and it is there.
    for case in &cases {
        let out = case.system_out.as_ref().expect("output").as_str();
        let path = out.lines().find_map(|line| line.strip_prefix("report: ")).expect("a report");
        assert!(workshop.path(path).is_file(), "{path}");
    }

    workshop.run(&["run", "short.toml", "--wall-limit-s", "0.05", "--junit", "limit.xml"]).expect(4);
    let (limit, ty, _) = kind(&junit("limit.xml")[0].status).expect("a limit");
    assert_eq!((limit, ty.as_str()), (NonSuccessKind::Error, "timeout"));

    // A folder that cannot be put in its place when the run is over: a file has taken it meanwhile.
    workshop.write("later.toml", super::workshop::scenario("later", 1.6));
    let mut running = workshop.start(&["run", "failing.toml", "later.toml", "--out", "again", "--junit", "error.xml", "--json"]);
    running.until("the first run's folder", |_| workshop.path("again/failing").is_dir());
    fs::write(workshop.path("again/later"), "in the way").expect("a file");
    let ran = running.wait().expect(3).saying(&["again/later is a file"]);
    let document = ran.json();
    assert_eq!(document["runs"][1]["verdict"], "error");
    assert_eq!(document["errors"].as_array().map(Vec::len), Some(1), "{document}");
    let (error, ty, message) = kind(&junit("error.xml")[1].status).expect("an error");
    assert_eq!((error, ty.as_str()), (NonSuccessKind::Error, "error"));
    assert!(message.contains("again/later"), "{message}");
    assert_eq!(workshop.names("again"), ["failing", "later"]);
}

#[test]
fn perception_can_be_the_truth() {
    let workshop = Workshop::new();
    let ran = workshop.run(&["run", "short.toml", "--perception", "truth", "--json"]).expect(0);
    assert_eq!(ran.json()["runs"][0]["metrics"]["lateral_estimate_rms_m"], 0.0);
}

#[test]
fn a_full_disk_behind_standard_output_is_not_a_success() {
    let workshop = Workshop::new();
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    for command in [&["run", "short.toml", "--json"][..], &["run", "short.toml"], &["check", "short.toml"], &["schema"]] {
        workshop.run_into("/dev/full", command).expect(3).saying(&["standard output", "cannot be written"]);
    }
    workshop.assert_whole("short");
}
