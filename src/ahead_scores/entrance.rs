//! What a fitting is to eyes that come to it by one of its ports: what it is called depends on where one comes from, and on which of its
//! ports are open.

use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{Blade, Shape};
use ductloop_duct::network::{Network, PortRef, Turn};
use ductloop_nav::ahead::{Fitting, Side};
use nalgebra::{Point3, Unit, Vector3};

/// Walls that move by less than this across are straight, in metres: a few beads.
const LEAST_CHANGE_M: f64 = 0.01;
/// A shut damper's curtain and a junction without exits are looked for up to here, in metres.
const WALL_WITHIN_M: f64 = 100.0;
/// A ray sets out so far inside the port, in metres.
const INSIDE_M: f64 = 1e-3;

/// What lies behind a port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Entrance {
    /// A duct that goes on as before, to this port.
    Plain(PortName),
    /// Something, so far behind the port, in metres.
    Thing(Fitting, f64),
}

/// What one sees who comes to a fitting by this port; `None` if there is no such port.
///
/// Junctions are known by the ways that they offer, capped ports being none: a wye's two branches are those of a bull-head tee, a tee
/// whose branch is capped is a straight duct. Slopes, grilles, open dampers and changes of
/// height do not show in a plan. Vanes stand in the way, a shut damper's curtain closes it.
pub(super) fn entrance(network: &Network, at: PortRef) -> Option<Entrance> {
    let (piece, port) = at;
    let fitting = network.fittings.get(piece)?;
    let forwards = port == PortName::In;
    let beyond = || fitting.ports().iter().map(|port| port.name).find(|name| *name != port);
    let elbow = |turn: f64| if (turn > 0.0) == forwards { Fitting::Elbow(Side::Left) } else { Fitting::Elbow(Side::Right) };
    Some(match fitting.shape {
        Shape::Straight { .. } | Shape::Slope { .. } | Shape::Grille { .. } => Entrance::Plain(beyond()?),
        Shape::Damper { blade: Blade::Open, .. } => Entrance::Plain(beyond()?),
        Shape::Damper { blade: Blade::Shut, .. } => Entrance::Thing(Fitting::DeadEnd, wall_m(network, at)?),
        Shape::RadiusElbow { angle_rad, .. } | Shape::MitredElbow { angle_rad } => Entrance::Thing(elbow(angle_rad), 0.0),
        Shape::VanedElbow { .. } => Entrance::Thing(Fitting::Obstacle, 0.0),
        Shape::Transition { to_width_m, .. } => match (fitting.width_m - to_width_m).abs() < LEAST_CHANGE_M {
            true => Entrance::Plain(beyond()?),
            false => Entrance::Thing(Fitting::Transition, 0.0),
        },
        // The same side from both ends: it is its own half turn.
        Shape::Offset { aside_m, .. } => match aside_m.abs() < LEAST_CHANGE_M {
            true => Entrance::Plain(beyond()?),
            false if aside_m > 0.0 => Entrance::Thing(Fitting::Offset(Side::Left), 0.0),
            false => Entrance::Thing(Fitting::Offset(Side::Right), 0.0),
        },
        Shape::Drop { length_m, hole_length_m, .. } => Entrance::Thing(Fitting::Drop, (length_m - hole_length_m) / 2.0),
        Shape::Tee { .. } | Shape::BullheadTee { .. } | Shape::SideBranch { .. } | Shape::Wye { .. } | Shape::Cross { .. } => {
            junction(network, at)?
        }
    })
}

fn junction(network: &Network, at: PortRef) -> Option<Entrance> {
    let exits = network.exits(at);
    let offers = |turn: Turn| exits.iter().any(|(offered, _)| *offered == turn);
    let thing = match [Turn::Left, Turn::Straight, Turn::Right].map(offers) {
        [true, true, true] => Fitting::Cross,
        [true, false, true] => Fitting::BullheadTee,
        [true, true, false] => Fitting::Branch(Side::Left),
        [false, true, true] => Fitting::Branch(Side::Right),
        [true, false, false] => Fitting::Elbow(Side::Left),
        [false, false, true] => Fitting::Elbow(Side::Right),
        [false, true, false] => return exits.first().map(|(_, exit)| Entrance::Plain(*exit)),
        [false, false, false] => return Some(Entrance::Thing(Fitting::DeadEnd, wall_m(network, at)?)),
    };
    Some(Entrance::Thing(thing, 0.0))
}

/// How far behind a port a wall stands across, in metres, at half the port's height.
fn wall_m(network: &Network, (piece, name): PortRef) -> Option<f64> {
    let port = network.fittings[piece].port(name)?;
    let pose = network.world_from_fitting[piece] * port.entry_from_inward();
    let from = pose * Point3::new(INSIDE_M, 0.0, port.height_m / 2.0);
    let cell = network.cell_at(&from, network.cells_of(piece).next()?)?;
    let way = Unit::new_unchecked(pose.rotation * Vector3::x());
    Some(INSIDE_M + network.cast(cell, &from, &way, WALL_WITHIN_M)?.distance_m)
}
