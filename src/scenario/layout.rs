//! Runs and branches as the pieces and joins of a network: names, and the cross-section that each fitting finds.

use std::collections::BTreeMap;

use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::{self, End, Join, NetworkError, PortRef, RouteError};

use super::check::quoted;
use super::model::{Branch, Duct, Piece};
use super::unknown_key::nearest;

/// The pieces of a network and what is joined, each with the path in the file that it comes from.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The fittings of the run, then those of the branches.
    pub pieces: Vec<network::Piece>,
    /// Paths of the pieces: `duct.run[3]`.
    pub(super) paths: Vec<String>,
    /// What is joined.
    pub joins: Vec<Join>,
    /// Paths of the joins: of the later fitting, or of a branch's `from` or `to`.
    pub(super) join_paths: Vec<String>,
    /// How free ports are finished.
    pub ends: Vec<(PortRef, End)>,
}

/// Why a duct is no network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DuctError {
    /// A branch names a port that is not there.
    #[error("{0}")]
    Port(#[from] PortError),
    /// The pieces cannot be joined.
    #[error("{0}")]
    Network(#[from] NetworkError),
    /// The route leads nowhere.
    #[error("{0}")]
    Route(#[from] RouteError),
}

/// A branch names a port that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` cannot be joined to \"{port}\": {reason}", .ends.first().map_or("", |(name, _)| name))]
pub struct PortError {
    /// Where it is named.
    pub(super) path: String,
    /// What is named.
    pub(super) port: String,
    /// Names and paths of the branch's fitting that would be joined, and of the one that is named, if there is one.
    pub(super) ends: Box<[(String, String)]>,
    /// Why it is nothing.
    pub(super) reason: String,
    /// What there is.
    pub(super) help: String,
}

/// Width and height of a duct, in metres.
pub(super) type Section = [f64; 2];

/// Names of fittings: their own, else what they are and their number among those.
pub(super) fn names<'p>(pieces: impl Iterator<Item = (&'p str, &'static str)>) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    pieces
        .map(|(name, kind)| {
            let count = counts.entry(kind).or_default();
            *count += 1;
            if name.is_empty() { format!("{kind}-{count}") } else { name.to_owned() }
        })
        .collect()
}

/// A fitting's name and a port's, as "tee-1.left".
pub(super) fn named_port(text: &str) -> Option<(&str, PortName)> {
    let (name, port) = text.rsplit_once('.')?;
    Some((name, PortName::named(port)?))
}

/// A run: the port that it begins at, by its fitting's name, and the names of its fittings.
pub(super) type NamedRun<'a> = (Option<(&'a str, PortName)>, &'a [String]);

/// The section that each fitting of each run finds at its `in`. The first run begins with `begin`, each other one at the port that it
/// names; where that port is not there, or only through itself, with `begin` too. `shape` is asked for each fitting once, with its
/// section.
pub(super) fn sections(
    begin: Section,
    runs: &[NamedRun<'_>],
    mut shape: impl FnMut(usize, usize, Section) -> Option<Shape>,
) -> Vec<Vec<Section>> {
    let mut found: Vec<Option<Vec<Section>>> = vec![None; runs.len()];
    let mut ports: BTreeMap<(&str, PortName), Section> = BTreeMap::new();
    while found.iter().any(Option::is_none) {
        let starts_at = |run: &usize| match runs[*run].0 {
            None => Some(begin),
            Some(port) => ports.get(&port).copied(),
        };
        let open = || (0..runs.len()).filter(|run| found[*run].is_none());
        let Some((run, start)) =
            open().find_map(|run| Some((run, starts_at(&run)?))).or_else(|| open().next().map(|run| (run, begin)))
        else {
            break;
        };
        let mut section = start;
        let sections = runs[run].1.iter().enumerate().map(|(index, name)| {
            let here = section;
            if let Some(shape) = shape(run, index, here) {
                let fitting = Fitting { shape, width_m: here[0], height_m: here[1], surface: SurfaceId(0) };
                for port in fitting.ports() {
                    ports.insert((name, port.name), [port.width_m, port.height_m]);
                }
                if let Some(out) = fitting.port(PortName::Out) {
                    section = [out.width_m, out.height_m];
                }
            }
            here
        });
        found[run] = Some(sections.collect());
    }
    found.into_iter().flatten().collect()
}

/// The word for a fitting in names and drawings.
pub(super) fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::Straight { .. } => "straight",
        Shape::RadiusElbow { .. } => "elbow",
        Shape::MitredElbow { .. } => "mitre",
        Shape::VanedElbow { .. } => "vaned",
        Shape::Transition { .. } => "transition",
        Shape::Offset { .. } => "offset",
        Shape::Slope { .. } => "slope",
        Shape::Tee { .. } => "tee",
        Shape::BullheadTee { .. } => "bullhead",
        Shape::SideBranch { .. } => "side-branch",
        Shape::Wye { .. } => "wye",
        Shape::Cross { .. } => "cross",
        Shape::Damper { .. } => "damper",
        Shape::Grille { .. } => "grille",
        Shape::Drop { .. } => "drop",
    }
}

impl Duct {
    /// All runs, that of the duct first.
    fn runs(&self) -> impl Iterator<Item = (Option<&Branch>, &[Piece])> {
        std::iter::once((None, &self.run[..])).chain(self.branches.iter().map(|branch| (Some(branch), &branch.run[..])))
    }

