//! Why fittings make no network, told with both ends and where they were typed.

use ductloop_duct::centreline::Segment;
use ductloop_duct::fitting::FittingError;
use ductloop_duct::network::{Join, Network, NetworkError, PortRef, RouteError, Turn};

use super::{Cross, Finding};
use crate::scenario::fittings::KINDS;
use crate::scenario::layout::{DuctError, Layout};
use crate::scenario::source::Span;

/// A place, and what a sentence beside it says.
pub(super) type Related = (Span, String);

impl Cross<'_> {
    pub(super) fn no_network(&mut self, error: DuctError) {
        match error {
            DuctError::Port(error) => {
                let ends = error.ends.iter().map(|(name, path)| self.named_at(name, path)).collect();
                self.at(&error.path, error.to_string(), &error.help, ends);
            }
            DuctError::Network(error) => self.not_joined(error),
            DuctError::Route(error) => self.no_way(&error),
        }
    }

    pub(super) fn at(&mut self, path: &str, message: String, help: &str, related: Vec<Related>) {
        let finding = Finding::new(self.typed.span(path), message).help(help);
        self.checked.wrong(path, related.into_iter().fold(finding, |finding, (span, what)| finding.also(span, what)));
    }

    fn not_joined(&mut self, error: NetworkError) {
        let Ok(layout) = self.scenario.duct.layout() else { return };
        match &error {
            NetworkError::Empty => {
                self.wrong(&["duct.run", "duct"], "the duct has no fittings".to_owned(), "one or more".to_owned());
            }
            NetworkError::Fitting { index, error, .. } => self.impossible(&layout, *index, error),
            NetworkError::SameName { second, first, name } => {
                let [path, other] = [second, first].map(|piece| format!("{}.name", layout.paths[*piece]));
                let related = vec![(self.typed.span(&other), "the other one".to_owned())];
                self.at(
                    &path,
                    format!("two fittings are called \"{name}\""),
                    "a name of its own for one of them, or none",
                    related,
                );
            }
            // Indices come from the layout.
            NetworkError::UnknownPiece { .. } => self.wrong(&["duct"], error.to_string(), String::new()),
            NetworkError::UnknownPort { piece, port, .. } => {
                let help = "end the run there, and put what follows into `[[duct.branch]]` with `from` one of its ports";
                let end = (*piece, *port);
                let others = layout.joins.iter().filter_map(|join| match join {
                    Join { a, b } if *a == end => Some(b.0),
                    Join { a, b } if *b == end => Some(a.0),
                    _ => None,
                });
                let others: Vec<usize> = others.collect();
                let joined = others.first().map(|other| format!("`{}` cannot be joined: ", layout.pieces[*other].name));
                let message = format!("{}{error}", joined.unwrap_or_default());
                let related = others.into_iter().map(|piece| self.piece_at(&layout, piece)).collect();
                self.at(&layout.paths[*piece], message, help, related);
            }
            NetworkError::JoinedTwice { join, .. } => self.joined_twice(&layout, *join, &error),
            NetworkError::DifferentSizes { join, .. } => {
                self.ends_differ(&layout, *join, error.to_string(), "a transition between them");
            }
            NetworkError::NotReachable { piece, .. } => {
                let help = "a branch begins `from` a port of what is joined to the run";
                self.at(&layout.paths[*piece], error.to_string(), help, vec![self.piece_at(&layout, 0)]);
            }
            NetworkError::Gap { join, .. } => {
                self.ends_differ(&layout, *join, error.to_string(), "lengths and angles that bring the two together");
            }
            NetworkError::Overlap { first, second, first_name, second_name } => {
                let message = format!("`{second_name}` runs into `{first_name}`: both would occupy the same space");
                let help = "turn the other way, or put a longer straight between them";
                self.at(&layout.paths[*second], message, help, vec![self.piece_at(&layout, *first)]);
            }
        }
    }

    /// The two ends of a join do not go together.
    fn ends_differ(&mut self, layout: &Layout, join: usize, message: String, help: &str) {
        let Some(Join { a, b }) = layout.joins.get(join) else { return };
        let ends = [a, b].map(|end| self.piece_at(layout, end.0));
        self.at(&layout.join_paths[join], message, help, ends.into());
    }

    fn joined_twice(&mut self, layout: &Layout, join: usize, error: &NetworkError) {
        let Some(second) = layout.joins.get(join) else { return };
        if second.a == second.b {
            let message = format!("`{}.{}` is joined to itself", layout.pieces[second.a.0].name, second.a.1);
            return self.at(&layout.join_paths[join], message, "another port", vec![self.piece_at(layout, second.a.0)]);
        }
        let is_in = |join: &Join, end: PortRef| join.a == end || join.b == end;
        let first = layout.joins[..join].iter().position(|first| is_in(first, second.a) || is_in(first, second.b));
        let mut related = Vec::new();
        if let Some((first, path)) = first.map(|index| (&layout.joins[index], &layout.join_paths[index])) {
            let end = if is_in(first, second.a) { second.a } else { second.b };
            let other = if first.a == end { first.b } else { first.a };
            let message = format!("here it is joined to `{}.{}`", layout.pieces[other.0].name, other.1);
            related = vec![(self.typed.span(path), message), self.piece_at(layout, end.0)];
        }
        self.at(&layout.join_paths[join], error.to_string(), "another port for one of the two", related);
    }

    /// The place of a fitting, as something else that an error is about.
    fn piece_at(&self, layout: &Layout, piece: usize) -> Related {
        self.named_at(&layout.pieces[piece].name, &layout.paths[piece])
    }

    pub(super) fn named_at(&self, name: &str, path: &str) -> Related {
        (self.typed.span(path), format!("`{name}` is here"))
    }

    /// What a fitting of the network is called, and where it is in the file; drawn networks stand where they are asked for.
    pub(super) fn fitting_at(&self, piece: usize) -> Option<(String, String)> {
        let layout = self.scenario.duct.layout().ok()?;
        Some((layout.pieces.get(piece)?.name.clone(), layout.paths.get(piece)?.clone()))
    }

    /// The fitting that the way is in after so many metres, as something else that an error is about.
    pub(super) fn way_at(&self, network: &Network, along_m: f64) -> Option<Related> {
        let on_the_way = |segment: &&Segment| segment.start_m <= along_m;
        let segments = &network.centreline.segments;
        let segment = segments.iter().rev().find(on_the_way).or_else(|| segments.first())?;
        self.fitting_at(segment.fitting).map(|(name, path)| self.named_at(&name, &path))
    }

    fn impossible(&mut self, layout: &Layout, piece: usize, error: &FittingError) {
        let (path, name) = (&layout.paths[piece], &layout.pieces[piece].name);
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
        self.checked.wrong(path, Finding::new(span, format!("`{name}`: {error}")).help(help));
    }

    /// A way explores, or it takes turns.
    pub(super) fn one_way(&mut self) {
        let explores = self.checked.is_sound(&["route.explore"]) && self.scenario.duct.route.explore;
        if explores && let Some(turns) = self.field_at("route.turns") {
            let message = "`route.explore` beside `route.turns`: a way that explores takes none of them".to_owned();
            self.at("route.explore", message, "take one of the two out", vec![turns]);
        }
    }

    fn no_way(&mut self, error: &RouteError) {
        let list = |turns: &[Turn]| turns.iter().map(|turn| format!("\"{turn}\"")).collect::<Vec<_>>().join(", ");
        // Names are each fitting's own where there is a route to judge.
        let place = |name: &String| {
            let layout = self.scenario.duct.layout().ok()?;
            let index = layout.pieces.iter().position(|piece| piece.name == *name)?;
            Some((layout.paths[index].clone(), self.piece_at(&layout, index)))
        };
        let (path, help, piece) = match error {
            RouteError::Start { .. } => ("duct.run".to_owned(), String::new(), None),
            RouteError::NotOffered { index, offers, piece, .. } => {
                (format!("route.turns[{index}]"), format!("one of {}", list(offers)), place(piece))
            }
            RouteError::TooShort { piece, .. } => {
                let help = "`[route]` with `turns`, one for each junction on the way, \"stop\" to end there, or `explore = true`";
                let place = place(piece);
                // Where to say that a turn is missing: the turns that there are, else the junction.
                let path = match &place {
                    Some((path, _)) if self.typed.root.at("route.turns").is_none() => path,
                    _ => "route.turns",
                };
                (path.to_owned(), help.to_owned(), place)
            }
            RouteError::TooLong { turns, piece, .. } => {
                (format!("route.turns[{turns}]"), "\"stop\" is the last turn of a route".to_owned(), place(piece))
            }
        };
        self.at(&path, error.to_string(), &help, piece.into_iter().map(|(_, related)| related).collect());
    }
}
