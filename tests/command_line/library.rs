//! The library that is built in: listed, run, checked and copied from a folder that knows nothing of it.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use super::workshop::{Workshop, keys, scenario};

/// What `list` shows, as its document has it.
#[track_caller]
fn listed(workshop: &Workshop, words: &[&str]) -> Vec<Value> {
    let args: Vec<_> = ["list", "--json"].iter().chain(words).copied().collect();
    let document = workshop.run(&args).expect(0).json();
    assert_eq!(keys(&document), ["scenarios", "errors"]);
    document["scenarios"].as_array().expect("a list").clone()
}

fn names(rows: &[Value]) -> Vec<&str> {
    rows.iter().map(|row| row["name"].as_str().expect("a name")).collect()
}

/// What stands in the workshop's folder; hidden there is what the program said.
fn visible(workshop: &Workshop) -> Vec<String> {
    workshop.names("").into_iter().filter(|name| !name.starts_with('.')).collect()
}

#[test]
fn the_list_shows_every_scenario_with_its_sentence_theme_by_theme() {
    let workshop = Workshop::new();
    let rows = listed(&workshop, &[]);
    assert_eq!(keys(&rows[0]), ["name", "theme", "about"]);
    // What stands in the folder is in the list, and nothing else.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let document = workshop.run(&["check", root.to_str().expect("a path"), "--json"]).expect(0).json();
    let there = document["scenarios"].as_array().expect("a list");
    let there: BTreeSet<_> = there.iter().filter_map(|row| row["scenario"].as_str()).collect();
    assert_eq!(names(&rows).into_iter().collect::<BTreeSet<_>>(), there);
    assert_eq!(rows.len(), there.len(), "no name comes twice");
    let text = workshop.run(&["list"]).expect(0).stdout;
    for row in &rows {
        let (name, about) = (row["name"].as_str().expect("a name"), row["about"].as_str().expect("a sentence"));
        // Into a pipe each keeps a line of its own.
        let line = text.lines().find(|line| line.trim_start().starts_with(&format!("{name} "))).expect(name);
        assert!(line.ends_with(about), "{line}");
        assert!(text.lines().any(|line| Some(line) == row["theme"].as_str()), "{row}");
    }
}

#[test]
fn words_choose_from_the_list() {
    let workshop = Workshop::new();
    assert_eq!(names(&listed(&workshop, &["Mitre", "LEFT", "fittings"])), ["mitre-45-left", "mitre-left", "vaned-left"]);
    assert!(listed(&workshop, &["faults"]).iter().all(|row| row["theme"] == "faults"));
    workshop.run(&["list", "quite", "absurd"]).expect(2).saying(&["quite absurd: no scenario", "`ductloop list` shows all"]);
    let document = workshop.run(&["list", "absurd", "--json"]).expect(2).json();
    assert_eq!((keys(&document), &document["scenarios"]), (vec!["scenarios", "errors"], &Value::Array(vec![])));
}

#[test]
fn a_name_is_run_rendered_and_checked_from_any_folder() {
    let workshop = Workshop::new();
    workshop.run(&["run", "straight", "--renderer", "cpu", "--set", "time_limit_s=0.5"]).expect(1);
    let ran = &workshop.names("out")[0];
    assert!(ran.starts_with("straight-s1-"), "what is laid over it counts: {ran}");
    assert!(workshop.read(&format!("out/{ran}/scenario.toml")).contains("time_limit_s = 0.5"));
    // The folder's scenario is complete: it runs without the library.
    workshop.run(&["check", &format!("out/{ran}/scenario.toml")]).expect(0);
    workshop.run(&["render", "elbow-left", "--at-s", "0", "--renderer", "cpu"]).expect(0);
    assert!(workshop.path("frame.png").is_file());
    let checked = workshop.run(&["check", "elbow-left", "tees", "elbow-left", "--json", "--plan", "plan.svg"]).expect(0).json();
    let rows = checked["scenarios"].as_array().expect("rows");
    let files: Vec<_> = rows.iter().map(|row| row["file"].as_str().expect("a name")).collect();
    assert_eq!(files, ["library:elbow-left", "library:tees"], "a name that comes twice is one scenario");
    assert!(workshop.path("plan-tees.svg").is_file() && workshop.path("plan-elbow-left.svg").is_file());
}