    /// Its fittings as the pieces of a network.
    ///
    /// # Errors
    /// If a branch names a port that is not there.
    pub fn layout(&self) -> Result<Layout, PortError> {
        let all = || self.runs().flat_map(|(_, run)| run);
        let names = names(all().map(|piece| (piece.name.as_str(), kind(&piece.shape))));
        let mut firsts = Vec::new();
        let mut runs = Vec::new();
        let mut first = 0;
        for (branch, run) in self.runs() {
            firsts.push(first);
            runs.push((branch.and_then(|branch| named_port(&branch.from)), &names[first..first + run.len()]));
            first += run.len();
        }
        let pieces_of: Vec<&[Piece]> = self.runs().map(|(_, run)| run).collect();
        let sections = sections([self.width_m, self.height_m], &runs, |run, index, _| Some(pieces_of[run][index].shape));
        let fittings = all().zip(sections.into_iter().flatten()).map(|(piece, [width_m, height_m])| Fitting {
            shape: piece.shape,
            width_m,
            height_m,
            surface: piece.surface,
        });
        let mut layout = Layout {
            pieces: fittings.zip(&names).map(|(fitting, name)| network::Piece { fitting, name: name.clone() }).collect(),
            paths: Vec::new(),
            joins: Vec::new(),
            join_paths: Vec::new(),
            ends: Vec::new(),
        };
        let list = |branch: usize| if branch == 0 { "duct.run".to_owned() } else { format!("duct.branch[{}].run", branch - 1) };
        for (run, pieces) in pieces_of.iter().enumerate() {
            layout.paths.extend((0..pieces.len()).map(|index| format!("{}[{index}]", list(run))));
        }
        let mut free = Vec::new();
        for (number, (branch, run)) in self.runs().enumerate() {
            let first = firsts[number];
            for index in first + 1..first + run.len() {
                let path = layout.paths[index].clone();
                layout.join((index - 1, PortName::Out), (index, PortName::In), path);
            }
            let Some(last) = (first + run.len()).checked_sub(1).filter(|_| !run.is_empty()) else { continue };
            let mut end = Some(self.exit);
            if let Some(branch) = branch {
                let path = |key: &str| format!("duct.branch[{}].{key}", number - 1);
                let from = layout.find(&branch.from, path("from"), first)?;
                layout.join(from, (first, PortName::In), path("from"));
                end = Some(branch.end);
                if let Some(to) = &branch.to {
                    let to = layout.find(to, path("to"), last)?;
                    layout.join((last, PortName::Out), to, path("to"));
                    end = None;
                }
            } else {
                free.push(((first, PortName::In), self.entry));
            }
            free.extend(end.map(|end| ((last, PortName::Out), end)));
            for (index, piece) in run.iter().enumerate() {
                free.push(((first + index, PortName::Left), piece.left_end));
                free.push(((first + index, PortName::Right), piece.right_end));
            }
        }
        let joined = |port: &PortRef| layout.joins.iter().any(|join| join.a == *port || join.b == *port);
        let is_there = |(piece, port): &PortRef| layout.pieces[*piece].fitting.port(*port).is_some();
        layout.ends = free.into_iter().filter(|(port, _)| is_there(port) && !joined(port)).collect();
        Ok(layout)
    }
}

impl Layout {
    fn join(&mut self, a: PortRef, b: PortRef, path: String) {
        self.joins.push(Join { a, b });
        self.join_paths.push(path);
    }

    /// The port that is to be joined to the fitting `end`.
    fn find(&self, text: &str, path: String, end: usize) -> Result<PortRef, PortError> {
        let named = |piece: usize| (self.pieces[piece].name.clone(), self.paths[piece].clone());
        let error = |reason: String, help: String| PortError {
            path: path.clone(),
            port: text.to_owned(),
            ends: Box::new([named(end)]),
            reason,
            help,
        };
        let Some((name, port)) = text.rsplit_once('.') else {
            return Err(error(
                "it names no port".to_owned(),
                "a fitting's name, a dot, and `in`, `out`, `left` or `right`, as in \"tee-1.left\"".to_owned(),
            ));
        };
        let names: Vec<&str> = self.pieces.iter().map(|piece| piece.name.as_str()).collect();
        let Some(piece) = names.iter().position(|known| *known == name) else {
            let guess = nearest(name, names.iter().copied()).map(|near| format!("did you mean \"{near}\"? ")).unwrap_or_default();
            let few: Vec<&str> = names.iter().copied().take(20).collect();
            let more = if names.len() > few.len() { ", …" } else { "" };
            return Err(error(format!("there is no fitting \"{name}\""), format!("{guess}known: {}{more}", quoted(&few))));
        };
        let fitting = &self.pieces[piece].fitting;
        let ports: Vec<&str> = fitting.ports().iter().map(|port| port.name.as_str()).collect();
        match PortName::named(port).filter(|port| fitting.port(*port).is_some()) {
            Some(port) => Ok((piece, port)),
            None => Err(PortError {
                ends: Box::new([named(end), named(piece)]),
                ..error(
                    format!("`{name}`, a {}, has no port `{port}`", fitting.shape.name()),
                    format!("it has {}", quoted(&ports)),
                )
            }),
        }
    }
}
