//! What lies ahead in the duct: read off the ranges of many frames, as the robot goes along.
//!
//! In data-flow order:
//!
//! - `strip`: rays counted in bins along the way: walls closed or open, the inside free or not;
//! - `change`: side walls that leave their lines without ending;
//! - `features`: openings in the walls, and what stands across: where a fitting may begin;
//! - `sightings`: rays of the last piece of the way;
//! - `model`: families of fittings with their dimensions, each drawn as a `plan`;
//! - `matching`: which of them explains the rays best;
//! - [`outlook`]: which fitting that is, and how sure;
//! - `thing`: what stands in the duct and may be passed;
//! - `outer`: what a bend turns along;
//! - `flanks`: the side walls up to where they end.

mod change;
mod features;
mod flanks;
mod matching;
mod model;
mod outer;
pub mod outlook;
mod plan;
mod sightings;
mod strip;
mod thing;

pub use change::WallChange;
use features::Features;
pub use flanks::Stretch;
use matching::{Match, Matcher};
use model::Model;
pub use outer::{Outer, OuterArc, OuterWall};
pub use outlook::{Fitting, Outlook, Side};
use sightings::Sightings;
pub use strip::DuctPlace;
use strip::{Ray, RayEnd, Strip};
pub use thing::Thing;

use crate::perception::side_walls::SideWalls;
use crate::perception::{RangePoint, Upon};

/// A fitting reaches so many widths of the duct before it behind where it begins and aside of the duct's middle, at most, as far as it is
/// looked at; a bend that the robot is in, so many of its radii.
const REACH_WIDTHS: [f64; 2] = [2.4, 2.0];
const ARC_REACH_RADII: f64 = 1.8;
/// Share of a fitting's dimensions that are taken over from the last time.
const BLEND: f64 = 0.6;
/// Ghosts are told from walls up to this share of half the width off the middle.
const GHOST_SHARE: f64 = 0.5;
/// Plans are held against the rays with every so many-th frame.
const EVERY: u64 = 6;
/// Fewest rays that tell fittings apart.
const FEWEST_SIGHTS: usize = 60;
/// A fitting begins where something is seen to, no farther than this behind the first such place, in widths.
const PLACES_WIDTHS: f64 = 1.2;
/// The duct begins at zero, as well as the robot knows: metres.
const MOUTH_M: f64 = 0.05;
/// Most such places.
const MOST_PLACES: usize = 8;
/// Ranges beyond this are not trusted, in metres: a pixel's error is a decimetre there.
const FARTHEST_M: f64 = 2.3;

/// The side walls of the duct in which the robot is about at `place`, where they are straight, as one frame's ranges show them.
pub fn side_walls(ranges: &[RangePoint], place: &DuctPlace, stretch: &Stretch) -> Option<SideWalls> {
    let points =
        ranges.iter().filter(|range| range.upon == Upon::Upright).map(|range| [range.point_in_base.x, range.point_in_base.y]);
    flanks::find(points, place, stretch)
}

/// The duct ahead, as it is known by now.
#[derive(Clone, Debug)]
pub struct Ahead {
    strip: Strip,
    sightings: Sightings,
    matcher: Matcher,
    /// What explained the rays best when they were last held against plans.
    matched: Option<Match>,
    watch: outlook::Watch,
    /// Frames looked at.
    frames: u64,
    /// Room to work in.
    run: Vec<(i64, f64)>,
    places_m: Vec<f64>,
    outlook: Outlook,
    /// Where the camera is in the base frame, in metres.
    camera_m: [f64; 2],
}

impl Ahead {
    /// Nothing seen yet, by a camera at this place of the base frame.
    pub fn new(camera_m: [f64; 2]) -> Self {
        Self {
            strip: Strip::default(),
            sightings: Sightings::new(),
            matcher: Matcher::new(),
            matched: None,
            watch: outlook::Watch::default(),
            frames: 0,
            run: Vec::with_capacity(256),
            places_m: Vec::with_capacity(MOST_PLACES),
            outlook: Outlook::default(),
            camera_m,
        }
    }

    /// Forgets all: the robot is in another duct.
    pub fn enter(&mut self) {
        self.strip.clear();
        self.sightings.clear();
        self.matcher.clear();
        self.matched = None;
        self.watch = outlook::Watch::default();
        self.outlook = Outlook::default();
    }

    /// Forgets what rays found, but not what that was taken for.
    pub fn forget_rays(&mut self) {
        self.strip.clear();
        self.sightings.clear();
    }

    /// The fitting that was ahead is behind the robot; what is beyond it was seen already.
    pub fn passed(&mut self) {
        self.matched = None;
        self.watch = outlook::Watch::default();
        self.outlook = Outlook::default();
    }

