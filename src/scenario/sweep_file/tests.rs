use proptest::prelude::*;

use super::*;

const BASE: &str = "format = 1\nkind = \"scenario\"\nname = \"b\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n\
                    [duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 3.0 }]\n";

const FILE: &str = r#"format = 1
kind = "sweep"
name = "widths"
base = "b.toml"
design = "grid"
replicates = 4
metrics = ["lateral_rms_m"]
[factor]
duct.width_m = { from = 0.3, to = 1.2, levels = 10 }
sensor.preset = ["wide", "incra1"]
"duct.run[0].straight_m" = [2.0, 3.0]
[scenario]
time_limit_s = 20.0
pass.lateral_rms_mm = 5.0
[stop]
pass_rate_half_width = 0.1
[pass]
pass_rate_min = 0.9
"#;

fn read(text: &str) -> Result<SweepFile, Diagnostics> {
    SweepFile::from_toml_str(text, &[("b.toml", BASE), ("c.toml", BASE)])
}

#[test]
fn a_file_is_read_as_it_says() {
    let sweep = read(FILE).unwrap_or_else(|wrong| panic!("{wrong}"));
    let paths: Vec<&str> = sweep.factors.iter().map(|factor| factor.path.as_str()).collect();
    assert_eq!(paths, ["duct.width_m", "sensor.preset", "duct.run[0].straight_m"]);
    let Levels::List(widths) = &sweep.factors[0].levels else { panic!("{:?}", sweep.factors[0]) };
    // As a person would have typed them, without 0.7000000000000001.
    let texts: Vec<String> = widths.iter().map(Level::toml).collect();
    assert_eq!(texts, ["0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1.0", "1.1", "1.2"]);
    assert_eq!(sweep.factors[1].levels, Levels::List(vec![Level::Toml("\"wide\"".into()), Level::Toml("\"incra1\"".into())]));
    assert_eq!(sweep.settings, ["time_limit_s=20.0", "pass.lateral_rms_mm=5.0"]);
    assert_eq!((sweep.replicates, sweep.common_random_numbers, sweep.bases[0].name.as_str()), (4, true, "b"));
    let scenario = sweep.scenario(0, &["sensor.preset=\"incra1\"".to_owned()], 9).unwrap_or_else(|wrong| panic!("{wrong}"));
    assert_eq!((scenario.seed, scenario.time_limit_s), (9, 20.0));
    // A preset laid over the base is as if it had been typed there: its fields come with it.
    assert_ne!(scenario.rig, sweep.scenario(0, &[], 9).unwrap_or_else(|wrong| panic!("{wrong}")).rig);
}

