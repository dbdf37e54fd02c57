//! One scenario with many seeds: the same runs as one by one, and a verdict on all of them.

use std::fs;

use quick_junit::{NonSuccessKind, Report, TestCaseStatus};
use serde_json::{Value, json};

use super::workshop::{Ran, Workshop, keys};

const COMMON: [&str; 5] = ["run", "short.toml", "--renderer", "cpu", "--json"];

fn run(workshop: &Workshop, args: &[&str]) -> Ran {
    workshop.run(&[&COMMON[..], args].concat())
}

/// What each run says of something.
fn each(document: &Value, pointer: &str) -> Vec<Value> {
    document["runs"].as_array().into_iter().flatten().map(|run| run.pointer(pointer).cloned().unwrap_or_default()).collect()
}

/// A criterion that two of the seeds 1 to 4 meet, and how each of them fares.
fn half_pass(workshop: &Workshop) -> (String, Vec<bool>) {
    let ran = run(workshop, &["--seeds", "1..4", "--jobs", "2", "--out", "before"]).expect(0);
    let off: Vec<f64> = each(&ran.json(), "/metrics/lateral_rms_m").iter().filter_map(Value::as_f64).collect();
    let mut sorted = off.clone();
    sorted.sort_by(f64::total_cmp);
    let bound_m = (sorted[1] + sorted[2]) / 2.0;
    let passes: Vec<_> = off.iter().map(|off_m| *off_m <= bound_m).collect();
    assert_eq!(passes.iter().filter(|passes| **passes).count(), 2, "{off:?}");
    (format!("pass.lateral_rms_mm={}", bound_m * 1e3), passes)
}

/// The kind of each JUnit case that did not succeed, with its type and message.
fn junit(workshop: &Workshop, name: &str) -> Vec<String> {
    let report = Report::deserialize_from_str(&workshop.read(name)).expect("JUnit");
    let words = |words: &Option<quick_junit::XmlString>| words.as_ref().map_or(String::new(), |w| w.as_str().to_owned());
    let cases = report.test_suites.into_iter().flat_map(|suite| suite.test_cases);
    cases
        .map(|case| match &case.status {
            TestCaseStatus::Success { .. } => "success".to_owned(),
            TestCaseStatus::Skipped { ty, message, .. } => format!("skipped {} {}", words(ty), words(message)),
            TestCaseStatus::NonSuccess { kind: NonSuccessKind::Failure, ty, message, .. } => {
                format!("failure {} {}", words(ty), words(message))
            }
            TestCaseStatus::NonSuccess { ty, message, .. } => format!("error {} {}", words(ty), words(message)),
        })
        .collect()
}

#[test]
fn each_seed_is_the_run_that_it_is_alone() {
    let workshop = Workshop::new();
    let document = run(&workshop, &["--seeds", "7,1..2", "--jobs", "2"]).expect(0).json();
    assert_eq!(keys(&document), ["runs", "seeds", "errors"]);
    assert_eq!(each(&document, "/seed"), [7, 1, 2], "in the order that was typed");
    assert_eq!(document["seeds"], json!([{"scenario": "short", "seeds": 3, "passed": 3, "at_least": 3, "verdict": "pass"}]));
    let hashes = each(&document, "/run_hash");
    let names = workshop.names("out");
    assert_eq!(names.len(), 3, "{names:?}");
    for (seed, hash) in ["7", "1", "2"].iter().zip(&hashes) {
        let alone = run(&workshop, &["--seed", seed, "--out", "alone"]).expect(0).json();
        assert_eq!(&alone["runs"][0]["run_hash"], hash, "seed {seed}");
    }
    assert_eq!(workshop.names("alone"), names);
    for name in &names {
        workshop.assert_whole(name);
        for file in ["scenario.toml", "frames.parquet"] {
            let [a, b] = ["out", "alone"].map(|out| fs::read(workshop.path(&format!("{out}/{name}/{file}"))).expect("a file"));
            assert!(a == b, "{name}/{file}");
        }
    }
}

