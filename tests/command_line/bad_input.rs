//! What is wrong is said with its place and what would be right; the exit code is 2 and nothing is written.

use std::path::Path;

use serde_json::{Value, json};

use super::workshop::{NO_ADAPTER, Ran, Workshop, keys, scenario};

/// A call that is refused before it needs an adapter, and leaves the folder as it was.
#[track_caller]
fn refused(workshop: &Workshop, args: &[&str]) -> Ran {
    let visible = || workshop.names(".").into_iter().filter(|name| !name.starts_with(".streams")).collect::<Vec<_>>();
    let before = visible();
    let ran = workshop.run_with(&NO_ADAPTER, args).expect(2);
    assert_eq!(visible(), before, "nothing is written");
    ran
}

/// The one error of a refused call's document.
#[track_caller]
fn error(ran: &Ran) -> Value {
    let document = ran.json();
    let errors = document["errors"].as_array().expect("errors");
    assert_eq!(errors.len(), 1, "{document}");
    assert_eq!(keys(&errors[0]), ["file", "line", "column", "message", "help", "related"]);
    errors[0].clone()
}

#[test]
fn an_error_in_a_file_has_its_place() {
    let workshop = Workshop::new();
    workshop.write("bad.toml", scenario("bad", 1.6).replace("height_m = 0.3", "height_m = -0.3"));
    let ran = refused(&workshop, &["run", "bad.toml", "--json"]).saying(&["height_m = -0.3", "bad.toml:7:"]);
    assert_eq!(keys(&ran.json()), ["runs", "errors"]);
    assert_eq!(ran.json()["runs"], json!([]));
    let error = error(&ran);
    assert_eq!((&error["file"], &error["line"], &error["column"]), (&json!("bad.toml"), &json!(7), &json!(12)));
    assert!(error["message"].as_str().expect("words").contains("height_m"), "{error}");
}

/// What is wrong between two fittings is told with both, as they are called, each with its line.
#[test]
fn an_error_between_two_fittings_has_both_places() {
    let workshop = Workshop::new();
    let bad = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bad_scenarios");
    for (file, names, lines) in [
        ("branch_of_another_size", &["straight-6.out", "tee-2.left"][..], [13, 12, 8]),
        ("loop_does_not_close", &["straight-6.out", "tee-2.left"], [13, 12, 8]),
        ("branch_overlaps", &["up", "turn"], [16, 12, 0]),
        ("branch_no_such_port", &["straight-3", "tee-1"], [11, 12, 8]),
        ("branch_from_nowhere", &["straight-3", "frist.left"], [11, 12, 0]),
        ("route_turn_not_there", &["straight", "first"], [15, 8, 0]),
        ("start_behind_the_entry", &["along the duct"], [11, 8, 0]),
    ] {
        let text = std::fs::read_to_string(bad.join(file).with_extension("toml")).expect(file);
        workshop.write("bad.toml", text);
        let error = error(&refused(&workshop, &["check", "bad.toml", "--json"]));
        let message = error["message"].as_str().expect("words");
        assert!(names.iter().all(|name| message.contains(name)) && !message.contains("duct.run["), "{message}");
        let related = error["related"].as_array().expect("an array");
        assert!(related.iter().all(|other| keys(other) == ["file", "line", "column", "message"]), "{error}");
        let told: Vec<_> = std::iter::once(&error).chain(related).map(|place| place["line"].as_u64()).collect();
        let expected: Vec<_> = lines.into_iter().filter(|line| *line > 0).map(Some).collect();
        assert_eq!(told, expected, "{error}");
    }
}

/// One wrong file keeps the others from running, and every error of every file is told.
#[test]
fn every_file_is_checked_before_the_first_run() {
    let workshop = Workshop::new();
    workshop.write("two.toml", scenario("two", 1.6).replace("width_m", "widht_m").replace("collisions", "collision"));
    workshop.write("empty.toml", "");
    workshop.write("latin1.toml", b"name = \"\xe9\"".as_slice());
    let ran = refused(&workshop, &["run", "short.toml", "two.toml", "empty.toml", "latin1.toml", "missing.toml", "--json"]);
    let document = ran.json();
    let told = |file: &str| document["errors"].as_array().expect("errors").iter().filter(|error| error["file"] == file).count();
    assert_eq!(["two.toml", "empty.toml", "latin1.toml", "missing.toml"].map(told), [2, 1, 1, 1], "{document:#}");
}

#[test]
fn arguments_are_named() {
    let workshop = Workshop::new();
    let said = |args: &[&str]| {
        let args: Vec<_> = ["run", "short.toml", "--json"].iter().chain(args).copied().collect();
        error(&refused(&workshop, &args))
    };
    let unknown = said(&["--perception", "robots"]);
    assert_eq!(unknown["file"], "--perception robots");
    assert!(unknown["message"].as_str().expect("words").contains("does not know \"robots\""), "{unknown}");
    assert!(unknown["help"].as_str().expect("words").contains("\"robust\", \"paper\", \"truth\""), "{unknown}");

    let set = said(&["--set", "duct.run[3].straight_m=1"]);
    assert_eq!((&set["file"], &set["line"], &set["column"]), (&json!("--set duct.run[3].straight_m=1"), &json!(1), &json!(9)));
    assert!(set["help"].as_str().expect("words").contains("there is one"), "{set}");

    assert_eq!(said(&["--with", "missing.toml"])["file"], "--with missing.toml");
}

