use super::*;

const FILE: &str = r#"
format = 1
kind = "accuracy"
name = "rigs"
[poses]
count = 7
wall_m = [0.15, 0.5]
heading_deg = [-6.0, 6.0]
[grid]
sensor.preset = ["wide", "incra1"]
duct.surface = ["galvanised", "painted", "greasy"]
[pass.robust]
wall_distance_rms_mm = 0.3
detection_min = 0.99
[duct]
height_m = 0.3
run = [{ straight_m = 20.0 }]
"#;

#[test]
fn a_grid_is_the_product_of_its_fields() {
    let file = AccuracyFile::from_toml_str(FILE).unwrap();
    assert_eq!(file.cells.len(), 6);
    let labels: Vec<_> = file.cells.iter().map(Cell::label).collect();
    assert_eq!(labels[1], "sensor.preset = wide, duct.surface = painted");
    assert_eq!(labels[5], "sensor.preset = incra1, duct.surface = greasy");
    assert_ne!(file.cells[0].scenario.rig, file.cells[3].scenario.rig);
    assert_eq!(file.poses.count, 7);
    assert_eq!(file.pipelines, [Pipeline::Robust, Pipeline::Paper]);
    let heading = file.poses.heading_rad.unwrap();
    assert!((heading[1].to_degrees() - 6.0).abs() < 1e-12);
    assert_eq!(file.pass.len(), 2);
    assert!(file.pass[1].bound.is_least() && !file.pass[0].bound.is_least());
}

/// Every error names its line.
#[test]
fn what_is_wrong_is_said_at_its_place() {
    for (from, to, line, words) in [
        ("kind = \"accuracy\"", "kind = \"scenario\"", 3, "no accuracy study"),
        ("count = 7", "count = 0", 6, "`count` is a whole number"),
        ("count = 7", "counts = 7", 6, "unknown key `counts` in `poses`"),
        ("wall_m = [0.15, 0.5]", "wall_m = [0.5, 0.15]", 7, "`wall_m` is drawn between two numbers"),
        ("heading_deg = [-6.0, 6.0]", "lateral_m = [0.0, 0.1]", 8, "`wall_m` draws lateral offset and width"),
        ("sensor.preset = [", "sensor.presets = [", 10, "`sensor.presets` is no field"),
        ("sensor.preset = [\"wide\", \"incra1\"]", "sensor.preset = \"wide\"", 10, "needs the values that it takes"),
        ("sensor.preset = [\"wide\", \"incra1\"]", "sensor.preset = [\"wide\", \"narrow\"]", 10, "narrow"),
        ("[pass.robust]", "[pass.truth]", 12, "`truth` is not a pipeline"),
        ("duct.surface = [", "name = [\"a\", \"b\"]\nduct.surface = [", 11, "`name` is the whole study's"),
        ("detection_min = 0.99", "detections = 0.99", 14, "unknown bound `detections`"),
        ("[grid]", "[gird]", 9, "unknown key `gird`"),
        ("[poses]", "[positions]", 5, "unknown key `positions`"),
        ("height_m = 0.3", "height_mm = 0.3", 16, "unknown key `height_mm`"),
        (
            "duct.surface = [",
            "start.heading_deg = [0.0]\nduct.surface = [",
            11,
            "`heading_deg` of `[poses]` draws `start.heading_deg`",
        ),
        ("duct.surface = [", "start.lateral_m = [0.0]\nduct.surface = [", 11, "`wall_m` of `[poses]` draws `start.lateral_m`"),
        ("duct.surface = [", "duct.width_m = [0.5, 0.8]\nduct.surface = [", 11, "`wall_m` of `[poses]` draws `duct.width_m`"),
        ("wall_m = [0.15, 0.5]", "distance_m = [1.0, 2.0]\n[grid.start]\ndistance_m = [3.0]", 9, "draws `start.distance_m`"),
    ] {
        let text = FILE.replace(from, to);
        assert_ne!(text, FILE, "{from}");
        let Diagnostics(found) = AccuracyFile::from_toml_str(&text).unwrap_err();
        let lines: Vec<_> = found.iter().map(|d| (d.place.as_ref().map(|p| p.line), d.message.as_str())).collect();
        assert!(lines.iter().any(|(at, message)| *at == Some(line) && message.contains(words)), "{to}: {lines:?}");
        assert!(found.iter().all(|d| d.help.is_some()), "{found:?}");
    }
}

#[test]
fn unknown_keys_are_told_what_a_study_has() {
    for (to, words) in [("[gird]", "did you mean `grid`?"), ("[things]", "`pipelines`, `poses`, `grid`")] {
        let Diagnostics(found) = AccuracyFile::from_toml_str(&FILE.replace("[grid]", to)).unwrap_err();
        assert!(found[0].help.as_ref().unwrap().contains(words), "{found:?}");
    }
}

/// What is laid over a field that varies would be overruled in every cell.
#[test]
fn what_would_never_count_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, FILE).unwrap();
    let read = |set: &str| AccuracyFile::read(&path, &Overlays { with: Vec::new(), set: vec![set.to_owned()] });
    for (set, words) in [
        ("sensor.preset=wide", "`[grid]` of the study gives `sensor.preset`"),
        ("duct.surface=rubber", "`[grid]` of the study gives `duct.surface`"),
        ("start.lateral_m=0.1", "`[poses]` of the study gives `start.lateral_m`"),
        ("start={heading_deg = 1.0}", "`[poses]` of the study gives `start.heading_deg`"),
        ("duct.width_m=0.7", "`[poses]` of the study gives `duct.width_m`"),
    ] {
        let Diagnostics(found) = read(set).unwrap_err();
        assert_eq!((found.len(), found[0].file.as_str()), (1, format!("--set {set}").as_str()), "{found:?}");
        assert!(found[0].message.contains(words) && found[0].help.is_some(), "{found:?}");
    }
    assert_eq!(read("grid.duct.surface=[\"rubber\"]").unwrap().cells.len(), 2);
    // What is not drawn may be in the grid, and what the grid is given by an argument is held against what is drawn, too.
    assert_eq!(read("grid.start.distance_m=[2.0, 3.0]").unwrap().cells.len(), 12);
    let Diagnostics(found) = read("grid.start.heading_deg=[2.0, 3.0]").unwrap_err();
    assert!(found[0].file.starts_with("--set grid.start.heading_deg"), "{found:?}");
    assert!(read("start.distance_m=2.0").is_ok());
}

#[test]
fn without_a_grid_there_is_one_cell() {
    let text = FILE.replace(
        "[grid]\nsensor.preset = [\"wide\", \"incra1\"]\nduct.surface = [\"galvanised\", \"painted\", \"greasy\"]\n",
        "",
    );
    let file = AccuracyFile::from_toml_str(&text).unwrap();
    assert_eq!((file.cells.len(), file.cells[0].label().as_str()), (1, ""));
}

proptest::proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "\\PC{0,200}", at in 0..FILE.len()) {
        let _ = AccuracyFile::from_toml_str(&text);
        let cut = (0..=at).rev().find(|i| FILE.is_char_boundary(*i)).unwrap_or(0);
        let _ = AccuracyFile::from_toml_str(&format!("{}{text}{}", &FILE[..cut], &FILE[cut..]));
    }
}
