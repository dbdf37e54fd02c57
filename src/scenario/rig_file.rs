//! A rig by itself: the sensor's tables of a scenario without duct, robot and run around them.
//!
//! What may be read as one: a whole scenario; a file with `[sensor]` and its tables, as the presets are, and `[perception]` or
//! `[navigation]` if one likes; or the sensor's own tables at the top (`[camera]`, `[laser.NAME]`, `[mount]`, `[line]`), as a calibration
//! writes them. The last two name no preset unless they say so: a photograph's rig has no laser of `wide`'s in it. Several files are
//! laid one over the other: a camera's, and one of each laser's plane.
//!
//! How wide the duct is a rig's file need not say: two walls tell it. Where it does not, [`RigFile::width_m`] is `None`, and one wall alone
//! gives no lateral error.

use super::source::Span;
use super::tree::{Entry, Node, Table, Value};
use super::typed::Typed;
use super::{Scenario, fields, parse};

/// A rig as read.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// Of it only `rig`, `perception` and `navigation` mean anything; `navigation.width_m` only where `width_m` is `Some`.
    pub scenario: Scenario,
    /// The duct's width that the files say, in metres: `[navigation] width_m`, else `[duct] width_m`.
    pub width_m: Option<f64>,
}

/// Tables of `[sensor]` that may stand at the top of a file.
const OF_THE_SENSOR: [&str; 4] = ["camera", "mount", "laser", "line"];

/// What a rig's file may leave out: that it is no scenario. The duct is one that any rig could stand in; nothing of it counts.
const BENEATH: &str = r#"
format = 1
kind = "scenario"
name = "rig"
[duct]
width_m = 0.5
height_m = 0.3
run = [{ straight_m = 3.0 }]
"#;

/// What a file may leave out that names no preset: how its camera is mounted (upright, in the base's origin: a lateral error is then the
/// camera's own), where its mount points, how thick its light is (an assumption, that of both presets).
const INSTEAD_OF_A_PRESET: &str = r#"
[sensor]
preset = "none"
[sensor.camera]
roll_deg = 0.0
position_in_base_m = [0.0, 0.0, 0.0]
[sensor.mount]
pan_deg = 0.0
tilt_deg = 0.0
[sensor.line]
width_mm = 2.0
growth_mrad = 4.0
"#;

/// Whether a file says that it is a scenario, or another whole thing.
pub(super) fn is_whole(root: &Table) -> bool {
    [fields::KIND, fields::FORMAT].iter().any(|key| root.get(key).is_some())
}

/// Whether somebody typed how wide the duct is; `root` is as typed, nothing filled in.
pub(super) fn says_width(root: &Table) -> bool {
    ["navigation.width_m", "duct.width_m"].iter().any(|path| root.at(path).is_some())
}

/// Brings the tables of a rig's file to where a scenario has them; a scenario's are there.
pub(super) fn prepare(root: &mut Table) {
    if !is_whole(root) {
        gather(root);
    }
}

/// Makes a scenario of a rig's file, as far as [`super::resolve`] needs one.
pub(super) fn complete(typed: &mut Typed) {
    gather(&mut typed.root);
    let has_preset = typed.root.at("sensor.preset").and_then(Node::as_text).is_some_and(|preset| preset != "none");
    let texts = if has_preset { &[BENEATH][..] } else { &[BENEATH, INSTEAD_OF_A_PRESET] };
    for text in texts {
        let source = typed.sources.add("what a rig's file may leave out", *text);
        let (mut beneath, _) = parse::document(&typed.sources, source);
        // A mounting is none without a camera: that there is none is then told as such.
        if typed.root.at("sensor.camera").is_none()
            && let Some(Value::Table(sensor)) = beneath.entry_mut("sensor").map(|entry| &mut entry.node.value)
        {
            sensor.entries.retain(|entry| entry.key != "camera");
        }
        fill(&mut typed.root, beneath);
    }
}

/// Takes in what a table has not. What it has keeps its place, by which errors are told.
fn fill(table: &mut Table, beneath: Table) {
    for entry in beneath.entries {
        match table.entry_mut(&entry.key) {
            None => table.entries.push(entry),
            Some(typed) => {
                if let (Value::Table(typed), Value::Table(beneath)) = (&mut typed.node.value, entry.node.value) {
                    fill(typed, beneath);
                }
            }
        }
    }
}

