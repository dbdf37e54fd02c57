//! Standard output and standard error. Neither may end the program: a reader who has gone away (`| head`) is no error, a full
//! disk behind standard output is one, and a lost message on standard error cannot be told to anybody.

use std::io::{ErrorKind, Write};

use serde_json::Value;

use super::problem::Problem;

/// Prints a line, or several, on standard output.
///
/// # Errors
/// Where it is lost, on a full disk for one.
pub(crate) fn print(text: &str) -> Result<(), Problem> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Problem::new(Problem::CANNOT_GO_ON, format!("cannot be written: {error}")).about("standard output"))
        }
        _ => Ok(()),
    }
}

/// Prints a document on standard output.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_json(document: &Value) -> Result<(), Problem> {
    print(&format!("{document:#}"))
}

/// Says something on standard error.
pub(crate) fn note(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
