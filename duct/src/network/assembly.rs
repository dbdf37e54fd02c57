//! Fittings joined port to port: where each comes to lie, and what cannot be joined.

use super::overlap::Overlaps;
use super::{End, Network};
use crate::Transform;
use crate::cell::{Beyond, Side};
use crate::centreline::Centreline;
use crate::fitting::port::{Port, PortName};
use crate::fitting::{Fitting, FittingError};

/// How far the two ports of a join that closes a cycle may be apart, in metres, and askew, in radians: rounding of a long chain of
/// transforms, and far below what could be made.
const CLOSES_M: f64 = 1e-6;
const CLOSES_RAD: f64 = 1e-6;
/// How much two ports that are joined may differ in width or height, in metres: rounding.
const SAME_SIZE_M: f64 = 1e-9;

/// A fitting of a network, with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// What it is.
    pub fitting: Fitting,
    /// What errors, drawings and routes call it; no two pieces of a network have the same.
    pub name: String,
}

/// A port of a piece, by the piece's index.
pub type PortRef = (usize, PortName);

/// Two ports put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Join {
    /// One of them.
    pub a: PortRef,
    /// The other.
    pub b: PortRef,
}

/// What a port leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attached {
    /// The port of another piece, or another port of the same.
    Port(PortRef),
    /// Nothing: an end.
    End(End),
}

/// Why a network cannot be assembled. Ports are named "piece.port".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// There is nothing to assemble.
    #[error("the duct has no fittings")]
    Empty,
    /// A fitting is impossible.
    #[error("`{name}`: {error}")]
    Fitting {
        /// Its index.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong with it.
        #[source]
        error: FittingError,
    },
    /// Two pieces have the same name.
    #[error("two pieces are called `{name}`: fittings {first} and {second}, counted from 0")]
    SameName {
        /// The name.
        name: String,
        /// Index of the earlier one.
        first: usize,
        /// Index of the later one.
        second: usize,
    },
    /// A join or an end names a piece that is not there.
    #[error("there is no piece {piece}; there are {pieces}, counted from 0")]
    UnknownPiece {
        /// The index asked for.
        piece: usize,
        /// How many there are.
        pieces: usize,
    },
    /// A piece has no such port.
    #[error("`{name}`, a {shape}, has no port `{port}`; it has {ports}")]
    UnknownPort {
        /// Index of the piece.
        piece: usize,
        /// Its name.
        name: String,
        /// What it is.
        shape: &'static str,
        /// The port asked for.
        port: PortName,
        /// The ports that there are.
        ports: String,
    },
    /// A port is joined, or joined and ended, twice.
    #[error("`{port}` is joined to {first} and to {second}; a port can be joined once")]
    JoinedTwice {
        /// The port.
        port: String,
        /// What it was joined to before.
        first: String,
        /// What it is joined to again.
        second: String,
        /// The join at fault, or the end behind them all, by its place in the order given.
        join: usize,
    },
    /// Ports of different sizes are joined.
    #[error("`{a}` is {} and `{b}` is {}: ports that are joined must have the same size", size(.a_m), size(.b_m))]
    DifferentSizes {
        /// One of them.
        a: String,
        /// Its width and height, in metres.
        a_m: [f64; 2],
        /// The other.
        b: String,
        /// Its width and height, in metres.
        b_m: [f64; 2],
        /// Which join.
        join: usize,
    },
    /// A piece is joined to nothing that leads to the first one.
    #[error("`{name}` is not joined to the rest: no way leads to it from `{first}`")]
    NotReachable {
        /// Index of the piece.
        piece: usize,
        /// Its name.
        name: String,
        /// Name of the first piece.
        first: String,
    },
    /// A cycle does not close.
    #[error("`{a}` and `{b}` do not meet: they are {off_mm:.3} mm apart and {off_deg:.4} degrees askew")]
    Gap {
        /// One port of the join that should close it.
        a: String,
        /// The other.
        b: String,
        /// How far apart they are.
        off_mm: f64,
        /// How much one is turned against the other.
        off_deg: f64,
        /// Which join.
        join: usize,
    },
    /// Two pieces occupy the same space.
    #[error("`{first_name}` and `{second_name}` overlap")]
    Overlap {
        /// Index of the earlier of the two.
        first: usize,
        /// Its name.
        first_name: String,
        /// Index of the later.
        second: usize,
        /// Its name.
        second_name: String,
    },
}

fn size(size_m: &[f64; 2]) -> String {
    format!("{} x {} m", size_m[0], size_m[1])
}

