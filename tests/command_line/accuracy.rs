//! `accuracy`, and `check` of its files.

use serde_json::Value;

use super::workshop::{Workshop, keys};

fn study(workshop: &Workshop) {
    let text = std::fs::read_to_string("scenarios/studies/accuracy-smoke.toml").expect("the study");
    workshop.write("smoke.toml", text.replace("count = 4", "count = 1"));
}

#[test]
fn a_study_leaves_figures_tables_and_maps() {
    let workshop = Workshop::new();
    study(&workshop);
    let ran = workshop.run(&["accuracy", "smoke.toml", "--json"]).expect(0);
    assert!(ran.stderr.contains("paper"), "{}", ran.stderr);
    let document = ran.json();
    let paper = &document["pipelines"]["paper"];
    assert_eq!(
        keys(paper)[..7],
        ["poses", "detected", "wall_distance_rms_m", "heading_rms_rad", "lateral_rms_m", "nees", "bound_ratio"]
    );
    assert_eq!(keys(&paper["bound_ratio"]), ["wall_distance", "heading", "lateral"]);
    assert_eq!(paper["poses"], 4);
    assert!(paper["wall_distance_rms_m"].as_f64().expect("measured") > 0.0);
    // The paper's chain states no deviations.
    assert_eq!(paper["nees"], Value::Null);
    assert_eq!(document["cells"].as_array().expect("cells").len(), 4);
    assert_eq!(document["cells"][3]["values"]["sensor.preset"], "incra1");
    let names = workshop.names("out/accuracy-smoke");
    assert_eq!(names, ["accuracy.parquet", "manifest.json", "maps", "poses", "report.html", "scenario.toml", "summary.json"]);
    // A map of each rig; where the robot stands is what a map is over.
    let maps = ["paper-heading.svg", "paper-lateral.svg", "paper-wall.svg"];
    let of_both: Vec<_> = ["000", "002"].iter().flat_map(|cell| maps.map(|map| format!("{cell}-{map}"))).collect();
    assert_eq!(workshop.names("out/accuracy-smoke/maps"), of_both);
    let page = workshop.read("out/accuracy-smoke/report.html");
    assert_eq!(
        (page.matches("<details").count(), page.matches("<details open").count(), page.matches("<figure>").count()),
        (2, 1, 6)
    );
    assert!(page.contains("sensor.preset = wide <") && page.contains("sensor.preset = incra1 <"));
    let written: Value = serde_json::from_str(&workshop.read("out/accuracy-smoke/summary.json")).expect("JSON");
    assert_eq!(written, document);
    // The worst pose can be looked at: its picture, and a scenario that starts there.
    let at = &paper["wall_distance_m"]["worst_at"];
    let worst = format!("poses/{:03}-{:06}-paper", at["cell"].as_u64().expect("a cell"), at["pose"].as_u64().expect("a pose"));
    assert!(workshop.files("out/accuracy-smoke").contains_key(&format!("{worst}.png")));
    workshop.run(&["check", &format!("out/accuracy-smoke/{worst}.toml")]).expect(0);
    // Again, on another number of threads: the same table to the byte.
    let table = |workshop: &Workshop| workshop.files("out/accuracy-smoke").remove("accuracy.parquet").expect("the table");
    let before = table(&workshop);
    let silent = workshop.run(&["accuracy", "smoke.toml", "--threads", "3", "--quiet"]).expect(0);
    assert_eq!((silent.stdout.as_str(), silent.stderr.as_str()), ("", ""));
    assert_eq!(table(&workshop), before);
}

#[test]
fn a_bound_that_does_not_hold_exits_1_and_is_named() {
    let workshop = Workshop::new();
    study(&workshop);
    let ran = workshop.run(&["accuracy", "smoke.toml", "--set", "pass.paper.heading_rms_deg=1e-9"]).expect(1);
    assert!(ran.stdout.contains("FAIL paper: heading_rms_deg"), "{}", ran.stdout);
    // What was not measured holds no bound.
    let ran = workshop.run(&["accuracy", "smoke.toml", "--set", "pass.paper.nees=9", "--json"]).expect(1);
    assert_eq!(ran.json()["reasons"][0]["value"], Value::Null);
}

#[test]
fn what_is_wrong_exits_2_before_anything_runs() {
    let workshop = Workshop::new();
    study(&workshop);
    let ran = workshop.run(&["accuracy", "short.toml"]).expect(2);
    assert!(ran.stderr.contains("no accuracy study") && ran.stderr.contains("short.toml:2"), "{}", ran.stderr);
    let ran = workshop.run(&["accuracy", "smoke.toml", "--set", "poses.count=0", "--json"]).expect(2);
    assert!(ran.json()["errors"][0]["message"].as_str().expect("words").contains("`count`"), "{}", ran.stdout);
    let ran = workshop.run(&["accuracy", "missing.toml"]).expect(2);
    assert!(ran.stderr.contains("there is no such file"), "{}", ran.stderr);
    workshop
        .run(&["accuracy", "smoke.toml", "--perception", "robust"])
        .expect(2)
        .saying(&["--perception robust", "--set 'pipelines=[\"robust\"]'"]);
    workshop.run(&["accuracy", "smoke.toml", "--set", "start.lateral_m=0.1"]).expect(2).saying(&["`[grid]`", "start.lateral_m"]);
    // Poses outside the duct are told at once and in words.
    let lateral = workshop.read("smoke.toml").replace("start.lateral_m = [-0.05, 0.05]", "");
    workshop.write("outside.toml", lateral);
    let outside = ["--set", "poses.count=100000", "--set", "poses.lateral_m=[0.35, 0.4]"];
    for command in ["accuracy", "check"] {
        let ran = workshop.run(&[&[command, "outside.toml"], &outside[..]].concat()).expect(2);
        assert!(
            ran.stderr.contains("pose 0 of cell 0 (distance 8.000 m, lateral offset 0.3")
                && ran.stderr.contains("outside the duct"),
            "{}",
            ran.stderr
        );
        assert!(!ran.stderr.contains("Pose"), "{}", ran.stderr);
    }
    // And a study is no scenario.
    let ran = workshop.run(&["run", "smoke.toml"]).expect(2);
    assert!(ran.stderr.contains("ductloop accuracy FILE"), "{}", ran.stderr);
    assert!(!workshop.path("out").exists());
}

#[test]
fn check_knows_studies_and_folders_leave_them_alone() {
    let workshop = Workshop::new();
    study(&workshop);
    let ran = workshop.run(&["check", "smoke.toml"]).expect(0);
    assert!(ran.stdout.contains("smoke.toml: ok") && ran.stdout.contains("cells: 4, poses: 4"), "{}", ran.stdout);
    let both = workshop.run(&["check", "smoke.toml", "short.toml", "--json"]).expect(0).json();
    assert_eq!(both["scenarios"].as_array().expect("rows").len(), 2);
    workshop.write("broken.toml", "format = 1\nkind = \"accuracy\"\nname = \"x\"\n[poses]\ncounts = 3\n");
    let ran = workshop.run(&["check", "broken.toml", "missing.toml"]).expect(2);
    assert!(ran.stderr.contains("unknown key `counts`") && ran.stderr.contains("missing.toml"), "{}", ran.stderr);
}
