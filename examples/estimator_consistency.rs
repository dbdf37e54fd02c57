//! Whether the estimator errs as much as it says, by real runs: a scenario over many seeds, NEES and NIS with their 95 % bands, and
//! what became of effective track and centre of rotation.
//!
//! ```text
//! cargo run --release --example estimator_consistency -- scenarios/straight-offset.toml 100
//! ```

use std::ops::ControlFlow;

use ductloop::closed_loop::{Pace, run_with};
use ductloop::consistency::{Consistency, nees, nis, turning};
use ductloop::record::RunRecord;
use ductloop::{Engine, Pilot, Scenario};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "scenarios/straight-offset.toml".into());
    let seeds: u64 = arguments.next().map_or(Ok(100), |text| text.parse())?;
    let base = Scenario::read(file.as_ref(), &Default::default())?;
    let mut runs: Vec<RunRecord> = Vec::new();
    for seed in 1..=seeds {
        let scenario = Scenario { seed, ..base.clone() };
        let mut renderer = Engine::Cpu.renderer(&scenario, 1)?;
        runs.push(run_with(&scenario, Pilot::of(&scenario), renderer.as_mut(), Pace::Alone, |_, _| ControlFlow::Continue(()))?);
    }
    println!("{}, {seeds} seeds", base.name);
    for (name, found) in [("NEES / 3", nees(&runs)), ("NIS / freedom", nis(&runs))] {
        match found {
            Some(Consistency { mean, band: [low, high], shares: [below, inside, above], frames }) => println!(
                "{name:<14} mean {mean:.3}, band {low:.3} to {high:.3}; of {frames} frames {:.1} % below, {:.1} % inside, {:.1} % above",
                100.0 * below,
                100.0 * inside,
                100.0 * above
            ),
            None => println!("{name:<14} none: there is no estimator"),
        }
    }
    let turned: Vec<_> = runs.iter().filter_map(|run| turning(run, base.robot.metres_per_count())).collect();
    let told = [base.robot.chi() * base.robot.track_m, 0.0];
    for (at, name) in ["effective track", "centre of rotation"].into_iter().enumerate() {
        let of = |turned: &ductloop::consistency::Turning| if at == 0 { turned.track_m } else { turned.icr_m };
        let mean = |value: &dyn Fn([f64; 3]) -> f64| turned.iter().map(|t| value(of(t))).sum::<f64>() / turned.len() as f64;
        println!(
            "{name:<18} told {:.2} mm; at the end {:.2} mm, deviation {:.2} mm; truly {:.2} mm; error RMS {:.2} mm, NEES {:.2}",
            1e3 * told[at],
            1e3 * mean(&|v| v[0]),
            1e3 * mean(&|v| v[1]),
            1e3 * mean(&|v| v[2]),
            1e3 * mean(&|v| (v[0] - v[2]) * (v[0] - v[2])).sqrt(),
            mean(&|v| (v[0] - v[2]) * (v[0] - v[2]) / (v[1] * v[1])),
        );
    }
    Ok(())
}
