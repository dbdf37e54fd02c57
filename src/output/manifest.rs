//! `manifest.json`: what made a run, where and when. Nothing in it bears on the result, and nothing of it is in the run's hash.

use std::time::{Duration, SystemTime};

use serde::Serialize;

/// What made a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Manifest {
    /// Version of this document's format.
    pub format: u32,
    /// Version of ductloop.
    pub version: String,
    /// The scenario's seed.
    pub seed: u64,
    /// What rendered: `wgpu` or `cpu`.
    pub renderer: String,
    /// The graphics adapter; null for a renderer that uses none.
    pub adapter: Option<AdapterInfo>,
    /// The command line of the navigator's program; null for the robot's own navigator.
    pub navigator: Option<String>,
    /// The machine.
    pub host: Host,
    /// Threads that the call was given.
    pub threads: usize,
    /// When the run began: RFC 3339, UTC.
    pub started_at: String,
}

/// A graphics adapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdapterInfo {
    /// Its name, as its driver gives it.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// Whether it computes on the processor.
    pub software: bool,
}

/// A machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Host {
    /// Operating system, as Rust names it: `linux`.
    pub os: String,
    /// Processor architecture: `x86_64`.
    pub arch: String,
    /// Processor model, where the system tells.
    pub cpu: Option<String>,
    /// Threads that run at once.
    pub cores: Option<usize>,
}

#[cfg(feature = "wgpu")]
impl From<&ductloop_sensor::gpu::Adapter> for AdapterInfo {
    fn from(adapter: &ductloop_sensor::gpu::Adapter) -> Self {
        let ductloop_sensor::gpu::Adapter { name, driver, backend, software } = adapter.clone();
        Self { name, driver, backend, software }
    }
}

impl Host {
    /// This machine.
    pub fn this() -> Self {
        Self {
            os: std::env::consts::OS.to_owned(),
            arch: std::env::consts::ARCH.to_owned(),
            cpu: std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| cpu_model(&text)),
            cores: std::thread::available_parallelism().ok().map(usize::from),
        }
    }
}

fn cpu_model(cpuinfo: &str) -> Option<String> {
    let line = cpuinfo.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, model)| model.trim().to_owned())
}

impl Manifest {
    /// Of a run that begins now on this machine.
    #[expect(clippy::disallowed_methods, reason = "when a run began is shown and bears on no result")]
    pub fn now(seed: u64, renderer: &str, adapter: Option<AdapterInfo>, threads: usize) -> Self {
        Self {
            format: 1,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed,
            renderer: renderer.to_owned(),
            adapter,
            navigator: None,
            host: Host::this(),
            threads,
            started_at: rfc_3339(SystemTime::now()),
        }
    }

    /// The document's text.
    ///
    /// # Errors
    /// None that is known of.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// A time as RFC 3339 in UTC, to the second; times before 1970 as its beginning.
fn rfc_3339(time: SystemTime) -> String {
    let since = time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO).as_secs();
    let (days, second) = (since / 86_400, since % 86_400);
    // Howard Hinnant, "chrono-compatible low-level date algorithms", civil_from_days: years begin in March, eras have 400.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3_600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_calendar() {
        // From GNU date: `date -u -d @N +%FT%TZ`.
        for (since, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_200, "2024-03-01T00:00:00Z"),
            (1_767_225_599, "2025-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(rfc_3339(SystemTime::UNIX_EPOCH + Duration::from_secs(since)), text);
        }
    }

    #[test]
    fn the_processor_is_named_where_the_system_tells() {
        assert_eq!(cpu_model("vendor_id\t: X\nmodel name\t: A B: C\n").as_deref(), Some("A B: C"));
        assert_eq!(cpu_model("Processor: 0\n"), None);
    }
}
