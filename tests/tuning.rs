//! `ductloop tune`, as it is called: the same best whoever runs it, gone on with after an interrupt, and what is wrong said.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn ductloop(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ductloop")).args(arguments).output().expect("it runs")
}

/// A study of one parameter on a short duct with true errors, in a folder of its own.
fn study(folder: &Path, edit: impl Fn(String) -> String) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let text = std::fs::read_to_string(root.join("studies/smoke.toml")).expect("the study");
    let text = text.replace("\"../straight-offset.toml\"", &format!("{:?}", root.join("straight-offset.toml")));
    let text = edit(text.replace("straight_m = 3.0", "straight_m = 2.0").replace("runs = 24", "runs = 14"));
    let path = folder.join("study.toml");
    std::fs::write(&path, text).expect("it is written");
    path
}

fn tune(study: &Path, out: &Path, more: &[&str]) -> Output {
    let (study, out) = (study.display().to_string(), out.display().to_string());
    ductloop(&[&["tune", &study, "--out", &out], more].concat())
}

/// A file of the only study below a folder.
fn read(folder: &Path, file: &str) -> Vec<u8> {
    let studies: Vec<PathBuf> = std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path()).collect();
    assert_eq!(studies.len(), 1, "{studies:?}");
    std::fs::read(studies[0].join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// On one core and on two, begun anew and gone on with from half of its runs: the same best, the same trials, to the bit.
#[test]
fn the_best_follows_from_the_study_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = study(folder.path(), |text| text);
    let outs = ["one", "two"].map(|name| folder.path().join(name));
    for (out, threads) in outs.iter().zip(["1", "2"]) {
        let told = tune(&file, out, &["--threads", threads, "--json"]);
        assert_eq!(told.status.code(), Some(0), "{}", String::from_utf8_lossy(&told.stderr));
        let document: serde_json::Value = serde_json::from_slice(&told.stdout).expect("one document");
        assert_eq!(document["study"], "smoke");
        let cost = |which: &str| document[which]["costs"]["cost"].as_f64();
        let [best, default] = ["best", "default"].map(|which| cost(which).expect("a cost"));
        assert!(best < default && document["runs"].as_u64().is_some_and(|runs| (12..=14).contains(&runs)), "{document:#}");
        assert_eq!(document["held_out"]["found"][0]["comparisons"]["cost"]["pairs"], 6);
    }
    for file in ["best.toml", "trials.parquet", "summary.json", "study.json"] {
        assert_eq!(read(&outs[0], file), read(&outs[1], file), "{file}");
    }
    assert!(String::from_utf8_lossy(&read(&outs[0], "report.html")).contains("<svg"));
    // Half of its results are lost: they are run again, and nothing else changes.
    let before = read(&outs[0], "summary.json");
    let parts = outs[0].join("smoke/runs/parts");
    let all: Vec<_> = std::fs::read_dir(&parts).expect("parts").flatten().map(|entry| entry.path()).collect();
    for part in all.iter().take(all.len() / 2) {
        std::fs::remove_file(part).expect("it goes");
    }
    assert_eq!(tune(&file, &outs[0], &["--quiet"]).status.code(), Some(0));
    assert_eq!(read(&outs[0], "summary.json"), before);
    // What was found is laid over a scenario.
    let best = outs[0].join("smoke/best.toml").display().to_string();
    let checked = ductloop(&["check", "straight-offset", "--with", &best]);
    assert_eq!(checked.status.code(), Some(0), "{}", String::from_utf8_lossy(&checked.stderr));
}

