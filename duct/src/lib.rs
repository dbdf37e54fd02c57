//! Geometry of rectangular air ducts, and nothing else: no physics, no light, no robot.
//!
//! A duct network is a set of **convex cells with planar faces** joined by **portals**. In the order in which one is made:
//!
//! - [`cell`]: the convex cell, its faces, portals and the solids that stand in it;
//! - [`fitting`]: straights, elbows, transitions, junctions and the rest, each as cells between ports and as the paths through it;
//! - [`network`]: fittings joined port to port; which cell holds a point, what a ray meets, where a route leads;
//! - [`bead`]: the low ridges inside the joints;
//! - `enclosure`: whether a solid stands wholly inside;
//! - [`centreline`]: the reference path: distance along it, lateral and heading error;
//! - [`box_tree`]: which boxes meet a box, for whatever would otherwise compare each cell with each.
//!
//! Frames and units: SI, radians, x forward, y left, z up. A fitting's own frame has its origin on the floor in the middle of
//! the port `in`, x pointing into the fitting. World is the frame of the first fitting's `in`.
#![forbid(unsafe_code)]

pub mod bead;
pub mod box_tree;
pub mod cell;
pub mod centreline;
mod enclosure;
pub mod fitting;
pub mod network;

/// Rigid transform; named `to_from` wherever it occurs.
pub type Transform = nalgebra::Isometry3<f64>;
