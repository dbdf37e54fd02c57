//! The estimator against a robot that is simulated here: a skid-steered unicycle with encoders that count whole counts, on wheels that
//! slip at random, between walls whose measurements err by as much as they say. No image is rendered.

use ductloop_nav::estimation::chi_square::mean_band;
use ductloop_nav::estimation::{EstimationParams, Estimator, Outcome, Travel};
use ductloop_nav::perception::side_walls::SideWalls;
use nalgebra::{Matrix3, Vector3};

/// Normal random numbers: SplitMix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014) and Box-Muller.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (a, b) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * libm::log(a)).sqrt() * libm::cos(std::f64::consts::TAU * b)
    }
}

const WIDTH_M: f64 = 0.5;
const TRACK_M: f64 = 0.325;
/// Way of a count: INCRA I's.
const COUNT_M: f64 = 3.8e-6;
const TICKS_A_FRAME: u64 = 40;

/// As a perception states it: distances are measured half a metre ahead and carried back by the heading, so that all three go together.
fn stated() -> Matrix3<f64> {
    let (heading, at_stripe, ahead_m) = (1.5e-4, 0.1e-3, 0.5);
    let root = Matrix3::new(heading, 0.0, 0.0, ahead_m * heading, at_stripe, 0.0, -ahead_m * heading, 0.0, at_stripe);
    root * root.transpose()
}

/// A robot that drives a slalom, or straight on.
struct Robot {
    random: Random,
    params: EstimationParams,
    lateral_m: f64,
    heading_rad: f64,
    width_m: f64,
    track_m: f64,
    icr_m: f64,
    /// Ways of the wheels since the start, as turned, in metres.
    wheels_m: [f64; 2],
    /// Persistent part of the walls' errors, of variance one.
    common: Vector3<f64>,
}

impl Robot {
    /// Everything that the filter is unsure of at first is drawn as unsure.
    fn new(seed: u64, params: EstimationParams) -> Self {
        let mut random = Random(seed.wrapping_mul(0x5851_f42d_4c95_7f2d));
        let width_m = WIDTH_M + params.width_m * random.normal();
        let track_m = TRACK_M / (1.0 + params.track_ratio * random.normal());
        let icr_m = params.icr_m * random.normal();
        let common = Vector3::from_fn(|_, _| random.normal());
        let (lateral_m, heading_rad) = (0.03 * random.normal(), 0.03 * random.normal());
        Self { random, params, lateral_m, heading_rad, width_m, track_m, icr_m, wheels_m: [0.0; 2], common }
    }

    /// One frame period of wheels that turn by these ways, in fine steps, with slip; everything else walks too.
    fn drive(&mut self, turned: Travel) {
        const STEPS: usize = 20;
        let p = self.params;
        let part = [turned.left_m / STEPS as f64, turned.right_m / STEPS as f64];
        for _ in 0..STEPS {
            let mut slipped = || p.wheel_slip_m * self.random.normal();
            let [left, right] = part.map(|way| way + slipped() * way.abs().sqrt());
            let way = (part[0].abs() + part[1].abs()) / 2.0;
            let turn = (right - left) / self.track_m;
            // As much as the wheels were to turn it: on a straight, none.
            let meant = (part[1] - part[0]) / self.track_m;
            let turn = turn + p.turn_slip_rad * meant.abs().sqrt() * self.random.normal();
            let ahead = (left + right) / 2.0;
            let middle = self.heading_rad + turn / 2.0;
            // The base's origin goes ahead by `ahead`, and sideways by -x_ICR times the turn.
            self.lateral_m += ahead * libm::sin(middle) - self.icr_m * turn * libm::cos(middle);
            self.heading_rad += turn;
            let walk = way.sqrt();
            self.lateral_m += p.side_slip_m * walk * self.random.normal();
            self.width_m += p.width_walk_m * walk * self.random.normal();
            self.track_m += p.track_walk_ratio * TRACK_M * walk * self.random.normal();
            self.icr_m += p.icr_walk_m * walk * self.random.normal();
            let persisting = libm::exp(-way / p.correlation_m);
            let fresh = (1.0 - persisting * persisting).sqrt();
            self.common = self.common.map(|u| persisting * u) + Vector3::from_fn(|_, _| fresh * self.random.normal());
        }
        self.wheels_m[0] += turned.left_m;
        self.wheels_m[1] += turned.right_m;
    }

