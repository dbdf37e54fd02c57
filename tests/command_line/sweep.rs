//! Sweeps: every step, what a killed or damaged one leaves, and what is refused.

use std::collections::BTreeMap;
use std::fs;
use std::time::Duration;

use crate::workshop::Workshop;
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

/// Runs of 0.3 m: a tenth of a second each.
const SWEEP: &str = r#"format = 1
kind = "sweep"
name = "small"
base = "short.toml"
replicates = 2
[factor]
duct.width_m = [0.4, 0.5, 0.6]
robot.speed_m_s = [0.3, 0.5]
[scenario]
duct.run = [{ straight_m = 1.3 }]
perception.pipeline = "truth"
"#;

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("small.toml", SWEEP);
    workshop
}

/// A table's rows; none where there is no such file any more.
fn batches(workshop: &Workshop, path: &str) -> Vec<RecordBatch> {
    let Ok(bytes) = fs::read(workshop.path(path)) else { return Vec::new() };
    let reader = ParquetRecordBatchReaderBuilder::try_new(bytes::Bytes::from(bytes)).expect("Parquet").build().expect("a reader");
    reader.map(|batch| batch.expect("rows")).collect()
}

/// How long each case took, by its hash: another run of it takes another time.
fn wall_times(workshop: &Workshop, path: &str) -> BTreeMap<String, f64> {
    let mut times = BTreeMap::new();
    for batch in batches(workshop, path) {
        let hashes = batch.column_by_name("hash").expect("hashes").as_string::<i32>().clone();
        let spent = batch.column_by_name("wall_time_s").expect("times").as_primitive::<Float64Type>().clone();
        times.extend((0..batch.num_rows()).map(|row| (hashes.value(row).to_owned(), spent.value(row))));
    }
    times
}

/// Rows of a table by the hash of their case, each with all but what depends on the machine.
fn rows(workshop: &Workshop, path: &str) -> BTreeMap<String, String> {
    let mut rows = BTreeMap::new();
    for batch in batches(workshop, path) {
        let kept: Vec<usize> = batch
            .schema()
            .fields()
            .iter()
            .enumerate()
            .filter(|(_, field)| !["wall_time_s", "real_time_factor", "host"].contains(&field.name().as_str()))
            .map(|(index, _)| index)
            .collect();
        let hash = batch.column_by_name("hash").expect("hashes").as_string::<i32>().clone();
        let kept: RecordBatch = batch.project(&kept).expect("columns");
        for row in 0..kept.num_rows() {
            let twice = rows.insert(hash.value(row).to_owned(), format!("{:?}", kept.slice(row, 1).columns()));
            assert_eq!(twice, None, "this case has two rows");
        }
    }
    rows
}

/// One call on two cores, the steps over two shards, and one core give the same table.
#[test]
fn steps_and_threads_give_the_same_table() {
    let workshop = workshop();
    let whole = workshop.run(&["sweep", "small.toml", "--threads", "2", "--json"]);
    assert_eq!(whole.code, Some(0), "{whole:?}");
    let summary = whole.json();
    assert_eq!((&summary["all"]["cases"], &summary["verdict"]), (&12.into(), &"pass".into()), "{summary:#}");
    assert_eq!(summary["points"].as_array().map(Vec::len), Some(6));
    let plan = workshop.run(&["sweep", "plan", "small.toml", "--out", "s", "--json"]);
    assert_eq!((plan.code, &plan.json()["cases"]), (Some(0), &12.into()), "{plan:?}");
    let early = workshop.run(&["sweep", "merge", "s"]);
    assert_eq!(early.code, Some(2), "{early:?}");
    assert!(early.stderr.contains("12 of 12 cases are not done"), "{early:?}");
    for shard in ["1/2", "2/2"] {
        let worked = workshop.run(&["sweep", "work", "s", "--shard", shard, "--threads", "1", "--json"]);
        assert_eq!((worked.code, &worked.json()["ran"]), (Some(0), &6.into()), "{worked:?}");
    }
    let status = workshop.run(&["sweep", "status", "s", "--json"]);
    assert_eq!((&status.json()["done"], &status.json()["missing"]), (&12.into(), &0.into()), "{status:?}");
    let merged = workshop.run(&["sweep", "merge", "s"]);
    assert_eq!(merged.code, Some(0), "{merged:?}");
    let table = rows(&workshop, "out/small/results.parquet");
    assert_eq!(table.len(), 12);
    assert_eq!(table, rows(&workshop, "s/results.parquet"));
    assert!(workshop.read("out/small/report.html").contains("duct.width_m"));
}