/// Tracking against effort: a front, each of it an overlay, and what stands for it held out.
#[test]
fn several_objectives_give_a_front() {
    let folder = tempfile::tempdir().expect("a folder");
    let two = "[objective.tracking]\nweights = { lateral_rms_m = 1.0 }\n[objective.effort]\nweights = { control_effort = 1.0 }\n";
    let file = study(folder.path(), |text| {
        text.replace("[objective]\nweights = { lateral_rms_m = 1.0 }\n", two).replace("runs = 14", "runs = 22")
    });
    let out = folder.path().join("out");
    let told = tune(&file, &out, &["--json"]);
    assert_eq!(told.status.code(), Some(0), "{}", String::from_utf8_lossy(&told.stderr));
    let document: serde_json::Value = serde_json::from_slice(&told.stdout).expect("one document");
    assert_eq!(document["optimiser"], "MO-CMA-ES");
    let front = document["front"].as_array().expect("a front");
    assert!(front.len() > 1, "{document:#}");
    let of = |which: &str| -> Vec<f64> { front.iter().filter_map(|trial| trial["costs"][which].as_f64()).collect() };
    for (i, a) in of("tracking").iter().enumerate() {
        for (j, b) in of("tracking").iter().enumerate() {
            assert!(i == j || !(a <= b && of("effort")[i] < of("effort")[j]), "{i} betters {j}");
        }
    }
    for trial in front.iter().filter(|trial| trial["trial"] != 0) {
        let overlay = out.join(format!("smoke/front/{}.toml", trial["trial"]));
        let checked = ductloop(&["check", "straight-offset", "--with", &overlay.display().to_string()]);
        assert_eq!(checked.status.code(), Some(0), "{}", String::from_utf8_lossy(&checked.stderr));
    }
    assert!(document["held_out"]["found"].as_array().is_some_and(|found| !found.is_empty()));
    assert!(String::from_utf8_lossy(&read(&out, "report.html")).contains("The front"));
}

/// A program of thirty lines drives a study; killed and called again it goes on; what is no optimiser is told from one.
#[test]
fn another_program_proposes() {
    if Command::new("python3").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "CI must have python3");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = study(folder.path(), |text| text.replace("runs = 14", "runs = 12"));
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/optimiser.py");
    let command = format!("python3 '{}'", example.display());
    let told = tune(&file, &folder.path().join("a"), &["--optimiser", &command, "--json"]);
    assert_eq!(told.status.code(), Some(0), "{}", String::from_utf8_lossy(&told.stderr));
    let document: serde_json::Value = serde_json::from_slice(&told.stdout).expect("one document");
    assert_eq!((&document["optimiser"], &document["trials"]), (&"(1+1) evolution".into(), &6.into()), "{document:#}");

    // It dies when it is asked for the third time, once.
    let dies = folder.path().join("dies.py");
    std::fs::write(&dies, "import json, os, sys\nasked = 0\nfor line in sys.stdin:\n    word = json.loads(line)['message']\n    \
        if word == 'begin': print(json.dumps({'ready': 'mortal'}), flush=True)\n    \
        if word == 'ask':\n        asked += 1\n        if asked == 3 and not os.path.exists('DIED'):\n            open('DIED', 'w')\n            \
        sys.exit('out of ideas')\n        print(json.dumps({'candidates': [{'control.koh-cho.landing': 0.01 * asked}]}), flush=True)\n"
        .replace("DIED", &folder.path().join("died").display().to_string()))
    .expect("it is written");
    let (out, command) = (folder.path().join("b"), format!("python3 '{}'", dies.display()));
    let told = tune(&file, &out, &["--optimiser", &command]);
    let said = String::from_utf8_lossy(&told.stderr).into_owned();
    assert_eq!(told.status.code(), Some(3), "{said}");
    assert!(said.contains("exit status: 1") && said.contains("out of ideas") && said.contains("optimiser.log"), "{said}");
    let kept = read(&out, "candidates.jsonl");
    let told = tune(&file, &out, &["--optimiser", &command]);
    assert_eq!(told.status.code(), Some(0), "{}", String::from_utf8_lossy(&told.stderr));
    assert!(read(&out, "candidates.jsonl").starts_with(&kept), "what was proposed is not proposed again");

    for (command, words) in
        [("no-such-program", "not found"), ("echo hello; cat >/dev/null", "answered `hello`"), ("", "it is empty")]
    {
        let out = folder.path().join("c");
        let told = tune(&file, &out, &["--optimiser", command]);
        let said = String::from_utf8_lossy(&told.stderr).into_owned();
        assert!(told.status.code() == Some(2) && said.contains(words), "{command}: {said}");
        let begun = std::fs::read_dir(&out).into_iter().flatten().flatten().any(|entry| entry.path().join("study.json").exists());
        assert!(!begun, "no study is left");
    }
}

