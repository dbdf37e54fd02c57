use proptest::prelude::*;

use super::*;

const BASE: &str = "format = 1\nkind = \"scenario\"\nname = \"b\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n\
                    [duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 3.0 }]\n";

const FILE: &str = r#"format = 1
kind = "study"
name = "landing"
optimiser = "cma-es"
runs = 100
[parameter]
robot.speed_m_s = { from = 0.1, to = 0.5, scale = "log" }
[train]
base = "b.toml"
replicates = 2
[held_out]
base = "b.toml"
seed = 100
[objective]
over = 0.9
relative = true
weights = { lateral_rms_m = 1.0 }
[constraints]
most = { collisions = 0 }
[stop]
step = 0.01
[scenario]
time_limit_s = 20.0
"#;

fn read(text: &str) -> Result<StudyFile, Diagnostics> {
    StudyFile::from_toml_str(text, &[("b.toml", BASE)])
}

#[test]
fn a_file_is_read_as_it_says() {
    let study = read(FILE).unwrap_or_else(|wrong| panic!("{wrong}"));
    assert_eq!((study.optimiser, study.runs, study.halving, study.seed), (Optimiser::CmaEs, 100, true, 1));
    assert_eq!((study.parameters.len(), study.parameters[0].path.as_str()), (1, "robot.speed_m_s"));
    assert_eq!((study.train.seed, study.train.replicates, study.train.bases[0].name.as_str()), (1, 2, "b"));
    assert_eq!((study.held_out.seed, study.held_out.replicates), (100, 1));
    assert_eq!(study.train.settings, ["time_limit_s=20.0"]);
    let objective =
        |name: &str, over| Objective { name: name.into(), weights: vec![("lateral_rms_m".into(), 1.0)], relative: true, over };
    assert_eq!(study.objectives, [objective("cost", Over::Quantile(0.9))]);
    assert_eq!(
        study.constraints,
        Constraints { finishes: true, most: vec![("collisions".into(), 0.0)], ..Constraints::default() }
    );
    assert_eq!(study.stop, Stop { step: Some(0.01), generations_without_gain: None });
    assert_eq!(study.runs_of_a_candidate(), 2);
    let text = serde_json::to_string(&study).expect("JSON");
    assert_eq!(serde_json::from_str::<StudyFile>(&text).expect("a study"), study);
}

/// Several objectives stand below names of theirs.
#[test]
fn several_objectives_have_names() {
    let several = "[objective.tracking]\nweights = { lateral_rms_m = 1.0 }\n[objective.effort]\nover = \"worst\"\nweights = { control_effort = 2.0 }\n";
    let text = FILE.replace("[objective]\nover = 0.9\nrelative = true\nweights = { lateral_rms_m = 1.0 }\n", several);
    let study = read(&text).unwrap_or_else(|wrong| panic!("{wrong}"));
    let told: Vec<(&str, Over)> = study.objectives.iter().map(|objective| (objective.name.as_str(), objective.over)).collect();
    assert_eq!(told, [("tracking", Over::Mean), ("effort", Over::Worst)]);
    for (from, to, words) in [
        ("over = \"worst\"", "over = \"most\"", "a quantile from 0 to 1"),
        ("{ control_effort = 2.0 }", "{}", "`[objective.effort]` weighs no metric"),
        ("[objective.effort]\nover", "[objective.effort]\nmode", "unknown key `mode`"),
        ("[objective.effort]", "[objective.\"no name\"]", "is no name of an objective"),
        (
            "[objective.effort]",
            "[objective.a]\nweights = { collisions = 1 }\n[objective.b]\nweights = { collisions = 1 }\n[objective.c]\nweights = { collisions = 1 }\n[objective.d]",
            "make no front",
        ),
    ] {
        let text = text.replacen(from, to, 1);
        let wrong = read(&text).err().map(|wrong| wrong.to_string()).unwrap_or_default();
        assert!(wrong.contains(words), "{to}: {wrong}");
    }
}

