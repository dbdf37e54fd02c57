//! What lies ahead along the path, as eyes that follow it could name it: where each thing begins and what it measures.
//!
//! The path is cut into legs where it turns back. What lies beyond a leg's end (the wall of a dead end that the robot turns round
//! before, the junction at which its route stops) is looked for along the network, from port to port.

use std::f64::consts::PI;
use std::ops::Range;

use ductloop_duct::Transform;
use ductloop_duct::centreline::{Centreline, Segment};
use ductloop_duct::fitting::Shape;
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::network::{Attached, End, Network, PortRef};
use ductloop_nav::ahead::Fitting;
use ductloop_sim::truth::Truth;
use nalgebra::{Point3, Vector3};

use super::entrance::{Entrance, entrance};
use super::obstacles::{half_width_and_height_m, on_segment};
use super::reach::reach_m;
use crate::scenario::Scenario;

/// A port is where the path is if it is so near, in metres: rounding.
const SAME_PLACE_M: f64 = 1e-4;
/// Who faces more than this off the path does not look along it: it is turning round.
const FACING_RAD: f64 = PI / 12.0;

/// Something ahead.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// What it is to one who comes along this path.
    pub fitting: Fitting,
    /// What it is called: the fitting's name, or the object's.
    pub name: String,
    /// Where it begins, in metres along the path: the port by which it is entered, the wall of a dead end, the edge of a drop. Beyond the
    /// end of a leg it goes on counting.
    pub at_m: f64,
    /// Where the path is out of it again; infinite where it does not go through it.
    pub to_m: f64,
    /// Width of the duct before it, in metres.
    pub width_m: f64,
    /// Of a transition: width of the duct behind it, in metres.
    pub width_after_m: Option<f64>,
    /// Of an elbow that is an arc: radius of its middle, in metres.
    pub radius_m: Option<f64>,
    /// Distance of the base from which on it can be seen, in metres.
    pub reach_m: f64,
}

/// What is truly ahead of a base on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueAhead {
    /// The next thing: its number on the way, from 0.
    pub thing: usize,
    /// What it is; nothing but a straight duct where there is no next thing.
    pub fitting: Fitting,
    /// How far its beginning is ahead of the base, in metres along the path; infinite where there is none.
    pub distance_m: f64,
    /// Whether it is near enough to be seen.
    pub is_in_reach: bool,
    /// Whether the robot is still in the thing before it with its base, or in this one with its nose.
    pub is_inside: bool,
}

/// A stretch of the path along which it does not turn back.
#[derive(Clone, Debug, PartialEq)]
struct Leg {
    segments: Range<usize>,
    things: Range<usize>,
}

/// What lies along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Which fitting each segment of the path is in: a base elsewhere is off the path.
    fittings: Vec<usize>,
    legs: Vec<Leg>,
    things: Vec<Thing>,
    /// How far the robot's nose is ahead of its base, in metres.
    nose_m: f64,
}

/// The path's way through a fitting.
struct Pass {
    fitting: usize,
    segments: Range<usize>,
}

impl Way {
    /// Along the path of a network, as a scenario's robot sees it.
    pub fn new(scenario: &Scenario, network: &Network) -> Self {
        let segments = &network.centreline.segments;
        let turns: Vec<usize> = (1..segments.len()).filter(|at| segments[*at].turns_back).collect();
        let starts = std::iter::once(0).chain(turns.iter().copied());
        let ends = turns.iter().copied().chain([segments.len()]);
        let (mut legs, mut things) = (Vec::new(), Vec::new());
        let survey = Surveyor { scenario, network };
        for (start, end) in starts.zip(ends).filter(|(start, end)| start < end) {
            let first = things.len();
            things.extend(survey.along(start..end));
            legs.push(Leg { segments: start..end, things: first..things.len() });
        }
        let fittings = segments.iter().map(|segment| segment.fitting).collect();
        Self { fittings, legs, things, nose_m: scenario.robot.nose_m }
    }

    /// All of it, in the order of the path.
    pub fn things(&self) -> &[Thing] {
        &self.things
    }