/// Puts the sensor's tables that stand at the top into `[sensor]`.
fn gather(root: &mut Table) {
    let is_moved = |entry: &Entry| OF_THE_SENSOR.contains(&entry.key.as_str());
    let Some(first) = root.entries.iter().find(|entry| is_moved(entry)).map(|entry| entry.key_span) else { return };
    let (moved, kept) = std::mem::take(&mut root.entries).into_iter().partition(is_moved);
    root.entries = kept;
    let sensor = Entry { key: "sensor".to_owned(), key_span: first, node: table(moved, first) };
    let mut gathered = Table { entries: vec![sensor] };
    // What `[sensor]` itself says counts.
    gathered.merge(std::mem::take(root));
    *root = gathered;
}

fn table(entries: Vec<Entry>, span: Span) -> Node {
    Node { value: Value::Table(Table { entries }), span }
}

#[cfg(test)]
mod tests {
    use crate::scenario::{Diagnostics, Scenario};

    fn rig_of(text: &str) -> Result<Scenario, Diagnostics> {
        Scenario::rig_from_toml_str(text).map(|read| read.scenario)
    }

    fn read_rig(paths: &[&std::path::PathBuf]) -> Result<Scenario, Diagnostics> {
        Scenario::read_rig(paths).map(|read| read.scenario)
    }

    const TOP: &str = r#"
[camera]
width_px = 640
height_px = 480
focal_px = 1081.0
centre_px = [320.0, 240.0]
roll_deg = 90.0
position_in_base_m = [0.12, 0.0, 0.10]
[laser.right]
normal = [0.75130632, -0.61816050, 0.23111989]
offset_m = 0.06878742
[mount]
pan_deg = -50.0
"#;

    /// What nobody said is not known, whatever stands beneath.
    #[test]
    fn a_width_is_known_where_it_was_said() {
        let width_of = |text: &str| Scenario::rig_from_toml_str(text).expect("a rig").width_m;
        assert_eq!(width_of(TOP), None);
        assert_eq!(width_of("[sensor]\npreset = \"wide\"\n"), None);
        assert_eq!(width_of(&format!("{TOP}[navigation]\nwidth_m = 0.8\n")), Some(0.8));
        assert_eq!(width_of(&format!("{TOP}[duct]\nwidth_m = 0.7\n")), Some(0.7));
        assert_eq!(width_of(&format!("{TOP}[duct]\nwidth_m = 0.7\n[navigation]\nwidth_m = 0.8\n")), Some(0.8));
        assert_eq!(width_of(include_str!("../../scenarios/straight-wide.toml")), Some(0.8));
    }

    #[test]
    fn a_rig_may_stand_at_the_top_or_in_the_sensors_tables() {
        let top = rig_of(TOP).expect("a rig");
        assert_eq!(top.rig.lasers.len(), 1);
        assert_eq!(top.rig.mount.rest.pan_rad, (-50.0_f64).to_radians());
        assert_eq!(top.rig.line.width_m, 2e-3);
        let below =
            TOP.replace("[camera]", "[sensor.camera]").replace("[laser", "[sensor.laser").replace("[mount]", "[sensor.mount]");
        assert_eq!(rig_of(&below).expect("a rig").rig, top.rig);
        let both = format!("{TOP}[sensor.line]\nwidth_mm = 3.0\n[navigation]\nwidth_m = 0.8\n");
        let both = rig_of(&both).expect("a rig");
        assert_eq!((both.rig.line.width_m, both.navigation.width_m), (3e-3, 0.8));
        assert_eq!(both.rig.camera, top.rig.camera);
    }

