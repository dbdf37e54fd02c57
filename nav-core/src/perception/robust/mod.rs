//! The robust pipeline: sub-pixel centres with a deviation each, walls with a covariance each, and from them the robot's place.
//!
//! In data-flow order, a file each:
//!
//! 1. `view`: the frame in scan coordinates, x along the stripes and y across them;
//! 2. `detect`: ridges of the width that a stripe must have, in every fourth column;
//! 3. `chain`: ridges linked to chains, and these cut to straight segments;
//! 4. `proposal`: which segments are which laser's stripes on which wall: walls that two stripes propose alike;
//! 5. `measure`: each stripe of each wall followed column by column; `centre` fits a column, `overexposed` takes the
//!    middle between the flanks where too much is full;
//! 6. `plane_fit`: all centres of a wall to its plane, with covariance;
//! 7. `duct_pose`: planes to lateral and heading error, width and height, each with its standard deviation.
//!
//! Beside them, `ranges` says for every block of columns where each laser's light falls, whatever it falls on: what is ahead where it is no
//! wall of a straight duct.
//!
//! `stripe` predicts where a laser's stripe on a plane is in the image, and how thick.
//!
//! What it does not do: it reads each frame for itself, without the one before; it takes walls for planes, upright or level.

mod centre;
mod chain;
mod detect;
mod duct_pose;
mod measure;
mod overexposed;
mod plane_fit;
mod proposal;
mod ranges;
mod stripe;
#[cfg(test)]
mod test_rig;
mod view;

use nalgebra::Vector3;

use super::scan::Across;
use super::wall_plane::WallPlane;
use super::{Measurement, Perception, RangePoint, SeenPlane, Stages, StripeCentre, StripeLine, Wall};
use crate::messages::Frame;
use crate::rig::{MountAngles, Rig};
use centre::Noise;
use chain::{Chains, Segment};
use detect::{Detector, Ridge};
use measure::{Neighbour, Point, Search};
use plane_fit::{Plane, Priors};
use proposal::{Limits, MOST_LASERS, Proposal, Proposer, Upright};
use ranges::Ranger;
use stripe::Projector;
use view::{BLOCK, View};

/// Parameters of the pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustParams {
    /// Least height of a stripe above what is beside it, in DN of 8 bits.
    pub contrast_dn: f64,
    /// The camera's point spread (standard deviation), in pixels.
    pub psf_sigma_px: f64,
    /// Full well, in electrons: with the black level it says how many electrons a grey value is, for the shot noise.
    pub full_well_e: f64,
    /// Standard deviation of read-out, in electrons.
    pub read_noise_e: f64,
    /// Grey value of black, in DN of 8 bits.
    pub black_dn: f64,
    /// Light at the ends of a laser's fan as a share of that in its middle, between which it falls as the square of the angle's
    /// exponential (a Powell lens).
    pub fan_edge: f64,
    /// Contrast of the lasers' speckle in a pixel.
    pub speckle_contrast: f64,
    /// Least and greatest depth at which stripes are sought, in metres.
    pub range_m: [f64; 2],
    /// Largest heading relative to a wall, in radians.
    pub max_heading_rad: f64,
    /// Standard deviation of a wall's lean against the robot's own upright, in radians.
    pub lean_rad: f64,
    /// Standard deviation of the error that all centres of a stripe have in common, in pixels ...
    pub offset_px: f64,
    /// ... and, added to it, as a share of the stripe's thickness (standard deviation).
    pub offset_share: f64,
    /// Fewest centres of a wall.
    pub min_centres: usize,
    /// Width of the duct, in metres: used where only one wall is seen.
    pub duct_width_m: f64,
}

impl Default for RobustParams {
    fn default() -> Self {
        Self {
            contrast_dn: 1.0,
            psf_sigma_px: 0.6,
            full_well_e: 30_000.0,
            read_noise_e: 15.0,
            black_dn: 8.0,
            fan_edge: 0.8,
            speckle_contrast: 0.12,
            range_m: [0.08, 4.0],
            max_heading_rad: 35.0_f64.to_radians(),
            lean_rad: 0.2_f64.to_radians(),
            offset_px: 0.004,
            offset_share: 0.0008,
            min_centres: 24,
            duct_width_m: 0.5,
        }
    }
}