#[test]
fn a_scenario_passes_when_enough_of_its_seeds_do() {
    let workshop = Workshop::new();
    let (criterion, passes) = half_pass(&workshop);
    let args = ["--seeds", "1..4", "--jobs", "2", "--set", &criterion, "--junit", "junit.xml"];
    for (at_least, code, verdict) in [(None, 1, "fail"), (Some("3"), 1, "fail"), (Some("2"), 0, "pass"), (Some("1"), 0, "pass")] {
        let least: Vec<&str> = at_least.iter().flat_map(|least| ["--at-least", least]).collect();
        let ran = run(&workshop, &[&args[..], &least].concat()).expect(code);
        let document = ran.json();
        let must: u64 = at_least.map_or(4, |least| least.parse().expect("a number"));
        let seeds = json!([{"scenario": "short", "seeds": 4, "passed": 2, "at_least": must, "verdict": verdict}]);
        assert_eq!(document["seeds"], seeds, "{at_least:?}");
        // A run's own verdict is what it was.
        let verdicts: Vec<_> = passes.iter().map(|passes| if *passes { "pass" } else { "fail" }).collect();
        assert_eq!(each(&document, "/verdict"), verdicts);
        let cases = junit(&workshop, "junit.xml");
        for (case, passes) in cases.iter().zip(&passes) {
            let allowed = format!("skipped allowed allowed, as 2 of 4 seeds passed and {must} must: RMS lateral error");
            let expected = if *passes {
                "success"
            } else if code == 0 {
                &allowed
            } else {
                "failure verdict RMS lateral error"
            };
            assert!(case.starts_with(expected), "{at_least:?}: {case}");
        }
        assert_eq!(cases.len(), 4);
        // People are told which seeds, and why.
        let told = format!("short: 2 of 4 seeds did not pass, and {must} must");
        let failing = passes.iter().zip(1..).filter(|(passes, _)| !**passes).map(|(_, seed)| format!("short-s{seed}-"));
        let failing: Vec<_> = failing.collect();
        ran.saying(&["2/4", &told, &failing[0], &failing[1], "RMS lateral error"]);
    }
}

#[test]
fn a_run_without_an_end_is_not_made_up_for_by_others() {
    let workshop = Workshop::new();
    let timeless = ["--seeds", "1..3", "--at-least", "1", "--wall-limit-s", "0.01", "--out", "late"];
    let document = run(&workshop, &timeless).expect(4).json();
    assert_eq!(document["seeds"][0]["verdict"], "timeout", "{document}");

    // The last one's folder cannot be put in its place when its run is over: a file has taken it meanwhile.
    let names = workshop.names("late");
    let mut running = workshop.start(&[&COMMON[..], &["--seeds", "1..3", "--at-least", "1", "--junit", "junit.xml"]].concat());
    running.until("the first run's folder", |_| workshop.path(&format!("out/{}", names[0])).is_dir());
    workshop.write(&format!("out/{}", names[2]), "in the way");
    let document = running.wait().expect(3).json();
    assert_eq!(each(&document, "/verdict"), ["pass", "pass", "error"]);
    let seeds = json!([{"scenario": "short", "seeds": 3, "passed": 2, "at_least": 1, "verdict": "error"}]);
    assert_eq!(document["seeds"], seeds);
    assert!(junit(&workshop, "junit.xml")[2].starts_with("error error "), "an allowance is not for errors");
}

#[test]
fn few_runs_are_shown_one_by_one_and_many_as_a_line_a_scenario() {
    let workshop = Workshop::new();
    let brief = super::workshop::scenario("brief", 1.6).replace("completed = true", "end_state = \"time-limit\"");
    workshop.write("brief.toml", brief.replace("60.0", "0.1"));
    let show = |args: &[&str], code: i32| {
        let args = [&["run", "brief.toml", "--renderer", "cpu", "--jobs", "2"], args].concat();
        workshop.run(&args).expect(code).stdout
    };
    let count = |text: &str, words: &str| text.lines().filter(|line| line.contains(words)).count();
    let few = show(&["--seeds", "1..3"], 0);
    assert_eq!((count(&few, "pass "), count(&few, "3/3"), count(&few, "report.html")), (4, 1, 3), "{few}");
    let many = show(&["--seeds", "1..21"], 0);
    assert_eq!((count(&many, "pass "), count(&many, "21/21"), count(&many, "report.html")), (1, 1, 1), "{many}");
    let failing = show(&["--seeds", "1..21", "--at-least", "20", "--set", "pass.sim_time_s=0.05"], 1);
    assert!(failing.contains("brief: 21 of 21 seeds did not pass, and 20 must"), "{failing}");
    assert_eq!((count(&failing, "at most 0.05"), count(&failing, "and 18 more of brief")), (3, 1), "{failing}");
    assert_eq!((count(&failing, "0/21"), count(&failing, "report.html")), (1, 3), "{failing}");
}

