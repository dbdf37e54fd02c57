//! The paper's pipeline: its stages run in order.
//!
//! By default Hough *selects* pixels, each line is refitted to sub-pixel centres, and a wall's plane goes through all points of
//! its two stripes. [`LineFit::HoughPeak`] and [`PlaneFit::CrossProduct`] are the paper's own steps.

use nalgebra::{Matrix3, Vector3};

use super::assignment::{self, Proposal, WallLimits};
use super::bit_image::BitImage;
use super::duct_error;
use super::hough::{Hough, HoughGrid};
use super::line_fit::{self, Centre, FREE, ScanLine};
use super::morphology::{self, Element};
use super::scan::{Across, ScanImage};
use super::thinning::{self, ExpectedThickness, StripePoint, ThicknessLimits};
use super::threshold::{self, LocalThreshold};
use super::triangulation::{Triangulation, ray_from_pixel};
use super::wall_plane::{JointFit, Line3, WallPlane};
use super::{Measurement, Perception, SeenPlane, Stages, StripeCentre, StripeLine, Wall, WallMeasurement};
use crate::messages::Frame;
use crate::rig::{MountAngles, Rig, Transform};

/// What a line is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFit {
    /// Least squares over the sub-pixel centres of the points that Hough selected.
    LeastSquares,
    /// The Hough bin itself, as in the paper.
    HoughPeak,
}

/// What a plane is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneFit {
    /// All points of both stripes.
    Joint,
    /// The cross product of the two lines' directions, as in the paper (equation 18).
    CrossProduct,
}

/// Parameters of the pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperParams {
    /// How far above the background a stripe's pixel must stand, in DN of 8 bits.
    pub threshold_dn: f64,
    /// Depth of the nearest wall that stripes are sought on, in metres: they are thickest there, and the windows that a pixel's
    /// background is taken from must lie beyond that thickness.
    pub nearest_wall_m: f64,
    /// Pixels in each of these windows.
    pub background_window_px: usize,
    /// Sides of the opening's element, along and across the stripe, in pixels; odd.
    pub opening_px: [usize; 2],
    /// Sides of the closing's element.
    pub closing_px: [usize; 2],
    /// Thinnest and thickest run taken for a stripe, as shares of the expected thickness.
    pub thickness_ratio: [f64; 2],
    /// The camera's point spread, in pixels, for the expected thickness.
    pub psf_sigma_px: f64,
    /// Hough bin in r, in pixels.
    pub hough_r_px: f64,
    /// Hough bin in theta, in radians.
    pub hough_theta_rad: f64,
    /// Fewest points that make a line.
    pub min_points: usize,
    /// Distance within which a point belongs to a refitted line, in pixels.
    pub inlier_px: f64,
    /// What a line is made from.
    pub line_fit: LineFit,
    /// What a plane is made from.
    pub plane_fit: PlaneFit,
    /// Largest heading relative to a wall, in radians.
    pub max_heading_rad: f64,
    /// Width W_d of the duct, in metres: used where only one wall is seen.
    pub duct_width_m: f64,
}

impl Default for PaperParams {
    fn default() -> Self {
        Self {
            threshold_dn: 6.0,
            nearest_wall_m: 0.25,
            background_window_px: 6,
            opening_px: [3, 3],
            closing_px: [3, 3],
            thickness_ratio: [0.5, 2.0],
            psf_sigma_px: 0.6,
            hough_r_px: 1.0,
            hough_theta_rad: 1.0_f64.to_radians(),
            min_points: 30,
            inlier_px: 1.5,
            line_fit: LineFit::LeastSquares,
            plane_fit: PlaneFit::Joint,
            max_heading_rad: 35.0_f64.to_radians(),
            duct_width_m: 0.5,
        }
    }
}

/// Most lines sought in a frame: two lasers on four walls, floor and ceiling included, and a wall ahead.
const MAX_LINES: usize = 10;
/// A point's distance from a Hough line, in pixels, within which it is one of those that voted for it: half a bin of theta over
/// half an image is three pixels.
const HOUGH_INLIER_PX: f64 = 3.0;
/// No line is trusted beyond this, in pixels, however well its points lie.
const LEAST_RESIDUAL_PX: f64 = 0.05;
/// The scatter that is stated for a point on no line, in pixels: a binary run's.
const UNFITTED_SIGMA_PX: f64 = 0.5;
/// How often a line is refitted to the points near it.
const REFITS: usize = 2;

