//! What the documents say to type or to copy works.
#![cfg(feature = "cli")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ductloop::scenario::study_file::StudyFile;
use ductloop::scenario::sweep_file::SweepFile;

/// A fenced block of a document.
struct Block {
    /// `sh`, `yaml`.
    language: String,
    text: String,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The README and everything in `docs/`.
fn documents() -> Vec<PathBuf> {
    let mut files: Vec<_> = fs::read_dir(root().join("docs")).expect("docs").map(|entry| entry.expect("docs").path()).collect();
    files.extend([root().join("README.md")]);
    files.retain(|file| file.extension().is_some_and(|ending| ending == "md") && file.exists());
    files.sort();
    files
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(root().join(&path)).unwrap_or_else(|error| panic!("{}: {error}", path.as_ref().display()))
}

/// The fenced blocks of a document, without the indentation of a list around them.
fn blocks(markdown: &str) -> Vec<Block> {
    split(markdown).0
}

/// Blocks, and the rest.
fn split(markdown: &str) -> (Vec<Block>, String) {
    let (mut blocks, mut rest) = (Vec::new(), String::new());
    let mut open: Option<(usize, Block)> = None;
    for line in markdown.lines() {
        let fence = line.trim_start().strip_prefix("```");
        match (open.take(), fence) {
            (None, Some(language)) => {
                let indent = line.len() - line.trim_start().len();
                open = Some((indent, Block { language: language.trim().to_owned(), text: String::new() }));
            }
            (Some((_, block)), Some(_)) => blocks.push(block),
            (Some((indent, mut block)), None) => {
                block.text += line.get(indent..).unwrap_or_default();
                block.text.push('\n');
                open = Some((indent, block));
            }
            (None, None) => {
                rest += line;
                rest.push('\n');
            }
        }
    }
    assert!(open.is_none(), "a fence is not closed");
    (blocks, rest)
}

/// Everything that is shown as code: fenced blocks, and what stands between backquotes in a paragraph.
fn code(markdown: &str) -> Vec<String> {
    let (blocks, rest) = split(markdown);
    let spans = rest.split('`').skip(1).step_by(2).map(|span| span.split_whitespace().collect::<Vec<_>>().join(" "));
    blocks.into_iter().map(|block| block.text).chain(spans).collect()
}

/// The words of a line; what stands between single quotes is one.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (at, part) in line.split('\'').enumerate() {
        match at % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_owned)),
            _ => words.push(part.to_owned()),
        }
    }
    words
}

/// The arguments of every call of the program in a piece of code: after `ductloop`, a path that ends so, or `cargo run … --`.
fn calls(code: &str) -> Vec<Vec<String>> {
    let mut calls = Vec::new();
    for line in code.replace("\\\n", " ").lines() {
        // What follows belongs to the shell.
        let line = [" #", " |", " >", " &&", " 2>"].iter().fold(line, |line, end| line.split(end).next().unwrap_or_default());
        let words = words(line);
        let is_program = |word: &String| word == "ductloop" || word.ends_with("/ductloop");
        let cargo_run = words.windows(2).any(|pair| pair == ["cargo", "run"]) && !words.iter().any(|word| word == "--example");
        let start = match words.iter().position(is_program) {
            Some(at) => Some(at + 1),
            None if cargo_run => words.iter().position(|word| word == "--").map(|at| at + 1),
            None => None,
        };
        calls.extend(start.map(|start| words[start..].to_vec()));
    }
    calls
}

/// `--help` behind the arguments makes the program read them and do nothing: what it does not know, it says.
#[test]
fn commands_are_understood_and_name_files_that_exist() {
    let mut seen = 0;
    for file in documents() {
        for call in code(&read(&file)).iter().flat_map(|code| calls(code)) {
            let shown = format!("{}: ductloop {}", file.display(), call.join(" "));
            let ran = Command::new(env!("CARGO_BIN_EXE_ductloop")).args(&call).arg("--help").output().expect("the program");
            assert!(ran.status.success(), "{shown}\n{}", String::from_utf8_lossy(&ran.stderr));
            for argument in call.iter().filter(|argument| argument.starts_with("scenarios")) {
                assert!(root().join(argument).exists(), "{shown}: no {argument}");
            }
            seen += 1;
        }
    }
    assert!(seen >= 7, "only {seen} commands were found in {:?}", documents());
}