/// The command that the report gives for a case makes the very run.
#[test]
fn a_case_is_repeated_alone() {
    let workshop = workshop();
    assert_eq!(workshop.run(&["sweep", "small.toml", "--quiet", "--set", "scenario.pass.lateral_rms_mm=1e-9"]).code, Some(0));
    let folder = workshop.names("out").into_iter().next().expect("a folder");
    let page = workshop.read(&format!("out/{folder}/report.html"));
    let command = page.split("<code>ductloop ").nth(1).and_then(|rest| rest.split("</code>").next()).expect("a command");
    let command = command.replace("&#x27;", "'").replace("&quot;", "\"").replace("&#x2f;", "/");
    let words: Vec<String> = command.split(' ').map(|word| word.trim_matches('\'').to_owned()).collect();
    // The setting with a space in it comes apart at spaces: put it together again as the shell does.
    let mut args: Vec<String> = Vec::new();
    for word in words {
        match args.last_mut().filter(|last| last.contains("[{") && !last.contains("}]")) {
            Some(last) => *last += &format!(" {word}"),
            None => args.push(word),
        }
    }
    args.push("--json".into());
    let ran = workshop.run(&args.iter().map(String::as_str).collect::<Vec<_>>());
    let hash = ran.json()["runs"][0]["run_hash"].as_str().expect("a hash").to_owned();
    let table = rows(&workshop, &format!("out/{folder}/results.parquet"));
    assert!(table.values().any(|row| row.contains(&hash)), "{hash} is not in the table: {args:?}");
}

/// Killed at any moment, the next call does what is missing and nothing twice; a part that was damaged is named and redone.
#[test]
fn interrupted_is_not_lost() {
    let workshop = workshop();
    let args = ["sweep", "small.toml", "--threads", "1", "--set", "replicates=4"];
    let finished =
        |folder: &str| workshop.names(&format!("out/{folder}/parts")).iter().filter(|name| name.ends_with(".parquet")).count();
    let running = workshop.start(&args);
    let folder = loop {
        std::thread::sleep(Duration::from_millis(20));
        if let Some(folder) = workshop.names("out").into_iter().next().filter(|folder| finished(folder) >= 3) {
            break folder;
        }
    };
    running.signal("KILL");
    assert_eq!(running.wait().code, None);
    let done = finished(&folder);
    assert!((3..24).contains(&done), "{done}");
    // A part that is cut, one with a bit that has turned, and what a killed writer leaves.
    let parts = workshop.names(&format!("out/{folder}/parts"));
    let path = |name: &str| workshop.path(&format!("out/{folder}/parts/{name}"));
    let whole = fs::read(path(&parts[0])).expect("a part");
    fs::write(path(&parts[0]), &whole[..whole.len() / 2]).expect("a file");
    let mut turned = fs::read(path(&parts[1])).expect("a part");
    let middle = turned.len() / 3;
    turned[middle] ^= 4;
    fs::write(path(&parts[1]), turned).expect("a file");
    fs::write(path("half.parquet#1"), "ha").expect("a file");
    let status = workshop.run(&["sweep", "status", &format!("out/{folder}")]);
    assert!(status.stderr.contains(&parts[0]), "{status:?}");
    // All that was done and is whole is found, all else is run.
    let work = workshop.run(&["sweep", "work", &format!("out/{folder}"), "--json"]);
    assert!(work.stderr.contains(&parts[0]) && work.stderr.contains("run again"), "{work:?}");
    assert_eq!((&work.json()["found"], &work.json()["ran"]), (&(done - 2).into(), &(26 - done).into()), "{done}: {work:?}");
    let again = workshop.run(&args);
    assert_eq!(again.code, Some(0), "{again:?}");
    let third = workshop.run(&["sweep", "work", &format!("out/{folder}"), "--json"]);
    assert_eq!((&third.json()["ran"], &third.json()["found"]), (&0.into(), &24.into()), "{third:?}");
    // The same sweep made in one go.
    assert_eq!(workshop.run(&["sweep", "small.toml", "--set", "replicates=4", "--out", "other", "--quiet"]).code, Some(0));
    let other = workshop.names("other").into_iter().next().expect("a folder");
    assert_eq!(
        rows(&workshop, &format!("out/{folder}/results.parquet")),
        rows(&workshop, &format!("other/{other}/results.parquet"))
    );
}

