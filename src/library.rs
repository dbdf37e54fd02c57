//! The library: every scenario below `scenarios/`, built into the program (`build.rs`), so that it can be listed, run and copied from
//! any folder. Names are unique in it whatever the theme: a test holds that.

use std::sync::OnceLock;

use crate::scenario::{Diagnostics, Overlays, Scenario, text_of};

/// The theme of the files that stand in no folder.
const BASICS: &str = "basics";

/// `("fittings/elbow-left.toml", its text)`, in the order of the paths.
static FILES: &[(&str, &str)] = &include!(concat!(env!("OUT_DIR"), "/library.rs"));

/// A scenario of the library.
#[derive(Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name, which is its file's too: `elbow-left`.
    pub name: &'static str,
    /// Its folder: `fittings`.
    pub theme: &'static str,
    /// What it is for, in a sentence.
    pub about: String,
    /// The whole file, with its comments.
    pub text: &'static str,
}

/// All of it: what stands in no folder first, then theme by theme, by name within each.
pub fn all() -> &'static [Entry] {
    static ALL: OnceLock<Vec<Entry>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut entries: Vec<Entry> = FILES.iter().map(|(path, text)| Entry::of(path, text)).collect();
        entries.sort_by_key(|entry| (entry.theme != BASICS, entry.theme, entry.name));
        entries
    })
}

/// The scenario of this name.
pub fn get(name: &str) -> Option<&'static Entry> {
    all().iter().find(|entry| entry.name == name)
}

impl Entry {
    fn of(path: &'static str, text: &'static str) -> Self {
        let (theme, file) = path.rsplit_once('/').unwrap_or((BASICS, path));
        let about = text_of(text, "about").unwrap_or_default();
        Self { name: file.strip_suffix(".toml").unwrap_or(file), theme, about, text }
    }

    /// By what errors call its text.
    pub fn label(&self) -> String {
        format!("library:{}", self.name)
    }

    /// Reads it, as [`Scenario::read`] reads a file.
    ///
    /// # Errors
    /// What is wrong with what was laid over it.
    pub fn read(&self, overlays: &Overlays) -> Result<Scenario, Diagnostics> {
        Scenario::read_text(&self.label(), self.text, overlays)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_has_a_name_of_its_own_and_says_what_it_is_for() {
        assert!(all().len() > 60, "{}", all().len());
        let names: BTreeSet<_> = all().iter().map(|entry| entry.name).collect();
        assert_eq!(names.len(), all().len(), "a name stands for one scenario, whatever its folder");
        for entry in all() {
            let scenario = entry.read(&Overlays::default()).unwrap_or_else(|wrong| panic!("{wrong}"));
            assert_eq!(scenario.name, entry.name, "a file is named after its scenario");
            assert_eq!(scenario.about, entry.about);
            assert!(entry.about.ends_with('.') && entry.about.len() > 20, "{}: `{}` is no sentence", entry.name, entry.about);
            assert!(!scenario.pass.list.is_empty(), "{} asks for nothing", entry.name);
            assert_eq!(get(entry.name), Some(entry));
        }
    }

    /// What the build took in is what stands in the folder: no scenario is left out, no sweep is in it.
    #[test]
    fn it_is_what_stands_in_the_folder() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        for (path, text) in FILES {
            assert_eq!(std::fs::read_to_string(root.join(path)).expect(path), *text);
        }
        for theme in ["sweeps", "studies", "gauge"] {
            assert!(all().iter().all(|entry| entry.theme != theme), "{theme}");
        }
        let themes: BTreeSet<_> = all().iter().map(|entry| entry.theme).collect();
        assert!(["basics", "faults", "fittings", "narrow", "networks", "widths"].iter().all(|theme| themes.contains(theme)));
    }

    #[test]
    fn what_is_laid_over_one_is_told_with_its_place() {
        let straight = get("straight").expect("it is there");
        let set = |set: &str| straight.read(&Overlays { set: vec![set.to_owned()], ..Default::default() });
        assert_eq!(set("robot.speed_m_s=0.2").map(|scenario| scenario.speed_m_s), Ok(0.2));
        let wrong = set("duct.width_m=0.1").expect_err("the robot is wider");
        assert!(wrong.0.iter().all(|error| error.place.is_some()), "{wrong}");
    }
}