impl Network {
    /// Joins fittings one after the other, the first one's entry at the world's origin; other ports than `in` and `out` are capped.
    /// Pieces are called "fitting 0", "fitting 1", …
    ///
    /// # Errors
    /// If there is none, one is impossible or cannot be joined, or two overlap.
    pub fn from_run(fittings: &[Fitting], entry: End, exit: End) -> Result<Self, NetworkError> {
        let name = |index: usize| format!("fitting {index}");
        let pieces: Vec<Piece> =
            fittings.iter().enumerate().map(|(index, fitting)| Piece { fitting: *fitting, name: name(index) }).collect();
        let joins: Vec<Join> =
            (1..fittings.len()).map(|index| Join { a: (index - 1, PortName::Out), b: (index, PortName::In) }).collect();
        let mut ends = vec![((0, PortName::In), entry)];
        if fittings.last().is_some_and(|last| last.port(PortName::Out).is_some()) {
            ends.push(((fittings.len() - 1, PortName::Out), exit));
        }
        Self::assemble(&pieces, &joins, &ends)
    }

    /// Joins pieces port to port: the first one's `in` at the world's origin, the others as a walk over the joins, nearest first, comes
    /// to them; a join of two pieces that earlier joins connect must close a cycle. Ports that are neither joined nor among `ends`
    /// are capped.
    ///
    /// # Errors
    /// What cannot be joined, with the names of both ends.
    pub fn assemble(pieces: &[Piece], joins: &[Join], ends: &[(PortRef, End)]) -> Result<Self, NetworkError> {
        if pieces.is_empty() {
            return Err(NetworkError::Empty);
        }
        for (index, piece) in pieces.iter().enumerate() {
            let name = || piece.name.clone();
            piece.fitting.validate().map_err(|error| NetworkError::Fitting { index, name: name(), error })?;
        }
        same_name(pieces)?;
        let plan = Assembly { pieces, joins };
        let attached = plan.attached(ends)?;
        let world_from_piece = plan.placed()?;
        let firsts: Vec<usize> = pieces
            .iter()
            .scan(0, |next, piece| {
                let first = *next;
                *next += piece.fitting.cell_at_port(PortName::In).0;
                Some(first)
            })
            .collect();
        let mut network = Self {
            cells: Vec::new(),
            fittings: pieces.iter().map(|piece| piece.fitting).collect(),
            names: pieces.iter().map(|piece| piece.name.clone()).collect(),
            world_from_fitting: world_from_piece,
            attached,
            centreline: Centreline::default(),
        };
        for (index, piece) in pieces.iter().enumerate() {
            let beyond = |name| match network.attached((index, name)) {
                Some(Attached::Port((other, port))) => {
                    let (_, at) = pieces[other].fitting.cell_at_port(port);
                    Side::Portal(Beyond::Cell(firsts[other] + at))
                }
                Some(Attached::End(End::Open)) => Side::Portal(Beyond::Outside),
                _ => Side::Wall,
            };
            let cells = piece.fitting.cells(firsts[index], index, beyond);
            network.cells.extend(cells.iter().map(|cell| cell.transformed(&network.world_from_fitting[index])));
        }
        if let Some((first, second)) = Overlaps::new(&network.cells).first() {
            let name = |index: usize| pieces[index].name.clone();
            return Err(NetworkError::Overlap { first, first_name: name(first), second, second_name: name(second) });
        }
        network.centreline = network.straight_through();
        Ok(network)
    }
}

fn same_name(pieces: &[Piece]) -> Result<(), NetworkError> {
    let mut seen = std::collections::BTreeMap::new();
    for (second, piece) in pieces.iter().enumerate() {
        if let Some(first) = seen.insert(piece.name.as_str(), second) {
            return Err(NetworkError::SameName { name: piece.name.clone(), first, second });
        }
    }
    Ok(())
}

struct Assembly<'p> {
    pieces: &'p [Piece],
    joins: &'p [Join],
}