/// Killed three times: nothing that was finished is run again, the table is that of a sweep that
/// nobody killed, and what killed workers left in parts of their own, or half written, is cleared away.
#[test]
fn killed_three_times_nothing_finished_is_run_again() {
    let workshop = workshop();
    let text = SWEEP.replace("replicates = 2", "replicates = 5");
    workshop.write("long.toml", text);
    let cases = 6 * 5;
    let (parts, call) = ("out/small/parts", ["sweep", "long.toml", "--threads", "2", "--quiet"]);
    let finished = || -> BTreeMap<String, f64> {
        let names = workshop.names(parts).into_iter().map(|name| format!("{parts}/{name}"));
        // One may be packed while this looks; what is half written has another ending.
        names.filter(|name| name.ends_with(".parquet")).flat_map(|name| wall_times(&workshop, &name)).collect()
    };
    let mut known = BTreeMap::new();
    for least in [3, 10, 20] {
        let mut running = workshop.start(&call);
        running.until("so many cases", |_| finished().len() >= least);
        running.signal("KILL");
        assert_eq!(running.wait().code, None);
        let now = finished();
        assert!(now.len() >= least && now.len() < cases, "{} of {cases} when killed", now.len());
        for (hash, spent) in &known {
            assert_eq!(now.get(hash), Some(spent), "{hash} was run again");
        }
        known = now;
    }
    workshop.write(&format!("{parts}/old.parquet#1"), "ha");
    workshop.write(&format!("{parts}/new.parquet#1"), "ha");
    #[allow(clippy::disallowed_methods, reason = "the age of a file, which no result has to do with")]
    let old = std::time::SystemTime::now() - Duration::from_secs(7200);
    let half = fs::File::options().write(true).open(workshop.path(&format!("{parts}/old.parquet#1"))).expect("a file");
    half.set_modified(old).expect("a time");
    workshop.run(&call).expect(0);
    let table = wall_times(&workshop, "out/small/results.parquet");
    assert_eq!(table.len(), cases);
    for (hash, spent) in &known {
        assert_eq!(table.get(hash), Some(spent), "{hash} was run again");
    }
    let left: Vec<_> = workshop.names(parts).into_iter().filter(|name| !name.starts_with("pack-")).collect();
    let has = |name: &str| left.iter().any(|other| other == name);
    assert!(has("new.parquet#1") && !has("old.parquet#1"), "{left:?}");
    assert!(left.iter().filter(|name| name.ends_with(".parquet")).count() <= 1, "{left:?}");
    // The same sweep that nobody killed.
    workshop.run(&["sweep", "long.toml", "--out", "other", "--quiet"]).expect(0);
    assert_eq!(rows(&workshop, "out/small/results.parquet"), rows(&workshop, "other/small/results.parquet"));
}

