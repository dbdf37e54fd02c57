//! All runs of a call as JUnit, for CI servers: a run that failed its criteria, one that could not go on and one that was not
//! given the time are a failure, an error and a time-out. A failure that an allowance covers (`run --at-least`) is skipped, with the
//! reason as its message, so that a server does not count it.

use std::io;
use std::path::Path;
use std::time::Duration;

use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};

use super::summary::Summary;
use super::whole_file::{self, FileError};
use super::words::METRICS;
use crate::metrics::Verdict;

/// A run for the file.
#[derive(Clone, Debug)]
pub struct Case<'a> {
    /// What it came to.
    pub summary: &'a Summary,
    /// The name of its folder, which tells runs of one scenario apart.
    pub name: &'a str,
    /// Its verdict's reasons as sentences ([`super::words::reason`]).
    pub reasons: Vec<String>,
    /// Where its report is, if it has one.
    pub report: Option<&'a Path>,
    /// Why its failure does not count, if it does not: so many of its scenario's seeds may fail.
    pub allowed: Option<&'a str>,
}

/// The document.
///
/// # Errors
/// None that is known of: characters that XML does not allow are left out.
pub fn junit(cases: &[Case<'_>]) -> Result<String, quick_junit::SerializeError> {
    let mut suite = TestSuite::new("ductloop");
    suite.add_test_cases(cases.iter().map(test_case));
    let total = cases.iter().filter_map(|case| time(case.summary)).sum();
    suite.set_time(total);
    let mut report = Report::new("ductloop");
    report.set_time(total).add_test_suite(suite);
    report.to_string()
}

/// Writes the document, whole or not at all. Folders above it are made.
///
/// # Errors
/// Where something other than a regular file stands there, or the system refuses.
pub fn write_junit(path: &Path, cases: &[Case<'_>]) -> Result<(), FileError> {
    whole_file::write(path, junit(cases).map_err(io::Error::other)?.as_bytes())
}

fn time(summary: &Summary) -> Option<Duration> {
    summary.metrics.wall_time_s.and_then(|time_s| Duration::try_from_secs_f64(time_s).ok())
}

fn test_case(case: &Case<'_>) -> TestCase {
    let summary = case.summary;
    let message = summary.message.clone().unwrap_or_else(|| case.reasons.join(" "));
    let not_passed = |kind, word: &str| {
        let mut status = TestCaseStatus::non_success(kind);
        status.set_type(word).set_message(message.as_str()).set_description(case.reasons.join("\n"));
        status
    };
    let status = match summary.verdict {
        Verdict::Pass => TestCaseStatus::success(),
        Verdict::Fail => match case.allowed {
            Some(why) => {
                let mut status = TestCaseStatus::skipped();
                status.set_type("allowed").set_message(format!("{why}: {message}")).set_description(case.reasons.join("\n"));
                status
            }
            None => not_passed(NonSuccessKind::Failure, "verdict"),
        },
        Verdict::Error => not_passed(NonSuccessKind::Error, "error"),
        Verdict::Timeout => not_passed(NonSuccessKind::Error, "timeout"),
    };
    let mut test = TestCase::new(case.name, status);
    test.set_classname(format!("ductloop.{}", summary.scenario));
    if let Some(time) = time(summary) {
        test.set_time(time);
    }
    test.add_property(Property::new("seed", summary.seed.to_string()));
    test.add_property(Property::new("renderer", summary.renderer.as_str()));
    if let Some(hash) = &summary.run_hash {
        test.add_property(Property::new("run_hash", hash.as_str()));
    }
    let mut out: String =
        METRICS.iter().map(|words| format!("{}: {}\n", words.label, words.show(summary.metrics.get(words.metric), 4))).collect();
    if let Some(report) = case.report {
        let report = report.display().to_string();
        test.add_property(Property::new("report", report.as_str()));
        // GitLab and the attachments plugin of Jenkins make a link of such a line.
        out += &format!("report: {report}\n[[ATTACHMENT|{report}]]\n");
    }
    test.set_system_out(out);
    test
}
