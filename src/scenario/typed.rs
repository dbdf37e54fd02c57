//! A scenario as typed: the file with everything laid over it, before presets and defaults.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::diagnostic::{Diagnostic, Finding};
use super::overlay::{self, Overlays};
use super::parse;
use super::source::{Sources, Span};
use super::tree::Table;

/// The largest file that is read: a duct of a hundred thousand fittings fits, a device or an image named by mistake does not
/// fill the memory.
const LARGEST_BYTES: u64 = 8 << 20;

/// What was typed, with its places, and what was wrong with the texts themselves.
#[derive(Clone, Debug, Default)]
pub(super) struct Typed {
    pub(super) sources: Sources,
    pub(super) root: Table,
    /// Texts that are not TOML, and `--set` arguments that cannot be applied.
    pub(super) findings: Vec<Finding>,
    /// Texts that could not be read at all.
    pub(super) unreadable: Vec<Diagnostic>,
}

impl Typed {
    /// From a text, named `file` in errors.
    pub(super) fn from_text(file: &str, text: &str) -> Self {
        let mut typed = Self::default();
        typed.lay_text(file.to_owned(), text);
        typed
    }

    /// From a text with single fields laid over it, as by `--set`.
    pub(super) fn from_text_with<'s>(file: &str, text: &str, set: impl Iterator<Item = &'s String>) -> Self {
        let mut typed = Self::from_text(file, text);
        set.for_each(|set| typed.lay_setting(set));
        typed
    }

    /// From files, each prepared by itself and laid over those before it.
    pub(super) fn of_files(paths: &[impl AsRef<Path>], prepare: fn(&mut Table)) -> Self {
        let mut typed = Self::default();
        for path in paths.iter().map(AsRef::as_ref) {
            let mut file = Table::default();
            std::mem::swap(&mut typed.root, &mut file);
            typed.lay_file(path.display().to_string(), path);
            std::mem::swap(&mut typed.root, &mut file);
            prepare(&mut file);
            typed.root.merge(file);
        }
        typed
    }

    /// From a file with what is laid over it.
    pub(super) fn read(path: &Path, overlays: &Overlays) -> Self {
        let mut typed = Self::default();
        typed.lay_file(path.display().to_string(), path);
        typed.lay_over(overlays);
        typed
    }

    /// From a text, named `file` in errors, with what is laid over it.
    pub(super) fn read_text(file: &str, text: &str, overlays: &Overlays) -> Self {
        let mut typed = Self::from_text(file, text);
        typed.lay_over(overlays);
        typed
    }

    fn lay_over(&mut self, overlays: &Overlays) {
        for with in &overlays.with {
            self.lay_file(format!("--with {}", with.display()), with);
        }
        overlays.set.iter().for_each(|set| self.lay_setting(set));
    }

    fn lay_setting(&mut self, set: &str) {
        let source = self.sources.add(format!("--set {set}"), set);
        if let Err(finding) = overlay::set(&mut self.root, &self.sources, source) {
            self.findings.push(finding);
        }
    }

    fn lay_file(&mut self, label: String, path: &Path) {
        match read(path) {
            Ok(bytes) if bytes.len() as u64 > LARGEST_BYTES => {
                let message = format!("larger than {} MiB, which no scenario is", LARGEST_BYTES >> 20);
                self.unreadable.push(Diagnostic::of_file(label, message, "check the name of the file"));
            }
            Err(error) => self.unreadable.push(unreadable(label, path, &error)),
            Ok(bytes) => match String::from_utf8(bytes) {
                Ok(text) => self.lay_text(label, &text),
                Err(error) => self.unreadable.push(not_utf8(label, error.as_bytes(), error.utf8_error().valid_up_to())),
            },
        }
    }

    fn lay_text(&mut self, label: String, text: &str) {
        let source = self.sources.add(label, text);
        let (table, syntax) = parse::document(&self.sources, source);
        if table.entries.is_empty() && syntax.is_empty() {
            let what = if text.trim().is_empty() { "the file is empty" } else { "the file holds nothing but comments" };
            let help =
                "a scenario starts with `format = 1` and `kind = \"scenario\"`; `ductloop schema` lists all that may follow";
            self.findings.push(Finding::new(Span::new(source, 0..0), what).help(help));
        }
        self.findings.extend(syntax);
        self.root.merge(table);
    }

    /// Where a path was typed; where it was not, the nearest table around it that was.
    pub(super) fn span(&self, path: &str) -> Span {
        let mut span = Span::default();
        let mut table = &self.root;
        let mut steps = path.split('.');
        while let Some((key, index)) = steps.next().map(|step| step.split_once('[').unwrap_or((step, ""))) {
            let Some(entry) = table.entry(key) else { break };
            let index = index.trim_end_matches(']').parse().ok();
            let node = index.and_then(|i: usize| entry.node.as_list()?.get(i)).unwrap_or(&entry.node);
            span = node.span;
            match node.as_table() {
                Some(inner) => table = inner,
                None => break,
            }
        }
        span
    }
}

/// A file's bytes; one more than the bound shows that there are more.
fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn unreadable(label: String, path: &Path, error: &std::io::Error) -> Diagnostic {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::NotFound => {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
            let help = match folder.filter(|folder| !folder.is_dir()) {
                Some(folder) => format!("there is no folder `{}` either", folder.display()),
                None => "check the name; relative paths start from the working directory".to_owned(),
            };
            Diagnostic::of_file(label, "there is no such file", help)
        }
        ErrorKind::IsADirectory => Diagnostic::of_file(label, "this is a folder, not a file", "name a file in it"),
        _ => Diagnostic::of_file(label, format!("cannot be read: {error}"), "check that the file may be read"),
    }
}

/// The place of the first byte that is not UTF-8; its line is shown up to there.
fn not_utf8(label: String, bytes: &[u8], valid_to: usize) -> Diagnostic {
    let valid = String::from_utf8_lossy(&bytes[..valid_to]).into_owned();
    let mut sources = Sources::default();
    let source = sources.add(label.clone(), valid);
    let mut place = sources.place(Span::new(source, valid_to..valid_to));
    place.text.push('\u{fffd}');
    place.mark.end = place.text.len();
    Diagnostic::new(
        label,
        Some(place),
        format!("not UTF-8: byte 0x{:02x}", bytes[valid_to]),
        Some("save the file as UTF-8 text".to_owned()),
    )
}
