//! The stages of a perception, held against the truth.

use ductloop_nav::perception::{Measurement, SeenPlane, Stages, StripeCentre, Wall};
use ductloop_sensor::lens::Projection;
use nalgebra::Vector3;

use super::truth::{Scan, StageTruth, TrueCentre, TruthScene};

/// A centre this far across its stripe from the middle, in pixels, is not a centre of it. The widest stripes of the rigs are twice
/// as thick.
pub const GATE_PX: f64 = 3.0;

/// Stripe centres: those that were taken for a laser's light on a wall, against those that truly are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CentreScore {
    /// Centres that were taken for a stripe.
    pub claimed: usize,
    /// Of these, those within [`GATE_PX`] of this laser's stripe on this wall.
    pub right: usize,
    /// Columns (or rows) of stripe that there truly are on walls.
    pub there: usize,
    /// Of these, those where a right centre was found.
    pub found: usize,
    /// Sum of the squares of the errors of the right ones, along their column (or row), in px^2.
    pub square_px2: f64,
    /// Sum of the squares of error over stated deviation.
    pub nees: f64,
}

/// Lines that were taken for a stripe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineScore {
    /// How many of them have a true counterpart.
    pub lines: usize,
    /// Sum of the mean squares of their ends' distances from the true stripe, in px^2.
    pub square_px2: f64,
}

/// A wall, as measured and as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallScore {
    /// Which one.
    pub wall: Wall,
    /// Columns of stripe that are truly visible on it.
    pub columns: usize,
    /// Its true distance from the camera, in metres.
    pub camera_distance_m: f64,
    /// Its true distance from the base's origin, in metres.
    pub distance_m: f64,
    /// The true heading relative to it, in radians; `None` of floor and ceiling.
    pub heading_rad: Option<f64>,
    /// What was measured less what is; `None` where the wall was not measured.
    pub distance_error_m: Option<f64>,
    /// The same of the heading.
    pub heading_error_rad: Option<f64>,
    /// Angle between the measured plane's normal and the true one, in radians.
    pub normal_error_rad: Option<f64>,
    /// Stated standard deviation of the distance, in metres.
    pub distance_sigma_m: Option<f64>,
    /// And of the heading, in radians.
    pub heading_sigma_rad: Option<f64>,
}

/// One frame's scores.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Stripe centres.
    pub centres: CentreScore,
    /// Lines.
    pub lines: LineScore,
    /// The walls that light falls on, each if it is one plane.
    pub walls: Vec<WallScore>,
    /// Estimate less truth of the lateral offset, in metres.
    pub lateral_error_m: Option<f64>,
    /// The same of the heading, in radians.
    pub heading_error_rad: Option<f64>,
    /// Stated standard deviations of the two.
    pub lateral_sigma_m: Option<f64>,
    /// And of the heading, in radians.
    pub heading_sigma_rad: Option<f64>,
}

impl CentreScore {
    /// Share of the claimed centres that are right; `None` where nothing was claimed.
    pub fn precision(&self) -> Option<f64> {
        (self.claimed > 0).then(|| self.right as f64 / self.claimed as f64)
    }

    /// Share of the true columns in which a right centre was found; `None` where there are none.
    pub fn recall(&self) -> Option<f64> {
        (self.there > 0).then(|| self.found as f64 / self.there as f64)
    }

    /// RMS error of the right ones, in pixels.
    pub fn rms_px(&self) -> Option<f64> {
        (self.right > 0).then(|| (self.square_px2 / self.right as f64).sqrt())
    }

    /// Mean square of error over stated deviation.
    pub fn mean_nees(&self) -> Option<f64> {
        (self.right > 0).then(|| self.nees / self.right as f64)
    }
}

impl LineScore {
    /// RMS distance of the lines' ends from the true stripes, in pixels.
    pub fn rms_px(&self) -> Option<f64> {
        (self.lines > 0).then(|| (self.square_px2 / self.lines as f64).sqrt())
    }
}