    /// Takes in the ranges of a frame that was exposed at `place`.
    pub fn look(&mut self, place: &DuctPlace, ranges: &[RangePoint]) -> &Outlook {
        self.strip.follow(place.along_m);
        let rays = || ranges.iter().map(|range| ray(range, place, self.camera_m));
        // What seems to stand where the duct was seen to be free is a ghost: the other laser's light, taken for this one's.
        let is_ghost = |ray: &Ray| {
            ray.end == RayEnd::Surface && ray.to[1].abs() < GHOST_SHARE * place.width_m / 2.0 && self.strip.is_free(ray.to[0])
        };
        let half_m = place.width_m / 2.0;
        self.sightings.take(place, rays().filter(|ray| !is_ghost(ray)).filter_map(|ray| ray.past_the_mouth(half_m)));
        self.strip.take(place, rays());
        let features = self.strip.features(place.along_m, place.width_m / 2.0, &mut self.run);
        if self.frames.is_multiple_of(EVERY) {
            self.find(&features, place);
        }
        self.frames += 1;
        self.outlook = self.watch.look(&features, self.matched.as_ref(), place);
        &self.outlook
    }

    /// Holds plans against the rays.
    fn find(&mut self, features: &Features, place: &DuctPlace) {
        let is_near = |model: &Model| model.ends_m() > place.along_m;
        let near = self.matched.map(|found| found.model).filter(is_near).map(|model| model.begins_m());
        let across = features.across_m.into_iter().flat_map(|at_m| [at_m, at_m - place.width_m]);
        self.places_m.clear();
        // What begins before the duct does is what the robot came out of.
        let is_in_duct = |at_m: &f64| *at_m > -MOUTH_M;
        self.places_m.extend(features.events_m().chain(across).chain(near).filter(is_in_duct).take(MOST_PLACES));
        let first_m = self.places_m.iter().copied().fold(f64::INFINITY, f64::min);
        self.places_m.retain(|at_m| *at_m <= first_m + PLACES_WIDTHS * place.width_m);
        let sights = self.sightings.about(first_m, REACH_WIDTHS.map(|widths| widths * place.width_m));
        let before = self.matched.take();
        if sights.len() >= FEWEST_SIGHTS {
            let found = self.matcher.find(sights, place.width_m, &self.places_m, self.outlook.fitting);
            // Steadier than any one of them.
            self.matched =
                found.map(|found| Match { model: found.model.blended(before.map(|before| before.model), BLEND), ..found });
        }
    }

    /// What it is taken for.
    pub fn outlook(&self) -> &Outlook {
        &self.outlook
    }

    /// What the way to this side turns along, if there is one; `width_m` is that of the duct that the robot is in.
    pub fn outer(&self, side: Side, width_m: f64) -> Option<Outer> {
        self.watch.model()?.outer(side, width_m)
    }

    /// An arc, and above all how far it goes round, as it is seen from within a duct of this width; `None` between looks.
    pub fn arc(&mut self, arc: &OuterArc, width_m: f64) -> Option<OuterArc> {
        if !self.frames.is_multiple_of(EVERY) {
            return None;
        }
        let side = if arc.turn_rad > 0.0 { Side::Left } else { Side::Right };
        let model = Model::arc(side, arc.start_m, arc.turn_rad.abs(), arc.radius_m - width_m);
        let sights = self.sightings.about(arc.start_m, [ARC_REACH_RADII * arc.radius_m; 2]);
        if sights.len() < FEWEST_SIGHTS {
            return None;
        }
        match self.matcher.arc(&model, sights, width_m).outer(side, width_m) {
            Some(Outer::Arc(arc)) => Some(arc),
            _ => None,
        }
    }

    /// How the left and the right wall move where the duct goes on without a bend.
    pub fn changes(&self, width_m: f64) -> [Option<WallChange>; 2] {
        self.watch.model().map_or([None; 2], |model| model.changes(width_m))
    }
}

/// A range as a ray in the duct, from a camera at a place of the base frame.
fn ray(range: &RangePoint, place: &DuctPlace, camera_m: [f64; 2]) -> Ray {
    let from = place.duct_from_base(camera_m[0], camera_m[1]);
    let to = place.duct_from_base(range.point_in_base.x, range.point_in_base.y);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let range_m = (dx * dx + dy * dy).sqrt();
    match range.upon {
        Upon::Nothing => Ray { from, to, end: RayEnd::NoFloor },
        Upon::Air => Ray { from, to, end: RayEnd::Beyond },
        _ if range_m > FARTHEST_M => {
            let share = FARTHEST_M / range_m;
            Ray { from, to: [from[0] + share * dx, from[1] + share * dy], end: RayEnd::Beyond }
        }
        Upon::Floor | Upon::Below => Ray { from, to, end: RayEnd::Floor },
        Upon::Upright => Ray { from, to, end: RayEnd::Surface },
    }
}
