//! Ctrl-C and worse: whole folders or none.
#![cfg(unix)]

use super::workshop::{Workshop, long};

#[test]
fn ctrl_c_exits_130_and_leaves_nothing_of_the_run() {
    let workshop = Workshop::new();
    workshop.write("long.toml", long("long"));
    let mut running = workshop.start(&["run", "long.toml", "--json"]);
    running.until_it_simulates();
    running.signal("INT");
    let ran = running.wait().expect(130).saying(&["interrupted", "0 of 1"]);
    assert_eq!(ran.json()["runs"], serde_json::json!([]));
    assert_eq!(workshop.names("out"), Vec::<String>::new());
}

#[test]
fn ctrl_c_leaves_an_earlier_runs_folder_whole() {
    let workshop = Workshop::new();
    workshop.run(&["run", "short.toml"]).expect(0);
    let before = workshop.files("out");
    workshop.write("long.toml", long("short"));
    let mut running = workshop.start(&["run", "long.toml", "--force"]);
    running.until_it_simulates();
    running.signal("INT");
    running.wait().expect(130);
    assert!(workshop.files("out") == before, "{:?}", workshop.names("out"));
}

#[test]
fn ctrl_c_keeps_the_runs_that_are_complete() {
    let workshop = Workshop::new();
    workshop.write("long.toml", long("long"));
    let mut running = workshop.start(&["run", "short.toml", "long.toml", "--json", "--junit", "junit.xml"]);
    running.until("the first run's folder", |_| workshop.path("out/short").exists());
    running.signal("INT");
    let ran = running.wait().expect(130).saying(&["1 of 2"]);
    let document = ran.json();
    assert_eq!(document["runs"].as_array().map(Vec::len), Some(1), "{document}");
    assert_eq!(document["runs"][0]["scenario"], "short");
    assert!(workshop.read("junit.xml").contains("name=\"short\""));
    workshop.assert_whole("short");
    assert_eq!(workshop.names("out"), ["short"]);
}

/// Whether the folder of `short.toml`'s run is being filled by this process.
fn staged(workshop: &Workshop, process: u32) -> bool {
    let is = |name: &String| name.starts_with(".short.tmp-") && name.contains(&format!("-{process}-"));
    workshop.names("out").iter().any(|name| is(name) && workshop.path(&format!("out/{name}/scenario.toml")).exists())
}

/// A run that is being written has been simulated: it is finished.
#[test]
fn ctrl_c_while_the_folder_is_written_lets_it_be_finished() {
    let workshop = Workshop::new();
    let mut running = workshop.start(&["run", "short.toml"]);
    let process = running.id();
    let staged = || staged(&workshop, process);
    running.until("the writing", |_| staged() || workshop.path("out/short").exists());
    running.signal("INT");
    running.wait().expect(0);
    workshop.assert_whole("short");
    assert_eq!(workshop.names("out"), ["short"]);
}

#[test]
fn a_kill_in_mid_run_leaves_no_folder() {
    let workshop = Workshop::new();
    workshop.write("long.toml", long("long"));
    let mut running = workshop.start(&["run", "long.toml"]);
    running.until_it_simulates();
    running.signal("KILL");
    assert_eq!(running.wait().code, None);
    assert_eq!(workshop.names("out"), Vec::<String>::new());
}

#[test]
fn a_kill_while_the_folder_is_written_leaves_the_old_one_and_disturbs_nothing() {
    let workshop = Workshop::new();
    workshop.run(&["run", "short.toml"]).expect(0);
    let before = workshop.files("out/short");
    let mut running = workshop.start(&["run", "short.toml"]);
    let process = running.id();
    let staged = || staged(&workshop, process);
    running.until("the writing", |_| staged());
    running.signal("KILL");
    assert_eq!(running.wait().code, None);
    workshop.assert_whole("short");
    // Where the signal came before the folder was put in its place, the old one stands untouched.
    if staged() {
        assert!(workshop.files("out/short") == before);
    }

    // What is left of the staged folder is hidden: neither the next run nor a search for scenarios minds it.
    workshop.run(&["run", "short.toml"]).expect(0);
    workshop.assert_whole("short");
    if cfg!(target_os = "linux") {
        assert_eq!(workshop.names("out"), ["short"], "the next run clears it up");
    }
    let ran = workshop.run(&["check", ".", "--json"]).expect(0);
    assert_eq!(ran.json()["scenarios"].as_array().map(Vec::len), Some(1), "{}", ran.stdout);
}

#[test]
fn ctrl_c_stops_a_rendering() {
    let workshop = Workshop::new();
    workshop.write("long.toml", long("long"));
    let mut running = workshop.start(&["render", "long.toml", "--at-s", "35", "--out", "frame.png"]);
    running.until_it_simulates();
    running.signal("INT");
    running.wait().expect(130).saying(&["interrupted"]);
    assert!(!workshop.path("frame.png").exists() && !workshop.path("frame.json").exists());
}