    fn counts(&self) -> [f64; 2] {
        self.wheels_m.map(|way| (way / COUNT_M).floor())
    }

    fn walls(&mut self) -> SideWalls {
        let root = stated().cholesky().expect("a covariance").unpack();
        let white = Vector3::from_fn(|_, _| self.random.normal());
        let share = self.params.correlated_share;
        let error = root * (self.common * share.sqrt() + white * (1.0 - share).sqrt());
        SideWalls {
            heading_rad: self.heading_rad + error[0],
            left_m: Some(self.width_m / 2.0 - self.lateral_m + error[1]),
            right_m: Some(self.width_m / 2.0 + self.lateral_m + error[2]),
            covariance: stated(),
        }
    }
}

/// What is asked of a run, frame by frame.
struct Run {
    nees: Vec<f64>,
    nis: Vec<f64>,
    /// Squares of the errors of effective track and x_ICR over their variances, at the end.
    turning: [f64; 2],
    track_error: f64,
    icr_error_m: f64,
}

/// Four seconds of slalom and two straight on, at 0.3 m/s and 30 frames a second. `filter` is what the estimator believes of the noise.
fn run(seed: u64, truth: EstimationParams, filter: EstimationParams) -> Run {
    let mut robot = Robot::new(seed, truth);
    let mut estimator = Estimator::new(filter, WIDTH_M, TRACK_M, COUNT_M);
    let (mut nees, mut nis) = (Vec::new(), Vec::new());
    let mut before = robot.counts();
    for frame in 0..180u64 {
        if frame > 0 {
            let yaw_rate = if frame < 120 { 0.8 * libm::cos(frame as f64 / 30.0 * 3.0) } else { 0.0 };
            let (ahead, half) = (0.3 / 30.0, yaw_rate * TRACK_M / 2.0 / 30.0);
            robot.drive(Travel { left_m: ahead - half, right_m: ahead + half });
            let now = robot.counts();
            let travel = Travel { left_m: (now[0] - before[0]) * COUNT_M, right_m: (now[1] - before[1]) * COUNT_M };
            before = now;
            estimator.advance(travel, frame * TICKS_A_FRAME);
        }
        let walls = robot.walls();
        if let Outcome::Taken { nis: value, .. } | Outcome::Refused { nis: value, .. } =
            estimator.look(&walls, frame * TICKS_A_FRAME, false)
        {
            nis.push(value);
        }
        let estimate = estimator.estimate();
        nees.push(estimate.nees(robot.lateral_m, robot.heading_rad, robot.width_m).expect("a covariance"));
    }
    let estimate = estimator.estimate();
    let (track, icr) = (estimate.effective_track_m - robot.track_m, estimate.icr_m - robot.icr_m);
    let square = |error: f64, i: usize| (error / estimate.deviation(i)) * (error / estimate.deviation(i));
    Run { nees, nis, turning: [square(track, 3), square(icr, 4)], track_error: track / robot.track_m, icr_error_m: icr }
}

/// Ten times the usual hundred. A wall's error persists for longer than a run, so that a run is little more than one sample, and the
/// mean over a hundred of them may lie out of the band for half the run by chance; over a thousand the band is three times narrower.
const SEEDS: usize = 1000;

fn runs(seeds: usize, truth: EstimationParams, filter: EstimationParams) -> Vec<Run> {
    (1..=seeds as u64).map(|seed| run(seed, truth, filter)).collect()
}

/// Mean over the frames and seeds, and the share of the frames whose mean over the seeds lies in the 95 % band of three degrees.
fn held(runs: &[Run], of: impl Fn(&Run) -> &[f64]) -> (f64, f64) {
    let [low, high] = mean_band(3, runs.len(), 0.95);
    let frames = runs.iter().map(|run| of(run).len()).min().expect("runs");
    let means: Vec<f64> = (0..frames).map(|k| runs.iter().map(|run| of(run)[k]).sum::<f64>() / runs.len() as f64).collect();
    let inside = means.iter().filter(|mean| (low..=high).contains(*mean)).count();
    (means.iter().sum::<f64>() / frames as f64, inside as f64 / frames as f64)
}

