//! Whatever stands in a file, reading it ends with a scenario or with errors; what was read is written without loss.

use ductloop::Scenario;
use ductloop::scenario::Overlays;
use proptest::prelude::*;

use super::LEAST;

/// A resolved file: every field stands in it.
fn full() -> String {
    let text = format!(
        "{LEAST}bead_mm = 2.0\n[[duct.object]]\nname = \"brick\"\n\
         size_m = [0.1, 0.05, 0.02]\nat_m = 3.0\nleft_m = 0.15\nabove_m = 0.02\n\
         turned_deg = 20.0\n[start]\nlateral_m = 0.01\n\
         heading_deg = 2.0\n[[fault]]\nkind = \"laser-off\"\nat_s = 1.0\nfor_s = 0.5\nlaser = \"low\"\n\
         [pass]\ncompleted = true\nend_state = \"finished\"\nstop_reason = \"obstacle\"\ncollisions = 3\n\
         contact_speed_max_m_s = 0.5\nmin_clearance_mm = 5.0\n\
         lateral_rms_mm = 5.0\nlateral_max_mm = 20.0\nheading_rms_deg = 0.5\nheading_max_deg = 2.0\nlateral_estimate_rms_mm = 3.0\n\
         heading_estimate_rms_deg = 0.25\nestimates_valid_min = 0.9\nsim_time_s = 30.0\ndistance_min_m = 4.0\ncontrol_effort = 100.0\n\
         junctions_taken_min = 2\nsurvey_drift_share = 0.01\nsurvey_length_error_max = 0.01\nsurvey_width_error_max_mm = 2.0\n\
         survey_deposits_missed = 0\nsurvey_deposits_false = 0\nsurvey_deposit_error_max_mm = 2.0\n\
         ahead_named_share_min = 0.98\nahead_detection_widths_min = 1.5\nahead_latency_max_s = 4.0\n\
         ahead_distance_error_max_mm = 100.0\nahead_false_alarms = 0\n\
         settle_m = 1.0\n"
    );
    Scenario::from_toml_str(&text).unwrap_or_else(|errors| panic!("{errors}")).to_toml()
}

/// The same of a network with every fitting, branches, a loop's end and a route.
fn network() -> String {
    let text = "format = 1\nkind = \"scenario\"\nname = \"net\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nexit = \"cap\"\nrun = [\n\
         { straight_m = 2.0 }, { tee = \"left\", name = \"first\", branch_width_m = 0.45 }, { straight_m = 2.0 },\n\
         { side_branch = \"right\", branch_width_m = 0.4, shoe_m = 0.15 }, { grille = \"left\" }, { offset_m = 0.4 },\n\
         { transition_m = 0.6, to_width_m = 0.4, to_height_m = 0.25 }, { elbow_deg = -90 }, { slope_deg = 5, length_m = 1.5 },\n\
         { damper = \"open\" }, { wye_deg = 45, branch_width_m = 0.41 }]\n\
         [[duct.branch]]\nfrom = \"first.left\"\nrun = [{ straight_m = 1.5 }, { cross_m = 0.5, left_end = \"open\" }, { vaned_deg = 45 }]\n\
         [[duct.branch]]\nfrom = \"side-branch-1.right\"\nend = \"open\"\nrun = [{ straight_m = 1.2 }, { drop_m = 0.5, hole_width_m = 0.3 }]\n\
         [[duct.branch]]\nfrom = \"wye-1.right\"\nrun = [{ straight_m = 1.0 }, { bullhead_m = 0.3 }]\n\
         [route]\nturns = [\"left\", \"straight\", \"stop\"]\nturn_back_m = 0.7\n";
    Scenario::from_toml_str(text).unwrap_or_else(|errors| panic!("{errors}")).to_toml()
}

/// A network is written as it was read, and each number of each of its fittings has a place of its own.
#[test]
fn a_network_survives_being_written_out_and_each_number_has_its_place() {
    let text = network();
    let scenario = Scenario::from_toml_str(&text).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(scenario.to_toml(), text);
    let lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().position(|line| line.starts_with("[[duct.run]]")).expect("a run");
    let last = lines.iter().rposition(|line| line.starts_with("[[duct.branch.run]]")).expect("a branch");
    let mut changed = Vec::new();
    for (i, line) in lines.iter().enumerate().take(last + 4).skip(first) {
        let Some((key, old)) = line.split_once(" = ") else { continue };
        let other = others(old).into_iter().find_map(|new| {
            let mut lines = lines.clone();
            let line = format!("{key} = {new}");
            lines[i] = &line;
            let text = format!("{}\n", lines.join("\n"));
            Scenario::from_toml_str(&text).ok().map(|scenario| (scenario.to_toml(), text))
        });
        if let Some((written, text)) = other {
            assert_eq!(written, text, "{line}");
            changed.push(key);
        }
    }
    changed.sort_unstable();
    changed.dedup();
    let numbers = [
        "bullhead_m",
        "cross_m",
        "depth_m",
        "drop_m",
        "elbow_deg",
        "hole_width_m",
        "length_m",
        "offset_m",
        "opening_height_m",
        "opening_length_m",
        "shoe_m",
        "slope_deg",
        "straight_m",
        "throat_radius_m",
        "transition_m",
        "vaned_deg",
        "wye_deg",
    ];
    for number in numbers {
        assert!(changed.contains(&number), "no other value was accepted for {number}");
    }
}