/// Variance of rounding to whole grey values (EMVA 1288).
const QUANTISATION_VARIANCE: f64 = 1.0 / 12.0;
/// Columns beyond the segments of a wall that its stripes are followed.
const BEYOND_COLUMNS: usize = 64;
/// No wall is nearer to the camera than this, in metres.
const NEAREST_WALL_M: f64 = 0.03;
/// The floor is below the camera by its height, up to tyres and dust: standard deviation, in metres.
const FLOOR_SIGMA_M: f64 = 0.002;
/// Fewest centres of a second stripe that bear a wall out.
const FEWEST_OF_A_STRIPE: usize = 12;
/// A plane's stripes disagree beyond this chi-square (of their common errors and the lean): then they are not one wall's.
const MOST_DISAGREEMENT: f64 = 25.0;

/// The pipeline with its buffers: after the first frames it allocates nothing.
#[derive(Clone, Debug)]
pub struct RobustPerception {
    params: RobustParams,
    rig: Rig,
    projector: Projector,
    detector: Detector,
    chains: Chains,
    proposer: Proposer,
    ridges: Vec<Ridge>,
    segments: Vec<Segment>,
    proposals: Vec<Proposal>,
    neighbours: Vec<Neighbour>,
    column: Vec<f64>,
    points: Vec<Point>,
    walls: Vec<(Wall, Plane)>,
    centres: Vec<StripeCentre>,
    lines: Vec<StripeLine>,
    planes: Vec<SeenPlane>,
    ranger: Ranger,
    ranges: Vec<RangePoint>,
}

impl RobustPerception {
    /// A pipeline for the nominal rig.
    pub fn new(rig: Rig, params: RobustParams) -> Self {
        let projector = Projector::new(&rig, params.psf_sigma_px, params.fan_edge);
        let columns = projector.size[0];
        let most_points = columns * MOST_LASERS;
        Self {
            detector: Detector::new(&projector, params.range_m, params.contrast_dn),
            chains: Chains::default(),
            proposer: Proposer::default(),
            ridges: Vec::new(),
            segments: Vec::with_capacity(chain::MOST_SEGMENTS),
            proposals: Vec::with_capacity(Wall::ALL.len() + 2),
            neighbours: Vec::with_capacity(chain::MOST_SEGMENTS + Wall::ALL.len() * MOST_LASERS),
            column: Vec::with_capacity(centre::LONGEST),
            points: Vec::with_capacity(most_points),
            walls: Vec::with_capacity(Wall::ALL.len()),
            centres: Vec::with_capacity(most_points * Wall::ALL.len()),
            lines: Vec::with_capacity(chain::MOST_SEGMENTS + Wall::ALL.len() * MOST_LASERS),
            planes: Vec::with_capacity(Wall::ALL.len()),
            ranger: Ranger::default(),
            ranges: Vec::with_capacity(most_points / BLOCK),
            projector,
            params,
            rig,
        }
    }

    fn propose(&mut self, upright: &Upright) {
        let limits =
            Limits { max_heading_rad: self.params.max_heading_rad, distance_m: [NEAREST_WALL_M, self.params.range_m[1]] };
        self.proposer.find(&self.segments, &self.projector, upright, &limits, &mut self.proposals);
        let of = |proposals: &[Proposal], wall: Wall| proposals.iter().find(|p| p.wall == wall).copied();
        for (wall, across) in [(Wall::Left, Wall::Right), (Wall::Right, Wall::Left)] {
            if of(&self.proposals, wall).is_none() {
                let taken = self.proposals.iter().fold(0, |bits, p| bits | p.segments);
                let parallel = of(&self.proposals, across).map(|p| p.m);
                let lone = self.proposer.lone(wall, taken, parallel.as_ref(), &self.segments, &self.projector, upright);
                self.proposals.extend(lone);
            }
        }
    }