/// Noises of a robot that slips more than the defaults, so that each of them counts.
fn slipping() -> EstimationParams {
    EstimationParams {
        wheel_slip_m: 0.3e-3,
        side_slip_m: 0.2e-3,
        turn_slip_rad: 5e-3,
        width_walk_m: 0.3e-3,
        correlation_m: 0.5,
        correlated_share: 0.5,
        ..EstimationParams::default()
    }
}

#[test]
fn errors_and_innovations_are_as_large_as_the_filter_says() {
    for (name, params) in [("defaults", EstimationParams::default()), ("slipping", slipping())] {
        let runs = runs(SEEDS, params, params);
        for (what, (mean, inside)) in [("NEES", held(&runs, |run| &run.nees)), ("NIS", held(&runs, |run| &run.nis))] {
            println!("{name}: {what} mean {mean:.3} of 3, {:.1} % of the frames inside the band", 100.0 * inside);
            // Innovations are new in every frame: of 179 means 95 % lie inside, three deviations of a binomial are 4.9 %; the first
            // frames, where the filter is linearised about what it does not know yet, cost another 2 %.
            // Errors persist, and so does their mean over the seeds: a run out of the band lasts for tens of frames.
            let least = if what == "NIS" { 0.88 } else { 0.75 };
            assert!(inside >= least, "{name}: {what}: {inside}");
            // The mean over 180 000 innovations: three deviations are 0.017, and the linearisation twice as much again. Of NEES, were it the
            // same in all frames of a run, one mean of a thousand: 99.9 %.
            let [low, high] = if what == "NIS" { [2.94, 3.06] } else { mean_band(3, SEEDS, 0.999) };
            assert!((low..=high).contains(&mean), "{name}: {what}: {mean}");
        }
        // Effective track and centre of rotation, after the turns: one degree, a run each. 99.9 % lie within 0.86 and 1.15; that the
        // turns' first frames are linearised about a track and a centre which are hardly known makes the filter surer of the track
        // by up to a tenth, of its variance a fifth.
        for (i, what) in ["effective track", "centre of rotation"].into_iter().enumerate() {
            let mean = runs.iter().map(|run| run.turning[i]).sum::<f64>() / SEEDS as f64;
            println!("{name}: {what} NEES {mean:.3}");
            assert!((0.86..=1.20).contains(&mean), "{name}: {what}: {mean}");
        }
        let rms = |of: &dyn Fn(&Run) -> f64| (runs.iter().map(|run| of(run) * of(run)).sum::<f64>() / SEEDS as f64).sqrt();
        let (track, icr_m) = (rms(&|run| run.track_error), rms(&|run| run.icr_error_m));
        println!("{name}: effective track to {:.2} %, centre of rotation to {:.2} mm", 100.0 * track, 1e3 * icr_m);
        // Told to 15 % and 20 mm: the turns must have shown most of it.
        assert!(track < 0.05 && icr_m < 6e-3, "{name}: {track} {icr_m}");
    }
}

/// The reason for the states of the walls' errors: taken for white, errors that persist make the filter overconfident.
#[test]
fn a_filter_that_takes_persisting_errors_for_white_is_overconfident() {
    let runs = runs(100, slipping(), EstimationParams { correlated_share: 0.0, ..slipping() });
    let (mean, inside) = held(&runs, |run| &run.nees);
    println!("white: NEES mean {mean:.2} of 3, {:.1} % of the frames inside the band", 100.0 * inside);
    assert!(mean > 4.0 && inside < 0.2, "{mean} {inside}");
}

fn straight(estimator: &mut Estimator, frames: std::ops::Range<u64>, walls: impl Fn(u64) -> Option<SideWalls>) -> Vec<Outcome> {
    let step = |frame: u64| {
        if frame > 0 {
            estimator.advance(Travel { left_m: 0.01, right_m: 0.01 }, frame * TICKS_A_FRAME);
        }
        walls(frame).map_or(Outcome::None, |walls| estimator.look(&walls, frame * TICKS_A_FRAME, false))
    };
    frames.map(step).collect()
}