/// An optimiser that never answers: Ctrl-C ends the study, and with it all that the optimiser has started.
#[cfg(unix)]
#[test]
fn nothing_is_left_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = study(folder.path(), |text| text);
    let mark = folder.path().join("alive");
    // A descendant that says every moment that it lives.
    let mute = format!("echo '{{\"ready\": \"mute\"}}'; (while :; do date >> '{0}'; sleep 0.1; done) & wait", mark.display());
    let out = folder.path().join("out");
    let mut going = Command::new(env!("CARGO_BIN_EXE_ductloop"))
        .args(["tune", &file.display().to_string(), "--out", &out.display().to_string(), "--optimiser", &mute])
        .spawn()
        .expect("it runs");
    let pause = |milliseconds| std::thread::sleep(std::time::Duration::from_millis(milliseconds));
    let until = std::time::Instant::now() + std::time::Duration::from_secs(60);
    while !mark.exists() {
        assert!(std::time::Instant::now() < until, "the optimiser did not come");
        pause(50);
    }
    assert!(Command::new("kill").args(["-INT", &going.id().to_string()]).status().is_ok_and(|status| status.success()));
    assert_eq!(going.wait().expect("it ends").code(), Some(130));
    pause(300);
    let said = std::fs::metadata(&mark).map(|mark| mark.len()).unwrap_or_default();
    pause(1000);
    assert_eq!(std::fs::metadata(&mark).map(|mark| mark.len()).unwrap_or_default(), said, "it lives on");
}

/// One call at a time is at work in a folder.
#[test]
fn a_folder_is_one_calls_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = study(folder.path(), |text| text);
    let place = folder.path().join("out/smoke");
    std::fs::create_dir_all(&place).expect("a folder");
    let lock = std::fs::File::create(place.join("lock")).expect("a file");
    lock.lock().expect("it is nobody else's");
    let told = tune(&file, &folder.path().join("out"), &[]);
    let said = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(told.status.code() == Some(2) && said.contains("another call is at work"), "{said}");
}

#[test]
fn what_is_wrong_is_said_before_anything_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let told = |edit: &dyn Fn(String) -> String, more: &[&str]| {
        let told = tune(&study(folder.path(), edit), &out, more);
        (told.status.code(), String::from_utf8_lossy(&told.stderr).into_owned())
    };
    for (edit, more, words) in [
        (
            &(|text: String| text.replace("from = 0.005, to = 0.1", "from = 0.1, to = 0.005")) as &dyn Fn(String) -> String,
            &[][..],
            "smaller one",
        ),
        (&|text: String| text.replace("control.koh-cho.landing", "control.koh-cho.landings"), &[], "names no field"),
        (&|text: String| text.replace("lateral_rms_m", "lateral_rms"), &[], "no metric of a run"),
        (&|text: String| text.replace("seed = 1001", "seed = 2"), &["--strict"], "trained on and held out"),
    ] {
        let (code, said) = told(edit, more);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(words) && said.contains("study.toml"), "{words}: {said}");
    }
    assert!(!out.exists(), "nothing was begun");
    // Another study in the same folder is left alone.
    std::fs::create_dir_all(out.join("smoke")).expect("a folder");
    std::fs::write(out.join("smoke/study.json"), "{}").expect("it is written");
    let (code, said) = told(&|text| text, &[]);
    assert!(code == Some(2) && said.contains("holds another study") && said.contains("--force"), "{said}");
}

/// A bound that nobody keeps: the study is complete, says which bound it is, and finds nothing.
#[test]
fn constraints_that_no_candidate_keeps_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = study(folder.path(), |text| text.replace("most = { collisions = 0 }", "most = { lateral_rms_m = 1e-9 }"));
    let told = tune(&file, &folder.path().join("out"), &[]);
    let said = String::from_utf8_lossy(&told.stdout).into_owned();
    assert_eq!(told.status.code(), Some(0));
    assert!(said.contains("NO CANDIDATE keeps the constraints") && said.contains("most lateral_rms_m"), "{said}");
    assert!(!folder.path().join("out/smoke/best.toml").exists());
}