/// Every error names its line.
#[test]
fn what_is_wrong_is_said_at_its_place() {
    let width = "duct.width_m = { from = 0.3, to = 1.2, levels = 10 }";
    for (from, to, line, words) in [
        ("kind = \"sweep\"", "kind = \"scenario\"", 2, "no sweep"),
        ("format = 1", "format = 2", 1, "reads format 1"),
        ("base = \"b.toml\"", "base = \"none.toml\"", 4, "no such file"),
        ("base = \"b.toml\"", "base = [\"b.toml\", \"c.toml\"]", 4, "both named"),
        ("base = \"b.toml\"", "base = 3", 4, "a base is a scenario file"),
        ("design = \"grid\"", "design = \"gird\"", 5, "no such design"),
        ("design = \"grid\"", "design = \"sobol\"", 5, "needs its number of points"),
        ("design = \"grid\"", "samples = 8", 5, "not `samples`"),
        ("replicates = 4", "replicates = 0", 6, "`replicates` is a whole number"),
        ("replicates = 4", "replicate = 4", 6, "unknown key `replicate`"),
        ("[\"lateral_rms_m\"]", "[\"lateral_rms\"]", 7, "no such metric"),
        ("duct.width_m", "duct.width", 9, "`duct.width` names no field"),
        (width, "duct.width_m = []", 9, "needs the values"),
        (width, "duct.width_m = [0.5, 99.0]", 9, "must be between"),
        (width, "duct.width_m = [0.5, \"wide\"]", 9, "must be a number"),
        (width, "duct.width_m = [0.5, 0.5]", 9, "this value twice"),
        (width, "duct.width_m = { from = 1.2, to = 0.3, levels = 3 }", 9, "the smaller one comes first"),
        (width, "duct.width_m = { from = 0.3, to = 1.2 }", 9, "without `levels`"),
        (width, "duct.width_m = { from = 0.3, to = 99.0, levels = 3 }", 9, "must be between"),
        (width, "duct.width_m = { mean = 0.5, deviation = 0.1 }", 9, "draws none"),
        (width, "duct.width_m = { from = 0.3, to = 1.2, level = 3 }", 9, "unknown key `level`"),
        (width, "seed = [1, 2]", 9, "cannot be varied"),
        ("sensor.preset = [\"wide\", \"incra1\"]", "sensor.preset = { from = 1, to = 2, levels = 2 }", 10, "no numbers between"),
        ("sensor.preset = [\"wide\", \"incra1\"]", "sensor.preset = [\"wide\", \"incra\"]", 10, "does not know"),
        ("[scenario]\n", "[scenario]\nduct.width_m = 0.5\n", 12, "would never count"),
        ("pass_rate_half_width = 0.1", "half_width = 0.1", 16, "unknown key `half_width`"),
        ("pass_rate_min = 0.9", "pass_rate_min = 90.0", 18, "a number from 0 to 1"),
        ("pass_rate_min = 0.9", "lateral_rms_mm = 5.0", 18, "a bound on a run"),
    ] {
        let text = FILE.replacen(from, to, 1);
        assert_ne!(text, FILE, "{from}");
        let Err(Diagnostics(found)) = read(&text) else { panic!("{to}: taken") };
        let lines: Vec<_> = found.iter().map(|d| (d.place.as_ref().map(|p| p.line), d.message.as_str())).collect();
        assert!(lines.iter().any(|(at, message)| *at == Some(line) && message.contains(words)), "{to}: {lines:?}");
        assert!(found.iter().all(|d| d.help.is_some()), "{to}: {found:?}");
    }
}

#[test]
fn an_element_that_the_base_does_not_have_is_refused() {
    let wrong = read(&FILE.replace("run[0]", "run[3]")).expect_err("there is one fitting").to_string();
    assert!(wrong.contains("no such element") && wrong.contains("duct.run[3].straight_m"), "{wrong}");
}

#[test]
fn what_is_laid_over_the_bases_is_checked_with_them() {
    let wrong = read(&FILE.replace("time_limit_s = 20.0", "time_limit_s = -1.0")).expect_err("it is negative").to_string();
    assert!(wrong.contains("time_limit_s=-1.0"), "{wrong}");
}

#[test]
fn a_sweep_reads_back_from_its_plan() {
    let sweep = read(FILE).unwrap_or_else(|wrong| panic!("{wrong}"));
    let text = serde_json::to_string(&sweep).expect("JSON");
    assert_eq!(serde_json::from_str::<SweepFile>(&text).expect("a sweep"), sweep);
}

proptest! {
    /// Any edit of the file is read or refused, without a panic; what is read has at least one point.
    #[test]
    fn no_text_is_too_much(at in 0..FILE.len(), cut in 0_usize..40, put in "[ -~\n]{0,12}") {
        let end = (at + cut).min(FILE.len());
        let text = format!("{}{put}{}", &FILE[..at], &FILE[end..]);
        if let Ok(sweep) = read(&text) {
            prop_assert!(!sweep.bases.is_empty());
            prop_assert!(sweep.factors.iter().all(|factor| crate::scenario::fields::field(&factor.path).is_some()));
        }
    }
}
