//! Why fittings make no network, told with both ends and where they were typed.

use ductloop_duct::fitting::FittingError;
use ductloop_duct::network::{NetworkError, RouteError, Turn};

use super::{Cross, Finding};
use crate::scenario::fittings::KINDS;
use crate::scenario::layout::{DuctError, Layout};

impl Cross<'_> {
    pub(super) fn no_network(&mut self, error: DuctError) {
        match error {
            DuctError::Port(error) => {
                let message = format!("`{}` is \"{}\": {}", error.path, error.port, error.reason);
                self.at(&error.path, message, error.help);
            }
            DuctError::Network(error) => self.not_joined(error),
            DuctError::Route(error) => self.no_way(&error),
        }
    }

    fn at(&mut self, path: &str, message: String, help: String) {
        let finding = Finding::new(self.typed.span(path), message).help(help);
        self.checked.wrong(path, finding);
    }

    fn not_joined(&mut self, error: NetworkError) {
        let Ok(layout) = self.scenario.duct.layout() else { return };
        match &error {
            NetworkError::Empty => {
                self.wrong(&["duct.run", "duct"], "the duct has no fittings".to_owned(), "one or more".to_owned());
            }
            NetworkError::Fitting { index, error, .. } => self.impossible(&layout.paths[*index], error),
            NetworkError::SameName { second, first, name } => {
                let path = format!("{}.name", layout.paths[*second]);
                let message = format!("`{path}` is \"{name}\", and so is `{}`", layout.paths[*first]);
                self.at(&path, message, "a name of its own, or none".to_owned());
            }
            // Indices come from the layout.
            NetworkError::UnknownPiece { .. } => self.wrong(&["duct"], error.to_string(), String::new()),
            NetworkError::UnknownPort { piece, .. } => {
                let help = "end the run there, and put what follows into `[[duct.branch]]` with `from` one of its ports";
                self.at(&layout.paths[*piece], error.to_string(), help.to_owned());
            }
            NetworkError::JoinedTwice { join, .. } => {
                let path = layout.join_paths.get(*join).map_or("duct", String::as_str);
                self.at(path, error.to_string(), "another port for one of the two".to_owned());
            }
            NetworkError::DifferentSizes { join, .. } => {
                let path = layout.join_paths.get(*join).map_or("duct", String::as_str);
                self.at(path, error.to_string(), "a transition between them".to_owned());
            }
            NetworkError::NotReachable { piece, .. } => {
                let help = "a branch begins `from` a port of what is joined to the run";
                self.at(&layout.paths[*piece], error.to_string(), help.to_owned());
            }
            NetworkError::Gap { join, .. } => {
                let path = layout.join_paths.get(*join).map_or("duct", String::as_str);
                self.at(path, error.to_string(), "lengths and angles that bring the two together".to_owned());
            }
            NetworkError::Overlap { first, second, .. } => {
                let path = layout.paths[*second].clone();
                let message = format!(
                    "{} runs into {}: both would occupy the same space",
                    self.called(&layout, *second),
                    self.called(&layout, *first).trim_end_matches(',')
                );
                self.at(&path, message, "turn the other way, or put a longer straight between them".to_owned());
            }
        }
    }

    /// A fitting as a sentence speaks of it: by its path, and by its name where it has been given one.
    fn called(&self, layout: &Layout, piece: usize) -> String {
        let path = &layout.paths[piece];
        let name = &layout.pieces[piece].name;
        let duct = &self.scenario.duct;
        let is_given = duct.run.iter().chain(duct.branches.iter().flat_map(|branch| &branch.run)).any(|p| p.name == *name);
        if is_given { format!("`{path}`, \"{name}\",") } else { format!("`{path}`") }
    }

    fn impossible(&mut self, path: &str, error: &FittingError) {
        let help = match error {
            FittingError::Angle { max_deg, .. } => {
                format!("1 to {max_deg} degrees to the left, or -1 to -{max_deg} to the right")
            }
            FittingError::OutOfRange { low_deg, high_deg, .. } => format!("{low_deg} to {high_deg} degrees"),
            FittingError::NotPositive { .. } => "a positive length in metres".to_owned(),
            FittingError::TooLarge { .. } => "less of it, or a longer fitting".to_owned(),
        };
        let paths = KINDS.iter().map(|kind| format!("{path}.{}", kind.key));
        let span = paths.map(|p| self.typed.span(&p)).min_by_key(|s| s.end - s.start).unwrap_or_default();
        self.checked.wrong(path, Finding::new(span, format!("`{path}`: {error}")).help(help));
    }

    /// Where to say that a turn is missing: the turns that there are, else the junction.
    fn too_short_at(&self, junction: &str) -> String {
        if self.typed.root.at("route.turns").is_some() {
            return "route.turns".to_owned();
        }
        let path = self.scenario.duct.layout().ok().and_then(|layout| {
            let index = layout.pieces.iter().position(|piece| piece.name == junction)?;
            layout.paths.get(index).cloned()
        });
        path.unwrap_or_else(|| "duct.run".to_owned())
    }

    fn no_way(&mut self, error: &RouteError) {
        let list = |turns: &[Turn]| turns.iter().map(|turn| format!("\"{turn}\"")).collect::<Vec<_>>().join(", ");
        let (path, help) = match error {
            RouteError::Start { .. } => ("duct.run".to_owned(), String::new()),
            RouteError::NotOffered { index, offers, .. } => (format!("route.turns[{index}]"), format!("one of {}", list(offers))),
            RouteError::TooShort { piece, .. } => (
                self.too_short_at(piece),
                "`[route]` with `turns`, one for each junction on the way, \"stop\" to end there, or `explore = true`".to_owned(),
            ),
            RouteError::TooLong { turns, .. } => {
                (format!("route.turns[{turns}]"), "\"stop\" is the last turn of a route".to_owned())
            }
        };
        self.at(&path, error.to_string(), help);
    }
}
