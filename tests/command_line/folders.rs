//! A run's folder: its name, what it replaces, and that nothing else is touched.

use std::fs;

use super::workshop::{Workshop, long, scenario};

/// Another scenario of the same name as `short.toml`.
fn another() -> String {
    scenario("short", 1.7)
}

#[test]
fn the_same_scenario_replaces_its_own_folder() {
    let workshop = Workshop::new();
    workshop.run(&["run", "short.toml"]).expect(0);
    workshop.write("out/short/frames/old.png", "from the run before");
    workshop.write("out/short/notes.txt", "from the run before");
    // What is typed differently and resolves to the same is the same.
    workshop.write("again.toml", format!("# The same, written at length.\n{}settle_m = 0.0\n", scenario("short", 1.6)));
    workshop.run(&["run", "again.toml"]).expect(0);
    workshop.assert_whole("short");
    let files = workshop.files("out/short");
    assert!(!files.contains_key("frames/old.png") && !files.contains_key("notes.txt"), "{:?}", files.keys());
    assert_eq!(workshop.names("out"), ["short"]);
}

#[test]
fn another_scenarios_folder_needs_force() {
    let workshop = Workshop::new();
    workshop.run(&["run", "short.toml"]).expect(0);
    let before = workshop.files("out");
    workshop.write("another.toml", another());
    workshop.run(&["run", "another.toml"]).expect(2).saying(&["out/short", "different scenario", "--force", "--out"]);
    assert!(workshop.files("out") == before, "nothing is changed");
    workshop.run(&["run", "another.toml", "--force"]).expect(0);
    workshop.assert_whole("short");
    assert!(workshop.read("out/short/scenario.toml").contains("1.7"));
}

#[test]
fn what_is_not_a_runs_folder_is_left_alone_even_with_force() {
    let workshop = Workshop::new();
    workshop.write("out/short/thesis.txt", "the only copy");
    workshop.run(&["run", "short.toml", "--force"]).expect(2).saying(&["out/short", "not a run's folder"]);
    assert_eq!(workshop.read("out/short/thesis.txt"), "the only copy");
    assert_eq!(workshop.files("out").len(), 1);
    // An empty folder is nobody's.
    fs::create_dir_all(workshop.path("empty/short")).expect("a folder");
    workshop.run(&["run", "short.toml", "--out", "empty"]).expect(0);
}

#[test]
fn a_changed_scenario_has_a_folder_of_its_own() {
    let workshop = Workshop::new();
    workshop.run(&["run", "short.toml"]).expect(0);
    workshop.run(&["run", "short.toml", "--seed", "7"]).expect(0);
    workshop.run(&["run", "short.toml", "--set", "robot.speed_m_s=0.25"]).expect(0);
    let names = workshop.names("out");
    assert_eq!(names.len(), 3, "{names:?}");
    assert_eq!(names[0], "short");
    for (name, prefix) in names[1..].iter().zip(["short-s1-", "short-s7-"]) {
        let digits = name.strip_prefix(prefix).unwrap_or_else(|| panic!("{names:?}"));
        assert!(digits.len() == 8 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()), "{names:?}");
        workshop.assert_whole(name);
    }
    assert!(workshop.read(&format!("out/{}/scenario.toml", names[2])).contains("seed = 7"));
    // The same again replaces it.
    workshop.run(&["run", "short.toml", "--seed", "7"]).expect(0);
    assert_eq!(workshop.names("out"), names);
}

#[test]
fn two_inputs_of_one_name_are_refused() {
    let workshop = Workshop::new();
    workshop.write("another.toml", another());
    workshop.run(&["run", "short.toml", "another.toml"]).expect(2).saying(&["another.toml", "short.toml", "`name`"]);
    assert_eq!(workshop.files("out").len(), 0);
    // One file named twice is one run.
    let ran = workshop.run(&["run", "short.toml", "./short.toml", "--json"]).expect(0);
    assert_eq!(ran.json()["runs"].as_array().map(Vec::len), Some(1));
}