    /// Measures the stripes of proposal `index` and fits its plane.
    fn wall(&mut self, index: usize, view: &View<'_>, noise: &Noise, upright: &Upright) -> Option<(Wall, Plane)> {
        let proposal = self.proposals[index];
        self.points.clear();
        let (mut from, mut to) = (usize::MAX, 0);
        for (i, segment) in self.segments.iter().enumerate() {
            if proposal.segments >> i & 1 == 1 {
                from = from.min(segment.ends[0][0] as usize);
                to = to.max(segment.ends[1][0] as usize + 1);
            }
        }
        let columns = [from.saturating_sub(BEYOND_COLUMNS), (to + BEYOND_COLUMNS).min(self.projector.size[0])];
        for laser in 0..self.projector.lasers.len().min(MOST_LASERS) {
            self.gather_neighbours(index, laser, columns);
            let search =
                Search { view, projector: &self.projector, m: &proposal.m, laser, columns, neighbours: &self.neighbours, noise };
            search.measure(&mut self.column, &mut self.points);
        }
        if self.points.len() < self.params.min_centres || !self.is_agreed(&proposal) {
            return None;
        }
        let RobustParams { lean_rad, offset_px, offset_share, .. } = self.params;
        let priors = Priors { lean_rad, floor_m: FLOOR_SIGMA_M, offset: [offset_px, offset_share] };
        let plane = plane_fit::fit(proposal.wall, &proposal.m, &self.points, &self.projector, upright, &priors)?;
        if plane.disagreement > MOST_DISAGREEMENT {
            return None;
        }
        self.show(proposal.wall, &plane);
        Some((proposal.wall, plane))
    }

    /// Whether the centres of two lasers bear an upright wall out, where it was believed on two.
    fn is_agreed(&self, proposal: &Proposal) -> bool {
        let level = matches!(proposal.wall, Wall::Floor | Wall::Ceiling);
        let lasers = 0..self.projector.lasers.len();
        let shown = lasers.filter(|laser| self.points.iter().filter(|point| point.laser == *laser).count() >= FEWEST_OF_A_STRIPE);
        level || proposal.lone || shown.count() >= 2
    }

    /// Where other stripes are than that of `laser` on the wall of proposal `index`.
    fn gather_neighbours(&mut self, index: usize, laser: usize, [from, to]: [usize; 2]) {
        let own = self.proposals[index];
        self.neighbours.clear();
        // The other stripes of this wall as predicted, a straight piece over these columns: near enough for telling what is near.
        let at = |beside: usize, x: usize| {
            let stripe = self.projector.stripe(beside, &own.m, x as f64, self.projector.size[1] as f64 / 2.0);
            stripe.map(|stripe| ([x as f64, stripe.y_px], stripe.sigma_px))
        };
        for beside in
            (0..self.projector.lasers.len().min(MOST_LASERS)).filter(|beside| *beside != laser && own.support[*beside] > 0)
        {
            if let (Some(first), Some(last)) = (at(beside, from), at(beside, to.saturating_sub(1))) {
                self.neighbours.push(Neighbour { ends: [first.0, last.0], sigma_px: first.1.max(last.1) });
            }
        }
        for (i, segment) in self.segments.iter().enumerate() {
            // Own segments that this laser's stripe goes through are no neighbours.
            let own_segment = own.segments >> i & 1 == 1;
            if !own_segment || !self.runs_through(segment, &own.m, laser) {
                self.neighbours.push(Neighbour::of(segment));
            }
        }
    }

    fn runs_through(&self, segment: &Segment, m: &Vector3<f64>, laser: usize) -> bool {
        segment
            .ends
            .iter()
            .all(|[x, y]| self.projector.stripe(laser, m, *x, *y).is_some_and(|s| (s.y_px - y).abs() < 1.5 + 0.5 * s.sigma_px))
    }