    #[test]
    fn a_preset_and_a_whole_scenario_are_rigs() {
        let wide = rig_of("[sensor]\npreset = \"wide\"\n").expect("a rig").rig;
        let preset = rig_of(include_str!("../../presets/sensor/wide.toml")).expect("a rig").rig;
        assert_eq!(wide, preset);
        // Where a preset's mount points is not overlaid by what files without one may leave out.
        let incra1 = rig_of("[sensor]\npreset = \"incra1\"\n").expect("a rig").rig;
        assert_eq!(incra1.mount.rest.pan_rad, (-50.0_f64).to_radians());
        let whole = include_str!("../../scenarios/straight-incra1.toml");
        assert_eq!(rig_of(whole).expect("a rig").rig, Scenario::from_toml_str(whole).expect("a scenario").rig);
    }

    /// As calibrations write them: a camera without a mounting, lasers in files of their own.
    #[test]
    fn a_rig_may_come_in_several_files_and_without_a_mounting() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).expect("a file");
            path
        };
        let mounting = "roll_deg = 90.0\nposition_in_base_m = [0.12, 0.0, 0.10]\n";
        let bare = TOP.replace(mounting, "");
        assert!(bare.len() < TOP.len());
        let rig = rig_of(&bare).expect("a rig").rig;
        assert_eq!((rig.mount.roll_rad, rig.mount.position_in_base_m), (0.0, nalgebra::Point3::origin()));
        let camera = write("camera.toml", bare.split("[laser").next().expect("a part"));
        let right =
            write("right.toml", "[sensor.laser.right]\nnormal = [0.75130632, -0.61816050, 0.23111989]\noffset_m = 0.06878742\n");
        let left = write("left.toml", "[laser.left]\nnormal = [0.74444940, -0.60260520, 0.28751011]\noffset_m = 0.03728516\n");
        let mount = write("mount.toml", &format!("[camera]\n{mounting}"));
        let rig = read_rig(&[&camera, &right, &left, &mount]).expect("a rig").rig;
        let names: Vec<_> = rig.lasers.iter().map(|laser| laser.name.as_str()).collect();
        assert_eq!((names, rig.mount.roll_rad), (vec!["right", "left"], 90.0_f64.to_radians()));
        assert_eq!(rig.camera, rig_of(TOP).expect("a rig").rig.camera);
        // A later file counts, whichever form either has.
        let shorter = write("shorter.toml", "[camera]\nfocal_px = 900.0\n[laser.right]\noffset_m = 0.05\n");
        let rig = read_rig(&[&camera, &right, &shorter]).expect("a rig").rig;
        assert_eq!((rig.camera.focal_px, rig.lasers[0].offset_m), ([900.0; 2], 0.05));
        // What is wrong is told of the file where it stands; without a camera there is none.
        let wrong = write("wrong.toml", "[laser.left]\nnormal = [0.74444940, -0.60260520, 0.28751011]\noffset_m = 0.0002\n");
        let errors = read_rig(&[&camera, &wrong]).expect_err("refused").0;
        assert_eq!(errors[0].place.as_ref().map(|place| place.line), Some(3), "{errors:?}");
        assert!(errors[0].file.ends_with("wrong.toml"), "{errors:?}");
        let errors = read_rig(&[&right]).expect_err("refused");
        assert!(errors.to_string().contains("width_px") && !errors.to_string().contains("may leave out"), "{errors}");
    }

    /// Every error with the line where it was typed.
    #[test]
    fn errors_have_their_lines() {
        for (from, to, line, word) in [
            ("offset_m = 0.06878742", "offset_m = 0.0002", 11, "camera's centre"),
            ("width_px = 640", "width_px = 2", 3, "width_px"),
            ("pan_deg = -50.0", "pam_deg = -50.0", 13, "pam_deg"),
            ("focal_px = 1081.0\n", "", 2, "focal_px"),
            ("0.75130632", "0.15130632", 10, "unit vector"),
            ("[mount]", "[mount", 12, "not TOML"),
            ("[laser.right]\nnormal = [0.75130632, -0.61816050, 0.23111989]\noffset_m = 0.06878742\n", "", 2, "no laser"),
        ] {
            assert!(TOP.contains(from), "{from}");
            let wrong = rig_of(&TOP.replace(from, to)).expect_err(to);
            let first = &wrong.0[0];
            assert!(first.message.contains(word), "{from}: {wrong}");
            assert_eq!(first.place.as_ref().map(|place| place.line), Some(line), "{from}: {wrong}");
        }
        assert!(rig_of("").is_err());
    }
}
