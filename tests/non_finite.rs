//! A state that stops being finite ends the run: exit code 3, the tick named, and everything until then on disk.
//!
//! No field of a scenario makes it happen: pushes are bounded, and commands that are none do not get so far (`loop_contract.rs`). So a
//! push that no file can hold is put into the scenario afterwards: a force of 1e308 N, which is a number, and what it does is not.
#![cfg(feature = "cli")]

use std::fs;
use std::ops::ControlFlow;

use ductloop::closed_loop::{Pace, RunError, run_with};
use ductloop::output::{Manifest, RunFolder, Summary};
use ductloop::record::EndState;
use ductloop::run_files::write_run;
use ductloop::scenario::{Fault, FaultKind};
use ductloop::{Engine, Pilot, Scenario, Verdict};
use ductloop_sim::world::SimError;
use parquet::file::reader::{FileReader, SerializedFileReader};

const SCENARIO: &str = r#"format = 1
kind = "scenario"
name = "t"
time_limit_s = 3.0
[sensor]
preset = "wide"
[perception]
pipeline = "truth"
[duct]
width_m = 0.5
height_m = 0.3
run = [{ straight_m = 6.0 }]
"#;

#[test]
fn a_state_that_is_not_finite_ends_the_run_with_exit_code_3() {
    let sound = Scenario::from_toml_str(SCENARIO).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
    for force_n in [[1e308, 0.0], [0.0, f64::INFINITY]] {
        for pace in [Pace::Alone, Pace::Overlapped] {
            let mut scenario = sound.clone();
            scenario.faults.push(Fault { at_s: 1.0, for_s: None, kind: FaultKind::Push { force_n } });
            let mut renderer = Engine::Cpu.renderer(&scenario, 1).expect("a sound scenario");
            let result = run_with(&scenario, Pilot::of(&scenario), renderer.as_mut(), pace, |_, _| ControlFlow::Continue(()));
            let failure = result.expect_err("such a push");
            let RunError::Sim(SimError::NonFinite { tick }) = failure.error else { panic!("{failure}") };
            // It begins at tick 1200, with the exposure of frame 30.
            assert!((1201..=1240).contains(&tick), "{tick}");
            let record = failure.record.as_ref().expect("the frames until then");
            assert_eq!((record.frames.len(), record.end), (31, EndState::Failed));
            assert!(record.frames.iter().all(|frame| {
                let pose = &frame.truth.world_from_base;
                pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|value| value.is_finite())
            }));
            assert!((0.1..0.4).contains(&record.distance_m), "{}", record.distance_m);

            // What the command makes of it, on disk.
            let summary = Summary::of(&scenario, record, "cpu", None).broken_off(Verdict::Error, failure.error.to_string());
            assert_eq!(summary.verdict.exit_code(), 3);
            let out = tempfile::tempdir().expect("a temporary folder");
            let folder = RunFolder::prepare(out.path(), "t", &scenario.to_toml(), false).expect("a folder");
            write_run(&folder, &scenario, record, &summary, &Manifest::now(1, "cpu", None, 1)).expect("a run's files");
            let read = |name: &str| fs::read_to_string(out.path().join("t").join(name)).expect("a file");
            let told: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
            assert_eq!((&told["verdict"], told["metrics"]["end_state"].as_str()), (&"error".into(), Some("failed")));
            let message = told["message"].as_str().expect("words");
            assert!(message.contains("stopped being finite") && message.contains(&tick.to_string()), "{message}");
            assert!(read("report.html").contains(&format!("stopped being finite at tick {tick}")), "the report says it too");
            let table = fs::File::open(out.path().join("t/frames.parquet")).expect("a table");
            let rows = SerializedFileReader::new(table).expect("Parquet").metadata().file_metadata().num_rows();
            assert_eq!(rows, 31, "the last good state");
        }
    }
}
