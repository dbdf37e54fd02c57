//! `--with` and `--set`.

use std::path::PathBuf;

use ductloop::scenario::{Diagnostics, FaultKind, Overlays, Scenario};

const BASE: &str = "scenarios/straight.toml";

fn set(sets: &[&str]) -> Result<Scenario, Diagnostics> {
    let set = sets.iter().map(|s| (*s).to_owned()).collect();
    Scenario::read(BASE.as_ref(), &Overlays { with: Vec::new(), set })
}

/// Line, column, message and help of the one error that an argument gives.
fn error_of(argument: &str) -> (usize, usize, String, String) {
    let errors = set(&[argument]).expect_err(argument);
    let [error] = &errors.0[..] else { panic!("{argument}: one error, not\n{errors}") };
    assert_eq!(error.file, format!("--set {argument}"), "errors name the argument");
    let place = error.place.as_ref().expect("a place in the argument");
    (place.line, place.column, error.message.clone(), error.help.clone().unwrap_or_default())
}

#[test]
fn a_set_reaches_every_kind_of_field() {
    let scenario = set(&[
        "seed=7",
        "name=other",
        "duct.run=[{ straight_m = 2.0 }, { straight_m = 3.0 }]",
        "duct.run[1].straight_m = 4",
        "surface.brick = { albedo = 0.4, friction = 0.8 }",
        "duct.run[0].surface=brick",
        "fault=[{ kind = \"frame-blank\", at_s = 1.0 }]",
        "fault[0].at_s=2.5",
        "fault[0].kind=laser-off",
        "fault[0].laser=high",
        "sensor.error.pan_deg=-0.25",
        "pass.lateral_rms_mm=1.5",
        "perception.pipeline=truth",
        "duct.bead_mm=2.5",
        "duct.bead_width_mm=15",
        "duct.object=[{ size_m = [0.2, 0.1, 0.05], at_m = 2.0 }, \
         { name = \"plank\", size_m = [0.02, 0.02, 0.3], at_m = 1.5, left_m = -0.2 }]",
        "duct.object[0].turned_deg=30",
        "duct.object[0].surface=brick",
        "sensor.laser.high.power=0.5",
        "sensor.light.shadows=false",
    ])
    .unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((scenario.seed, scenario.name.as_str()), (7, "other"));
    assert_eq!(scenario.duct.network().expect("valid").centreline.length_m(), 6.0);
    assert_eq!(scenario.surfaces.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["galvanised", "brick"]);
    assert_eq!(scenario.duct.run[0].surface.0, 1);
    assert_eq!(scenario.faults[0].at_s, 2.5);
    assert_eq!(scenario.faults[0].kind, FaultKind::LaserOff { laser: 1 });
    assert_eq!((scenario.duct.bead_m, scenario.duct.bead_width_m), (0.0025, 0.015));
    let [first, second] = &scenario.duct.objects[..] else { panic!("two objects: {:?}", scenario.duct.objects) };
    assert_eq!((first.name.as_str(), first.turned_rad, first.surface.0), ("", 30f64.to_radians(), 1));
    assert_eq!((second.name.as_str(), second.left_m, second.surface), ("plank", -0.2, scenario.duct.surface));
    assert_eq!(scenario.laser_power, [1.0, 0.5]);
    assert!(!scenario.optics.shadows);
    assert_eq!(scenario.rig_error.pan_rad, -(0.25f64.to_radians()));
    let bound = &scenario.pass.get("lateral_rms_mm").expect("a criterion").bound;
    assert_eq!(*bound, ductloop::scenario::Bound::AtMost(0.0015));
}

#[test]
fn the_last_word_is_the_last_argument_and_files_come_before_fields() {
    let folder = tempfile::tempdir().expect("a folder");
    let overlay = |name: &str, text: &str| -> PathBuf {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("an overlay");
        path
    };
    let first = overlay("first.toml", "[robot]\nspeed_m_s = 0.1\n[duct]\nrun = [{ straight_m = 3.0 }]\n");
    let second = overlay("second.toml", "[robot]\nspeed_m_s = 0.2\nmass_kg = 4.0\n");
    let read = |with: &[&PathBuf], set: &[&str]| {
        let with = with.iter().map(|p| (*p).clone()).collect();
        let set = set.iter().map(|s| (*s).to_owned()).collect();
        Scenario::read(BASE.as_ref(), &Overlays { with, set }).unwrap_or_else(|errors| panic!("{errors}"))
    };
    let both = read(&[&first, &second], &[]);
    assert_eq!((both.speed_m_s, both.robot.mass_kg), (0.2, 4.0));
    assert_eq!(both.duct.run.len(), 1, "arrays are replaced");
    assert_eq!(both.duct.width_m, 0.5, "tables merge");
    assert_eq!(read(&[&second, &first], &[]).speed_m_s, 0.1);
    assert_eq!(read(&[&first], &["robot.speed_m_s=0.4", "robot.speed_m_s=0.5"]).speed_m_s, 0.5);
}

