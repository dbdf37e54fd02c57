//! A strip between what hides it: where a shadow or a silhouette takes away the whole thickness of a stripe, the stripe is cut in two.
//!
//! What a body shades and what it hides of the same stripe often end at nearly the same place (the camera and the lasers are near each
//! other), and the light that two soft edges keep is not the product of what each keeps. Along a stripe there is one edge that counts,
//! the outermost. Only a hole with a corner within the stripe's thickness, or one that runs along it, stays a hole.

use std::ops::Range;

use nalgebra::Point3;

use crate::band::Middle;
use crate::beam::clip_top;
use crate::coverage::Edge;

/// Working memory, to be kept from one strip to the next.
#[derive(Debug, Default)]
pub(super) struct Gaps {
    /// Edges of the holes.
    pub(super) edges: Vec<Edge>,
    /// The holes: all that might hide a part of the strip, and after [`Gaps::divide`] those that have to stay holes.
    pub(super) holes: Vec<Range<usize>>,
    /// What is left of the strip.
    pub(super) parts: Vec<Part>,
    bars: Vec<Part>,
    inside: Vec<Point3<f64>>,
}

/// A part of a strip's middle, as shares of its length, with the lines at its ends, the part on their inner side; none where it goes on to
/// the end of the strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) shares: [f64; 2],
    pub(super) ends: [Option<Edge>; 2],
}

impl Gaps {
    pub(super) fn clear(&mut self) {
        self.edges.clear();
        self.holes.clear();
    }

    /// Divides a strip with this middle, whose lit piece within its thickness is `sliver`.
    pub(super) fn divide(&mut self, middle: &Middle, sliver: &[Point3<f64>], spare: &mut Vec<Point3<f64>>) {
        self.bars.clear();
        let Self { edges, holes, bars, inside, .. } = self;
        holes.retain(|hole| match bar(&edges[hole.clone()], middle, sliver, inside, spare) {
            Some(bar) => {
                bars.push(bar);
                false
            }
            None => true,
        });
        bars.sort_by(|a, b| a.shares[0].total_cmp(&b.shares[0]));
        self.parts.clear();
        let (mut from, mut end) = (0.0, None);
        for bar in &self.bars {
            if bar.shares[0] > from {
                self.parts.push(Part { shares: [from, bar.shares[0]], ends: [end, bar.ends[0].map(|edge| -edge)] });
            }
            if bar.shares[1] > from {
                (from, end) = (bar.shares[1], bar.ends[1].map(|edge| -edge));
            }
        }
        if from < 1.0 {
            self.parts.push(Part { shares: [from, 1.0], ends: [end, None] });
        }
    }
}

/// Where a hole takes away the whole thickness of a strip, with the hole's edges there; `None` if it does so nowhere, or not only so.
fn bar(
    hole: &[Edge],
    middle: &Middle,
    sliver: &[Point3<f64>],
    inside: &mut Vec<Point3<f64>>,
    spare: &mut Vec<Point3<f64>>,
) -> Option<Part> {
    /// As the sine of an angle: corners that touch the hole's other edges are within it.
    const ROUNDING: f64 = 1e-9;
    let mut part = Part { shares: [0.0, 1.0], ends: [None, None] };
    for edge in hole {
        let [from, to] = [middle.first, middle.last].map(|xy| edge.xy().dot(&xy) + edge.z);
        let crossing = from / (from - to);
        match (from > 0.0, to > 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (false, true) if crossing > part.shares[0] => (part.shares[0], part.ends[0]) = (crossing, Some(*edge)),
            (true, false) if crossing < part.shares[1] => (part.shares[1], part.ends[1]) = (crossing, Some(*edge)),
            _ => {}
        }
    }
    if part.shares[0] >= part.shares[1] {
        return None;
    }
    // Between these two edges nothing of the strip may be outside another.
    inside.clear();
    inside.extend_from_slice(sliver);
    for edge in part.ends.into_iter().flatten() {
        clip_top(inside, 0, spare, |p| -edge.dot(&p.coords));
    }
    let covers = |edge: &Edge| inside.iter().all(|p| edge.dot(&p.coords) >= -ROUNDING * p.coords.norm());
    hole.iter().all(covers).then_some(part)
}
