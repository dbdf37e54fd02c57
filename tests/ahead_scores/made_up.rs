//! Scores of made-up frames: a robot at 0.25 m/s, 30 frames a second, names what the test says.

use ductloop::ahead_scores::{AheadScores, FittingScore, Glance, Named, Thing, TrueAhead};
use ductloop_nav::ahead::{Fitting, Side};

const STEP_M: f64 = 0.25 / 30.0;
const WIDTH_M: f64 = 0.5;
const REACH_M: f64 = 2.7;
const NOSE_M: f64 = 0.16;
const LEFT: Fitting = Fitting::Elbow(Side::Left);
const RIGHT: Fitting = Fitting::Elbow(Side::Right);

fn thing(fitting: Fitting, at_m: f64) -> Thing {
    let name = fitting.word().to_owned();
    Thing { fitting, name, at_m, to_m: at_m + 0.5, width_m: WIDTH_M, width_after_m: None, radius_m: None, reach_m: REACH_M }
}

/// Towards things from the path's beginning to `to_m`; what is named where there is `left_m` to the thing of this number.
fn drive(things: &[Thing], to_m: f64, name: impl Fn(usize, f64) -> Option<(Fitting, f64)>) -> Vec<Glance> {
    (0..(to_m / STEP_M) as usize)
        .map(|frame| {
            let along_m = frame as f64 * STEP_M;
            let thing = things.iter().take_while(|thing| thing.at_m <= along_m).count();
            let was_entered = thing > 0 && along_m < things[thing - 1].to_m;
            let time_s = frame as f64 / 30.0;
            let (truth, said) = match things.get(thing) {
                Some(Thing { fitting, at_m, .. }) => {
                    let distance_m = at_m - along_m;
                    let is_inside = was_entered || distance_m <= NOSE_M;
                    let truth = TrueAhead { thing, fitting: *fitting, distance_m, is_in_reach: distance_m <= REACH_M, is_inside };
                    (truth, name(thing, distance_m))
                }
                None => {
                    let truth = TrueAhead {
                        thing: usize::MAX,
                        fitting: Fitting::Straight,
                        distance_m: f64::INFINITY,
                        is_in_reach: false,
                        is_inside: was_entered,
                    };
                    (truth, name(thing, f64::INFINITY))
                }
            };
            let named = said.map(|(fitting, distance_m)| Named { fitting, distance_m, width_m: None });
            Glance { time_s, truth, named, ducts: 1 }
        })
        .collect()
}

fn scores(things: &[Thing], glances: &[Glance]) -> AheadScores {
    AheadScores::of_glances(things, glances, |_| None)
}

fn only(scores: &AheadScores) -> &FittingScore {
    let [score] = &scores.fittings[..] else { panic!("{scores:?}") };
    score
}

#[track_caller]
fn near(found: f64, expected: f64, by: f64) {
    assert!((found - expected).abs() <= by, "{found}, not {expected}");
}

/// Unknown up to a place, and the right name from there on.
fn from(known_m: f64, fitting: Fitting) -> impl Fn(usize, f64) -> Option<(Fitting, f64)> {
    move |_, left_m| Some((if left_m <= known_m { fitting } else { Fitting::Unknown }, left_m + 0.03))
}

#[test]
fn a_straight_duct_has_no_figures_but_frames() {
    let all = scores(&[], &drive(&[], 3.0, |_, _| Some((Fitting::Straight, 2.3))));
    assert_eq!((all.fittings.len(), all.false_alarms, all.by_frames.of("straight", "straight")), (0, Some(0), 360));
    assert_eq!((all.named_share(), all.detection_widths_min(), all.latency_max_s()), (None, None, None));
}

/// Known from 1.5 m on, 30 mm too far: three widths; 1.2 m at 0.25 m/s after it came into reach.
#[test]
fn an_elbow_that_is_named_in_time() {
    let things = [thing(LEFT, 4.0)];
    let all = scores(&things, &drive(&things, 4.4, from(1.5, LEFT)));
    let score = only(&all);
    assert_eq!((score.named, score.truth, score.right), ("elbow-left", "elbow-left", true));
    near(score.detected_m, 1.5, STEP_M);
    near(score.detected_widths, 3.0, 2.0 * STEP_M);
    near(score.latency_s, 1.2 / 0.25, 0.05);
    near(score.visible_m, REACH_M, STEP_M);
    near(score.distance_error_m.unwrap_or(f64::NAN), 0.03, 1e-9);
    near(score.entered_s, (4.0 - NOSE_M) / 0.25, 0.05);
    assert_eq!((all.named_share(), all.by_fittings.of("elbow-left", "elbow-left")), (Some(1.0), 1));
    // Frames by what is within reach: unknown 1.3 m out of reach, 1.2 m within it; then the right name up to the nose.
    near(all.by_frames.of("straight", "unknown") as f64, 1.3 / STEP_M, 2.0);
    near(all.by_frames.of("elbow-left", "unknown") as f64, 1.2 / STEP_M, 2.0);
    near(all.by_frames.of("elbow-left", "elbow-left") as f64, (1.5 - NOSE_M) / STEP_M, 2.0);
}

