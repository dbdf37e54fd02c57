//! Scenario files: what a run is made of and what it must achieve.
//!
//! In data-flow order:
//!
//! - [`fields`]: the one table of fields that everything else is driven by;
//! - `source`, `parse`, `tree`: texts to TOML values with their places;
//! - [`overlay`], `typed`: the file **as typed**, with what `--with` and `--set` lay over it;
//! - `check`, `value`, `unknown_key`: each key and value against its row;
//! - `presets`, `resolve`, `elements`, `fittings`, `faults`: presets beneath, defaults filled in, into the typed [`Scenario`] **as
//!   resolved**;
//! - `random_network`: networks drawn from a seed, as if they had been typed;
//! - `layout`: runs and branches as the pieces and joins of a network;
//! - `cross`: what fields say of each other;
//! - [`accuracy_file`]: a file of kind `accuracy`, which holds a scenario, a grid over its fields and poses to draw;
//! - [`sweep_file`]: a file of kind `sweep`: base scenarios and what is varied of them;
//! - [`diagnostic`]: every error found, for people and for programs;
//! - `text`: single words of a file, and the file under another name;
//! - `rig_file`: a sensor without a scenario around it;
//! - `write`: a resolved scenario as a file again; [`schema`]: the format for editors.
//!
//! It reads files and writes none, and knows nothing of how a run is carried out.

pub mod accuracy_file;
mod check;
pub mod criteria;
mod cross;
pub mod diagnostic;
mod elements;
mod faults;
pub mod fields;
mod fittings;
mod layout;
mod model;
pub mod overlay;
mod parse;
mod presets;
mod random_network;
mod resolve;
mod rig_file;
mod schema;
mod source;
pub mod study_file;
pub mod sweep_file;
mod text;
mod tree;
mod typed;
mod unknown_key;
mod value;
mod write;

use std::path::Path;

pub use criteria::{Bound, Criteria, Criterion, Measured};
pub use diagnostic::{Diagnostic, Diagnostics, Place, Related};
pub use faults::{Fault, FaultKind, Side, Wheel};
pub use layout::{DuctError, Layout, PortError};
pub use model::{
    AutoExposure, Branch, Control, Duct, Estimation, EstimatorKind, Finish, Law, LinkParams, MountControl, Navigation, Object,
    ObjectShape, Perception, Piece, Pipeline, Rates, RigDeviation, Route, Scenario, Start, Surface, WheelControl,
};
pub use overlay::Overlays;
pub use rig_file::RigFile;
pub use schema::schema;
pub use text::{renamed, text_of};
pub use unknown_key::near;
pub use value::shown;

/// What a file of this project describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// One run.
    Scenario,
    /// A list of many runs.
    Sweep,
    /// A search over many runs.
    Study,
    /// A grid of poses, each rendered and estimated, against the truth.
    Accuracy,
    /// A calibration with a simulated block gauge.
    Gauge,
}

impl FileKind {
    /// By the file's `kind`; `None` if it does not say, or says something else.
    pub fn of(text: &str) -> Option<Self> {
        let typed = typed::Typed::from_text("", text);
        match typed.root.get(fields::KIND)?.as_text()? {
            "scenario" => Some(Self::Scenario),
            "sweep" => Some(Self::Sweep),
            "study" => Some(Self::Study),
            "accuracy" => Some(Self::Accuracy),
            "gauge" => Some(Self::Gauge),
            _ => None,
        }
    }
}

impl Scenario {
    /// Reads a scenario file, lays the overlays over it, fills in presets and defaults, and checks all of it.
    ///
    /// # Errors
    /// Every error found, in the order of the texts: the file, then each overlay.
    pub fn read(path: &Path, overlays: &Overlays) -> Result<Self, Diagnostics> {
        resolve::resolve(&typed::Typed::read(path, overlays))
    }

    /// The same from a text; errors name it `label`.
    ///
    /// # Errors
    /// Every error found, in the order of the texts: this one, then each overlay.
    pub fn read_text(label: &str, text: &str, overlays: &Overlays) -> Result<Self, Diagnostics> {
        resolve::resolve(&typed::Typed::read_text(label, text, overlays))
    }

    /// The same from a text; errors name it `scenario`.
    ///
    /// # Errors
    /// Every error found, in the order of the text.
    pub fn from_toml_str(text: &str) -> Result<Self, Diagnostics> {
        resolve::resolve(&typed::Typed::from_text("scenario", text))
    }

    /// Reads a rig: a whole scenario's, or a file that holds nothing but a sensor, in `[sensor]` or with `[camera]`, `[laser.NAME]`,
    /// `[mount]` and `[line]` at the top. Several such files are laid one over the other, and over a scenario's.
    ///
    /// # Errors
    /// Every error found, in the order of the texts; no file is one, too.
    pub fn read_rig(paths: &[impl AsRef<Path>]) -> Result<RigFile, Diagnostics> {
        Self::rig(typed::Typed::of_files(paths, rig_file::prepare))
    }

    /// The same from a text; errors name it `rig`.
    ///
    /// # Errors
    /// Every error found, in the order of the text.
    pub fn rig_from_toml_str(text: &str) -> Result<RigFile, Diagnostics> {
        Self::rig(typed::Typed::from_text("rig", text))
    }

    fn rig(mut typed: typed::Typed) -> Result<RigFile, Diagnostics> {
        let says_width = rig_file::says_width(&typed.root);
        let scenario = if rig_file::is_whole(&typed.root) {
            resolve::resolve(&typed)
        } else {
            rig_file::complete(&mut typed);
            resolve::resolve_rig(&typed)
        }?;
        let width_m = says_width.then_some(scenario.navigation.width_m);
        Ok(RigFile { scenario, width_m })
    }

    /// The resolved scenario as a file, every default written out. Read back, it gives an equal scenario.
    pub fn to_toml(&self) -> String {
        write::to_toml(self)
    }

    /// Checks a scenario that was changed or made by hand as if it had been read.
    ///
    /// # Errors
    /// Every error found, with its place in [`Scenario::to_toml`]'s text.
    pub fn validate(&self) -> Result<(), Diagnostics> {
        Self::from_toml_str(&self.to_toml()).map(|_| ())
    }
}