/// The pipeline with its buffers: after the first frame it allocates nothing.
#[derive(Clone, Debug)]
pub struct PaperPerception {
    rig: Rig,
    params: PaperParams,
    across: Across,
    limits: WallLimits,
    gap_px: usize,
    expected: ExpectedThickness,
    rays: Matrix3<f64>,
    triangulations: Vec<Triangulation>,
    hough: Hough,
    grey: ScanImage,
    sums: Vec<u32>,
    binary: BitImage,
    spare: BitImage,
    starts: Vec<u32>,
    points: Vec<StripePoint>,
    line_of: Vec<u8>,
    /// Room to work in: `line_of` without the points beside another line.
    crowded: Vec<u8>,
    lines: Vec<ScanLine>,
    proposals: Vec<Proposal>,
    seen: Vec<StripeLine>,
    centres: Vec<StripeCentre>,
    planes: Vec<SeenPlane>,
}

impl PaperPerception {
    /// A pipeline for the nominal rig.
    pub fn new(rig: Rig, params: PaperParams) -> Self {
        let across = Across::of(&rig);
        let camera = &rig.camera;
        let grid = HoughGrid { r_px: params.hough_r_px, theta_rad: params.hough_theta_rad, max_slope_rad: 60.0_f64.to_radians() };
        // Six standard deviations of a Gaussian, 2.5 times its width at half maximum, are half of it either side of the middle.
        let focal_px = camera.focal_px[0].max(camera.focal_px[1]);
        let thickest_px = focal_px * rig.line.at(params.nearest_wall_m) / params.nearest_wall_m;
        Self {
            across,
            gap_px: (1.25 * thickest_px).ceil() as usize,
            limits: WallLimits {
                max_heading_rad: params.max_heading_rad,
                distance_m: [0.03, 3.0],
                pair_heading_rad: 6.0_f64.to_radians(),
                pair_distance_ratio: 0.1,
            },
            expected: ExpectedThickness::new(&rig, across, params.psf_sigma_px),
            rays: ray_from_pixel(camera),
            triangulations: rig.lasers.iter().map(|laser| Triangulation::from_rig(camera, laser)).collect(),
            hough: Hough::new(grid, camera.width_px, camera.height_px),
            grey: ScanImage::default(),
            sums: Vec::new(),
            binary: BitImage::default(),
            spare: BitImage::default(),
            starts: Vec::new(),
            points: Vec::new(),
            line_of: Vec::new(),
            crowded: Vec::new(),
            lines: Vec::with_capacity(MAX_LINES),
            proposals: Vec::with_capacity(MAX_LINES * rig.lasers.len()),
            seen: Vec::with_capacity(MAX_LINES),
            centres: Vec::new(),
            planes: Vec::with_capacity(2),
            rig,
            params,
        }
    }

    /// The points of the last frame, in scan coordinates.
    pub fn points(&self) -> &[StripePoint] {
        &self.points
    }

    /// The binary image of the last frame, after morphology, in scan coordinates.
    pub fn binary(&self) -> &BitImage {
        &self.binary
    }

    fn find_points(&mut self, frame: &Frame<'_>) {
        let params = &self.params;
        self.grey.load(frame, self.across);
        let threshold_dn = params.threshold_dn * frame.dn_per_dn8();
        let local = LocalThreshold {
            above_background_dn: threshold_dn as u16,
            gap_px: self.gap_px,
            window_px: params.background_window_px,
        };
        threshold::binarise_local(&self.grey, &local, &mut self.sums, &mut self.binary);
        let element = |[along_px, across_px]: [usize; 2]| Element { along_px, across_px };
        morphology::open(&mut self.binary, element(params.opening_px), &mut self.spare);
        morphology::close(&mut self.binary, element(params.closing_px), &mut self.spare);
        let [min_ratio, max_ratio] = params.thickness_ratio;
        thinning::thin(
            &self.binary,
            &self.grey,
            threshold_dn,
            &self.expected,
            ThicknessLimits { min_ratio, max_ratio },
            &mut self.starts,
            &mut self.points,
        );
    }

    fn find_lines(&mut self) {
        self.lines.clear();
        self.line_of.clear();
        self.line_of.resize(self.points.len(), FREE);
        self.hough.clear();
        self.points.iter().for_each(|p| self.hough.vote(p));
        while self.lines.len() < MAX_LINES {
            let peak = self.hough.strongest();
            // A line's votes are spread over neighbouring bins; half its points at least meet in one.
            if (peak.votes as usize) < self.params.min_points / 2 {
                break;
            }
            let index = self.lines.len() as u8;
            let Some(line) = self.refine(&peak, index) else { break };
            let (points, hough) = (&self.points, &mut self.hough);
            points.iter().zip(&self.line_of).filter(|(_, owner)| **owner == index).for_each(|(p, _)| hough.withdraw(p));
            self.lines.push(line);
        }
        if self.params.line_fit == LineFit::LeastSquares {
            self.refit_uncrowded();
        }
    }

