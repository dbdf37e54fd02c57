//! What an optimiser of its own proposed, generation by generation: should it die, or this program, nothing of it is lost, and nothing is
//! proposed twice.

use std::path::PathBuf;

use serde_json::{Map, Value};

use super::ask_tell::Lost;
use crate::output::write_whole;

/// The candidates of a generation as they were proposed: each a number for every parameter's path.
pub type Generation = Vec<Map<String, Value>>;

/// The journal: JSON lines, each a generation.
#[derive(Clone, Debug, Default)]
pub struct Journal {
    /// Its file; without one nothing is kept.
    file: Option<PathBuf>,
    generations: Vec<Generation>,
    /// How many of them have been read again.
    read: usize,
}

impl Journal {
    /// Of a file, which need not be there yet.
    ///
    /// # Errors
    /// Where it is there and is no journal.
    pub fn open(file: PathBuf) -> Result<Self, Lost> {
        let wrong = |what: String| Lost {
            message: format!("{}: {what}", file.display()),
            help: "remove the file: candidates are proposed anew, and what was run of them is found".into(),
        };
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(wrong(error.to_string())),
        };
        let line = |(index, line)| match serde_json::from_str::<Generation>(line) {
            Ok(generation) if generation.is_empty() => Err(wrong(format!("line {} has no candidates", index + 1))),
            Ok(generation) => Ok(generation),
            Err(error) => Err(wrong(format!("line {} is no list of candidates: {error}", index + 1))),
        };
        let generations = text.lines().enumerate().map(line).collect::<Result<_, _>>()?;
        Ok(Self { file: Some(file), generations, read: 0 })
    }

    /// The next generation of an earlier call.
    pub fn earlier(&mut self) -> Option<Generation> {
        let next = self.generations.get(self.read).cloned()?;
        self.read += 1;
        Some(next)
    }

    /// That what was read last makes no sense, and where it stands.
    pub fn wrong(&self, why: &str) -> Lost {
        let file = self.file.as_ref().map_or(String::new(), |file| file.display().to_string());
        Lost {
            message: format!("{file}: line {}: {why}", self.read),
            help: "remove the file: candidates are proposed anew, and what was run of them is found".into(),
        }
    }

    /// Keeps a generation.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn keep(&mut self, generation: &Generation) -> Result<(), Lost> {
        self.generations.push(generation.clone());
        self.read = self.generations.len();
        let Some(file) = &self.file else { return Ok(()) };
        let lines: String = self.generations.iter().map(|one| serde_json::json!(one).to_string() + "\n").collect();
        // As a whole, so that it never ends within a line.
        write_whole(file, lines.as_bytes()).map_err(|error| Lost {
            message: error.to_string(),
            help: "make room; what was run is kept: the same call goes on from there".into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_is_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("candidates.jsonl");
        let generation = |value: f64| vec![Map::from_iter([("a".to_owned(), Value::from(value))])];
        let mut journal = Journal::open(file.clone()).expect("none yet");
        assert_eq!(journal.earlier(), None);
        for value in [0.5, 0.25] {
            journal.keep(&generation(value)).expect("it is written");
        }
        assert_eq!(journal.earlier(), None, "what is kept now was not proposed by an earlier call");
        let mut again = Journal::open(file.clone()).expect("a journal");
        assert_eq!([again.earlier(), again.earlier(), again.earlier()], [Some(generation(0.5)), Some(generation(0.25)), None]);
        for (text, words) in [("[{\"a\": 1}]\n[{\"a\":", "line 2 is no list"), ("[]\n", "line 1 has no candidates")] {
            std::fs::write(&file, text).expect("it is written");
            assert!(Journal::open(file.clone()).expect_err(text).message.contains(words));
        }
    }
}