/// What begins like an array, a table or a string in quotes is not taken as a word.
#[test]
fn a_setting_that_is_not_quite_toml_is_told_so() {
    let workshop = Workshop::new();
    for (set, column) in [
        ("robot.speed_m_s=[", 18),
        ("duct.run = [{ straight_m = 2.0 }", 33),
        ("surface.brick={ albedo = 0.4", 29),
        ("name=\"short", 12),
        ("name='short", 12),
        ("name=[short]", 7),
    ] {
        let error = error(&refused(&workshop, &["check", "short.toml", "--json", "--set", set]));
        assert_eq!((&error["file"], &error["column"]), (&json!(format!("--set {set}")), &json!(column)), "{error}");
        assert!(error["message"].as_str().expect("words").starts_with("not TOML: "), "{error}");
        assert!(error["help"].as_str().expect("words").contains("single quotes"), "{error}");
    }
}

/// Three hundred digits tell nobody anything.
#[test]
fn huge_and_tiny_numbers_are_shown_by_their_exponents() {
    let workshop = Workshop::new();
    let said = |set: &str| error(&refused(&workshop, &["check", "short.toml", "--json", "--set", set]));
    for (set, message) in [
        ("robot.speed_m_s=1e308", "`robot.speed_m_s` is 1e308 m/s: it must be between 0.01 and 1.2 m/s"),
        ("robot.speed_m_s=-2.5e-300", "`robot.speed_m_s` is -2.5e-300 m/s: it must be between 0.01 and 1.2 m/s"),
        ("robot.speed_m_s=1000000", "`robot.speed_m_s` is 1000000 m/s: it must be between 0.01 and 1.2 m/s"),
        ("robot.centre_of_mass_m=[0.0, 1e99]", "`robot.centre_of_mass_m[1]` is 1e99 m: it must be between -1 and 1 m"),
    ] {
        assert_eq!(said(set)["message"], message);
    }
    for (set, help) in [("seed=1e308", "Feeds every"), ("seed=9223372036854775808", "from 0 to 9223372036854775807: Feeds every")]
    {
        assert!(said(set)["help"].as_str().expect("words").starts_with(help), "{}", said(set));
    }
}

#[test]
fn a_command_line_that_is_not_understood_exits_2() {
    let workshop = Workshop::new();
    let cases: &[(&[&str], &str)] = &[
        (&["run"], "<FILE|DIR|NAME>"),
        (&["fly"], "fly"),
        (&["run", "short.toml", "--speed"], "--speed"),
        (&["run", "short.toml", "--seed", "-1"], "a whole number from 0"),
        (&["run", "short.toml", "--seed", "9223372036854775808"], "a whole number from 0 to 9223372036854775807"),
        (&["run", "short.toml", "--wall-limit-s", "0"], "above zero"),
        (&["run", "short.toml", "--wall-limit-s", "-3"], "above zero"),
        (&["run", "short.toml", "--threads", "0"], "--threads"),
        (&["run", "short.toml", "--renderer", "opengl"], "opengl"),
        (&["render", "short.toml"], "--at-s"),
        (&["render", "short.toml", "--at-s", "-1"], "zero or more"),
        (&["render", "short.toml", "--at-s", "nan"], "zero or more"),
        (&["bench", "--frames", "1"], "--frames"),
        (&["schema", "extra"], "extra"),
    ];
    for (args, word) in cases {
        refused(&workshop, args).saying(&[word]);
    }
}

/// Who asked for a document gets one, whatever went wrong.
#[test]
fn a_command_line_that_is_not_understood_gives_a_document_too() {
    let workshop = Workshop::new();
    let ran = refused(&workshop, &["run", "short.toml", "--json", "--seed", "many"]).saying(&["--seed"]);
    assert_eq!(keys(&ran.json()), ["runs", "errors"]);
    assert!(error(&ran)["message"].as_str().expect("words").contains("'many' for '--seed <N>'"), "{}", ran.stdout);
    assert_eq!(keys(&refused(&workshop, &["check", "--json"]).json()), ["scenarios", "errors"]);
    // After `--` it is the name of a file.
    let ran = refused(&workshop, &["run", "--", "--json"]);
    assert_eq!(ran.stdout, "");
}

#[test]
fn help_and_version_are_no_errors() {
    let workshop = Workshop::new();
    let help = workshop.run(&["--help"]).expect(0);
    for word in ["run", "render", "check", "schema", "bench", "Exit codes"] {
        assert!(help.stdout.contains(word), "{}", help.stdout);
    }
    let help = workshop.run(&["run", "--help"]).expect(0);
    assert!(help.stdout.contains("0 to 9223372036854775807"), "{}", help.stdout);
    assert_eq!(workshop.run(&["--version"]).expect(0).stdout, format!("ductloop {}\n", env!("CARGO_PKG_VERSION")));
}
