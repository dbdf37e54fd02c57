//! Rays of the last pieces of the way, kept to hold plans against.

use std::collections::VecDeque;

use super::matching::Sight;
use super::strip::{DuctPlace, Ray, RayEnd};

/// Rays are kept of a frame after this much way, in metres, or turning, in radians.
const EVERY_M: f64 = 0.04;
const EVERY_RAD: f64 = 0.06;
/// Frames of which they are kept.
const FRAMES: usize = 30;
/// Of a frame's rays every so many-th is kept.
const STRIDE: usize = 2;
/// So many rays are held against a plan.
const MOST: usize = 480;
/// From this before where a fitting may begin rays say something of it, in metres.
const BEFORE_M: f64 = 0.3;

/// Rays.
#[derive(Clone, Debug)]
pub(super) struct Sightings {
    frames: VecDeque<(DuctPlace, Vec<Sight>)>,
    spare: Vec<Vec<Sight>>,
    /// Those that are held against plans.
    chosen: Vec<Sight>,
}

impl Sightings {
    pub(super) fn new() -> Self {
        Self {
            frames: VecDeque::with_capacity(FRAMES),
            spare: (0..FRAMES).map(|_| Vec::with_capacity(256)).collect(),
            chosen: Vec::with_capacity(MOST),
        }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.spare.extend(self.frames.drain(..).map(|(_, sights)| sights));
    }

    /// Keeps a frame's rays, if the robot has gone on since the last ones.
    pub(super) fn take(&mut self, place: &DuctPlace, rays: impl Iterator<Item = Ray>) {
        let has_moved = self.frames.back().is_none_or(|(before, _)| {
            (place.along_m - before.along_m).abs() >= EVERY_M || (place.heading_rad - before.heading_rad).abs() >= EVERY_RAD
        });
        if !has_moved {
            return;
        }
        let mut kept =
            if self.frames.len() == FRAMES { self.frames.pop_front().map(|(_, sights)| sights) } else { self.spare.pop() }
                .unwrap_or_default();
        kept.clear();
        let sights = rays.step_by(STRIDE).filter(|ray| ray.end != RayEnd::NoFloor).filter_map(|Ray { from, to, end }| {
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let range_m = (dx * dx + dy * dy).sqrt();
            (range_m > 1e-6).then(|| Sight { from, way: [dx / range_m, dy / range_m], range_m, hit: end == RayEnd::Surface })
        });
        kept.extend(sights);
        self.frames.push_back((*place, kept));
    }

    /// Those that say something of a fitting that begins at about `from_m` and reaches so far behind that and aside of the duct's middle.
    /// What they meet farther on is another fitting's: they are cut short there.
    pub(super) fn about(&mut self, from_m: f64, [behind_m, aside_m]: [f64; 2]) -> &[Sight] {
        let (least_m, most_m) = (from_m - BEFORE_M, from_m + behind_m);
        let end = |sight: &Sight| [0, 1].map(|axis| sight.from[axis] + sight.way[axis] * sight.range_m);
        let tells = |sight: &&Sight| end(sight)[0] > least_m;
        let count = self.frames.iter().flat_map(|(_, sights)| sights).filter(tells).count();
        let stride = count.div_ceil(MOST).max(1);
        self.chosen.clear();
        let chosen = self.frames.iter().flat_map(|(_, sights)| sights).filter(tells).step_by(stride).map(|sight| {
            let to = end(sight);
            let mut share: f64 = 1.0;
            if to[0] > most_m {
                share = share.min((most_m - sight.from[0]) / (to[0] - sight.from[0]));
            }
            if to[1].abs() > aside_m {
                share = share.min((aside_m.copysign(to[1]) - sight.from[1]) / (to[1] - sight.from[1]));
            }
            if share < 1.0 { Sight { range_m: share.max(0.0) * sight.range_m, hit: false, ..*sight } } else { *sight }
        });
        self.chosen.extend(chosen);
        &self.chosen
    }
}