/// A case that cannot be, and one that takes too long, are rows; the sweep goes on.
#[test]
fn cases_that_cannot_go_on_are_rows() {
    let workshop = workshop();
    let narrow = SWEEP.replace("[0.4, 0.5, 0.6]", "[0.1, 0.5]").replace("replicates = 2", "wall_limit_s = 60");
    workshop.write("narrow.toml", &narrow);
    let ran = workshop.run(&["sweep", "narrow.toml", "--json"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.stderr.contains("of 4 points looked at 2 are no possible scenario"), "{ran:?}");
    assert_eq!((&ran.json()["all"]["error"], &ran.json()["all"]["pass"]), (&2.into(), &2.into()), "{ran:?}");
    let table = rows(&workshop, "out/small/results.parquet");
    assert_eq!(table.values().filter(|row| row.contains("no scenario")).count(), 2, "{table:?}");
    let ran = workshop.run(&[
        "sweep",
        "small.toml",
        "--set",
        "wall_limit_s=0.001",
        "--json",
        "--out",
        "slow",
        "--set",
        "pass.timeouts=0",
    ]);
    assert_eq!((ran.code, &ran.json()["all"]["timeout"]), (Some(1), &12.into()), "{ran:?}");
    // Nothing possible at all is not begun.
    workshop.write("none.toml", narrow.replace("[0.1, 0.5]", "[0.1, 0.12]"));
    let ran = workshop.run(&["sweep", "none.toml", "--out", "none"]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(workshop.names("none").is_empty());
}

/// A point is repeated until its pass rate is known well enough, the same ones on one core and on two.
#[test]
fn a_stopping_rule_spares_cases_and_is_the_same_on_any_number_of_cores() {
    let workshop = workshop();
    let text = SWEEP.replace("replicates = 2", "replicates = 9").replace(", 0.6]", "]").replace("[0.3, 0.5]", "[0.5]");
    workshop.write("stop.toml", format!("{text}[stop]\npass_rate_half_width = 0.25\nleast_replicates = 2\n"));
    for threads in ["1", "2"] {
        let ran = workshop.run(&["sweep", "stop.toml", "--threads", threads, "--json", "--out", threads]);
        // Wilson's interval of 4 passes in 4 is 0.51 to 1.
        let summary = ran.json();
        assert_eq!((&summary["all"]["cases"], &summary["spared"]), (&8.into(), &10.into()), "{summary:#}");
    }
    assert_eq!(rows(&workshop, "1/small/results.parquet"), rows(&workshop, "2/small/results.parquet"));
}

/// Points that a design draws twice are run once and have a row each.
#[test]
fn equal_points_have_a_row_each() {
    let workshop = workshop();
    let text = SWEEP.replace("replicates = 2", "design = \"random\"\nsamples = 6").replace("[0.4, 0.5, 0.6]", "[0.4, 0.5]");
    workshop.write("drawn.toml", text.replace("[0.3, 0.5]", "[0.5]"));
    let ran = workshop.run(&["sweep", "drawn.toml", "--json"]).expect(0);
    assert_eq!((&ran.json()["all"]["cases"], &ran.json()["missing"]), (&6.into(), &0.into()), "{ran:?}");
    assert_eq!(workshop.run(&["sweep", "status", "out/small", "--json"]).expect(0).json()["done"], 6);
    workshop.run(&["sweep", "merge", "out/small"]).expect(0);
    // The same sweep by another name of its file is the same sweep.
    workshop.run(&["sweep", "./drawn.toml", "--set", "about=other words", "--out", "out", "--quiet"]).expect(0);
}

/// What is not whole has not passed, and a plan that was edited is none.
#[test]
fn what_is_not_whole_has_not_passed() {
    let workshop = workshop();
    workshop.run(&["sweep", "plan", "small.toml", "--out", "s", "--quiet"]).expect(0);
    workshop.run(&["sweep", "work", "s", "--shard", "1/2", "--quiet"]).expect(0);
    let partial = workshop.run(&["sweep", "merge", "s", "--partial", "--json"]).expect(1);
    assert_eq!((&partial.json()["verdict"], &partial.json()["missing"]), (&"incomplete".into(), &6.into()), "{partial:?}");
    let plan = workshop.read("s/plan.json");
    for (from, to) in
        [("\"replicates\": 2", "\"replicates\": 0"), ("\"format\": 1", "\"format\": 99"), ("\"seed\": 1", "\"seed\": 5")]
    {
        assert!(plan.contains(from), "{plan}");
        workshop.write("s/plan.json", plan.replacen(from, to, 1));
        workshop.run(&["sweep", "status", "s"]).expect(2).saying(&["was changed since it was written"]);
    }
}

/// What is wrong is said before anything runs.
#[test]
fn what_cannot_be_planned_is_refused() {
    let workshop = workshop();
    workshop.write("there/file", "mine");
    workshop.write("file", "mine");
    assert_eq!(workshop.run(&["sweep", "plan", "small.toml", "--out", "s", "--quiet"]).code, Some(0));
    for (args, words) in [
        (vec!["sweep", "none.toml"], "no such file"),
        (vec!["sweep", "short.toml"], "no sweep"),
        (vec!["sweep", "small.toml", "--set", "factor.duct.width=[0.5]"], "names no field"),
        (vec!["sweep", "small.toml", "--set", "replicates=9000"], "--yes"),
        (vec!["sweep", "small.toml", "--out", "file"], "not a folder"),
        (vec!["sweep", "small.toml", "--out", "/proc"], "/proc"),
        (vec!["sweep", "plan", "small.toml", "--out", "there"], "left alone"),
        (vec!["sweep", "plan", "small.toml", "--out", "s", "--set", "seed=2"], "another sweep"),
        (vec!["sweep", "work", "none"], "no such folder"),
        (vec!["sweep", "work", "there"], "holds no plan.json"),
        (vec!["sweep", "work", "s", "--shard", "3/2"], "1/2 to 2/2"),
        (vec!["sweep", "work", "s", "--shard", "0/2"], "1/2 to 2/2"),
        (vec!["sweep", "work", "s", "--shard", "1/99"], "6 points"),
        (vec!["sweep", "merge", "there"], "holds no plan.json"),
        (vec!["sweep", "small.toml", "--perception", "paper"], "scenario.perception.pipeline"),
        (vec!["run", "small.toml"], "sweep"),
    ] {
        let ran = workshop.run(&args);
        assert_eq!(ran.code, Some(2), "{args:?}: {ran:?}");
        assert!(ran.stderr.contains(words), "{args:?}: {ran:?}");
    }
    assert!(workshop.names("out").is_empty(), "{:?}", workshop.names("out"));
    assert_eq!(workshop.run(&["sweep", "plan", "small.toml", "--out", "s", "--set", "seed=2", "--force"]).code, Some(0));
    // Another build's plan is not worked on.
    let plan = workshop.read("s/plan.json");
    let build = plan.split("\"build\": \"").nth(1).and_then(|rest| rest.get(..32)).expect("a build").to_owned();
    workshop.write("s/plan.json", plan.replace(&build, &"0".repeat(32)));
    let ran = workshop.run(&["sweep", "work", "s"]);
    assert!(ran.code == Some(2) && ran.stderr.contains("another build"), "{ran:?}");
}

/// Where results cannot be written the work ends, and says where.
#[test]
fn what_cannot_be_written_ends_the_work() {
    let workshop = workshop();
    assert_eq!(workshop.run(&["sweep", "plan", "small.toml", "--out", "s", "--quiet"]).code, Some(0));
    // A file where the folder of the parts would be: it cannot be made, whoever runs this.
    workshop.write("s/parts", "in the way");
    let ran = workshop.run(&["sweep", "work", "s"]);
    assert_eq!(ran.code, Some(3), "{ran:?}");
    assert!(ran.stderr.contains("parts"), "{ran:?}");
}
