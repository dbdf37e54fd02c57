//! Whether the filter errs as much as it says, with real images: the scenario that tells it how exact the simulated world is.
//!
//! A hundred seeds are what `examples/estimator_consistency.rs` is for; `docs/estimation.md` has its figures. Here are a few, held against
//! bands as wide as chi-square makes them for so few, and the same with a filter that takes perception for too exact or too modest.

use ductloop::consistency::{Consistency, nees, nis};
use ductloop::{Engine, Pilot, Scenario};
use ductloop_nav::estimation::chi_square::mean_band;

/// Independent runs; a persistent error is a new one in each.
const SEEDS: u64 = 6;

/// NEES and NIS, a degree of freedom, with the variances that perception states multiplied by `factor`.
fn consistency(factor: f64) -> [Consistency; 2] {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/straight-consistent.toml");
    let mut base = Scenario::read(file.as_ref(), &Default::default()).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
    // A good metre of the way suffices here.
    base.finish.before_end_m = 1.3;
    base.estimation.params.stated_ratio *= factor.sqrt();
    let runs: Vec<_> = (1..=SEEDS)
        .map(|seed| {
            let scenario = Scenario { seed, ..base.clone() };
            let outcome =
                ductloop::run_on(&Engine::Cpu, &scenario, Pilot::of(&scenario)).unwrap_or_else(|error| panic!("{error}"));
            outcome.record
        })
        .collect();
    [nees(&runs), nis(&runs)].map(|found| found.unwrap_or_else(|| panic!("no estimator")))
}

/// The mean of a chi-square's band over so many samples of three degrees, a degree of freedom.
fn band(samples: usize) -> [f64; 2] {
    mean_band(3, samples, 0.95).map(|bound| bound / 3.0)
}

#[test]
fn the_filter_errs_as_much_as_it_says() {
    let [nees, nis] = consistency(1.0);
    println!("NEES {nees:?}\nNIS {nis:?}");
    assert!(nees.frames > 100 && nis.frames > 100, "{nees:?} {nis:?}");
    // Innovations are new in every frame, a thousand samples here; the bound is that of a hundred, the width of a single frame's band over
    // a hundred seeds: what is left over is for centres whose variance is stated to a few percent.
    let [low, high] = band(100);
    assert!((low..=high).contains(&nis.mean), "{nis:?}");
    // Of a frame's mean over the seeds 95 % lie in its band; three deviations of a binomial over 100 frames are 6.5 %.
    assert!(nis.shares[1] > 0.88, "{nis:?}");
    // The persistent part of an estimate's error is one sample a run.
    let [low, high] = band(SEEDS as usize);
    assert!((low..=high).contains(&nees.mean), "{nees:?}");
}

/// That the test above can fail: a filter that takes perception for twice as exact, or half, is found out.
#[test]
fn a_filter_with_half_or_twice_the_variance_does_not() {
    let [low, high] = band(100);
    let [_, exact] = consistency(0.5);
    assert!(exact.mean > high, "{exact:?}");
    let [_, modest] = consistency(2.0);
    assert!(modest.mean < low, "{modest:?}");
}