/// A picture that a command is shown for is what that command makes, if not to the bit: the mean over its pixels differs by no more
/// than a grey value. What another version of the sensor makes is several away.
#[test]
fn pictures_are_what_their_commands_make() {
    let mut seen = 0;
    for file in documents() {
        for mut call in code(&read(&file)).iter().flat_map(|code| calls(code)) {
            let shown = call.join(" ");
            let Some(out) = call.iter_mut().find(|word| word.starts_with("docs/") && word.ends_with(".png")) else { continue };
            let folder = tempfile::tempdir().expect("a folder");
            let stored = image::open(root().join(&out)).unwrap_or_else(|error| panic!("{out}: {error}")).into_rgb8();
            let made = folder.path().join("made.png");
            *out = made.display().to_string();
            let ran = Command::new(env!("CARGO_BIN_EXE_ductloop")).args(&call).current_dir(root()).output().expect("the program");
            assert!(ran.status.success(), "{shown}\n{}", String::from_utf8_lossy(&ran.stderr));
            let made = image::open(made).expect("a picture").into_rgb8();
            assert_eq!(made.dimensions(), stored.dimensions(), "{shown}");
            let sum: f64 = made.as_raw().iter().zip(stored.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
            let mean = sum / made.as_raw().len() as f64;
            assert!(mean < 1.0, "{shown}: {mean} grey values apart; docs/gallery.sh makes it anew");
            seen += 1;
        }
    }
    assert!(seen >= 1, "no command makes a picture");
}

/// Scenarios and sweeps that are shown in full are right.
#[test]
fn files_that_are_shown_are_valid() {
    let straight = read("scenarios/straight.toml");
    for file in documents() {
        for block in blocks(&read(&file)).iter().filter(|block| block.language == "toml" && block.text.contains("kind = ")) {
            if block.text.contains("kind = \"study\"") {
                let bases = ["straight-offset", "straight-fast", "fittings/elbow-left", "fittings/elbow-right"]
                    .map(|name| (format!("../{name}.toml"), read(format!("scenarios/{name}.toml"))));
                let bases: Vec<(&str, &str)> = bases.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
                if let Err(wrong) = StudyFile::from_toml_str(&block.text, &bases) {
                    panic!("{}:\n{wrong}", file.display());
                }
            } else if block.text.contains("kind = \"sweep\"") {
                if let Err(wrong) = SweepFile::from_toml_str(&block.text, &[("../straight.toml", &straight)]) {
                    panic!("{}:\n{wrong}", file.display());
                }
            } else if let Err(wrong) = ductloop::Scenario::from_toml_str(&block.text) {
                panic!("{}:\n{wrong}", file.display());
            }
        }
    }
}

#[test]
fn the_files_to_copy_are_those_that_are_shown() {
    let document = read("docs/ci.md");
    let shown: Vec<_> = blocks(&document).into_iter().filter(|block| block.language == "yaml").map(|block| block.text).collect();
    assert_eq!(shown, [read("docs/ci/github-actions.yml"), read("docs/ci/gitlab-ci.yml")]);
}

#[test]
fn ci_takes_the_oldest_rust_that_the_package_allows() {
    let rust = env!("CARGO_PKG_RUST_VERSION");
    assert!(read("docs/ci/github-actions.yml").contains(&format!("rustup toolchain install {rust} ")));
    assert!(read("docs/ci/gitlab-ci.yml").contains(&format!("image: rust:{rust}\n")));
}

#[test]
fn links_between_documents_lead_somewhere() {
    for file in documents() {
        let text = read(&file);
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for target in targets.filter(|target| !target.contains("://") && !target.starts_with('#')) {
            let path = file.parent().expect("a folder").join(target.split('#').next().unwrap_or_default());
            assert!(path.exists(), "{} links to {target}", file.display());
        }
    }
}