    /// Keeps what was made of a wall, to be looked at.
    fn show(&mut self, wall: Wall, plane: &Plane) {
        let across = self.projector.across;
        for laser in 0..self.projector.lasers.len() {
            let (mut count, mut squares) = (0usize, 0.0);
            let mut ends: Option<[[f64; 2]; 2]> = None;
            for point in self.points.iter().filter(|point| point.laser == laser) {
                let here = across.pixel(point.x_px, point.y_px);
                let by_y = (self.projector.lasers[laser].inverse_plane - plane.m).dot(&point.ray_by_y);
                let off = (point.inverse_depth - plane.m.dot(&point.ray)) / by_y;
                count += 1;
                squares += off * off;
                ends = Some([ends.map_or(here, |ends| ends[0]), here]);
                let [u_px, v_px] = here;
                self.centres.push(StripeCentre { u_px, v_px, sigma_px: point.sigma_px, assigned: Some((laser, wall)) });
            }
            if let Some(ends_px) = ends {
                let residual_px = (squares / count as f64).sqrt();
                self.lines.push(StripeLine { ends_px, assigned: Some((laser, wall)), points: count, residual_px });
            }
        }
        if let Some(seen) = WallPlane::from_inverse(&plane.m) {
            let points = plane.counts.iter().sum();
            self.planes.push(SeenPlane { wall, plane: seen, covariance: Some(plane.covariance), points });
        }
    }

    /// Segments that no wall was found for, or whose wall was not borne out, are shown too.
    fn show_rest(&mut self) {
        let found = |wall: Wall| self.walls.iter().any(|(found, _)| *found == wall);
        let taken = self.proposals.iter().filter(|p| found(p.wall)).fold(0u64, |bits, p| bits | p.segments);
        for (_, segment) in self.segments.iter().enumerate().filter(|(i, _)| taken >> i & 1 == 0) {
            self.lines.push(StripeLine {
                ends_px: segment.ends_px(self.projector.across),
                assigned: None,
                points: segment.blocks * BLOCK,
                residual_px: segment.residual_px,
            });
        }
    }

    fn noise(&self, view: &View<'_>) -> Noise {
        let RobustParams { full_well_e, read_noise_e, black_dn, speckle_contrast, .. } = self.params;
        let dn = 1.0 / view.dn8_per_dn;
        let gain = (255.0 - black_dn) / full_well_e * dn;
        Noise {
            floor: read_noise_e * read_noise_e * gain * gain + QUANTISATION_VARIANCE,
            gain,
            black: black_dn * dn,
            speckle: speckle_contrast * speckle_contrast,
        }
    }
}

impl Perception for RobustPerception {
    fn perceive(&mut self, frame: &Frame<'_>, mount: MountAngles) -> Measurement {
        self.centres.clear();
        self.lines.clear();
        self.planes.clear();
        self.walls.clear();
        self.ranges.clear();
        let camera = &self.rig.camera;
        if (frame.width_px, frame.height_px) != (camera.width_px, camera.height_px) {
            return Measurement::default();
        }
        let upright = Upright::new(self.rig.mount.base_from_camera(mount));
        let view = View::new(frame, self.projector.across);
        view.sum_blocks(self.detector.sums());
        self.detector.find(view.full_block(), &mut self.ridges);
        self.chains.find(&self.ridges, &self.projector, &mut self.segments);
        self.propose(&upright);
        let noise = self.noise(&view);
        for index in 0..self.proposals.len() {
            if let Some(wall) = self.wall(index, &view, &noise, &upright) {
                self.walls.push(wall);
            }
        }
        self.show_rest();
        // Slits that stand upright show a wall at one place along it, and no plan.
        if self.projector.across == Across::V {
            self.ranger.find(
                &self.ridges,
                self.chains.before(),
                &self.projector,
                &upright,
                self.params.range_m,
                &mut self.ranges,
            );
        }
        duct_pose::measure(&self.walls, &upright, self.params.duct_width_m)
    }

    fn stages(&self) -> Stages<'_> {
        Stages { centres: &self.centres, lines: &self.lines, planes: &self.planes, ranges: &self.ranges }
    }
}