/// Found before anything simulates, so that it takes no adapter and leaves nothing.
#[test]
fn a_place_that_cannot_be_written_is_refused_beforehand() {
    let workshop = Workshop::new();
    workshop.write("file", "in the way");
    let no_adapter = [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent"), ("WGPU_BACKEND", "noop")];
    let refused = |args: &[&str], words: &[&str]| {
        let args: Vec<_> = ["run", "short.toml"].iter().chain(args).copied().collect();
        workshop.run_with(&no_adapter, &args).expect(2).saying(words);
    };
    refused(&["--out", "file"], &["--out file", "not a folder"]);
    refused(&["--out", "file/below"], &["--out file/below", "not a folder"]);
    refused(&["--junit", "file/junit.xml"], &["--junit file/junit.xml", "not a folder"]);
    fs::create_dir(workshop.path("folder")).expect("a folder");
    refused(&["--junit", "folder"], &["--junit folder", "is a folder"]);
    refused(&["--out", ""], &["--out"]);
    // `--junit scenarios/*.toml`: the shell's first file is no place for a report.
    let scenario = workshop.read("short.toml");
    refused(&["--junit", "short.toml"], &["--junit short.toml", "out/junit.xml"]);
    assert_eq!(workshop.read("short.toml"), scenario);
    if cfg!(target_os = "linux") {
        // Root may write anywhere but here.
        refused(&["--out", "/proc/out"], &["error: --out /proc/out: cannot create", "choose another place"]);
        refused(&["--junit", "/proc/junit.xml"], &["--junit /proc/junit.xml: cannot be written", "choose another place"]);
    }
    workshop.write("out/short", "in the way");
    refused(&[], &["out/short", "is a file", "move it away", "--out"]);
    assert_eq!(workshop.names("out"), ["short"]);
    assert_eq!(workshop.names("folder"), Vec::<String>::new());
}

/// A pipe that a CI server reads stays a pipe, and a link stays a link to what is then the report.
#[cfg(unix)]
#[test]
fn what_is_not_a_regular_file_is_refused_and_links_are_followed() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let workshop = Workshop::new();
    let made = std::process::Command::new("mkfifo").arg(workshop.path("pipe")).status().expect("mkfifo");
    assert!(made.success());
    symlink("pipe", workshop.path("frame.json")).expect("a link");
    symlink("round.xml", workshop.path("round.xml")).expect("a link");
    let before = workshop.names(".");
    let words = ["is a named pipe", "only a regular file", "name a regular file"];
    for args in [&["run", "short.toml", "--junit", "pipe"][..], &["render", "short.toml", "--at-s", "0"]] {
        workshop.run(args).expect(2).saying(&words);
    }
    workshop.run(&["run", "short.toml", "--junit", "round.xml"]).expect(2).saying(&["--junit round.xml: cannot be written"]);
    let after: Vec<_> = workshop.names(".").into_iter().filter(|name| !name.starts_with(".streams")).collect();
    assert_eq!(after, before, "nothing is written");
    assert!(fs::metadata(workshop.path("pipe")).expect("it").file_type().is_fifo());

    workshop.write("deep/there.xml", "from the run before");
    symlink("deep/there.xml", workshop.path("link.xml")).expect("a link");
    symlink("link.xml", workshop.path("link-to-link.xml")).expect("a link");
    symlink("deep/new.json", workshop.path("picture.json")).expect("a link");
    workshop.run(&["run", "short.toml", "--junit", "link-to-link.xml"]).expect(0);
    workshop.run(&["render", "short.toml", "--at-s", "0", "--out", "picture.png"]).expect(0);
    assert!(workshop.read("deep/there.xml").contains("<testsuite"));
    assert!(workshop.read("deep/new.json").contains("\"truth\""));
    for link in ["link.xml", "link-to-link.xml", "picture.json"] {
        assert!(fs::symlink_metadata(workshop.path(link)).expect("it").is_symlink(), "{link}");
    }
    assert_eq!(workshop.names("deep"), ["new.json", "there.xml"]);
}

#[test]
fn a_folder_that_goes_while_the_run_is_on_is_made_again() {
    let workshop = Workshop::new();
    workshop.write("out/other/file", "somebody's");
    workshop.write("long.toml", long("long"));
    let mut running = workshop.start(&["run", "long.toml"]);
    running.until_it_simulates();
    // It must not end between the look and the removal.
    running.signal("STOP");
    assert!(!workshop.names("out").contains(&"long".into()), "it ended before its folder went");
    fs::remove_dir_all(workshop.path("out")).expect("removed");
    running.signal("CONT");
    running.wait().expect(0);
    workshop.assert_whole("long");
}
