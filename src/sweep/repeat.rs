//! The command that repeats one case alone.

use super::case::Case;
use crate::scenario::sweep_file::SweepFile;

/// `ductloop run BASE --set … --seed N --renderer cpu`, quoted for a shell.
pub fn command(sweep: &SweepFile, case: &Case, renderer: &str) -> String {
    let mut words = vec!["ductloop".to_owned(), "run".to_owned(), quoted(&sweep.bases[case.at.base].file)];
    for setting in sweep.settings.iter().chain(&case.settings) {
        words.extend(["--set".to_owned(), quoted(setting)]);
    }
    let renderer = renderer.split(' ').next().unwrap_or(renderer);
    words.extend(["--seed".to_owned(), case.seed.to_string(), "--renderer".to_owned(), renderer.to_owned()]);
    words.join(" ")
}

/// A word as a POSIX shell reads it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_every_word_back() {
        for word in
            ["plain", "duct.width_m=0.5", "sensor.preset=\"wide\"", "it's", "", "a b", "$HOME `x`", "duct.run[0].straight_m=2.0"]
        {
            let output =
                std::process::Command::new("sh").args(["-c", &format!("printf %s {}", quoted(word))]).output().expect("sh");
            assert_eq!(String::from_utf8_lossy(&output.stdout), word);
        }
    }
}