#[test]
fn presets_resolve_after_overlays() {
    let narrow = set(&["sensor.preset=incra1"]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(narrow.rig.lasers[0].name, "right");
    let width = set(&["duct.width_m=0.7"]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(width.navigation.width_m, 0.7);
    // A resolved file no longer depends on presets, but takes overlays all the same.
    let resolved = Scenario::from_toml_str(&narrow.to_toml()).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(resolved, narrow);
}

#[test]
fn a_source_given_in_one_frame_replaces_the_one_given_in_the_other() {
    let moved = set(&["sensor.laser.low.source_in_base_m=[0.12, 0.0, 0.04]"]).unwrap_or_else(|errors| panic!("{errors}"));
    let source = moved.rig.lasers[0].source_in_camera;
    assert!((source - nalgebra::Point3::new(0.0, 0.06, 0.0)).norm() < 1e-12, "{source}");
}

#[test]
fn errors_name_the_argument_and_the_place_in_it() {
    let cases = [
        ("robot.sped_m_s=1", 7, "unknown key `sped_m_s` in [robot]", "did you mean `speed_m_s`?"),
        ("robot.speed_m_s=9", 17, "`robot.speed_m_s` is 9 m/s", "Speed along the duct"),
        ("robot.speed_m_s = fast", 19, "must be a number, not a string", "[m/s]"),
        ("robot.speed_m_s", 1, "no `=`", "robot.speed_m_s=0.2"),
        ("=3", 1, "has no name", "duct.run[1].elbow_deg"),
        ("fault[0].at_s=1", 1, "`fault` has no such element", "--with"),
        ("duct.run[3].straight_m=1", 9, "`run` has no such element", "index 0"),
        ("duct.run[a].straight_m=1", 6, "an index is a whole number", "duct.run[1].elbow_deg"),
        ("duct.run[0.straight_m=1", 6, "without `]`", "duct.run[1].elbow_deg"),
        ("duct.run[0]x=1", 6, "after an index", "duct.run[1].elbow_deg"),
        ("duct.run.straight_m=1", 10, "is an array", "run[0]"),
        ("duct.width_m.x=1", 14, "cannot go on", "ends at `width_m`"),
        ("duct.width_m[0]=1", 13, "cannot go on", "ends at `width_m`"),
        ("duct=3", 6, "`duct` is a table", "[duct]"),
        ("duct.object[0].at_m=1", 6, "`object` has no such element", "--with"),
        ("duct.object=[{ size_m = [0.1, 0.1, 0.1], at_m = 5.97 }]", 49, "reaches out of the duct", "0.050 to 5.950"),
        ("duct.surface=brick", 14, "no surface \"brick\"", "galvanised-dusty"),
        ("sensor.laser.low.offset_m=0", 27, "shows no depth", "0.001"),
        ("rates.camera_hz=7", 17, "does not divide", "6 and 8"),
        ("duct.width_m=0.2", 14, "too narrow", "0.217"),
        ("duct.height_m=0.1", 15, "too low", "0.176"),
        ("robot.wheel_radius_m=0.09", 22, "cannot be built", "overlap"),
    ];
    for (argument, column, message, help) in cases {
        let (line, at, said, helped) = error_of(argument);
        assert_eq!((line, at), (1, column), "{argument}: {said}");
        assert!(said.contains(message), "{argument}: {said}");
        assert!(helped.contains(help), "{argument}: {helped}");
    }
}

#[test]
fn an_overlay_that_cannot_be_read_is_named() {
    let overlays = Overlays { with: vec!["tests/nowhere.toml".into()], set: vec!["robot.sped=1".to_owned()] };
    let errors = Scenario::read(BASE.as_ref(), &overlays).expect_err("there is no such file");
    assert_eq!(errors.0[0].file, "--with tests/nowhere.toml");
}

/// The bounds that help names for a robot in its duct are accepted, and a millimetre beyond them is not.
#[test]
fn what_help_says_is_right_is_accepted() {
    for (accepted, refused) in [
        ("duct.width_m=0.217", "duct.width_m=0.216"),
        ("duct.height_m=0.176", "duct.height_m=0.175"),
        ("start.distance_m=0.121", "start.distance_m=0.12"),
        ("start.lateral_m=0.141", "start.lateral_m=0.142"),
        ("start.lateral_m=-0.141", "start.lateral_m=-0.142"),
        ("rates.camera_hz=8", "rates.camera_hz=7"),
        ("sensor.exposure=33.3", "sensor.exposure=33.4"),
        ("pass.settle_m=4.999", "pass.settle_m=5"),
    ] {
        assert!(set(&[accepted]).is_ok(), "{accepted}: {}", set(&[accepted]).expect_err("errors"));
        assert!(set(&[refused]).is_err(), "{refused}");
    }
}