fn at(lateral_m: f64, covariance: Matrix3<f64>) -> SideWalls {
    SideWalls { heading_rad: 0.0, left_m: Some(WIDTH_M / 2.0 - lateral_m), right_m: Some(WIDTH_M / 2.0 + lateral_m), covariance }
}

fn estimator() -> Estimator {
    Estimator::new(EstimationParams::default(), WIDTH_M, TRACK_M, COUNT_M)
}

#[test]
fn a_look_with_a_huge_deviation_does_not_jerk() {
    let mut filter = estimator();
    straight(&mut filter, 0..30, |_| Some(at(0.01, stated())));
    let before = filter.estimate().lateral_m;
    // 100 mm off, and a deviation of as much: a thousand times less sure than what was seen before. It may say something of the
    // errors that persist, so that the offset may move within its own deviation, a few hundredths of a millimetre.
    let outcome = straight(&mut filter, 30..31, |_| Some(at(0.11, stated() * 1e6)));
    assert!(matches!(outcome[0], Outcome::Taken { .. }), "{outcome:?}");
    let (moved_m, sigma_m) = ((filter.estimate().lateral_m - before).abs(), filter.estimate().deviation(0));
    println!("a look 100 mm off moves the estimate by {:.4} mm, its deviation is {:.4} mm", 1e3 * moved_m, 1e3 * sigma_m);
    assert!(moved_m < sigma_m && sigma_m < 0.1e-3, "{moved_m} {sigma_m}");
}

#[test]
fn an_outlier_is_refused_and_a_run_of_them_begins_anew() {
    let mut filter = estimator();
    straight(&mut filter, 0..30, |_| Some(at(0.01, stated())));
    let run = EstimationParams::default().gate_run as u64;
    let outcomes = straight(&mut filter, 30..30 + run + 2, |_| Some(at(0.05, stated())));
    for (i, outcome) in outcomes.iter().enumerate() {
        match (i as u64).cmp(&run) {
            std::cmp::Ordering::Less => assert!(matches!(outcome, Outcome::Refused { .. }), "{i}: {outcome:?}"),
            std::cmp::Ordering::Equal => assert_eq!(*outcome, Outcome::Begun),
            std::cmp::Ordering::Greater => assert!(matches!(outcome, Outcome::Taken { .. }), "{i}: {outcome:?}"),
        }
    }
    let estimate = filter.estimate();
    assert!((estimate.lateral_m - 0.05).abs() < 1e-4, "{estimate:?}");
    assert_eq!((u64::from(estimate.refused), estimate.begun_anew), (run + 1, 1));
}

/// In bends wrong walls are found for a while: there the run is to be three times as long.
#[test]
fn a_steady_filter_begins_anew_after_a_longer_run() {
    let mut filter = estimator();
    straight(&mut filter, 0..30, |_| Some(at(0.01, stated())));
    let longest = 3 * EstimationParams::default().gate_run as u64;
    let begun = (30..30 + 2 * longest).position(|frame| {
        filter.advance(Travel::default(), frame * TICKS_A_FRAME);
        filter.look(&at(0.05, stated()), frame * TICKS_A_FRAME, true) == Outcome::Begun
    });
    assert_eq!(begun, Some(longest as usize));
}

/// A look that comes late counts as if it had come when it was exposed, to rounding.
#[test]
fn a_look_that_comes_late_is_put_where_it_belongs() {
    let walls = |frame: u64| at(0.01 + 0.0001 * (frame % 3) as f64, stated());
    let (mut in_time, mut late) = (estimator(), estimator());
    straight(&mut in_time, 0..20, |frame| Some(walls(frame)));
    straight(&mut late, 0..20, |frame| (frame != 16).then(|| walls(frame)));
    let difference = |late: &Estimator| {
        let (a, b) = (in_time.estimate(), late.estimate());
        ((a.lateral_m - b.lateral_m).abs(), (a.covariance - b.covariance).abs().max())
    };
    assert!(difference(&late).0 > 1e-7, "the look counts: {:?}", difference(&late));
    assert!(matches!(late.look(&walls(16), 16 * TICKS_A_FRAME, false), Outcome::Taken { .. }));
    let (lateral_m, covariance) = difference(&late);
    assert!(lateral_m < 1e-12 && covariance < 1e-12, "{lateral_m} {covariance}");
    // From before anything that is remembered: of no use, and nothing changes.
    assert_eq!(late.look(&walls(3), 3 * TICKS_A_FRAME, false), Outcome::Useless);
    assert!(difference(&late).0 < 1e-12);
}

