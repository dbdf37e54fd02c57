use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;
use crate::tune::front::Costs;

const BASE: &str = "format = 1\nkind = \"scenario\"\nname = \"b\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n\
                    [duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 3.0 }]\n";

fn study() -> StudyFile {
    let text = "format = 1\nkind = \"study\"\nname = \"s\"\n[parameter]\nrobot.speed_m_s = { from = 0.1, to = 1.0, scale = \"log\" }\n\
                perception.paper.min_points = { from = 10, to = 40 }\n[train]\nbase = \"b.toml\"\n\
                [held_out]\nbase = \"b.toml\"\nseed = 100\n[objective]\nweights = { lateral_rms_m = 1.0 }\n";
    StudyFile::from_toml_str(text, &[("b.toml", BASE)]).unwrap_or_else(|wrong| panic!("{wrong}"))
}

/// An optimiser that says what it is told to, whatever it is sent.
#[derive(Debug, Default)]
struct Script {
    says: VecDeque<String>,
    /// What it says before it is asked.
    early: Option<String>,
    heard: Vec<Value>,
}

impl Lines for Script {
    fn send(&mut self, line: &str) -> Result<(), Lost> {
        assert!(!line.contains('\n'), "one line");
        self.heard.push(serde_json::from_str(line).expect("JSON"));
        Ok(())
    }

    fn unasked(&mut self) -> Option<String> {
        self.early.take()
    }

    fn receive(&mut self) -> Result<String, Lost> {
        self.says.pop_front().ok_or_else(|| Lost { message: "it is silent".into(), help: String::new() })
    }
}

fn outside(says: &[&str], journal: Journal) -> Result<Outside<Script>, Lost> {
    let says = std::iter::once(&r#"{"ready": "a script"}"#).chain(says).map(|line| (*line).to_owned()).collect();
    Outside::greet(&study(), Script { says, ..Script::default() }, journal)
}

fn trial(number: u64, values: Option<Vec<Level>>) -> Trial {
    let costs = Costs { objectives: vec![0.5], violation: 0.0 };
    Trial { number, generation: number.min(1), values, costs, is_full: true, rows: Vec::new() }
}

const ANSWER: &str = r#"{"candidates": [{"robot.speed_m_s": 0.3333333333, "perception.paper.min_points": 20}]}"#;

#[test]
fn candidates_are_asked_for_and_told_of() {
    let mut script = outside(&[ANSWER, r#"{"candidates": []}"#], Journal::default()).expect("it answers");
    assert_eq!(script.name(), "a script");
    script.begin(&trial(0, None), &[Some(0.3), Some(30.0)]).expect("it listens");
    let candidates = script.ask().expect("candidates");
    assert_eq!(candidates, [[Level::Number(0.333333), Level::Integer(20)]], "six digits");
    script.tell(&[trial(1, Some(candidates[0].clone()))]).expect("it listens");
    assert_eq!(script.ask().expect("none"), Vec::<Vec<Level>>::new());
    let heard = script.farewell().heard;
    let words: Vec<&str> = heard.iter().filter_map(|message| message["message"].as_str()).collect();
    assert_eq!(words, ["begin", "tell", "ask", "tell", "ask", "end"]);
    assert_eq!(heard[0]["parameters"][0]["from"], 0.1);
    assert_eq!(heard[0]["parameters"][1]["whole"], true);
    assert_eq!(heard[0]["objectives"], json!(["cost"]));
    assert_eq!(heard[1]["trials"][0]["values"]["robot.speed_m_s"], 0.3);
    assert_eq!(heard[3]["trials"][0]["costs"], json!([0.5]));
    assert_eq!(heard[3]["trials"][0]["values"]["robot.speed_m_s"], 0.333333);
    assert_eq!(heard[3]["trials"][0]["is_replayed"], false);
}

/// What an earlier call asked for is not asked for again.
#[test]
fn an_earlier_calls_candidates_are_replayed() {
    let folder = tempfile::tempdir().expect("a folder");
    let journal = || Journal::open(folder.path().join("candidates.jsonl")).expect("a journal");
    let first = outside(&[ANSWER], journal()).expect("it answers").ask().expect("candidates");
    let mut again = outside(&[], journal()).expect("it answers");
    assert_eq!(again.ask().expect("the journal's"), first);
    again.tell(&[trial(1, Some(first[0].clone()))]).expect("it listens");
    assert!(again.ask().expect_err("it is asked now").message.contains("silent"));
    assert_eq!(again.farewell().heard[1]["trials"][0]["is_replayed"], true);
}

/// An answer too many would put all later ones out of step.
#[test]
fn an_answer_too_many_is_noticed() {
    let mut script = outside(&[ANSWER, ANSWER], Journal::default()).expect("it answers");
    script.ask().expect("candidates");
    script.lines.early = Some(ANSWER.to_owned());
    assert!(script.ask().expect_err("it spoke").message.contains("it was not asked"));
}

#[test]
fn what_makes_no_sense_is_quoted() {
    for (answer, words) in [
        ("hello", "it is no JSON"),
        ("[1, 2]", "it is no object"),
        ("{\"candidate\": []}", "no list `candidates`"),
        ("{\"candidates\": [0.3]}", "no object of paths"),
        ("{\"candidates\": [{\"robot.speed_m_s\": 0.3}]}", "has no `perception.paper.min_points`"),
        (
            "{\"candidates\": [{\"robot.speed_m_s\": 3, \"perception.paper.min_points\": 20}]}",
            "is 3, which is not between 0.1 and 1",
        ),
        ("{\"candidates\": [{\"robot.speed_m_s\": \"x\", \"perception.paper.min_points\": 20}]}", "is no number"),
        ("{\"candidates\": [{\"robot.speed_m_s\": 0.3, \"perception.paper.min_points\": 20.5}]}", "must be whole"),
        ("{\"candidates\": [{\"robot.speed_m_s\": 0.3, \"perception.paper.min_points\": 20, \"x\": 1}]}", "`x` is no parameter"),
    ] {
        let lost = outside(&[answer], Journal::default()).expect("it answers").ask().expect_err(answer);
        assert!(lost.message.contains(words) && lost.message.contains(&answer[..5]), "{answer}: {lost:?}");
        assert!(lost.help.contains("docs/tuning.md"), "{lost:?}");
    }
    let silent = Outside::greet(&study(), Script { says: ["{}".to_owned()].into(), ..Script::default() }, Journal::default());
    assert!(silent.expect_err("no greeting").message.contains("no `ready`"));
}

proptest! {
    /// Whatever it says, it is understood or refused, without a panic.
    #[test]
    fn no_answer_is_too_much(at in 0..ANSWER.len(), cut in 0_usize..30, put in "[ -~]{0,12}") {
        let end = (at + cut).min(ANSWER.len());
        let answer = format!("{}{put}{}", &ANSWER[..at], &ANSWER[end..]);
        if let Ok(candidates) = outside(&[&answer], Journal::default()).expect("it answers").ask() {
            for values in candidates {
                let speed = values[0].number().unwrap_or(f64::NAN);
                prop_assert!((0.1..=1.0).contains(&speed));
            }
        }
    }
}