impl WallScore {
    /// Error over stated deviation, of distance and of heading.
    pub fn normalised(&self) -> impl Iterator<Item = f64> + use<> {
        let distance = self.distance_error_m.zip(self.distance_sigma_m);
        let heading = self.heading_error_rad.zip(self.heading_sigma_rad);
        distance.into_iter().chain(heading).map(|(error, sigma)| error / sigma)
    }
}

impl Score {
    /// The score of a wall.
    pub fn wall(&self, wall: Wall) -> Option<&WallScore> {
        self.walls.iter().find(|score| score.wall == wall)
    }

    /// Error over stated deviation of lateral offset and heading.
    pub fn normalised(&self) -> impl Iterator<Item = f64> + use<> {
        let lateral = self.lateral_error_m.zip(self.lateral_sigma_m);
        let heading = self.heading_error_rad.zip(self.heading_sigma_rad);
        lateral.into_iter().chain(heading).map(|(error, sigma)| error / sigma)
    }

    /// Mean square of error over stated deviation of lateral offset and heading; `None` where neither has one.
    pub fn nees(&self) -> Option<f64> {
        let squares: Vec<f64> = self.normalised().map(|ratio| ratio * ratio).collect();
        (!squares.is_empty()).then(|| squares.iter().sum::<f64>() / squares.len() as f64)
    }
}

/// Scores what a perception made of a frame. `lateral_m` and `heading_rad` are where the base truly stood against the centreline.
pub fn score(
    scene: &TruthScene,
    truth: &StageTruth,
    stages: &Stages<'_>,
    measurement: &Measurement,
    lateral_m: f64,
    heading_rad: f64,
) -> Score {
    // A perception that answers without a centre does not tell of its stages.
    let tells = !stages.centres.is_empty() || measurement.lateral_m.is_none();
    Score {
        centres: if tells { centres(truth, stages.centres) } else { CentreScore::default() },
        lines: lines(scene, truth, stages),
        walls: Wall::ALL.into_iter().filter_map(|wall| wall_score(truth, stages.planes, measurement, wall)).collect(),
        lateral_error_m: measurement.lateral_m.map(|lateral| lateral - lateral_m),
        heading_error_rad: measurement.heading_rad.map(|heading| heading - heading_rad),
        lateral_sigma_m: measurement.lateral_m.and(measurement.deviation.lateral_m),
        heading_sigma_rad: measurement.heading_rad.and(measurement.deviation.heading_rad),
    }
}

fn centres(truth: &StageTruth, claimed: &[StripeCentre]) -> CentreScore {
    let mut score = CentreScore::default();
    // Which of the true centres were found.
    let mut found = vec![false; truth.centres.len()];
    for centre in claimed {
        let Some((laser, wall)) = centre.assigned else { continue };
        score.claimed += 1;
        let Some((index, error_px)) = nearest(truth, centre, laser, wall) else { continue };
        score.right += 1;
        score.square_px2 += error_px * error_px;
        let ratio = error_px / centre.sigma_px;
        score.nees += ratio * ratio;
        found[index] = true;
    }
    let on_wall = |centre: &TrueCentre| truth.planes[centre.plane].wall.is_some();
    for (index, centre) in truth.centres.iter().enumerate() {
        if centre.counts() && on_wall(centre) {
            score.there += 1;
            // A perception may look along the other side of the image.
            score.found += usize::from(found[index] || found_across(truth, centre, &found));
        }
    }
    score
}