#[test]
fn a_fitting_that_is_never_named() {
    let things = [thing(Fitting::Cross, 4.0)];
    let all = scores(&things, &drive(&things, 4.4, |_, left_m| Some((Fitting::Unknown, left_m))));
    let score = only(&all);
    assert_eq!((score.named, score.right, score.detected_m, score.distance_error_m), ("unknown", false, 0.0, None));
    // As long as there was to name it.
    near(score.latency_s, (REACH_M - NOSE_M) / 0.25, 0.05);
    assert_eq!(
        (all.named_share(), all.detection_widths_min(), all.by_fittings.of("cross", "unknown")),
        (Some(0.0), Some(0.0), 1)
    );
    // And where nothing at all is said.
    let mute = scores(&things, &drive(&things, 4.4, |_, _| None));
    assert_eq!((only(&mute).named, mute.false_alarms, mute.named_share()), ("nothing", None, Some(0.0)));
}

/// First an elbow, from 0.6 m on what it is.
#[test]
fn a_wrong_name_that_is_mended_late() {
    let things = [thing(Fitting::BullheadTee, 4.0)];
    let all =
        scores(&things, &drive(&things, 4.4, |_, left_m| Some((if left_m > 0.6 { LEFT } else { Fitting::BullheadTee }, left_m))));
    let score = only(&all);
    assert!(score.right);
    near(score.detected_m, 0.6, STEP_M);
    near(score.latency_s, (REACH_M - 0.6) / 0.25, 0.05);
    assert!(all.by_frames.of("bullhead-tee", "elbow-left") > 200, "{:?}", all.by_frames);
    // The other way round: it is the last name that counts, and with it nothing was ever detected.
    let all =
        scores(&things, &drive(&things, 4.4, |_, left_m| Some((if left_m < 0.6 { LEFT } else { Fitting::BullheadTee }, left_m))));
    let score = only(&all);
    assert_eq!((score.named, score.right, score.detected_m), ("elbow-left", false, 0.0));
    assert_eq!(all.by_fittings.of("bullhead-tee", "elbow-left"), 1);
}

/// Seven frames without it are none; eight begin anew behind them.
#[test]
fn a_name_that_is_lost_for_a_moment() {
    let things = [thing(LEFT, 4.0)];
    let gap = |frames: usize| {
        let within = move |left_m: f64| left_m < 1.0 && left_m > 1.0 - STEP_M * (frames as f64 + 0.5);
        let name = move |_, left_m: f64| Some((if left_m > 1.5 || within(left_m) { Fitting::Unknown } else { LEFT }, left_m));
        let glances = drive(&things, 4.4, name);
        let lost = glances.iter().filter(|g| within(g.truth.distance_m)).count();
        (lost, only(&scores(&things, &glances)).detected_m)
    };
    let ((seven, upheld_m), (eight, anew_m)) = (gap(7), gap(8));
    assert_eq!((seven, eight), (7, 8));
    near(upheld_m, 1.5, STEP_M);
    near(anew_m, 1.0 - 8.0 * STEP_M, 2.0 * STEP_M);
}

/// What was named within the last width counts although it is unknown by then; what was named before that is forgotten.
#[test]
fn what_is_lost_before_it_is_entered() {
    let things = [thing(LEFT, 4.0)];
    let until = |known_m: f64| {
        let name = move |_, left_m: f64| Some((if left_m < known_m { Fitting::Unknown } else { LEFT }, left_m));
        scores(&things, &drive(&things, 4.4, name))
    };
    let late = until(NOSE_M + 0.4);
    assert!(only(&late).right);
    assert!(only(&late).detected_m > REACH_M, "{late:?}");
    let early = until(NOSE_M + 0.6);
    assert_eq!((only(&early).named, only(&early).right, only(&early).detected_m), ("unknown", false, 0.0));
}

/// The right word for another place is no right name.
#[test]
fn a_name_belongs_to_a_place() {
    let things = [thing(LEFT, 4.0)];
    let all = scores(&things, &drive(&things, 4.4, |_, left_m| Some((LEFT, left_m + 0.6))));
    assert_eq!((only(&all).named, only(&all).right), ("elbow-left", false));
    // But a place that is lost at the end, while the name is held, does not undo it.
    let all = scores(&things, &drive(&things, 4.4, |_, left_m| Some((LEFT, if left_m < 0.4 { 2.3 } else { left_m }))));
    assert_eq!((only(&all).named, only(&all).right), ("elbow-left", true));
    near(only(&all).distance_error_m.unwrap_or(f64::NAN), 0.0, 1e-9);
}