#[test]
fn every_scenario_has_a_line_of_its_own() {
    let workshop = Workshop::new();
    workshop.write("failing.toml", super::workshop::scenario("failing", 1.6) + "sim_time_s = 0.5\n");
    let document = run(&workshop, &["failing.toml", "--seeds", "1..2", "--jobs", "2"]).expect(1).json();
    let told = |field: &str| document["seeds"].as_array().expect("a list").iter().map(|of| of[field].clone()).collect::<Vec<_>>();
    assert_eq!(told("scenario"), ["short", "failing"]);
    assert_eq!((told("passed"), told("verdict")), (vec![json!(2), json!(0)], vec![json!("pass"), json!("fail")]));
    assert_eq!(each(&document, "/seed"), [1, 2, 1, 2]);
    // Two files that say the same would write the same folders.
    workshop.write("again.toml", workshop.read("short.toml"));
    run(&workshop, &["again.toml", "--seeds", "1..2"]).expect(2).saying(&["again.toml", "short.toml", "another `name`"]);
}

#[test]
fn what_cannot_be_meant_is_refused_before_anything_runs() {
    let workshop = Workshop::new();
    let most = "9223372036854775807";
    for (args, words) in [
        (&["--seeds", "5..1"][..], &["--seeds", "runs backwards", "`1..5`"][..]),
        (&["--seeds", ""], &["--seeds", "a seed is missing", "`1..20`"]),
        (&["--seeds", "1..,3"], &["--seeds", "lacks an end"]),
        (&["--seeds", "-3..1"], &["--seeds", "`-3`", most]),
        (&["--seeds", "1..9223372036854775808"], &["--seeds", most]),
        (&["--seeds", "1..100001"], &["--seeds", "100000 is the most", "several calls"]),
        (&["--seeds", "1..3,2"], &["--seeds", "seed 2 is there twice"]),
        (&["--seeds", "1..3", "--seed", "1"], &["--seeds", "--seed", "cannot be used with"]),
        (&["--at-least", "2"], &["--seeds"]),
        (&["--seeds", "1..3", "--at-least", "0"], &["--at-least"]),
        (&["--seeds", "1..3", "--at-least", "4"], &["--at-least 4", "3 seeds only", "3 or fewer", "--seeds"]),
    ] {
        let ran = run(&workshop, args).expect(2).saying(words);
        assert_eq!(ran.json()["runs"], json!([]), "{args:?}");
        assert_eq!(ran.json()["errors"].as_array().map(Vec::len), Some(1), "{args:?}");
    }
    // A folder in the way of any of them is found too.
    run(&workshop, &["--seeds", "1..3"]).expect(0);
    let last = workshop.names("out")[2].clone();
    workshop.write(&format!("out/{last}/scenario.toml"), "another's");
    run(&workshop, &["--seeds", "1..3"]).expect(2).saying(&[&last, "a different scenario", "--force"]);
    run(&workshop, &["--seeds", "1..3", "--force"]).expect(0);
    fs::remove_dir_all(workshop.path("out")).expect("removed");
    run(&workshop, &["--seeds", "1..3", "--out", "short.toml"]).expect(2).saying(&["--out short.toml"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_seeds_that_are_complete_and_gives_no_verdict() {
    let workshop = Workshop::new();
    let args = ["--seeds", "1..200", "--jobs", "2", "--at-least", "1", "--junit", "junit.xml"];
    let mut running = workshop.start(&[&COMMON[..], &args].concat());
    let whole = || workshop.names("out").into_iter().filter(|name| !name.starts_with('.')).collect::<Vec<_>>();
    running.until("two runs' folders", |_| whole().len() >= 2);
    running.signal("INT");
    let ran = running.wait().expect(130).saying(&["interrupted", "of 200 runs are complete"]);
    let document = ran.json();
    let done = each(&document, "/seed").len();
    assert!((2..200).contains(&done), "{done}");
    assert_eq!((whole().len(), workshop.names("out").len()), (done, done), "nothing is left of the others");
    whole().iter().for_each(|name| workshop.assert_whole(name));
    let seeds = json!([{"scenario": "short", "seeds": 200, "passed": done, "at_least": 1, "verdict": null}]);
    assert_eq!(document["seeds"], seeds);
    assert_eq!(junit(&workshop, "junit.xml"), vec!["success"; done]);
}