/// Each fitting's name, and each port of it, is on the plan.
#[test]
fn a_plan_names_fittings_and_their_ports() {
    let workshop = Workshop::new();
    workshop.run(&["check", "tees", "--plan", "plan.svg"]).expect(0);
    let plan = workshop.read("plan.svg");
    let written = |class: &str, word: &str| {
        let begins = format!("<text class=\"{class}\"");
        plan.lines().filter(|line| line.starts_with(&begins) && line.ends_with(&format!(">{word}</text>"))).count()
    };
    // Seven straights, two tees, one bull-head tee.
    assert_eq!(["in", "out", "left", "right"].map(|port| written("port", port)), [10, 9, 2, 2]);
    for name in ["first", "second", "across", "straight-7"] {
        assert_eq!(written("name", name), 1, "{name}");
    }
}

#[test]
fn what_is_wrong_with_what_is_laid_over_one_is_said_with_lines() {
    let workshop = Workshop::new();
    workshop.write("over.toml", "[duct]\nwidth_m = 0.5\nheigth_m = 0.3\n");
    let document = workshop.run(&["check", "elbow-left", "--with", "over.toml", "--json"]).expect(2).json();
    let error = &document["errors"][0];
    assert_eq!((error["file"].as_str(), error["line"].as_u64()), (Some("--with over.toml"), Some(3)), "{error}");
    // Without its tee the branch that stands in the library's own text begins nowhere.
    let document = workshop.run(&["check", "tee-left", "--set", "duct.run=[{ straight_m = 3.0 }]", "--json"]).expect(2).json();
    let error = &document["errors"][0];
    let line =
        ductloop::library::get("tee-left").and_then(|entry| entry.text.lines().position(|line| line.contains("tee-1.left")));
    assert_eq!(
        (error["file"].as_str(), error["line"].as_u64()),
        (Some("library:tee-left"), line.map(|line| line as u64 + 1)),
        "{error}"
    );
}

#[test]
fn what_stands_here_comes_before_the_library() {
    let workshop = Workshop::new();
    let about = |args: &[&str]| {
        let args: Vec<_> = ["check", "--json"].iter().chain(args).copied().collect();
        workshop.run(&args).expect(0).json()["scenarios"][0]["file"].as_str().expect("a file").to_owned()
    };
    assert_eq!(about(&["elbow-left"]), "library:elbow-left");
    workshop.write("scenarios/deep/er/elbow-left.toml", scenario("mine", 1.6));
    assert_eq!(about(&["elbow-left"]), "scenarios/deep/er/elbow-left.toml");
    workshop.write("scenarios/other/elbow-left.toml", scenario("other", 1.6));
    let twice = ["2 scenarios have this name", "scenarios/deep/er/elbow-left.toml", "scenarios/other/elbow-left.toml"];
    workshop.run(&["check", "elbow-left"]).expect(2).saying(&twice);
    workshop.write("scenarios/elbow-left.toml", scenario("top", 1.6));
    assert_eq!(about(&["elbow-left"]), "scenarios/elbow-left.toml");
    workshop.write("elbow-left", scenario("nearest", 1.6));
    assert_eq!(about(&["elbow-left"]), "elbow-left");
}

#[test]
fn names_that_stand_for_nothing_are_told_with_what_they_are_near_to() {
    let workshop = Workshop::new();
    workshop.run(&["run", "elbow-lfet"]).expect(2).saying(&["did you mean `elbow-left`", "`ductloop list` shows"]);
    workshop.run(&["run", "left-elbow"]).expect(2).saying(&["`elbow-left`"]);
    // As the documents have it for the folder of the sources.
    workshop.run(&["run", "scenarios/straight.toml"]).expect(2).saying(&["the library has a `straight`"]);
    let lost = workshop.run(&["run", "quite-absurd"]).expect(2).saying(&["`ductloop list` shows"]);
    assert!(!lost.stderr.contains("did you mean"), "{}", lost.stderr);
    assert_eq!(visible(&workshop), ["short.toml"], "nothing is written");
}