/// Twice something is named where nothing is; a flicker in between does not count again. Naming what is there from afar is no alarm.
#[test]
fn false_alarms_are_counted_once_each() {
    let things = [thing(LEFT, 9.0)];
    let name = |_, left_m: f64| {
        let along_m = 9.0 - left_m;
        let first = (1.0..1.5).contains(&along_m) && !(1.2..1.22).contains(&along_m);
        let second = (3.0..3.2).contains(&along_m);
        let fitting = if first || second {
            RIGHT
        } else if left_m < 4.0 {
            LEFT
        } else {
            Fitting::Straight
        };
        Some((fitting, if first || second { 1.0 } else { left_m }))
    };
    let all = scores(&things, &drive(&things, 8.9, name));
    assert_eq!(all.false_alarms, Some(2));
    near(all.by_frames.of("straight", "elbow-right") as f64, 0.68 / STEP_M, 4.0);
    // From 4 m on.
    near(all.by_frames.of("elbow-left", "elbow-left") as f64, (4.0 - NOSE_M) / STEP_M, 2.0);
    near(only(&all).detected_m, 4.0, STEP_M);
}

/// Behind one fitting the next can be seen when the robot is out of it; what is said in between counts nowhere.
#[test]
fn one_fitting_after_the_other() {
    let things = [thing(LEFT, 3.0), thing(RIGHT, 4.6)];
    let name = |number: usize, left_m: f64| match number {
        0 => Some((LEFT, left_m)),
        // 1.6 m ahead when the base enters the first one, 1.1 m when it is out of it: until then a drop, for half a second more unknown.
        _ if left_m > 1.1 => Some((Fitting::Drop, 0.5)),
        _ if left_m > 0.975 => Some((Fitting::Unknown, left_m)),
        _ => Some((RIGHT, left_m)),
    };
    let all = scores(&things, &drive(&things, 5.0, name));
    let [first, second] = &all.fittings[..] else { panic!("{all:?}") };
    assert!(first.right && second.right);
    near(second.visible_m, 1.1, STEP_M);
    near(second.detected_m, 0.975, STEP_M);
    near(second.latency_s, 0.5, 0.05);
    assert_eq!(all.by_frames.pairs.iter().filter(|pair| pair.named == "drop").count(), 0);
    // 1.1 m are two widths and more: enough to be held to the goal.
    near(all.detection_widths_min().unwrap_or(f64::NAN), 1.95, 0.02);
    assert_eq!(all.false_alarms, Some(0));
}

/// A dead end is never entered: it counts if the robot came within a width and a half.
#[test]
fn a_dead_end_counts_when_it_is_near() {
    let things = [thing(Fitting::DeadEnd, 4.0)];
    let near_it = scores(&things, &drive(&things, 3.4, from(1.4, Fitting::DeadEnd)));
    assert!(only(&near_it).right);
    near(only(&near_it).detected_m, 1.4, STEP_M);
    assert!(scores(&things, &drive(&things, 3.2, from(1.4, Fitting::DeadEnd))).fittings.is_empty());
}

/// A transition's width and an elbow's radius, and no goal for a transition's detection distance.
#[test]
fn widths_and_radii_have_errors() {
    let taper = Thing { width_after_m: Some(0.4), ..thing(Fitting::Transition, 3.0) };
    let bend = Thing { radius_m: Some(0.6), ..thing(RIGHT, 6.0) };
    let things = [taper, bend];
    let mut glances = drive(&things, 6.4, |number, left_m| Some((if number == 0 { Fitting::Transition } else { RIGHT }, left_m)));
    for glance in &mut glances {
        if let Some(named) = glance.named.as_mut().filter(|named| named.fitting == Fitting::Transition) {
            named.width_m = Some(0.41);
        }
    }
    let all = AheadScores::of_glances(&things, &glances, |ducts| (ducts == 1).then_some(0.57));
    let [taper, bend] = &all.fittings[..] else { panic!("{all:?}") };
    near(taper.width_error_m.unwrap_or(f64::NAN), 0.01, 1e-9);
    near(bend.radius_error_m.unwrap_or(f64::NAN), -0.03, 1e-9);
    assert_eq!((taper.radius_error_m, bend.width_error_m), (None, None));
    let only_taper = AheadScores { fittings: vec![taper.clone()], ..AheadScores::default() };
    assert_eq!(only_taper.detection_widths_min(), None);
}

/// Counts of runs add up, whatever their order.
#[test]
fn matrices_add_up() {
    let things = [thing(LEFT, 4.0)];
    let runs = [
        scores(&things, &drive(&things, 4.4, from(1.5, LEFT))),
        scores(&things, &drive(&things, 4.4, |_, left_m| Some((RIGHT, left_m)))),
    ];
    let sum = |order: [usize; 2]| {
        let mut sum = runs[order[0]].by_frames.clone();
        sum.add(&runs[order[1]].by_frames);
        sum
    };
    assert_eq!(sum([0, 1]), sum([1, 0]));
    for pair in &sum([0, 1]).pairs {
        let of_each: u64 = runs.iter().map(|run| run.by_frames.of(pair.truth, pair.named)).sum();
        assert_eq!(pair.count, of_each);
    }
    assert_eq!(
        serde_json::to_value(&runs[1].by_fittings).expect("JSON"),
        serde_json::json!([
            { "true": "elbow-left", "named": "elbow-right", "count": 1 }
        ])
    );
}
