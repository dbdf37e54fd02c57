//! Scenario files as users meet them: what is wrong is said in place, what is right survives being written out.

#[path = "scenario_files/overlays.rs"]
mod overlays;
#[path = "scenario_files/properties.rs"]
mod properties;
#[path = "scenario_files/schema.rs"]
mod schema;

use std::path::{Path, PathBuf};

use ductloop::scenario::{FileKind, Overlays, Scenario, Surface};
use ductloop_nav::rig::Distortion;
use ductloop_sensor::optics::{Bits, FanProfile, Optics};
use ductloop_sim::spec::RobotSpec;

/// A scenario that says no more than it must.
const LEAST: &str =
    "format = 1\nkind = \"scenario\"\nname = \"least\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 6.0 }]\n";

/// The files of a folder with this ending, sorted.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect(folder);
    let mut files: Vec<_> =
        entries.map(|e| e.expect(folder).path()).filter(|p| p.extension().is_some_and(|e| e == ending)).collect();
    files.sort();
    assert!(!files.is_empty(), "no .{ending} in {folder}");
    files
}

fn read(path: &Path) -> Result<Scenario, ductloop::scenario::Diagnostics> {
    Scenario::read(path, &Overlays::default())
}

/// Each `bad_scenarios/X.toml` gives exactly the errors of `X.txt`. With `UPDATE_EXPECTED=1` in the environment the test rewrites
/// the expectations and fails, so that they are looked at before they count.
#[test]
fn bad_files_give_the_expected_errors() {
    let update = std::env::var_os("UPDATE_EXPECTED").is_some();
    let mut different = Vec::new();
    for path in files("tests/data/bad_scenarios", "toml") {
        let errors = read(&path).expect_err(&path.display().to_string());
        let said = format!("{}\n", errors.render(false));
        let expected_path = path.with_extension("txt");
        let expected = std::fs::read_to_string(&expected_path).unwrap_or_default();
        if said != expected {
            if update {
                std::fs::write(&expected_path, &said).expect("expectations can be rewritten");
            }
            different.push(format!("{}\n--- expected\n{expected}\n--- said\n{said}", path.display()));
        }
        let json = errors.to_json();
        for (error, json) in errors.0.iter().zip(json.as_array().expect("an array")) {
            let place = error.place.as_ref().expect("an error in a file has a place");
            assert_eq!(json["line"], place.line);
            assert_eq!(json["column"], place.column);
            assert_eq!(json["file"], path.display().to_string());
            assert!(json["message"].is_string() && json.get("help").is_some());
            let related = json["related"].as_array().expect("an array");
            assert_eq!(related.len(), error.related.len());
            for (other, json) in error.related.iter().zip(related) {
                assert_eq!(json["line"], other.place.line);
                assert_eq!(json["column"], other.place.column);
                assert_eq!((&json["file"], &json["message"]), (&other.file.clone().into(), &other.message.clone().into()));
                assert!(said.contains(&other.message), "{said}");
            }
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n\n"));
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let missing = read("tests/data/nowhere/missing.toml".as_ref()).expect_err("there is no such file");
    let [error] = &missing.0[..] else { panic!("one error: {missing}") };
    assert_eq!((error.file.as_str(), &error.place), ("tests/data/nowhere/missing.toml", &None));
    assert!(error.message.contains("no such file"), "{error:?}");
    assert!(error.help.as_ref().expect("help").contains("tests/data/nowhere"), "{error:?}");
    assert_eq!(error.to_json()["line"], serde_json::Value::Null);

    let folder = read("tests/data".as_ref()).expect_err("it is a folder");
    assert!(folder.0[0].message.contains("folder"), "{folder}");
}

#[test]
fn line_ends_and_marks_of_other_systems_are_read() {
    let expected = Scenario::from_toml_str(LEAST);
    assert_eq!(Scenario::from_toml_str(&LEAST.replace('\n', "\r\n")), expected);
    assert_eq!(Scenario::from_toml_str(&format!("\u{feff}{LEAST}")), expected);
    let errors = Scenario::from_toml_str(&LEAST.replace("height_m", "heigth_m").replace('\n', "\r\n")).expect_err("a typo");
    let place = errors.0[0].place.as_ref().expect("a place");
    assert_eq!((place.line, place.column, place.text.as_str()), (6, 1, "heigth_m = 0.3"));
}

#[test]
fn colours_are_for_terminals_only() {
    let errors = Scenario::from_toml_str("sede = 1").expect_err("an unknown key");
    assert!(!errors.render(false).contains('\u{1b}'));
    assert!(errors.render(true).contains('\u{1b}'));
}

#[test]
fn every_scenario_of_the_library_survives_being_written_out() {
    for entry in ductloop::library::all() {
        let scenario = entry.read(&Overlays::default()).unwrap_or_else(|errors| panic!("{errors}"));
        let text = scenario.to_toml();
        let again = Scenario::from_toml_str(&text).unwrap_or_else(|errors| panic!("{}\n{errors}", entry.name));
        assert_eq!(again, scenario, "{}", entry.name);
        assert_eq!(again.to_toml(), text, "{}", entry.name);
    }
}

#[test]
fn presets_and_defaults_are_those_of_the_parts() {
    let scenario = Scenario::from_toml_str(LEAST).expect("valid");
    assert_eq!(scenario.robot, RobotSpec::incra1());
    assert_eq!(scenario.optics, Optics::default());
    assert_eq!(scenario.perception.paper, Default::default());
    let wheel_bandwidth_rad_s = scenario.control.wheel_bandwidth_rad_s;
    assert_eq!(scenario.control, ductloop::scenario::Control { wheel_bandwidth_rad_s, ..Default::default() });
    assert_eq!(scenario.navigation.width_m, scenario.duct.width_m);
    assert_eq!(scenario.actual_rig(), scenario.rig);
    let surfaces: Vec<_> = scenario.surfaces.iter().map(|s: &Surface| s.name.as_str()).collect();
    assert_eq!(surfaces, ["galvanised"]);
}

#[test]
fn the_rig_of_a_preset_is_as_its_source_gives_it() {
    let with = |preset: &str| Scenario::from_toml_str(&format!("{LEAST}[sensor]\npreset = \"{preset}\"\n")).expect("valid").rig;
    let wide = with("wide");
    assert_eq!(wide.lasers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["low", "high"]);
    // The sources in the base frame at rest, where the mount stands at zero: 60 mm below and above the camera's centre.
    let base_from_camera = wide.mount.base_from_camera(Default::default());
    for (laser, height_m) in wide.lasers.iter().zip([0.04, 0.16]) {
        let source = base_from_camera * laser.source_in_camera;
        assert!((source - nalgebra::Point3::new(0.12, 0.0, height_m)).norm() < 1e-12, "{source}");
    }

    let incra1 = with("incra1");
    assert_eq!(incra1.lasers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["right", "left"]);
    let foot = incra1.lasers[0].normal_in_camera.into_inner() * incra1.lasers[0].offset_m;
    assert_eq!(incra1.lasers[0].source_in_camera.coords, foot);
    // Looking 50 degrees to the right, the line of sight has a part to the right (negative y).
    let sight = incra1.mount.base_from_camera(incra1.mount.rest) * nalgebra::Vector3::z();
    assert!((sight.y + libm::sin(50f64.to_radians())).abs() < 1e-12, "{sight}");
    // Portrait: increasing u points down.
    let down = incra1.mount.base_from_camera(incra1.mount.rest) * nalgebra::Vector3::x();
    assert!((down.z + 1.0).abs() < 1e-12, "{down}");
}

#[test]
fn the_true_rig_carries_the_errors() {
    let text = format!("{LEAST}[sensor.error]\npan_deg = 0.5\nlaser_plane_deg = [0.0, 2.0]\n");
    let scenario = Scenario::from_toml_str(&text).expect("valid");
    let actual = scenario.actual_rig();
    assert_eq!(actual.mount.rest.pan_rad, scenario.rig.mount.rest.pan_rad + 0.5f64.to_radians());
    assert_eq!(actual.lasers[0], scenario.rig.lasers[0]);
    let turned = actual.lasers[1].normal_in_camera.angle(&scenario.rig.lasers[1].normal_in_camera);
    // The normal is nearly square to the axis of turning, so it turns by nearly all of the angle.
    assert!((turned.to_degrees() - 2.0).abs() < 0.01, "{}", turned.to_degrees());
}

#[test]
fn words_of_the_sensor_are_taken_for_what_they_say_and_survive() {
    let text = format!(
        "{LEAST}[sensor]\nexposure = \"auto\"\n[sensor.auto_exposure]\ntarget_dn = 120.0\nmax_ms = 8.0\n[sensor.camera]\n\
         distortion = [-0.1, 0.02, 0.001, -0.002, 0.003]\n[sensor.light]\nfan_profile = \"cylinder\"\n[sensor.ccd]\nbits = 12\n\
         [surface.galvanised]\nspangle_mm = 7.0\n"
    );
    let scenario = Scenario::from_toml_str(&text).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((scenario.exposure_s, scenario.first_exposure_s()), (None, 0.004));
    assert_eq!((scenario.auto_exposure.target_dn, scenario.auto_exposure.exposure_s[1]), (120.0, 0.008));
    let distortion = Distortion { k1: -0.1, k2: 0.02, p1: 0.001, p2: -0.002, k3: 0.003 };
    assert_eq!(scenario.rig.camera.distortion, distortion);
    assert_eq!(scenario.optics.fan_profile, FanProfile::Cylinder);
    assert_eq!(scenario.optics.ccd.bits, Bits::Twelve);
    // What a file says of a surface is laid over the preset's.
    let look = scenario.surfaces[0].look;
    assert_eq!((look.spangle_m, look.specular), (0.007, 0.2));
    let written = scenario.to_toml();
    let light = written.split("[sensor.light]").nth(1).and_then(|rest| rest.split("\n[").next()).expect("a table");
    assert!(!light.contains("fan_edge"), "a cylinder lens has none:\n{light}");
    assert_eq!(Scenario::from_toml_str(&written), Ok(scenario));
}

#[test]
fn a_scenario_changed_by_hand_is_checked_like_a_file() {
    let mut scenario = Scenario::from_toml_str(LEAST).expect("valid");
    scenario.speed_m_s = 0.2;
    assert_eq!(scenario.validate(), Ok(()));
    scenario.duct.width_m = 0.1;
    scenario.seed = u64::MAX;
    scenario.exposure_s = Some(f64::NAN);
    let said = scenario.validate().expect_err("it cannot run").to_string();
    assert!(said.contains("too narrow"), "{said}");
    assert!(said.contains("finite"), "{said}");
}

#[test]
fn sweeps_and_studies_are_told_apart() {
    assert_eq!(FileKind::of(LEAST), Some(FileKind::Scenario));
    assert_eq!(FileKind::of("kind = \"sweep\"\nbroken ="), Some(FileKind::Sweep));
    assert_eq!(FileKind::of("kind = \"study\""), Some(FileKind::Study));
    assert_eq!(FileKind::of("kind = \"recipe\""), None);
    assert_eq!(FileKind::of(""), None);
}
