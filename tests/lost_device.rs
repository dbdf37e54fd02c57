//! A graphics device that is lost in mid-run ends the run with an error and the frames until then.
#![cfg(all(feature = "wgpu", feature = "cli"))]

use std::ops::ControlFlow;

use ductloop::closed_loop::{Pace, RunError, run_with};
use ductloop::output::Summary;
use ductloop::record::EndState;
use ductloop::{Engine, Pilot, Scenario, Verdict};
use ductloop_sensor::gpu::Gpu;
use ductloop_sensor::renderer::RenderError;

const SCENARIO: &str = r#"format = 1
kind = "scenario"
name = "t"
time_limit_s = 2.0
[sensor]
preset = "wide"
[duct]
width_m = 0.5
height_m = 0.3
run = [{ straight_m = 6.0 }]
"#;

/// Frames until the device goes.
const GOOD: usize = 4;

#[test]
fn a_device_lost_in_mid_run_ends_it_with_exit_code_3() {
    let scenario = Scenario::from_toml_str(SCENARIO).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
    for pace in [Pace::Alone, Pace::Overlapped] {
        let gpu = match Gpu::open() {
            Ok(gpu) => gpu,
            Err(RenderError::NoAdapter(why)) if std::env::var_os("DUCTLOOP_ALLOW_NO_GPU").is_some() => {
                println!("skipped: no graphics adapter ({why})");
                return;
            }
            Err(error) => panic!("{error}"),
        };
        let mut renderer = Engine::Wgpu(gpu.clone()).renderer(&scenario, 1).expect("a sound scenario");
        let mut seen = 0;
        let result = run_with(&scenario, Pilot::of(&scenario), renderer.as_mut(), pace, |_, _| {
            seen += 1;
            if seen == GOOD {
                gpu.close();
            }
            ControlFlow::Continue(())
        });
        let failure = result.expect_err("the device is gone");
        assert!(matches!(failure.error, RunError::Render(RenderError::Lost(_))), "{failure}");
        assert!(failure.to_string().starts_with("the graphics device was lost"), "{failure}");
        // No black frame is passed on as if it were one.
        let record = failure.record.expect("the frames until then");
        assert_eq!((record.frames.len(), seen, record.end), (GOOD, GOOD, EndState::Failed));
        // What the command makes of it.
        let summary = Summary::of(&scenario, &record, "wgpu", None).broken_off(Verdict::Error, failure.error.to_string());
        assert_eq!(summary.verdict.exit_code(), 3);
    }
}
