//! Files, folders and names: what an input stands for.

use std::fs;

use super::workshop::{Workshop, scenario};

/// The names of the scenarios that `check` finds.
#[track_caller]
fn found(workshop: &Workshop, args: &[&str]) -> Vec<String> {
    let args: Vec<_> = ["check", "--json"].iter().chain(args).copied().collect();
    let document = workshop.run(&args).expect(0).json();
    let scenarios = document["scenarios"].as_array().expect("scenarios");
    scenarios.iter().map(|scenario| scenario["scenario"].as_str().expect("a name").to_owned()).collect()
}

#[test]
fn a_folder_stands_for_every_scenario_below_it() {
    let workshop = Workshop::new();
    workshop.write("all/b.toml", scenario("b", 1.6));
    workshop.write("all/deep/er/a.toml", scenario("a", 1.6));
    workshop.write("all/looks-like-a-file.toml/c.toml", scenario("c", 1.6));
    workshop.write("all/sweeps/sweep.toml", "format = 1\nkind = \"sweep\"\nfactors = 3\n");
    workshop.write("all/studies/study.toml", "format = 1\nkind = \"study\"\n");
    workshop.write("all/.hidden/d.toml", "neither TOML nor seen");
    workshop.write("all/notes.txt", "not TOML");
    assert_eq!(found(&workshop, &["all"]), ["b", "a", "c"]);
    assert_eq!(found(&workshop, &["all/deep", "all"]), ["a", "b", "c"]);
    // `run` takes the same.
    let ran = workshop.run(&["run", "all", "--json"]).expect(0);
    assert_eq!(ran.json()["runs"].as_array().map(Vec::len), Some(3));
    assert_eq!(workshop.names("out"), ["a", "b", "c"]);
}

/// `ductloop run .` after `ductloop run .` finds the scenarios, not the runs' copies of them.
#[test]
fn the_folders_of_runs_are_left_alone_unless_named() {
    let workshop = Workshop::new();
    workshop.run(&["run", "short.toml"]).expect(0);
    assert_eq!(found(&workshop, &["."]), ["short"]);
    assert_eq!(found(&workshop, &["out/short"]), ["short"]);
    workshop.run(&["check", "out"]).expect(2).saying(&["no scenario file", "folders of runs are left alone"]);
}

#[test]
fn a_name_stands_for_a_file_below_scenarios() {
    let workshop = Workshop::new();
    workshop.write("scenarios/elbow.toml", scenario("elbow", 1.6));
    workshop.write("scenarios/tee.toml", scenario("tee", 1.6));
    assert_eq!(found(&workshop, &["elbow"]), ["elbow"]);
    workshop.run(&["check", "elbov"]).expect(2).saying(&["no elbov.toml below ./scenarios", "did you mean `elbow`"]);
}

#[test]
fn a_folder_without_scenarios_is_an_error() {
    let workshop = Workshop::new();
    fs::create_dir(workshop.path("empty")).expect("a folder");
    workshop.run(&["run", "empty"]).expect(2).saying(&["empty: no scenario file"]);
    workshop.run(&["run", "short.toml/below"]).expect(2).saying(&["short.toml/below: no such file"]);
}

#[cfg(unix)]
#[test]
fn links_in_circles_and_pipes_do_not_hang_it() {
    let workshop = Workshop::new();
    workshop.write("all/a.toml", scenario("a", 1.6));
    for (at, to) in [("all/round", "."), ("all/about", ".."), ("all/again.toml", "a.toml")] {
        std::os::unix::fs::symlink(to, workshop.path(at)).expect("a link");
    }
    let made = std::process::Command::new("mkfifo").arg(workshop.path("all/pipe.toml")).status().expect("mkfifo");
    assert!(made.success());
    // `about` leads to the folder above, where `short` is.
    assert_eq!(found(&workshop, &["all"]), ["a", "short"]);
}

#[test]
fn what_is_no_scenario_by_its_size_is_not_read() {
    let workshop = Workshop::new();
    let large = fs::File::create(workshop.path("large.toml")).expect("a file");
    large.set_len(1 << 40).expect("a file with a hole");
    workshop.run(&["check", "large.toml"]).expect(2).saying(&["large.toml", "larger than"]);
}