/// The true centre that a claimed one belongs to, and its error along the column (or row).
fn nearest(truth: &StageTruth, centre: &StripeCentre, laser: usize, wall: Wall) -> Option<(usize, f64)> {
    let (scan, along, at) =
        if centre.u_px.fract() == 0.0 { (Scan::Column, centre.u_px, centre.v_px) } else { (Scan::Row, centre.v_px, centre.u_px) };
    let line = along.round();
    if line < 0.0 {
        return None;
    }
    let belongs = |c: &TrueCentre| c.laser == laser && truth.planes[c.plane].wall == Some(wall);
    truth
        .in_line(scan, line as usize)
        .map(|index| (index, &truth.centres[index]))
        .filter(|(_, candidate)| belongs(candidate))
        .map(|(index, candidate)| {
            let error_px = at - (candidate.at_px + candidate.slope * (along - line));
            (index, error_px, error_px.abs() / (1.0 + candidate.slope * candidate.slope).sqrt())
        })
        .filter(|(.., across_px)| *across_px <= GATE_PX)
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .map(|(index, error_px, _)| (index, error_px))
}

/// Whether the same point of a stripe was found in the row (or column) that it is nearest to.
fn found_across(truth: &StageTruth, centre: &TrueCentre, found: &[bool]) -> bool {
    let (scan, line) = match centre.scan {
        Scan::Column => (Scan::Row, centre.at_px.round()),
        Scan::Row => (Scan::Column, centre.at_px.round()),
    };
    if line < 0.0 {
        return false;
    }
    truth.in_line(scan, line as usize).any(|index| {
        let c = &truth.centres[index];
        // Half a line's way along the stripe at most.
        let near = (c.at_px - centre.line as f64).abs() <= 0.5 * c.slope.abs() + 1.0;
        found[index] && near && c.laser == centre.laser && c.plane == centre.plane
    })
}

fn lines(scene: &TruthScene, truth: &StageTruth, stages: &Stages<'_>) -> LineScore {
    let mut score = LineScore::default();
    for line in stages.lines {
        let Some((laser, wall)) = line.assigned else { continue };
        let Some(plane) = truth.only_plane(wall).map(|index| &truth.planes[index]) else { continue };
        let laser = &scene.rig().lasers[laser];
        // On the wall m . p = 1 and the laser's plane n . p = o, the stripe is where (m - n / o) . r = 0.
        let g =
            plane.normal_in_camera.into_inner() / plane.camera_distance_m - laser.normal_in_camera.into_inner() / laser.offset_m;
        let square = |pixel: [f64; 2]| {
            let off = off_stripe_px(scene.projection(), &g, pixel);
            off * off
        };
        score.lines += 1;
        score.square_px2 += (square(line.ends_px[0]) + square(line.ends_px[1])) / 2.0;
    }
    score
}

/// Distance of a pixel from the line g . r = 0 of the image, in pixels.
fn off_stripe_px(projection: &Projection, g: &Vector3<f64>, pixel: [f64; 2]) -> f64 {
    let [x, y] = projection.ray(pixel);
    let by_pixel = projection.rays_per_pixel([x, y]).transpose() * g.xy();
    g.dot(&Vector3::new(x, y, 1.0)) / by_pixel.norm()
}

fn wall_score(truth: &StageTruth, planes: &[SeenPlane], measurement: &Measurement, wall: Wall) -> Option<WallScore> {
    let index = truth.only_plane(wall)?;
    let plane = &truth.planes[index];
    let heading_rad = plane.heading_rad();
    let measured = measurement.wall(wall);
    let deviation = measured.and_then(|measured| measured.deviation);
    let seen = planes.iter().find(|seen| seen.wall == wall && measured.is_some());
    Some(WallScore {
        wall,
        columns: truth.columns(index),
        camera_distance_m: plane.camera_distance_m,
        distance_m: plane.distance_m,
        heading_rad,
        distance_error_m: measured.map(|measured| measured.distance_m - plane.distance_m),
        heading_error_rad: measured.zip(heading_rad).map(|(measured, heading)| measured.heading_rad - heading),
        normal_error_rad: seen.map(|seen| {
            let (a, b) = (seen.plane.normal, plane.normal_in_camera);
            libm::atan2(a.cross(&b).norm(), a.dot(&b))
        }),
        distance_sigma_m: deviation.map(|deviation| deviation.distance_m),
        heading_sigma_rad: heading_rad.and(deviation).map(|deviation| deviation.heading_rad),
    })
}
