//! What a sweep of many cases costs besides its runs: planning, writing outcomes, reading them back into one table. The outcomes are made
//! up; nothing is simulated.
//!
//! ```text
//! cargo run --release --example sweep_scale -- 100000
//! ```

use std::time::Instant;

use ductloop::Verdict;
use ductloop::scenario::sweep_file::SweepFile;
use ductloop::sweep::case::CaseHash;
use ductloop::sweep::ledger::{self, Writer};
use ductloop::sweep::outcome::Outcome;
use ductloop::sweep::plan::Plan;
use ductloop::sweep::store::Store;
use ductloop::sweep::table::{self, Table};

/// Outcomes that are written each for itself and packed then; a multiple of a pack.
const ONE_BY_ONE: u64 = 1024;
const BASE: &str = include_str!("../scenarios/straight.toml");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: u64 = std::env::args().nth(1).map_or(Ok(100_000), |text| text.parse())?;
    let text = format!(
        "format = 1\nkind = \"sweep\"\nname = \"scale\"\nbase = \"straight.toml\"\ndesign = \"random\"\nsamples = {count}\n[factor]\n\
         duct.width_m = {{ from = 0.4, to = 1.0 }}\nrobot.speed_m_s = {{ from = 0.1, to = 0.8 }}\nsensor.preset = [\"wide\", \"incra1\"]\n"
    );
    let folder = tempfile::tempdir()?;
    let store = Store::open(&folder.path().display().to_string())?;

    let started = Instant::now();
    let plan = Plan::of(SweepFile::from_toml_str(&text, &[("straight.toml", BASE)])?, "cpu");
    plan.write(&store, false)?;
    store.replace("cases.parquet", table::list(&plan)?)?;
    println!("plan of {count} cases: {:.2} s, {}", started.elapsed().as_secs_f64(), resident());

    let (cases, mut written, mut one_by_one) = (plan.cases(), 0, 0.0);
    let mut writer = Writer::new(&store);
    while written < count {
        let until = count.min(written + ledger::PACK as u64);
        let outcomes: Vec<Outcome> = (written..until).map(|index| made_up(index, cases.case(index).hash)).collect();
        if written < ONE_BY_ONE {
            let started = Instant::now();
            outcomes.into_iter().try_for_each(|outcome| writer.put(outcome))?;
            one_by_one += started.elapsed().as_secs_f64();
        } else {
            // As a sweep leaves them in the end, without a flush of the disk for each.
            ledger::pack(&store, &outcomes)?;
        }
        written = until;
    }
    println!("outcomes written as they come: {:.2} ms each, {}", 1e3 * one_by_one / ONE_BY_ONE.min(count) as f64, resident());

    let started = Instant::now();
    let table = Table::read(&plan, &store)?;
    let summary = ductloop::sweep::figures::summary(&plan.sweep, &table, &plan.build, &plan.renderer);
    store.replace("results.parquet", table.parquet(&plan.sweep)?)?;
    store.replace("report.html", ductloop::report::sweep::html(&plan, &table, &summary)?.into_bytes())?;
    println!("merged {} rows: {:.2} s, {}", table.rows.len(), started.elapsed().as_secs_f64(), resident());
    Ok(())
}

/// A result such as a run might have had.
fn made_up(index: u64, hash: CaseHash) -> Outcome {
    Outcome {
        hash,
        verdict: if index.is_multiple_of(11) { Verdict::Fail } else { Verdict::Pass },
        reasons: String::new(),
        end_state: Some("finished".into()),
        metrics: [Some((index % 97) as f64 * 1e-5); ductloop::Metrics::NUMBERS.len()],
        run_hash: Some(format!("{index:032x}")),
        error: None,
        wall_time_s: 1.0,
        host: "host".into(),
    }
}

/// Peak resident memory, where the system tells.
fn resident() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("unknown");
    format!("peak {}", peak.trim())
}
