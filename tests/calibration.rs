//! The paper's tables, and the paper's experiment done again from image to millimetre.
#![cfg(feature = "cli")]

use ductloop::calibrate::gauge::{self, file::GaugeFile};
use ductloop::calibrate::linear::Applied;
use ductloop::calibrate::model::Fitted;
use ductloop::calibrate::points::Points;
use ductloop::calibrate::table::Table;
use ductloop::calibrate::{boards, camera, matrix};
use ductloop::engine::Engine;
use ductloop::scenario::Overlays;
use ductloop::{Scenario, calibrate};
use ductloop_nav::calibration::model::{Free, Scatter};
use proptest::prelude::*;

const TABLE_1: &str = include_str!("data/incra1/table1.csv");
const TABLES: [(&str, &str); 2] =
    [("right", include_str!("data/incra1/right.csv")), ("left", include_str!("data/incra1/left.csv"))];

fn points([name, text]: [&str; 2]) -> Points {
    Points::parse(&format!("{name}.csv"), text).expect("a table of the paper")
}

/// Within `tolerance` of what is expected.
#[track_caller]
fn assert_near(value: Option<f64>, expected: f64, tolerance: f64) {
    let value = value.expect("a value");
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}

/// Table 1 applied to the pixels of tables 2 and 3 gives the estimates printed there, which miss the actual positions by 13.6 and
/// 14.8 mm RMS.
#[test]
fn table_1_gives_the_printed_estimates() {
    for ((name, text), rms_mm) in TABLES.into_iter().zip([13.56, 14.81]) {
        let points = points([name, text]);
        let printed =
            Table::parse(name, text).expect("a table").numbers(["x_est_mm", "y_est_mm", "z_est_mm"]).expect("estimates");
        let t = matrix::parse("table1.csv", TABLE_1, Some(name)).expect("T");
        let applied = Applied::apply(t, &points);
        assert_eq!(printed.len(), applied.estimates_mm.len());
        for (printed, estimate) in printed.iter().zip(&applied.estimates_mm) {
            let estimate = estimate.expect("not on the horizon");
            for axis in 0..3 {
                assert!((estimate[axis] - printed[axis]).abs() <= 0.005, "{name}: {estimate} {printed:?}");
            }
        }
        assert_near(applied.rms_mm, rms_mm, 0.01);
    }
}

/// Equation 14 solved afresh: in sample, and with each point left out.
#[test]
fn equation_14_afresh() {
    let expected = [("right", 3.77, 6.43, 5e5), ("left", 0.523, 2.78, 9e5)];
    for ((name, text), (_, rms_mm, left_out_mm, printed)) in TABLES.into_iter().zip(expected) {
        let solved = Applied::solve(&points([name, text])).expect("T");
        assert_near(solved.rms_mm, rms_mm, 0.01);
        assert_near(solved.leave_one_out_rms_mm, left_out_mm, 0.01);
        let [condition, unscaled] = solved.condition.expect("solved");
        assert!(condition < 15.0 && (0.9..1.1).contains(&(unscaled / printed)), "{condition} {unscaled}");
        assert_eq!(solved.t[(3, 2)], 1.0);
    }
}

/// The rig that `presets/sensor/incra1.toml` holds misses the tables by 4.2 and 7.3 mm; the fit to the same points comes near it, and
/// misses them by less.
#[test]
fn the_model_comes_near_the_preset() {
    let tables = TABLES.map(|(name, text)| (name.to_owned(), points([name, text])));
    let stated = Scatter { pixel_px: 1.0, position_mm: 0.5 };
    let fitted = Fitted::fit(&tables, &camera::incra1(), Free::default(), stated).expect("a rig");
    for (laser, worst_mm) in [4.2, 7.3].into_iter().enumerate() {
        assert!(fitted.rms_mm(laser).expect("points") < worst_mm, "{laser}: {:?}", fitted.rms_mm(laser));
    }
    let preset = Scenario::from_toml_str(include_str!("../scenarios/straight-incra1.toml")).expect("a scenario").rig;
    for (laser, known) in preset.lasers.iter().enumerate() {
        let (normal, offset_mm) = fitted.rig.plane(laser);
        let turned = libm::acos(normal.dot(&known.normal_in_camera).min(1.0)).to_degrees();
        // Three standard deviations, as the fit states them: 0.19 and 0.33 degrees, 0.9 and 1.0 mm.
        assert!(turned < 1.0 && (offset_mm - known.offset_m * 1e3).abs() < 3.0, "{}: {turned} deg, {offset_mm} mm", known.name);
    }
    assert!(fitted.rig.sigma.focal_px.is_none() && fitted.rig.if_free.focal_px.is_some_and(|sigma| sigma > 5.0));

    // What is written can be laid over a scenario.
    let folder = tempfile::tempdir().expect("a folder");
    let with = folder.path().join("rig.toml");
    std::fs::write(&with, fitted.to_toml()).expect("a file");
    let overlays = Overlays { with: vec![with], set: Vec::new() };
    let laid = Scenario::read("scenarios/straight-incra1.toml".as_ref(), &overlays).unwrap_or_else(|errors| panic!("{errors}"));
    for (laser, laid) in laid.rig.lasers.iter().enumerate() {
        assert!((laid.offset_m * 1e3 - fitted.rig.plane(laser).1).abs() < 1e-9);
    }
}