impl Assembly<'_> {
    fn port(&self, (piece, name): PortRef) -> Result<Port, NetworkError> {
        let pieces = self.pieces.len();
        let at = self.pieces.get(piece).ok_or(NetworkError::UnknownPiece { piece, pieces })?;
        at.fitting.port(name).ok_or_else(|| NetworkError::UnknownPort {
            piece,
            name: at.name.clone(),
            shape: at.fitting.shape.name(),
            port: name,
            ports: at.fitting.ports().iter().map(|port| format!("`{}`", port.name)).collect::<Vec<_>>().join(", "),
        })
    }

    fn name(&self, (piece, port): PortRef) -> String {
        format!("{}.{port}", self.pieces[piece].name)
    }

    /// What each port of each piece leads to, in the order of the piece's ports.
    fn attached(&self, ends: &[(PortRef, End)]) -> Result<Vec<Vec<(PortName, Attached)>>, NetworkError> {
        let mut attached: Vec<Vec<(PortName, Option<Attached>)>> =
            self.pieces.iter().map(|piece| piece.fitting.ports().iter().map(|port| (port.name, None)).collect()).collect();
        let told = |what: &Attached| match what {
            Attached::Port(other) => format!("`{}`", self.name(*other)),
            Attached::End(End::Open) => "the open".to_owned(),
            Attached::End(End::Cap) => "a cap".to_owned(),
        };
        let mut attach = |at: PortRef, what: Attached, join: usize| {
            let ports = &mut attached[at.0];
            let Some((_, slot)) = ports.iter_mut().find(|(name, _)| *name == at.1) else { return Ok(()) };
            match slot.replace(what) {
                None => Ok(()),
                Some(first) => {
                    Err(NetworkError::JoinedTwice { port: self.name(at), first: told(&first), second: told(&what), join })
                }
            }
        };
        for (join, Join { a, b }) in self.joins.iter().enumerate() {
            let (port_a, port_b) = (self.port(*a)?, self.port(*b)?);
            let [a_m, b_m] = [port_a, port_b].map(|port| [port.width_m, port.height_m]);
            if (0..2).any(|i| (a_m[i] - b_m[i]).abs() > SAME_SIZE_M) {
                return Err(NetworkError::DifferentSizes { a: self.name(*a), a_m, b: self.name(*b), b_m, join });
            }
            attach(*a, Attached::Port(*b), join)?;
            attach(*b, Attached::Port(*a), join)?;
        }
        for (index, (at, end)) in ends.iter().enumerate() {
            self.port(*at)?;
            attach(*at, Attached::End(*end), self.joins.len() + index)?;
        }
        let or_capped = |what: Option<Attached>| what.unwrap_or(Attached::End(End::Cap));
        Ok(attached.into_iter().map(|ports| ports.into_iter().map(|(name, what)| (name, or_capped(what))).collect()).collect())
    }

    /// Whether each join is one over which pieces are placed: the first that connects its two pieces, in the order given. The others
    /// close cycles.
    fn places(&self) -> Vec<bool> {
        let mut parent: Vec<usize> = (0..self.pieces.len()).collect();
        let root = |parent: &mut Vec<usize>, mut piece: usize| {
            while parent[piece] != piece {
                parent[piece] = parent[parent[piece]];
                piece = parent[piece];
            }
            piece
        };
        let connects = self.joins.iter().map(|join| {
            let (a, b) = (root(&mut parent, join.a.0), root(&mut parent, join.b.0));
            parent[b] = a;
            a != b
        });
        connects.collect()
    }

    /// Where each piece lies.
    fn placed(&self) -> Result<Vec<Transform>, NetworkError> {
        let mut ways: Vec<Vec<(PortName, PortRef)>> = vec![Vec::new(); self.pieces.len()];
        for (Join { a, b }, _) in self.joins.iter().zip(self.places()).filter(|(_, places)| *places) {
            ways[a.0].push((a.1, *b));
            ways[b.0].push((b.1, *a));
        }
        let mut placed: Vec<Option<Transform>> = vec![None; self.pieces.len()];
        placed[0] = Some(Transform::identity());
        let mut order = vec![0];
        let mut next = 0;
        while let Some(&piece) = order.get(next) {
            next += 1;
            let Some(world_from_piece) = placed[piece] else { continue };
            for &(name, (other, port)) in &ways[piece] {
                if placed[other].is_some() {
                    continue;
                }
                let port_from_other = self.port((other, port))?.entry_from_inward().inverse();
                let world_from_port = world_from_piece * self.port((piece, name))?.entry_from_port;
                // An `in` is its fitting's own frame: nothing to multiply, nothing to round.
                let at = if port == PortName::In { world_from_port } else { world_from_port * port_from_other };
                placed[other] = Some(at);
                order.push(other);
            }
        }
        let not_placed = |piece: usize| NetworkError::NotReachable {
            piece,
            name: self.pieces[piece].name.clone(),
            first: self.pieces[0].name.clone(),
        };
        let placed: Vec<Transform> =
            placed.into_iter().enumerate().map(|(piece, at)| at.ok_or_else(|| not_placed(piece))).collect::<Result<_, _>>()?;
        for (join, Join { a, b }) in self.joins.iter().enumerate() {
            let out_of_a = placed[a.0] * self.port(*a)?.entry_from_port;
            let into_b = placed[b.0] * self.port(*b)?.entry_from_inward();
            let off_m = (out_of_a.translation.vector - into_b.translation.vector).norm();
            let off_rad = out_of_a.rotation.angle_to(&into_b.rotation);
            if off_m > CLOSES_M || off_rad > CLOSES_RAD {
                let (a, b) = (self.name(*a), self.name(*b));
                return Err(NetworkError::Gap { a, b, off_mm: off_m * 1e3, off_deg: off_rad.to_degrees(), join });
            }
        }
        Ok(placed)
    }
}