/// One wall shows the offset only as far as the width is known; the heading it shows in full.
#[test]
fn one_wall_is_as_good_as_the_width_is_known() {
    let mut filter = estimator();
    let one = |_| Some(SideWalls { left_m: None, ..at(0.01, stated()) });
    let outcomes = straight(&mut filter, 0..60, one);
    assert!(outcomes[1..].iter().all(|outcome| matches!(outcome, Outcome::Taken { freedom: 2, .. })), "{outcomes:?}");
    let estimate = filter.estimate();
    let half_width_sigma = EstimationParams::default().width_m / 2.0;
    assert!((estimate.deviation(0) / half_width_sigma - 1.0).abs() < 0.01, "{}", estimate.deviation(0));
    assert!(estimate.deviation(1) < 1.5e-4 && (estimate.lateral_m - 0.01).abs() < 1e-3, "{estimate:?}");
    // Both walls for one frame, and the width is known from there on.
    straight(&mut filter, 60..61, |_| Some(at(0.01, stated())));
    straight(&mut filter, 61..90, one);
    assert!(filter.estimate().deviation(0) < 0.2e-3, "{}", filter.estimate().deviation(0));
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let mut filter = estimator();
    straight(&mut filter, 0..10, |_| Some(at(0.01, stated())));
    let before = filter.estimate();
    for bad in [at(f64::NAN, stated()), at(0.01, Matrix3::zeros()), at(0.01, stated() * f64::NAN), at(0.01, -stated())] {
        assert_eq!(filter.look(&bad, 9 * TICKS_A_FRAME, false), Outcome::Useless, "{bad:?}");
        assert_eq!((filter.estimate().lateral_m, filter.estimate().covariance), (before.lateral_m, before.covariance));
    }
}

/// A robot that looks again at the same walls from the same place learns only what is new in every frame.
#[test]
fn standing_still_does_not_make_it_sure() {
    let mut filter = estimator();
    for frame in 0..3000u64 {
        filter.advance(Travel::default(), frame * TICKS_A_FRAME);
        filter.look(&at(0.01, stated()), frame * TICKS_A_FRAME, false);
    }
    let floor = (stated()[(0, 0)] * EstimationParams::default().correlated_share).sqrt();
    let sigma = filter.estimate().deviation(1);
    assert!(sigma > 0.9 * floor && sigma < 1.5 * floor, "{sigma} {floor}");
}

/// With independent errors the density is a product of normal ones.
#[test]
fn the_log_loss_is_that_of_the_density() {
    let deviations = [0.002, 0.01, 0.005];
    let mut estimate = Estimator::new(EstimationParams::default(), WIDTH_M, TRACK_M, COUNT_M).estimate();
    estimate.covariance.fill_diagonal(1.0);
    for (i, deviation) in deviations.iter().enumerate() {
        estimate.covariance[(i, i)] = deviation * deviation;
    }
    let truth = [estimate.lateral_m + 0.003, estimate.heading_rad - 0.01, estimate.width_m];
    let normal =
        |x: f64, deviation: f64| libm::exp(-0.5 * x * x / (deviation * deviation)) / (deviation * std::f64::consts::TAU.sqrt());
    let density: f64 = [0.003, -0.01, 0.0].iter().zip(deviations).map(|(x, deviation)| normal(*x, deviation)).product();
    let loss = estimate.log_loss(truth[0], truth[1], truth[2]).expect("a covariance");
    assert!((loss + libm::log(density)).abs() < 1e-9, "{loss}");
}
