//! What a sweep of many cases costs besides its runs: planning, writing outcomes, reading them back into one table. The outcomes are made
//! up; nothing is simulated.
//!
//! ```text
//! cargo run --release --example sweep_scale -- 100000
//! ```

use std::time::Instant;

use ductloop::Verdict;
use ductloop::scenario::sweep_file::SweepFile;
use ductloop::sweep::ledger::Writer;
use ductloop::sweep::outcome::Outcome;
use ductloop::sweep::plan::Plan;
use ductloop::sweep::store::Store;
use ductloop::sweep::table::{self, Table};

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

    let started = Instant::now();
    let (cases, mut writer) = (plan.cases(), Writer::new(&store));
    for index in 0..cases.count() {
        let value = (index % 97) as f64 * 1e-5;
        writer.put(Outcome {
            hash: cases.case(index).hash,
            verdict: if index % 11 == 0 { Verdict::Fail } else { Verdict::Pass },
            reasons: String::new(),
            end_state: Some("finished".into()),
            metrics: [Some(value); 14],
            run_hash: Some(format!("{index:032x}")),
            error: None,
            wall_time_s: 1.0,
            host: "host".into(),
        })?;
    }
    writer.pack()?;
    let spent = started.elapsed().as_secs_f64();
    println!("outcomes written one by one: {spent:.1} s, {:.2} ms each, {}", 1e3 * spent / count as f64, resident());

    let started = Instant::now();
    let table = Table::read(&plan, &store)?;
    let summary = ductloop::sweep::figures::summary(&plan.sweep, &table, &plan.build, &plan.renderer);
    store.replace("results.parquet", table.parquet(&plan.sweep)?)?;
    store.replace("report.html", ductloop::report::sweep::html(&plan, &table, &summary)?.into_bytes())?;
    println!("merged {} rows: {:.2} s, {}", table.rows.len(), started.elapsed().as_secs_f64(), resident());
    Ok(())
}

/// Peak resident memory, where the system tells.
fn resident() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("unknown");
    format!("peak {}", peak.trim())
}