/// Drawn from the seed, a network reads back from its resolved file to the same bits.
#[test]
fn a_drawn_network_is_written_out_as_if_typed() {
    let text = |seed: u64| {
        format!(
            "format = 1\nkind = \"scenario\"\nname = \"r\"\nseed = {seed}\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n[duct.random]\n"
        )
    };
    for seed in 0..200 {
        let drawn = Scenario::from_toml_str(&text(seed)).unwrap_or_else(|errors| panic!("{errors}"));
        let written = drawn.to_toml();
        assert!(!written.contains("random") && written.contains("name = \"straight-1\""));
        let again = Scenario::from_toml_str(&written).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(again, drawn);
        assert_eq!(again.duct.network(), drawn.duct.network());
    }
}

/// One that is drawn and explored takes no turns, drawn ones neither.
#[test]
fn a_drawn_network_that_is_explored_is_written_out_without_turns() {
    let text = "format = 1\nkind = \"scenario\"\nname = \"r\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n[duct.random]\nseed = 7\n";
    let drawn = Scenario::from_toml_str(&format!("{text}[route]\nexplore = true\n")).unwrap_or_else(|errors| panic!("{errors}"));
    assert!(drawn.duct.route.explore && drawn.duct.route.turns.is_empty());
    assert!(!Scenario::from_toml_str(text).unwrap_or_else(|errors| panic!("{errors}")).duct.route.turns.is_empty());
    assert_eq!(Scenario::from_toml_str(&drawn.to_toml()), Ok(drawn));
}

/// Reading must end, and what it says must be renderable both ways.
fn read_and_render(text: &str) {
    match Scenario::from_toml_str(text) {
        Ok(scenario) => assert_eq!(Scenario::from_toml_str(&scenario.to_toml()).as_ref(), Ok(&scenario)),
        Err(errors) => {
            assert!(!errors.0.is_empty());
            for error in &errors.0 {
                assert!(!error.render(true).is_empty() && !error.message.is_empty());
                let place = error.place.as_ref().expect("an error in a text has a place");
                assert!(place.line >= 1 && place.column >= 1 && place.text.get(place.mark.clone()).is_some());
            }
        }
    }
}

/// `normal` is near enough to `format` to be taken for it; the error must not get lost between the two.
#[test]
fn a_key_that_is_like_format_is_told_of() {
    for text in ["normal = 1", "normal = \"\"#", "knd = \"scenario\""] {
        read_and_render(text);
    }
}

/// Other values near `old`, with few digits, so that they are their own shortest spelling.
fn others(old: &str) -> Vec<String> {
    if old == "true" || old == "false" {
        return vec![(old == "false").to_string()];
    }
    if let Ok(x) = old.parse::<i64>() {
        return vec![(x + 1).to_string(), (x * 2).to_string(), (x + 2).to_string()];
    }
    let Ok(x) = old.parse::<f64>() else { return Vec::new() };
    let few = |x: f64| format!("{:?}", format!("{x:.3e}").parse::<f64>().expect("a number"));
    if x == 0.0 { vec![few(0.0123), few(1.23e-5)] } else { vec![few(x * 1.013), few(x * 0.987)] }
}