    /// Refits each line without the points that another line's light has moved, where enough remain.
    fn refit_uncrowded(&mut self) {
        // A centre is measured over the thickness of a stripe and as much on either side; so is the other stripe's light.
        let reach_px = 2.0 * self.gap_px as f64;
        for index in 0..self.lines.len() as u8 {
            self.crowded.clone_from(&self.line_of);
            line_fit::free_crowded(&self.points, &self.lines, index, reach_px, &mut self.crowded);
            let refitted = line_fit::fit(&self.points, &self.crowded, index, Centre::Light);
            if let Some(line) = refitted.filter(|line| line.points >= self.params.min_points) {
                std::mem::swap(&mut self.line_of, &mut self.crowded);
                self.lines[usize::from(index)] = line;
            }
        }
    }

    /// Gives the free points near a Hough line to line `index`, and fits it to them. `None` where the line has no points, which
    /// ends the search: its votes could never be withdrawn.
    fn refine(&mut self, peak: &super::hough::PolarLine, index: u8) -> Option<ScanLine> {
        let hough_line = ScanLine::from_polar(peak)?;
        let centre = match self.params.line_fit {
            LineFit::LeastSquares => Centre::Light,
            LineFit::HoughPeak => Centre::Run,
        };
        let (points, line_of) = (&self.points, &mut self.line_of);
        line_fit::claim(points, &hough_line, HOUGH_INLIER_PX, index, line_of);
        let mut line = line_fit::fit(points, line_of, index, centre)?;
        for _ in 0..REFITS {
            line_fit::claim(points, &line, self.params.inlier_px, index, line_of);
            line = line_fit::fit(points, line_of, index, centre)?;
        }
        match self.params.line_fit {
            LineFit::LeastSquares => Some(line),
            LineFit::HoughPeak => Some(ScanLine { slope: hough_line.slope, intercept_px: hough_line.intercept_px, ..line }),
        }
    }

    fn find_wall(&mut self, wall: Wall, base_from_camera: &Transform) -> Option<WallMeasurement> {
        let (a, b) = assignment::best_pair(&self.proposals, wall, &self.limits)?;
        for one in [a, b] {
            self.seen[one.line].assigned = Some((one.laser, wall));
        }
        let plane = match self.params.plane_fit {
            PlaneFit::Joint => self.joint_plane(&[a, b]),
            PlaneFit::CrossProduct => WallPlane::from_lines(&self.line3(&a)?, &self.line3(&b)?),
        }?;
        let points = a.measured.points + b.measured.points;
        let (side, measured) = duct_error::measure(&plane, base_from_camera, points, self.limits.max_heading_rad)?;
        if side != wall {
            return None;
        }
        self.planes.push(SeenPlane { wall, plane, covariance: None, points });
        Some(measured)
    }

    /// Equation 16: the 3D line through the ends of a stripe, by equation 1.
    fn line3(&self, stripe: &Proposal) -> Option<Line3> {
        let [from, to] = self.seen[stripe.line].ends_px;
        let t = &self.triangulations[stripe.laser];
        Some(Line3::through(t.point(from[0], from[1])?, t.point(to[0], to[1])?))
    }

    /// The plane through all points of both stripes, each weighted by what an error across the stripe does to it.
    fn joint_plane(&self, stripes: &[Proposal; 2]) -> Option<WallPlane> {
        let mut fit = JointFit::default();
        for stripe in stripes {
            let laser = &self.rig.lasers[stripe.laser];
            let inverse_plane = laser.normal_in_camera.into_inner() / laser.offset_m;
            let l = assignment::image_line(&self.lines[stripe.line], self.across, &self.rig.camera);
            let residual_px = self.lines[stripe.line].residual_px.max(LEAST_RESIDUAL_PX);
            let across_rad = match self.across {
                Across::V => l.y / self.rig.camera.focal_px[1],
                Across::U => l.x / self.rig.camera.focal_px[0],
            };
            let weight = 1.0 / (stripe.lambda * across_rad * residual_px).abs();
            for (point, _) in self.points.iter().zip(&self.line_of).filter(|(_, owner)| **owner as usize == stripe.line) {
                let [u, v] = self.across.pixel(point.x_px, point.centre_px);
                let ray = self.rays * Vector3::new(u, v, 1.0);
                fit.add(&ray, inverse_plane.dot(&ray), weight);
            }
        }
        WallPlane::from_inverse(&fit.solve()?)
    }