    /// What is ahead of a robot; `None` where it is off the path, or does not face along it. Costs the logarithm of what there is.
    pub fn ahead(&self, truth: &Truth) -> Option<TrueAhead> {
        if self.fittings.get(truth.segment) != Some(&truth.fitting) || truth.heading_rad.abs() > FACING_RAD {
            return None;
        }
        let leg = &self.legs[self.legs.partition_point(|leg| leg.segments.end <= truth.segment)];
        let things = &self.things[leg.things.clone()];
        let next = things.partition_point(|thing| thing.at_m <= truth.distance_m);
        let was_entered = next > 0 && truth.distance_m < things[next - 1].to_m;
        let thing = leg.things.start + next;
        Some(match things.get(next) {
            Some(Thing { fitting, at_m, reach_m, .. }) => {
                let distance_m = at_m - truth.distance_m;
                let is_inside = was_entered || distance_m <= self.nose_m;
                TrueAhead { thing, fitting: *fitting, distance_m, is_in_reach: distance_m <= *reach_m, is_inside }
            }
            None => {
                // A number that no thing has.
                let (thing, fitting) = (usize::MAX, Fitting::Straight);
                TrueAhead { thing, fitting, distance_m: f64::INFINITY, is_in_reach: false, is_inside: was_entered }
            }
        })
    }
}

/// Looks for things along the path.
struct Surveyor<'s> {
    scenario: &'s Scenario,
    network: &'s Network,
}

