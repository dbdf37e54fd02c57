//! Which of many boxes meet a box: a search whose cost grows with the logarithm of their number.
//!
//! The tree halves the boxes in the order in which they are given. That is good where neighbours in the order are neighbours in
//! space, as the cells of a run are; in another order it is right but slower. Answers do not depend on the tree's shape.

use nalgebra::Point3;

/// An axis-aligned box; its faces belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest coordinates.
    pub low: Point3<f64>,
    /// Highest coordinates.
    pub high: Point3<f64>,
}

impl Bounds {
    /// What no box meets.
    const NONE: Self = Self {
        low: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The smallest box around these points. All of space if one is not finite, so that no search passes over it.
    pub fn around<'p>(points: impl IntoIterator<Item = &'p Point3<f64>>) -> Self {
        points.into_iter().fold(Self::NONE, |bounds, point| {
            let finite = point.coords.iter().all(|c| c.is_finite());
            bounds.with(&if finite {
                Self { low: *point, high: *point }
            } else {
                Self { low: Self::NONE.high, high: Self::NONE.low }
            })
        })
    }

    /// The smallest box around both.
    fn with(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Whether they have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }
}

/// Boxes in a fixed order.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxTree {
    /// A full binary tree: node 1 is the root, node i has the children 2 i and 2 i + 1, and the second half are the boxes.
    nodes: Vec<Bounds>,
}

impl BoxTree {
    /// A tree of these boxes.
    pub fn new(boxes: &[Bounds]) -> Self {
        let leaves = boxes.len().next_power_of_two();
        let mut nodes = vec![Bounds::NONE; 2 * leaves];
        nodes[leaves..leaves + boxes.len()].copy_from_slice(boxes);
        for node in (1..leaves).rev() {
            nodes[node] = nodes[2 * node].with(&nodes[2 * node + 1]);
        }
        Self { nodes }
    }

    /// The first box, from number `from` on, that meets `bounds` and that `accept` takes; `accept` is asked in ascending order.
    pub fn first(&self, from: usize, bounds: &Bounds, mut accept: impl FnMut(usize) -> bool) -> Option<usize> {
        let leaves = self.nodes.len() / 2;
        // Subtrees still to be searched, the next one last: (node, number of its first box, how many boxes it has).
        let mut left = vec![(1, 0, leaves)];
        while let Some((node, first, count)) = left.pop() {
            if first + count <= from || !self.nodes[node].meets(bounds) {
                continue;
            }
            if count > 1 {
                let half = count / 2;
                left.extend([(2 * node + 1, first + half, half), (2 * node, first, half)]);
            } else if accept(first) {
                return Some(first);
            }
        }
        None
    }
}