/// Every error names its line.
#[test]
fn what_is_wrong_is_said_at_its_place() {
    let speed = "robot.speed_m_s = { from = 0.1, to = 0.5, scale = \"log\" }";
    for (from, to, line, words) in [
        ("kind = \"study\"", "kind = \"sweep\"", 2, "no study"),
        ("optimiser = \"cma-es\"", "optimiser = \"cmaes\"", 4, "no such optimiser"),
        ("runs = 100", "runs = 0", 5, "`runs` is a whole number"),
        ("runs = 100", "runs = 3", 5, "too few for the default and one candidate"),
        (
            speed,
            "robot.speed_m_s = { from = 0.1, to = 0.5 }\n\"robot.speed_m_s\" = { from = 0.1, to = 0.4 }",
            6,
            "stands there twice",
        ),
        ("runs = 100", "budget = 100", 5, "unknown key `budget`"),
        (speed, "robot.speed_m_s = { from = 0.5, to = 0.1 }", 7, "the smaller one comes first"),
        (speed, "robot.speed = { from = 0.1, to = 0.5 }", 7, "names no field"),
        (speed, "robot.speed_m_s = [0.1, 0.5]", 6, "no ends"),
        (speed, "robot.speed_m_s = { from = 0.1, to = 99.0 }", 7, "must be between"),
        (speed, "\"duct.run[0].straight_m\" = { from = 2.0, to = 3.0 }", 6, "no overlay can set"),
        ("base = \"b.toml\"\nreplicates", "base = \"none.toml\"\nreplicates", 9, "no such file"),
        ("replicates = 2", "replicate = 2", 10, "unknown key `replicate`"),
        ("over = 0.9", "over = 2.0", 15, "a quantile from 0 to 1"),
        ("relative = true", "relative = 1", 16, "`relative`"),
        ("{ lateral_rms_m = 1.0 }", "{ lateral_rms = 1.0 }", 17, "no metric of a run"),
        ("{ lateral_rms_m = 1.0 }", "{ lateral_rms_m = 0.0 }", 14, "weighs no metric"),
        ("{ collisions = 0 }", "{ collision = 0 }", 19, "no metric of a run"),
        ("most = {", "max = {", 19, "unknown key `max`"),
        ("step = 0.01", "step = 2.0", 21, "`step` is a number"),
    ] {
        let text = FILE.replacen(from, to, 1);
        assert_ne!(text, FILE, "{from}");
        let Err(Diagnostics(found)) = read(&text) else { panic!("{to}: taken") };
        let lines: Vec<_> = found.iter().map(|d| (d.place.as_ref().map(|p| p.line), d.message.as_str())).collect();
        assert!(lines.iter().any(|(at, message)| *at == Some(line) && message.contains(words)), "{to}: {lines:?}");
        assert!(found.iter().all(|d| d.help.is_some()), "{to}: {found:?}");
    }
    for table in ["[parameter]", "[train]", "[held_out]", "[objective]"] {
        let start = FILE.find(table).expect("it is there");
        let end = FILE[start + 1..].find("\n[").map_or(FILE.len(), |end| start + 2 + end);
        let text = format!("{}{}", &FILE[..start], &FILE[end..]);
        let wrong = read(&text).expect_err(table).to_string();
        assert!(wrong.contains(&format!("missing `{table}`")), "{table}: {wrong}");
    }
}

fn concerns(text: &str) -> Vec<String> {
    let study = read(text).unwrap_or_else(|wrong| panic!("{wrong}"));
    study.concerns().into_iter().map(|concern| concern.message).collect()
}

#[test]
fn what_is_trained_on_and_held_out_with_one_seed_is_told() {
    assert_eq!(concerns(FILE), Vec::<String>::new());
    let told = concerns(&FILE.replace("seed = 100", "seed = 0\nreplicates = 9"));
    assert_eq!(told, ["`b` is trained on and held out with seeds 1 to 2: what is found there proves nothing"]);
    let told = concerns(&FILE.replace("seed = 100", "seed = 2"));
    assert_eq!(told, ["`b` is trained on and held out with seed 2: what is found there proves nothing"]);
}

#[test]
fn parameters_of_what_is_not_used_are_told() {
    let told = |path: &str, scenario: &str| {
        let text = FILE.replace("robot.speed_m_s = { from = 0.1, to = 0.5", &format!("{path} = {{ from = 0.02, to = 0.9"));
        concerns(&text.replace("time_limit_s = 20.0", scenario))
    };
    for (path, unused, used) in [
        ("control.koh-cho.landing", "control.law = \"lqr\"", "control.law = \"koh-cho-printed\""),
        ("control.koh-cho.linear_along_m", "control.law = \"koh-cho-printed\"", "control.law = \"koh-cho\""),
        ("control.pure-pursuit.lookahead_m", "", "control.law = \"pure-pursuit\""),
        ("perception.paper.psf_sigma_px", "", "perception.pipeline = \"paper\""),
        ("estimation.correlated_share", "estimation.kind = \"none\"", ""),
    ] {
        let idle = told(path, unused);
        assert!(idle.len() == 1 && idle[0].starts_with(&format!("`{path}` changes nothing")), "{path}: {idle:?}");
        assert_eq!(told(path, used), Vec::<String>::new(), "{path}");
    }
    assert_eq!(told("control.limits.max_acceleration_m_s2", "control.law = \"lqr\""), Vec::<String>::new());
}

#[test]
fn a_step_that_ends_nothing_is_told() {
    let told = concerns(&FILE.replace("\"cma-es\"", "\"sobol\""));
    assert_eq!(told, ["`[stop]` `step` ends nothing: sobol has no steps that become smaller"]);
    let driven = StudyFile { driver: Some("optuna".to_owned()), ..read(FILE).unwrap_or_else(|wrong| panic!("{wrong}")) };
    assert!(driven.concerns().iter().any(|concern| concern.message.contains("optuna has no steps")), "{:?}", driven.concerns());
}

proptest! {
    /// Any edit of the file is read or refused, without a panic.
    #[test]
    fn no_text_is_too_much(at in 0..FILE.len(), cut in 0_usize..40, put in "[ -~\n]{0,12}") {
        let end = (at + cut).min(FILE.len());
        let text = format!("{}{put}{}", &FILE[..at], &FILE[end..]);
        if let Ok(study) = read(&text) {
            prop_assert!(!study.train.bases.is_empty() && !study.parameters.is_empty());
        }
    }
}