impl Surveyor<'_> {
    /// All things of a leg, in its order, and what ends it.
    fn along(&self, leg: Range<usize>) -> Vec<Thing> {
        let segments = &self.network.centreline.segments;
        let mut things: Vec<Thing> = Vec::new();
        let passes = self.passes(leg.clone());
        for pass in &passes {
            let first = &segments[pass.segments.start];
            let Some(entry) = self.port_at(pass.fitting, &first.world_from_start) else { continue };
            if let Some(Entrance::Thing(fitting, behind_m)) = entrance(self.network, (pass.fitting, entry)) {
                let last = &segments[pass.segments.end - 1];
                let (at_m, to_m) = (first.start_m + behind_m, last.start_m + last.length_m);
                things.extend(self.thing((pass.fitting, entry), fitting, at_m, to_m));
            }
        }
        things.extend(passes.last().and_then(|pass| self.end(pass)));
        things.extend(self.objects(leg));
        things.sort_by(|a, b| a.at_m.total_cmp(&b.at_m));
        things
    }

    fn passes(&self, leg: Range<usize>) -> Vec<Pass> {
        let segments = &self.network.centreline.segments;
        let mut passes: Vec<Pass> = Vec::new();
        for at in leg {
            let fitting = segments[at].fitting;
            match passes.last_mut().filter(|pass| pass.fitting == fitting) {
                Some(pass) => pass.segments.end = at + 1,
                None => passes.push(Pass { fitting, segments: at..at + 1 }),
            }
        }
        passes
    }

    /// The port of a fitting at which the path is.
    fn port_at(&self, fitting: usize, world_from_here: &Transform) -> Option<PortName> {
        let off_m = |name: PortName| {
            let port = self.network.world_from_port((fitting, name))?;
            Some((port.translation.vector - world_from_here.translation.vector).norm())
        };
        PortName::ALL.into_iter().find(|name| off_m(*name).is_some_and(|off_m| off_m < SAME_PLACE_M))
    }

    fn thing(&self, (piece, entry): PortRef, fitting: Fitting, at_m: f64, to_m: f64) -> Option<Thing> {
        let own = &self.network.fittings[piece];
        let port = own.port(entry)?;
        let other = own.ports().into_iter().find(|port| port.name != entry);
        Some(Thing {
            fitting,
            name: self.network.names[piece].clone(),
            at_m,
            to_m,
            width_m: port.width_m,
            width_after_m: other.filter(|_| fitting == Fitting::Transition).map(|port| port.width_m),
            radius_m: match own.shape {
                Shape::RadiusElbow { .. } => Some(1.0 / own.curvature_1_m().abs()),
                _ => None,
            },
            reach_m: reach_m(&self.scenario.rig, port.height_m),
        })
    }

    /// What lies beyond the end of a leg.
    fn end(&self, last: &Pass) -> Option<Thing> {
        let (network, piece) = (self.network, last.fitting);
        let segment = network.centreline.segments.get(last.segments.end - 1)?;
        let here = segment.pose_at(segment.length_m);
        let end_m = segment.start_m + segment.length_m;
        let exit = match self.port_at(piece, &here) {
            Some(exit) => exit,
            None => self.port_ahead(piece, &here)?,
        };
        let mut at_m = end_m + self.left_m((piece, exit), &here.translation.vector.into());
        let mut exit = (piece, exit);
        // A ring of straight ducts has no end.
        for _ in 0..=network.fittings.len() {
            let next = match network.attached(exit)? {
                Attached::Port(next) => next,
                Attached::End(End::Open) => return None,
                Attached::End(End::Cap) => {
                    let thing = self.thing(exit, Fitting::DeadEnd, at_m, f64::INFINITY)?;
                    return Some(Thing { radius_m: None, name: format!("{}.{}", thing.name, exit.1), ..thing });
                }
            };
            match entrance(network, next)? {
                Entrance::Thing(fitting, behind_m) => return self.thing(next, fitting, at_m + behind_m, f64::INFINITY),
                Entrance::Plain(through) => {
                    at_m += passage(network, (next.0, next.1), through).length_m();
                    exit = (next.0, through);
                }
            }
        }
        None
    }

    /// The port that lies farthest ahead.
    fn port_ahead(&self, piece: usize, here: &Transform) -> Option<PortName> {
        let forward = here.rotation * Vector3::x();
        let ahead_m = |name: PortName| {
            let port = self.network.world_from_port((piece, name))?;
            Some((name, forward.dot(&(port.translation.vector - here.translation.vector))))
        };
        let ports = PortName::ALL.into_iter().filter_map(ahead_m);
        ports.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| name)
    }

    /// What is left of the way from a place in a fitting to this port of it, in metres.
    fn left_m(&self, (piece, exit): PortRef, here: &Point3<f64>) -> f64 {
        let Some(entry) = self.network.fittings[piece].ports().into_iter().find(|port| port.name != exit) else { return 0.0 };
        let path = passage(self.network, (piece, entry.name), exit);
        if path.segments.is_empty() { 0.0 } else { (path.length_m() - path.project(here, 0).distance_m).max(0.0) }
    }

    fn objects(&self, leg: Range<usize>) -> Vec<Thing> {
        let path = &self.network.centreline;
        let robot = half_width_and_height_m(&self.scenario.robot);
        let mut things = Vec::new();
        for (index, object) in self.scenario.duct.objects.iter().enumerate() {
            let corners = object.solid(path).corners;
            let name = if object.name.is_empty() { format!("object {index}") } else { object.name.clone() };
            things.extend(path.segments[leg.clone()].iter().filter_map(|segment| {
                let found = on_segment(segment, &corners, robot)?;
                Some(Thing {
                    fitting: found.fitting,
                    name: name.clone(),
                    at_m: found.at_m[0],
                    to_m: found.at_m[1],
                    width_m: segment.width_m,
                    width_after_m: None,
                    radius_m: None,
                    reach_m: reach_m(&self.scenario.rig, segment.height_m),
                })
            }));
        }
        things
    }
}

/// The path from one port of a fitting to another.
fn passage(network: &Network, (piece, from): PortRef, to: PortName) -> Centreline {
    let mut path = Centreline::default();
    for part in network.fittings[piece].passage(from, to).unwrap_or_default() {
        path.segments.push(Segment {
            world_from_start: network.world_from_fitting[piece] * part.entry_from_start,
            length_m: part.length_m,
            curvature_1_m: part.curvature_1_m,
            pitch_rad: part.pitch_rad,
            width_m: part.width_m[0],
            height_m: part.height_m[0],
            end_width_m: part.width_m[1],
            end_height_m: part.height_m[1],
            start_m: path.length_m(),
            fitting: piece,
            turns_back: false,
        });
    }
    path
}
