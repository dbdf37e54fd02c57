//! Where laser light falls directly on what the camera sees.

use nalgebra::{Point3, Vector3};

use super::region::{Region, ridge};
use super::slit::Slit;
use super::{Frame, FrameGeometry};
use crate::Transform;
use crate::band::Middle;
use crate::beam::{clip_top, plane_of_edge};
use crate::coverage::Edge;
use crate::light::CUT_SIGMAS;
use crate::strip::Strip;

impl FrameGeometry {
    /// Adds the parts of a lit piece of a sheet (`self.lit`) that the camera sees.
    pub(super) fn add_strips(&mut self, frame: &Frame, lit: usize) {
        let sheet = self.lit.list[lit].sheet;
        let mut next = self.by_sheet.partition_point(|(other, _)| *other < sheet);
        while let Some((_, region)) = self.by_sheet.get(next).filter(|(other, _)| *other == sheet) {
            let region = *region;
            self.add_strip(frame, lit, region);
            next += 1;
        }
    }

    fn add_strip(&mut self, frame: &Frame, lit: usize, region: usize) {
        let lit = &self.lit.list[lit];
        let slit = &self.slits[lit.by];
        let Region { plane, outline, surface, body, .. } = &self.regions[region];
        // The lit piece as far as the camera sees it.
        self.points.clear();
        self.points.extend_from_slice(self.lit.outline(lit));
        clip_to_sight(&mut self.points, &self.corners[outline.clone()], &mut self.spare);
        if self.points.len() < 3 {
            return;
        }
        let first_edge = self.edges.len();
        self.edges.extend(edges_near(&self.points, slit).map(|(line, _)| line));
        clip_to_slit(&mut self.points, slit, &mut self.spare);
        let (ridge, sweep) = frame.ridge_and_sweep(|now| ridge(&plane.transformed(now), &slit.plane));
        let strip = Strip {
            laser: lit.by,
            plane: *plane,
            ridge,
            sweep,
            source: slit.source,
            fan: slit.fan,
            line: slit.line,
            look: frame.scenery.looks[usize::from(surface.0)],
            mirror: None,
            edges: first_edge..self.edges.len(),
            window: 0..0,
            holes: 0..0,
            band: 0..0,
        };
        if self.points.len() < 3 {
            self.edges.truncate(first_edge);
            return;
        }
        let Some(middle) = Middle::new(&strip, &self.points, &slit.plane.normal) else { return };
        let gaps = &mut self.gaps;
        gaps.clear();
        if self.shadows_on {
            self.shadows.aim(frame, &strip.source, None, &self.points);
            for id in self.lit.bodies(lit, frame.scenery) {
                self.shadows.add(&frame.scenery.bodies[id], plane, &mut gaps.edges, &mut gaps.holes);
            }
        }
        // What stands between camera and sheet, its own body apart.
        self.shadows.aim(frame, &Vector3::zeros(), None, &self.points);
        for id in self.seen_bodies.iter().copied().filter(|id| Some(*id) != *body) {
            self.shadows.add(&frame.scenery.bodies[id], plane, &mut gaps.edges, &mut gaps.holes);
        }
        gaps.divide(&middle, &self.points, &mut self.spare);
        self.place_strips(&strip, &middle);
    }

    /// Adds a strip's parts between the gaps, those that are in the image.
    fn place_strips(&mut self, strip: &Strip, middle: &Middle) {
        let gaps = &self.gaps;
        let first_hole = self.holes.len();
        for hole in &gaps.holes {
            let first = self.edges.len();
            self.edges.extend_from_slice(&gaps.edges[hole.clone()]);
            self.holes.push(first..self.edges.len());
        }
        let holes = first_hole..self.holes.len();
        for part in &gaps.parts {
            let [from, to] = part.shares;
            let middle = Middle { first: middle.at(from), last: middle.at(to) };
            let first_point = self.band.len();
            if !middle.lay(strip, |_| CUT_SIGMAS, &self.projection, &self.blur, &mut self.band) {
                self.band.truncate(first_point);
                continue;
            }
            let mut edges = strip.edges.clone();
            if part.ends != [None, None] {
                let first = self.edges.len();
                self.edges.extend_from_within(edges);
                self.edges.extend(part.ends.into_iter().flatten());
                edges = first..self.edges.len();
            }
            self.strips.push(Strip { edges, holes: holes.clone(), band: first_point..self.band.len(), ..strip.clone() });
        }
    }
}

impl Frame<'_> {
    /// The ridge as it is with the camera in the middle of the exposure, and how it changes from its beginning to its end. `ridge` is given
    /// the transform from the camera's frame in the middle to that of the moment.
    pub(super) fn ridge_and_sweep(&self, ridge: impl Fn(&Transform) -> Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let sweep = match &self.ends_from_camera {
            Some([first, last]) => ridge(last) - ridge(first),
            None => Vector3::zeros(),
        };
        (ridge(&Transform::identity()), sweep)
    }
}

/// Keeps of a polygon what is seen from the origin through the outline `seen`.
pub(super) fn clip_to_sight(points: &mut Vec<Point3<f64>>, seen: &[Point3<f64>], spare: &mut Vec<Point3<f64>>) {
    let middle: Vector3<f64> = seen.iter().map(|p| p.coords).sum();
    for (i, a) in seen.iter().enumerate() {
        let Some(normal) = plane_of_edge(a, &seen[(i + 1) % seen.len()]) else { continue };
        let outward = if normal.dot(&middle) > 0.0 { -normal } else { normal };
        clip_top(points, 0, spare, |p| outward.dot(&p.coords));
    }
}

/// Keeps of a polygon what is in the slit's light.
pub(super) fn clip_to_slit(points: &mut Vec<Point3<f64>>, slit: &Slit, spare: &mut Vec<Point3<f64>>) {
    for side in 0..2 {
        clip_top(points, 0, spare, |p| slit.outside(p)[side]);
    }
}

/// The edges of a piece that come into the slit's light: each as a line in the image with the piece inside, and its two ends.
pub(super) fn edges_near<'a>(piece: &'a [Point3<f64>], slit: &'a Slit) -> impl Iterator<Item = (Edge, [Point3<f64>; 2])> + 'a {
    let middle: Vector3<f64> = piece.iter().map(|p| p.coords).sum();
    (0..piece.len()).filter_map(move |i| {
        let (a, b) = (piece[i], piece[(i + 1) % piece.len()]);
        let (off_a, off_b) = (slit.outside(&a), slit.outside(&b));
        // The part of the edge, as shares of its length, that is within both sides.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (a, b) in off_a.into_iter().zip(off_b) {
            let crossing = a / (a - b);
            match (a > 0.0, b > 0.0) {
                (true, true) => return None,
                (true, false) => from = from.max(crossing),
                (false, true) => to = to.min(crossing),
                (false, false) => {}
            }
        }
        let line = plane_of_edge(&a, &b)?;
        (from <= to).then(|| (if line.dot(&middle) > 0.0 { line } else { -line }, [a, b]))
    })
}
