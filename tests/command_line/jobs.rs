//! Several runs at once: the same results in the same order as one after the other, and whole folders or none.

use serde_json::Value;

use super::own_navigator::{PROGRAM, python_with};
use super::workshop::{Workshop, scenario};

/// The document of a call, without what tells the time.
fn timeless(mut document: Value) -> Value {
    for run in document["runs"].as_array_mut().into_iter().flatten() {
        for clock in ["wall_time_s", "real_time_factor"] {
            run["metrics"][clock] = Value::Null;
        }
    }
    document
}

#[test]
fn results_and_their_order_do_not_depend_on_how_many_run_at_once() {
    let workshop = Workshop::new();
    // The first takes longest, so that of two at once it ends last.
    for (name, length_m) in [("a", 3.0), ("b", 1.6), ("c", 1.7)] {
        workshop.write(&format!("all/{name}.toml"), scenario(name, length_m));
    }
    let ran = |out: &str, args: &[&str]| {
        let args: Vec<_> = ["run", "all", "--renderer", "cpu", "--json", "--out", out].iter().chain(args).copied().collect();
        timeless(workshop.run(&args).expect(0).json())
    };
    let one = ran("one", &[]);
    let names: Vec<_> = one["runs"].as_array().expect("runs").iter().map(|run| run["scenario"].clone()).collect();
    assert_eq!(names, ["a", "b", "c"]);
    assert_eq!(ran("two", &["--jobs", "2"]), one);
    assert_eq!(ran("more", &["--jobs", "7", "--threads", "3"]), one);
    let tables = |out: &str| ["a", "b", "c"].map(|name| workshop.files(out)[&format!("{name}/frames.parquet")].clone());
    assert!(tables("two") == tables("one") && tables("more") == tables("one"));

    // The cores are shared out, unless so many threads were asked for; one run alone has them all.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = |folder: &str| {
        let manifest: Value = serde_json::from_str(&workshop.read(&format!("{folder}/manifest.json"))).expect("JSON");
        manifest["threads"].as_u64().expect("a number") as usize
    };
    assert_eq!([threads("one/a"), threads("two/b"), threads("more/c")], [cores, (cores / 2).max(1), 3]);
    workshop.run(&["run", "short.toml", "--jobs", "8", "--quiet"]).expect(0);
    assert_eq!(threads("out/short"), cores);
}

#[test]
fn each_of_several_runs_has_a_navigator_process_of_its_own() {
    if !python_with("struct") {
        return;
    }
    let workshop = Workshop::new();
    workshop.write("nav.py", PROGRAM);
    // Each must say hello before any may go on: it waits until there are three of its kind.
    let waiting = "import os, sys, time\nopen(f'here-{os.getpid()}', 'w').close()\n\
                   while len([f for f in os.listdir('.') if f.startswith('here-')]) < 3: time.sleep(0.01)\n\
                   sys.argv[0] = 'nav.py'\nexec(open('nav.py').read())\n";
    workshop.write("waiting.py", waiting);
    let ran = |out: &str, program: &str, jobs: &str| {
        let navigator = format!("python3 {program} well");
        let limit = ["--navigator-limit-s", "60"];
        let args = ["run", "short.toml", "--renderer", "cpu", "--json", "--seeds", "1..3", "--jobs", jobs, "--out", out];
        let ran = workshop.run(&[&args[..], &["--navigator", &navigator], &limit].concat()).expect(0);
        ran.json()["runs"].as_array().expect("runs").iter().map(|run| run["run_hash"].clone()).collect::<Vec<_>>()
    };
    let together = ran("together", "waiting.py", "3");
    assert_eq!(together.len(), 3);
    assert_eq!(ran("alone", "nav.py", "1"), together);
}

#[test]
fn a_number_of_jobs_that_cannot_be_is_refused() {
    let workshop = Workshop::new();
    for jobs in ["0", "-2", "1025", "two"] {
        workshop.run(&["run", "short.toml", "--jobs", jobs]).expect(2).saying(&["--jobs"]);
    }
    assert!(workshop.names("out").is_empty());
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_runs_that_are_complete_and_ends_all_others() {
    use super::workshop::long;

    let workshop = Workshop::new();
    for name in ["long", "longer", "never"] {
        workshop.write(&format!("{name}.toml"), long(name));
    }
    let args = ["run", "long.toml", "short.toml", "longer.toml", "never.toml", "--jobs", "2", "--json", "--junit", "junit.xml"];
    let mut running = workshop.start(&args);
    running.until("the short run's folder", |_| workshop.path("out/short").exists());
    running.signal("INT");
    let ran = running.wait().expect(130).saying(&["1 of 4 runs are complete"]);
    let document = ran.json();
    assert_eq!(document["runs"].as_array().map(Vec::len), Some(1), "{document}");
    assert_eq!(document["runs"][0]["scenario"], "short");
    assert!(workshop.read("junit.xml").contains("name=\"short\""));
    workshop.assert_whole("short");
    assert_eq!(workshop.names("out"), ["short"]);
}