/// Rendered, found, calibrated, and tested at other depths: half a millimetre is the goal. Eight seeds: not a lucky one.
#[test]
fn the_simulated_block_gauge_is_measured_to_half_a_millimetre() {
    let text = include_str!("../scenarios/gauge/incra1.toml");
    for seed in 1..=8 {
        let file = GaugeFile::parse("incra1.toml", &text.replace("seed = 1\n", &format!("seed = {seed}\n"))).expect("a gauge");
        assert_eq!(file.scenario.seed, seed);
        let result = gauge::run(&file, &Engine::Cpu, 2).expect("a result");
        for (laser, points) in result.lasers.iter().zip([13, 6]) {
            let (own, test) = (gauge::rms(&laser.calibration), gauge::rms(&laser.test));
            println!(
                "seed {seed} laser {}: 3D RMS {own:.3?} mm of {} points, {test:.3?} mm of {} others, centres {:.3} px",
                laser.name,
                laser.calibration.len(),
                laser.test.len(),
                laser.centre_rms_px()
            );
            assert_eq!((laser.calibration.len(), laser.unseen[0]), (points, 0), "every place of the tables is in view");
            assert!(laser.test.len() >= 19);
            assert!(own.is_some_and(|rms| rms < 0.5) && test.is_some_and(|rms| rms < 0.5), "{own:?} {test:?}");
            assert!(laser.centre_rms_px() < 0.15, "{}", laser.centre_rms_px());
        }
        let figure = gauge::figure::svg(&result);
        assert!(figure.starts_with("<svg") && !figure.contains("NaN") && !figure.contains("inf"), "{figure}");
    }
}

proptest! {
    /// Any bytes: read or refused, never a panic.
    #[test]
    fn any_bytes_are_a_table_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400), header in any::<bool>()) {
        let body = String::from_utf8_lossy(&bytes).into_owned();
        let text = if header { format!("u_px,v_px,x_mm,y_mm,z_mm\n{body}") } else { body };
        any_text(&text);
    }

    /// Tables that nearly are some: cells of all kinds.
    #[test]
    fn nearly_tables_are_survived(
        rows in prop::collection::vec(prop::collection::vec(
            prop_oneof![
                "-?[0-9]{1,4}(\\.[0-9]{1,3})?", Just("nan".to_owned()), Just("1e999".to_owned()), Just("\"".to_owned()),
                Just(String::new()),
                Just("\u{fc}".to_owned()), Just("#".to_owned()),
            ], 4..7), 0..8),
    ) {
        let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
        any_text(&format!("u_px,v_px,x_mm,y_mm,z_mm\n{}", lines.join("\n")));
    }
}

fn any_text(text: &str) {
    match Points::parse("any.csv", text) {
        Ok(points) => match Applied::solve(&points) {
            Ok(solved) => {
                assert!(solved.t.iter().all(|value| value.is_finite()));
                let _ = (solved.to_text(&points), solved.to_json(&points));
            }
            Err(errors) => assert!(!errors.0.is_empty() && !errors.render(false).is_empty()),
        },
        Err(errors) => assert!(!errors.0.is_empty() && !errors.render(false).is_empty()),
    }
    let _ = matrix::parse("any.csv", text, None);
    let _ = boards::Boards::parse("any.csv", text);
    let _ = calibrate::camera::parse("any.toml", text);
    let _ = GaugeFile::parse("any.toml", text);
}
