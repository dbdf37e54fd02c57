//! A navigator that is a program of its own: a good one completes, and whatever a bad one does is named, with exit code 3, in time.

use std::process::Command;
use std::time::{Duration, Instant};

use super::workshop::Workshop;

/// Speaks the protocol with Python's standard library alone, drives straight ahead, and misbehaves as told after a few frames.
pub(crate) const PROGRAM: &str = r#"
import struct, sys, time
say, hear = sys.stdout.buffer, sys.stdin.buffer
def answer(kind, body):
    say.write(struct.pack("<IB", len(body) + 1, kind) + body)
    say.flush()
frames = 0
while True:
    head = hear.read(5)
    if len(head) < 5:
        break
    length, kind = struct.unpack("<IB", head)
    body = hear.read(length - 1)
    if kind == 1:
        answer(2, b'{"protocol": 1}')
    elif kind == 3:
        frames += 1
        speed = 7.5
        if frames == 5:
            if sys.argv[1] == "die":
                sys.exit(7)
            if sys.argv[1] == "print":
                print("where am I?")
                sys.stdout.flush()
            if sys.argv[1] == "sleep":
                time.sleep(1000)
            if sys.argv[1] == "nan":
                speed = float("nan")
            if sys.argv[1] == "kind":
                answer(9, b"")
        nan = float("nan")
        answer(4, struct.pack("<8dB7x", speed, speed, 0, 0, nan, nan, nan, nan, 1))
    elif kind == 5:
        break
"#;

/// Whether there is a Python with these modules. Where it is missing a test is left out, and says so.
pub(crate) fn python_with(modules: &str) -> bool {
    let there = Command::new("python3").args(["-c", &format!("import {modules}")]).output().is_ok_and(|ran| ran.status.success());
    if !there {
        eprintln!("LEFT OUT: there is no python3 with {modules} here");
        assert!(std::env::var_os("CI").is_none(), "CI must have python3 with {modules}");
    }
    there
}

#[test]
fn the_example_in_python_completes_the_straight() {
    if !python_with("numpy") {
        return;
    }
    let workshop = Workshop::new();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/own_navigator.py");
    let command = format!("python3 '{example}'");
    let ran = workshop.run(&["run", "short.toml", "--renderer", "cpu", "--json", "--navigator", &command]).expect(0);
    let run = &ran.json()["runs"][0];
    assert_eq!(run["metrics"]["completed"], true, "{run}");
    // Its estimates are logged as the robot's own are.
    assert!(run["metrics"]["estimates_valid"].as_f64().is_some_and(|share| share > 0.5), "{run}");
}

#[test]
fn what_a_program_does_wrong_is_named() {
    if !python_with("struct") {
        return;
    }
    let workshop = Workshop::new();
    workshop.write("nav.py", PROGRAM);
    for (how, named) in [
        ("die", "ended (exit status: 7) on the frame of tick 160"),
        ("print", "no message of the protocol"),
        ("sleep", "no answer within 5 s on the frame of tick 160"),
        ("nan", "the left wheels' speed is NaN"),
        ("kind", "a message of kind 9 instead of 4"),
    ] {
        let command = format!("python3 nav.py {how}");
        let args = ["run", "short.toml", "--renderer", "cpu", "--navigator", &command, "--navigator-limit-s", "5", "--json"];
        // The limit holds for starting Python too: a busy machine may need seconds for it, and longer where nothing is to be late.
        let args = args.map(|word| if word == "5" && how != "sleep" { "20" } else { word });
        let started = Instant::now();
        let ran = workshop.run(&args).expect(3);
        assert!(started.elapsed() < Duration::from_secs(60), "{how}");
        let run = &ran.json()["runs"][0];
        assert_eq!(run["verdict"], "error", "{how}: {run}");
        assert!(ran.stdout.contains(named) || ran.stderr.contains(named), "{how}: {}\n{}", ran.stdout, ran.stderr);
    }
}

/// Programs that know nothing of the protocol: one that ends, one that prints, one that neither reads nor writes. The last is ended.
#[cfg(target_os = "linux")]
#[test]
fn programs_of_another_kind_end_the_run_and_nothing_is_left_behind() {
    let workshop = Workshop::new();
    for (program, named) in [
        ("false", "ended (exit status: 1) while greeting"),
        ("echo hello, world", "no message of the protocol while greeting"),
        ("sleep 86.4217", "no answer within 0.3 s while greeting"),
    ] {
        let args = ["run", "short.toml", "--renderer", "cpu", "--navigator", program, "--navigator-limit-s", "0.3"];
        let ran = workshop.run(&args).expect(3);
        assert!(ran.stderr.contains(named), "{program}: {}", ran.stderr);
    }
    let sleeping = std::fs::read_dir("/proc").expect("processes").flatten().any(|entry| {
        std::fs::read(entry.path().join("cmdline")).is_ok_and(|line| String::from_utf8_lossy(&line).contains("86.4217"))
    });
    assert!(!sleeping, "the program is still there");
}

#[test]
fn a_command_that_cannot_be_meant_is_refused_before_anything_runs() {
    let workshop = Workshop::new();
    for (command, named) in [
        ("/nonexistent/navigator --fast", "there is no program `/nonexistent/navigator`"),
        ("  ", "no program is named"),
        ("python3 'nav.py", "the quote ' is not closed"),
    ] {
        let ran = workshop.run(&["run", "short.toml", "--renderer", "cpu", "--navigator", command]).expect(2);
        assert!(ran.stderr.contains(named), "{command}: {}", ran.stderr);
    }
    assert!(workshop.names("out").is_empty());
}