    fn show_lines(&mut self) {
        self.seen.clear();
        let across = self.across;
        self.seen.extend(self.lines.iter().map(|line| StripeLine {
            ends_px: line.extent_px.map(|x| across.pixel(x, line.at(x))),
            assigned: None,
            points: line.points,
            residual_px: line.residual_px,
        }));
    }

    /// The points as they were assigned, each with the scatter of its line.
    fn show_centres(&mut self) {
        let across = self.across;
        self.centres.clear();
        self.centres.extend(self.points.iter().zip(&self.line_of).map(|(point, owner)| {
            let line = self.seen.get(usize::from(*owner));
            let [u_px, v_px] = across.pixel(point.x_px, point.centre_px);
            let sigma_px = line.map_or(UNFITTED_SIGMA_PX, |line| line.residual_px.max(LEAST_RESIDUAL_PX));
            StripeCentre { u_px, v_px, sigma_px, assigned: line.and_then(|line| line.assigned) }
        }));
    }
}

impl Perception for PaperPerception {
    fn perceive(&mut self, frame: &Frame<'_>, mount: MountAngles) -> Measurement {
        let base_from_camera = self.rig.mount.base_from_camera(mount);
        self.find_points(frame);
        self.find_lines();
        self.show_lines();
        self.proposals.clear();
        for (i, line) in self.lines.iter().enumerate().filter(|(_, line)| line.points >= self.params.min_points) {
            for laser in 0..self.rig.lasers.len() {
                let proposal = assignment::propose(i, line, laser, &self.rig, self.across, &base_from_camera, &self.limits);
                self.proposals.extend(proposal);
            }
        }
        self.planes.clear();
        let left = self.find_wall(Wall::Left, &base_from_camera);
        let right = self.find_wall(Wall::Right, &base_from_camera);
        self.show_centres();
        combine(left, right, self.params.duct_width_m)
    }

    fn stages(&self) -> Stages<'_> {
        Stages { centres: &self.centres, lines: &self.seen, planes: &self.planes, ..Stages::default() }
    }
}

/// Both walls, weighted by the points that they rest on, to one answer. With both walls the duct's width drops out of the
/// lateral error; with one it is the nominal `duct_width_m` (W_d of equation 19).
pub fn combine(left: Option<WallMeasurement>, right: Option<WallMeasurement>, duct_width_m: f64) -> Measurement {
    let (lateral_m, heading_rad) = match (left, right) {
        (None, None) => (None, None),
        (Some(one), None) => (duct_error::lateral_m(Wall::Left, &one, duct_width_m), Some(one.heading_rad)),
        (None, Some(one)) => (duct_error::lateral_m(Wall::Right, &one, duct_width_m), Some(one.heading_rad)),
        (Some(l), Some(r)) => {
            let share = l.points as f64 / (l.points + r.points) as f64;
            let heading = share * l.heading_rad + (1.0 - share) * r.heading_rad;
            (Some((r.distance_m - l.distance_m) / 2.0), Some(heading))
        }
    };
    let width_m = left.zip(right).map(|(l, r)| l.distance_m + r.distance_m);
    Measurement { lateral_m, heading_rad, width_m, left, right, ..Measurement::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_walls_share_in_the_answer_by_their_points() {
        let wall = |distance_m, heading_rad, points| WallMeasurement { distance_m, heading_rad, points, deviation: None };
        let (left, right) = (wall(0.2, 0.10, 300), wall(0.31, 0.02, 100));
        let both = combine(Some(left), Some(right), 0.5);
        // Nearer to the left wall than to the right one by 110 mm, so 55 mm to the left of the middle.
        assert!((both.lateral_m.unwrap() - 0.055).abs() < 1e-12, "{both:?}");
        assert!((both.width_m.unwrap() - 0.51).abs() < 1e-12, "{both:?}");
        assert!((both.heading_rad.unwrap() - 0.08).abs() < 1e-12, "{both:?}");
        // With one wall the nominal width stands in for the other.
        assert!((combine(Some(left), None, 0.5).lateral_m.unwrap() - 0.05).abs() < 1e-12);
        assert!((combine(None, Some(right), 0.5).lateral_m.unwrap() - 0.06).abs() < 1e-12);
        assert_eq!(combine(None, None, 0.5), Measurement::default());
    }
}