/// Every field of a resolved file is read into a place of its own: change one, and that one, and nothing else, comes out
/// changed.
#[test]
fn each_field_has_a_place_of_its_own() {
    let full = full();
    let lines: Vec<&str> = full.lines().collect();
    let mut unchangeable = Vec::new();
    let mut changed_fields = 0;
    for (i, line) in lines.iter().enumerate() {
        let Some((key, old)) = line.split_once(" = ") else { continue };
        if key == "normal" {
            // It is made a unit vector again, which changes its other components.
            continue;
        }
        let mut candidates = others(old);
        if let Some(items) = old.strip_prefix('[').and_then(|o| o.strip_suffix(']')) {
            let items: Vec<&str> = items.split(", ").collect();
            for (k, item) in items.iter().enumerate() {
                for other in others(item) {
                    let mut items = items.clone();
                    items[k] = &other;
                    candidates.push(format!("[{}]", items.join(", ")));
                }
            }
        }
        let changed = |new: &String| {
            let mut lines = lines.clone();
            let line = format!("{key} = {new}");
            lines[i] = &line;
            format!("{}\n", lines.join("\n"))
        };
        match candidates.iter().map(changed).find_map(|text| Scenario::from_toml_str(&text).ok().map(|s| (text, s))) {
            Some((text, scenario)) => {
                assert_eq!(scenario.to_toml(), text, "{key}");
                changed_fields += 1;
            }
            None => unchangeable.push(key),
        }
    }
    // Strings, and numbers that other fields tie down: a laser's plane and its source; a width that holds all along, the one at the start.
    let tied = [
        "format",
        "kind",
        "name",
        "about",
        "preset",
        "fan_profile",
        "width",
        "offset_m",
        "source_in_camera_m",
        "pipeline",
        "law",
        "line_fit",
        "plane_fit",
        "surface",
        "entry",
        "exit",
        "end_state",
        "stop_reason",
        "laser",
        "shape",
        "arithmetic",
        "voltage_limit_v",
        "acceleration_rad_s2",
    ];
    unchangeable.retain(|key| !tied.contains(key));
    assert!(unchangeable.is_empty(), "no other value was accepted for {unchangeable:?}");
    assert!(changed_fields > 80, "{changed_fields}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_text_never_panics(text in ".{0,200}") {
        read_and_render(&text);
    }

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), &bytes).expect("written");
        if let Err(errors) = Scenario::read(file.path(), &Overlays::default()) {
            prop_assert!(!errors.render(false).is_empty());
        }
    }

    #[test]
    fn random_toml_like_text_never_panics(parts in proptest::collection::vec(
        prop::sample::select(vec![
            "[", "]", "[[", "]]", "{", "}", "=", ".", ",", "\n", "\r\n", "\"", "'", "\"\"\"", "#", " ", "\t", "1", "-0.5", "1e999", "nan",
            "true", "format", "kind", "scenario", "duct", "run", "straight_m", "elbow_deg", "sensor", "laser", "normal", "fault",
            "surface", "robot", "pass", "\u{e9}", "\u{1f600}", "1979-05-27",
        ]), 0..60)) {
        read_and_render(&parts.concat());
    }

    #[test]
    fn mutated_files_never_panic(
        at in any::<prop::sample::Index>(), len in 0usize..30, with in "[ -~\n\u{e9}]{0,12}", twice in any::<bool>(),
    ) {
        let full = full();
        let start = at.index(full.len());
        let end = (start + len).min(full.len());
        // The file is ASCII: every byte is a boundary.
        let mut text = format!("{}{with}{}", &full[..start], &full[end..]);
        if twice {
            text.push_str(&full[start..end]);
        }
        read_and_render(&text);
    }

    #[test]
    fn random_arguments_never_panic(argument in "[a-z_.\\[\\]0-9=\" {}-]{0,40}") {
        let overlays = Overlays { with: Vec::new(), set: vec![argument] };
        if let Err(errors) = Scenario::read("scenarios/straight.toml".as_ref(), &overlays) {
            prop_assert!(!errors.render(true).is_empty());
        }
    }

    /// Angles and lengths that no one would type survive to the last bit.
    #[test]
    fn resolved_scenarios_survive_being_written(
        heading_deg in -20.0f64..20.0, lateral_m in -0.05f64..0.05, elbow_deg in 1.0f64..179.0, pan_deg in -10.0f64..10.0,
        turned_deg in -5.0f64..5.0, width_m in 0.4f64..1.0, exposure in 0.1f64..30.0, bound in 0.0f64..1000.0,
        tilt in -0.2f64..0.2,
    ) {
        let text = format!(
            "format = 1\nkind = \"scenario\"\nname = \"p\"\n[duct]\nwidth_m = {width_m:?}\nheight_m = 0.3\n\
             run = [{{ straight_m = 3.0 }}, {{ elbow_deg = {elbow_deg:?} }}, {{ straight_m = 3.0 }}, {{ mitre_deg = -90 }}]\n\
             [start]\nheading_deg = {heading_deg:?}\nlateral_m = {lateral_m:?}\n\
             [sensor]\nexposure = {exposure:?}\n[sensor.mount]\npan_deg = {pan_deg:?}\n\
             [sensor.laser.third]\nnormal = [{:?}, {:?}, 0.0]\noffset_m = 0.05\n\
             [sensor.error]\nlaser_plane_deg = [0.0, {turned_deg:?}, 0.0]\n\
             [pass]\nheading_rms_deg = {bound_deg:?}\nlateral_rms_mm = {bound:?}\n",
            libm::sin(tilt), libm::cos(tilt), bound_deg = bound / 10.0,
        );
        let scenario = Scenario::from_toml_str(&text);
        prop_assert!(scenario.is_ok(), "{}", scenario.expect_err("errors"));
        let scenario = scenario.expect("valid");
        let again = Scenario::from_toml_str(&scenario.to_toml());
        prop_assert_eq!(again.as_ref(), Ok(&scenario));
    }
}
