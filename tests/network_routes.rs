//! Where a route ends that nobody gave. What the library's networks ask for, elbows and tees told before they are entered and each turn
//! taken, is in their `[pass]`, which `library` judges.

use ductloop::{Engine, Pilot, Scenario, Verdict, run_on};

/// Without a route it stands before the end of its duct, and says why.
#[test]
fn it_stands_before_a_dead_end() {
    let text = "format = 1\nkind = \"scenario\"\nname = \"cap\"\ntime_limit_s = 30.0\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nsurface = \"galvanised-dusty\"\n\
                run = [{ straight_m = 3.0 }]\nexit = \"cap\"\n[finish]\nbefore_end_m = 0.2\n[pass]\ncollisions = 0\nend_state = \"stopped\"\n";
    let scenario = Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{wrong}"));
    let outcome = run_on(&Engine::Cpu, &scenario, Pilot::of(&scenario)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((outcome.verdict, &outcome.reasons), (Verdict::Pass, &vec![]));
    let last = outcome.record.frames.last().expect("a frame");
    assert!((2.7..2.8).contains(&last.truth.distance_m), "{:?}", last.truth.distance_m);
    assert_eq!(last.reason, Some(ductloop_nav::navigator::Reason::DeadEnd));
}
