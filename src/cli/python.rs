//! A Python in which a package is installed.

use std::process::{Command, Stdio};

use super::problem::Problem;

/// Looks for a package, `ray` or `optuna`, that `--engine` of the same name needs; `name` as people write it, and what can be done without it.
///
/// # Errors
/// Where there is no such Python, or no such package in it.
pub(crate) fn find(python: &str, package: &str, name: &str, elsewhere: &str) -> Result<(), Problem> {
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message).about(format!("--engine {package}"));
    // Looked for, not imported: that would take seconds.
    let look = format!("import importlib.util, sys; sys.exit(0 if importlib.util.find_spec('{package}') else 7)");
    match Command::new(python).args(["-c", &look]).stdin(Stdio::null()).output() {
        Ok(told) if told.status.success() => Ok(()),
        Ok(told) if told.status.code() == Some(7) => Err(wrong(format!("{name} is not installed in {python}")).help(format!(
            "`{python} -m pip install {package}` installs it (Debian's Python wants a virtual environment: `--python` names its \
                 python); {elsewhere}"
        ))),
        Ok(told) => Err(wrong(format!("{python} does not work: {}", String::from_utf8_lossy(&told.stderr).trim()))
            .help("`--python` names another one")),
        Err(error) => Err(wrong(format!("there is no Python here: {python}: {error}")).help(format!(
            "install Python and, in it, {name} (`python3 -m pip install {package}`), and name it with `--python`; {elsewhere}"
        ))),
    }
}