#[test]
fn a_copy_has_the_comments_its_own_name_and_runs() {
    let workshop = Workshop::new();
    let said = workshop.run(&["new", "my-elbow.toml", "--from", "elbow-left"]).expect(0).stdout;
    assert!(
        said.contains("my-elbow.toml: a copy of library:elbow-left") && said.contains("ductloop check my-elbow.toml"),
        "{said}"
    );
    let copy = workshop.read("my-elbow.toml");
    let original = ductloop::library::get("elbow-left").expect("it is there").text;
    let (head, rest) = copy.split_once("\n\n").expect("a head");
    assert!(head.lines().all(|line| line.starts_with('#')) && head.contains("ductloop run my-elbow.toml"), "{head}");
    assert_eq!(rest, original.replace("name = \"elbow-left\"", "name = \"my-elbow\""), "nothing else is another");
    let document = workshop.run(&["check", "my-elbow.toml", "--json"]).expect(0).json();
    assert_eq!(document["scenarios"][0]["scenario"], "my-elbow");

    // Without --from of `straight`; into folders that are made; of a file; as a document.
    let document = workshop.run(&["new", "deep/er/plain.toml", "--json"]).expect(0).json();
    assert_eq!(keys(&document), ["file", "scenario", "from", "errors"]);
    assert_eq!((&document["scenario"], &document["from"]), (&"plain".into(), &"library:straight".into()));
    workshop.run(&["new", "again.toml", "--from", "short.toml", "--quiet"]).expect(0);
    let ran = workshop.run(&["run", "again.toml", "--renderer", "cpu", "--json"]).expect(0).json();
    assert_eq!(ran["runs"][0]["scenario"], "again");
}

/// Each of the library can be started from.
#[test]
fn every_scenario_of_the_library_can_be_copied() {
    let workshop = Workshop::new();
    for (number, entry) in ductloop::library::all().iter().enumerate() {
        workshop.run(&["new", &format!("copies/copy-{number}.toml"), "--from", entry.name]).expect(0);
    }
    workshop.run(&["check", "copies"]).expect(0);
    assert_eq!(workshop.names("copies").len(), ductloop::library::all().len());
}

#[test]
fn nothing_is_written_over_unless_it_is_asked_for() {
    let workshop = Workshop::new();
    workshop.write("mine.toml", "years of work");
    workshop.run(&["new", "mine.toml"]).expect(2).saying(&["mine.toml: this file is there already", "`--force`"]);
    assert_eq!(workshop.read("mine.toml"), "years of work");
    workshop.run(&["new", "mine.toml", "--force"]).expect(0);
    assert!(workshop.read("mine.toml").contains("name = \"mine\""));
    // Not even so over what it is copied from.
    workshop.run(&["new", "mine.toml", "--from", "mine.toml", "--force"]).expect(2).saying(&["would replace mine.toml"]);
    fs::create_dir(workshop.path("folder.toml")).expect("a folder");
    workshop.run(&["new", "folder.toml"]).expect(2);
    workshop.run(&["new", "folder.toml", "--force"]).expect(2).saying(&["folder.toml"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere.toml", workshop.path("link.toml")).expect("a link");
        workshop.run(&["new", "link.toml"]).expect(2).saying(&["there already"]);
    }
    let all: &[&str] = if cfg!(unix) {
        &["folder.toml", "link.toml", "mine.toml", "short.toml"]
    } else {
        &["folder.toml", "mine.toml", "short.toml"]
    };
    assert_eq!(visible(&workshop), all);
}

#[test]
fn what_cannot_be_a_copy_leaves_nothing_behind() {
    let workshop = Workshop::new();
    for (args, said) in [
        (&["new", "no-ending"][..], "ends in .toml"),
        (&["new", "two words.toml"], "letters, digits"),
        (&["new", ".toml"], ".toml"),
        (&["new", "a.toml", "--from", "elbov-left"], "`elbow-left`"),
        (&["new", "a.toml", "--from", "."], "folder"),
        (&["new", "a.toml", "--from", "broken.toml"], "width_m"),
        (&["new", "short.toml/below/a.toml"], "short.toml is not a folder"),
    ] {
        workshop.write("broken.toml", scenario("broken", 1.6).replace("width_m = 0.5\n", ""));
        workshop.run(args).expect(2).saying(&[said]);
        let document = workshop.run(&[args, &["--json"]].concat()).expect(2).json();
        assert_eq!(document["errors"].as_array().map(Vec::len), Some(1), "{document}");
    }
    assert_eq!(visible(&workshop), ["broken.toml", "short.toml"]);
}

/// The device that takes files and keeps none; root may write anywhere, so permissions would not tell.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_file_is_said() {
    let workshop = Workshop::new();
    workshop.run(&["new", "/proc/a.toml"]).expect(2).saying(&["/proc/a.toml", "cannot be written"]);
    workshop.run(&["new", "/dev/full/a.toml"]).expect(2).saying(&["/dev/full is not a folder"]);
}
