//! The rig itself from pixels of known position: one camera and the planes of its lasers, fitted to the points of all lasers together.
//!
//! Equation 14 gives each laser eleven numbers that nothing holds to a camera's laws. Here the camera is one pinhole with square
//! pixels behind a radially distorting lens, it stands somewhere in the gauge's frame, and each laser is a plane: three numbers a
//! laser and six for the pose, besides what the camera is left free to be.
//!
//! What is made small is each point's miss, its triangulated less its actual position, weighed by what pixels and positions are
//! known to: S = sigma_px^2 J J^T + sigma_mm^2 1, J the triangulated position's change by the pixel. Depth, which a pixel moves most,
//! weighs least. To first order this is the maximum likelihood of both errors. Points that lie far off lose weight (Cauchy's loss).
//!
//! Points in a few millimetres' depth hardly tell the focal length from the distance. So it is held unless it is freed, and
//! [`Rig::if_free`] says to how much these points would tell it, and the principal point, and the distortion.
//!
//! The gauge's frame must be right-handed: a mirrored one fits no camera.

use nalgebra::{Matrix3, Point3, Rotation3, SMatrix, SVector, Vector3};

use super::first_guess::{plane_through, pose};
use super::levenberg::{self, Problem, cauchy, covariance, minimise};
use super::linear::{LinearCalibration, LinearError};
use super::pairs::{self, Pair, PairsError};
use crate::perception::lens::Lens;
use crate::rig::{Camera, Distortion};

/// Most lasers.
pub const LASERS: usize = 4;
/// Parameters: pose 6, focal length, centre 2, k1, k2, and three a laser.
pub const PARAMETERS: usize = 11 + 3 * LASERS;
const FOCAL: usize = 6;
const PLANES: usize = 11;
/// Unit of lengths within the fit, in millimetres, so that steps of all parameters are alike.
const UNIT_MM: f64 = 100.0;
/// Cauchy's constant, in standard deviations: 95 % efficient on Gaussian noise.
const CAUCHY: f64 = 2.385;
/// Rounds of new weights.
const ROUNDS: usize = 25;

/// What the fit may change beside pose and planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Free {
    /// The focal length, one for both axes.
    pub focal: bool,
    /// The principal point.
    pub centre: bool,
    /// k1.
    pub k1: bool,
    /// k2.
    pub k2: bool,
}

/// Standard deviations of what was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Of a pixel, along each axis.
    pub pixel_px: f64,
    /// Of a position, along each axis, in millimetres.
    pub position_mm: f64,
}

/// Why there is no rig. Lasers and points are numbered from zero.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// More lasers than a rig may have, or none.
    #[error("{0} lasers: one to {LASERS} can be fitted")]
    Lasers(usize),
    /// A laser's points determine nothing.
    #[error("laser {laser}: {error}")]
    Pairs {
        /// The laser.
        laser: usize,
        /// Why.
        error: PairsError,
    },
    /// The first guess, equation 14 for the laser of most points, failed.
    #[error("laser {laser}: {error}")]
    Start {
        /// The laser.
        laser: usize,
        /// Why.
        error: LinearError,
    },
    /// The fit runs away: points behind the camera, or planes through it.
    #[error("no camera fits these points")]
    NoFit,
    /// Some combination of the free parameters is not determined.
    #[error("these points do not determine what was left free: hold more of it")]
    Undetermined,
}

/// A rig fitted to points.
#[derive(Clone, Debug)]
pub struct Rig {
    /// The camera.
    pub camera: Camera,
    /// p_camera = rotation p_gauge + translation.
    pub rotation: Rotation3<f64>,
    /// In millimetres.
    pub translation_mm: Vector3<f64>,
    /// m = n / d of each laser's plane n . p = d in the camera frame, in 1/mm.
    pub planes: Vec<Vector3<f64>>,
    /// Misses of each laser's points, in the gauge's frame, in millimetres.
    pub misses_mm: Vec<Vec<Vector3<f64>>>,
    /// Root mean square of the residuals over what was stated for them: 1 where that is right.
    pub scatter: f64,
    /// Standard deviations of what was free, scaled by the scatter.
    pub sigma: Sigma,
    /// The same of what was held, were it free.
    pub if_free: Sigma,
    /// Covariance of all parameters (zeros where held): turn of the camera about its axes (rad), translation (mm), focal length,
    /// centre (px), k1, k2, then m of each laser (1/mm).
    pub covariance: SMatrix<f64, PARAMETERS, PARAMETERS>,
}

/// Standard deviations of a rig's parameters; `None` of what was held, or is not determined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sigma {
    /// Of the focal length, in pixels.
    pub focal_px: Option<f64>,
    /// Of the principal point, in pixels.
    pub centre_px: Option<[f64; 2]>,
    /// Of k1.
    pub k1: Option<f64>,
    /// Of k2.
    pub k2: Option<f64>,
    /// Of each plane's offset, in millimetres, and normal, in radians (the larger of two directions).
    pub planes: Vec<(f64, f64)>,
}

impl Rig {
    /// Unit normal and offset of a laser's plane n . p = d, in millimetres; the offset is positive.
    pub fn plane(&self, laser: usize) -> (Vector3<f64>, f64) {
        let m = self.planes[laser];
        (m.normalize(), 1.0 / m.norm())
    }

    /// Fits a rig to the points of one laser or of several.
    ///
    /// `camera` is where the fit starts, and what stays of it is what is not `free`. Its focal lengths are taken as one, their mean.
    ///
    /// # Errors
    /// Points that determine nothing, and those that no camera fits.
    pub fn fit(lasers: &[Vec<Pair>], camera: &Camera, free: Free, scatter: Scatter) -> Result<Self, ModelError> {
        if lasers.is_empty() || lasers.len() > LASERS {
            return Err(ModelError::Lasers(lasers.len()));
        }
        for (laser, pairs) in lasers.iter().enumerate() {
            pairs::check(pairs).map_err(|error| ModelError::Pairs { laser, error })?;
        }
        let mut fit = Fit::new(lasers, scatter);
        let mut state = fit.start(lasers, camera)?;
        let free = mask(free, lasers.len());
        let mut weights = vec![1.0; fit.points.len()];
        for round in 0..ROUNDS {
            fit.whiten(&state).ok_or(ModelError::NoFit)?;
            if round > 0 {
                let newer = fit.weights(&state).ok_or(ModelError::NoFit)?;
                let change = newer.iter().zip(&weights).map(|(newer, older)| (newer - older).abs()).fold(0.0, f64::max);
                weights = newer;
                if round > 1 && change < 1e-6 {
                    break;
                }
            }
            state = minimise(&fit, state, &weights, &free).ok_or(ModelError::NoFit)?;
        }
        fit.told(state, &weights, &free, lasers.len())
    }
}

/// Which parameters are free.
fn mask(free: Free, lasers: usize) -> [bool; PARAMETERS] {
    let camera = [free.focal, free.centre, free.centre, free.k1, free.k2];
    std::array::from_fn(|axis| match axis {
        0..FOCAL => true,
        FOCAL..PLANES => camera[axis - FOCAL],
        _ => axis < PLANES + 3 * lasers,
    })
}

/// Where the parameters are.
#[derive(Clone, Debug)]
struct State {
    rotation: Rotation3<f64>,
    translation_mm: Vector3<f64>,
    focal_px: f64,
    centre_px: [f64; 2],
    k: [f64; 2],
    /// In 1/mm.
    planes: [Vector3<f64>; LASERS],
    camera: Camera,
}

impl State {
    fn lens(&self) -> Lens {
        let distortion = Distortion { k1: self.k[0], k2: self.k[1], ..self.camera.distortion };
        Lens::new(&Camera { focal_px: [self.focal_px; 2], centre_px: self.centre_px, distortion, ..self.camera })
    }

    /// The triangulated position in the camera frame, in millimetres, and its changes by u and v.
    fn seen(&self, lens: &Lens, laser: usize, [u, v]: [f64; 2]) -> Option<(Vector3<f64>, [Vector3<f64>; 2])> {
        let (ray, m) = (lens.ray(u, v), self.planes[laser]);
        let s = m.dot(&ray);
        let changes = lens.ray_by_pixel(&ray).map(|by| by / s - ray * (m.dot(&by) / (s * s)));
        (s > 0.0 && s.is_finite()).then(|| (ray / s, changes))
    }
}

/// A point with the root of its weight.
struct Point {
    laser: usize,
    pair: Pair,
    whitener: Matrix3<f64>,
}

struct Fit {
    points: Vec<Point>,
    scatter: Scatter,
}

impl Problem<PARAMETERS> for Fit {
    type State = State;

    fn observations(&self) -> usize {
        self.points.len()
    }

    fn residual(&self, state: &State, observation: usize) -> Option<Vector3<f64>> {
        let point = &self.points[observation];
        Some(point.whitener * miss(state, &state.lens(), point)?)
    }

    fn moved(&self, state: &State, by: &SVector<f64, PARAMETERS>) -> State {
        let turn = Rotation3::from_scaled_axis(Vector3::new(by[0], by[1], by[2]));
        let mut moved = state.clone();
        moved.rotation = turn * state.rotation;
        moved.translation_mm += Vector3::new(by[3], by[4], by[5]) * UNIT_MM;
        moved.focal_px *= 1.0 + by[6];
        moved.centre_px = [0, 1].map(|axis| state.centre_px[axis] + by[7 + axis] * state.focal_px);
        moved.k = [0, 1].map(|axis| state.k[axis] + by[9 + axis]);
        for (laser, plane) in moved.planes.iter_mut().enumerate() {
            *plane += by.fixed_rows::<3>(PLANES + 3 * laser) / UNIT_MM;
        }
        moved
    }
}

/// Triangulated less actual position, in the camera frame, in millimetres.
fn miss(state: &State, lens: &Lens, point: &Point) -> Option<Vector3<f64>> {
    let (seen, _) = state.seen(lens, point.laser, point.pair.pixel_px)?;
    Some(seen - (state.rotation * Vector3::from(point.pair.position_mm) + state.translation_mm))
}

impl Fit {
    fn new(lasers: &[Vec<Pair>], scatter: Scatter) -> Self {
        let of = |(laser, pairs): (usize, &Vec<Pair>)| {
            pairs.iter().map(move |pair| Point { laser, pair: *pair, whitener: Matrix3::identity() }).collect::<Vec<_>>()
        };
        Self { points: lasers.iter().enumerate().flat_map(of).collect(), scatter }
    }

    /// The pose from equation 14 of the laser with most points, and planes through the positions.
    fn start(&self, lasers: &[Vec<Pair>], camera: &Camera) -> Result<State, ModelError> {
        let laser = (0..lasers.len()).max_by_key(|laser| (lasers[*laser].len(), usize::MAX - laser)).unwrap_or(0);
        let linear = LinearCalibration::of(&lasers[laser]).map_err(|error| ModelError::Start { laser, error })?;
        let focal_px = (camera.focal_px[0] + camera.focal_px[1]) / 2.0;
        let k = [camera.distortion.k1, camera.distortion.k2];
        let (rotation, translation_mm) = pose(&linear.t, focal_px, camera.centre_px).ok_or(ModelError::NoFit)?;
        let centre_px = camera.centre_px;
        let mut state = State {
            rotation,
            translation_mm,
            focal_px,
            centre_px,
            k,
            planes: [Vector3::zeros(); LASERS],
            camera: camera.clone(),
        };
        for (plane, pairs) in state.planes.iter_mut().zip(lasers) {
            let points: Vec<_> = pairs.iter().map(|pair| rotation * Vector3::from(pair.position_mm) + translation_mm).collect();
            *plane = plane_through(&points).ok_or(ModelError::NoFit)?;
        }
        Ok(state)
    }

    /// Weighs each point's miss by the inverse root of its covariance at `state`.
    fn whiten(&mut self, state: &State) -> Option<()> {
        let lens = state.lens();
        let Scatter { pixel_px, position_mm } = self.scatter;
        for point in &mut self.points {
            let (_, [by_u, by_v]) = state.seen(&lens, point.laser, point.pair.pixel_px)?;
            let of_pixel = (by_u * by_u.transpose() + by_v * by_v.transpose()) * (pixel_px * pixel_px);
            let covariance = of_pixel + Matrix3::identity() * (position_mm * position_mm);
            point.whitener = covariance.cholesky()?.l().try_inverse()?;
        }
        Some(())
    }

    /// Cauchy's weights, with the scatter taken from the median of the residuals.
    fn weights(&self, state: &State) -> Option<Vec<f64>> {
        let squares: Option<Vec<f64>> = (0..self.points.len()).map(|i| Some(self.residual(state, i)?.norm_squared())).collect();
        let squares = squares?;
        let mut sorted = squares.clone();
        sorted.sort_by(f64::total_cmp);
        // The median of chi squared with three degrees of freedom is 2.366.
        let scale = (sorted[sorted.len() / 2] / 2.366).sqrt().max(1e-9);
        // Cauchy's constant is that of one residual; a point has three.
        Some(squares.iter().map(|square| cauchy(*square / 3.0, CAUCHY * scale)).collect())
    }

    fn told(self, state: State, weights: &[f64], free: &[bool; PARAMETERS], lasers: usize) -> Result<Rig, ModelError> {
        let lens = state.lens();
        let back = state.rotation.inverse();
        let misses = |laser: usize| {
            let own = self.points.iter().filter(|point| point.laser == laser);
            own.map(|point| Some(back * miss(&state, &lens, point)?)).collect::<Option<Vec<_>>>()
        };
        let misses_mm: Option<Vec<_>> = (0..lasers).map(misses).collect();
        let normal = levenberg::normal(&self, &state, weights, free).ok_or(ModelError::NoFit)?;
        let count = free.iter().filter(|free| **free).count();
        let total: f64 = 3.0 * weights.iter().sum::<f64>();
        let variance = normal.cost / (total - count as f64).max(1.0);
        let unit = units(&state);
        let scaled = |matrix: SMatrix<f64, PARAMETERS, PARAMETERS>| {
            SMatrix::<f64, PARAMETERS, PARAMETERS>::from_fn(|i, j| matrix[(i, j)] * unit[i] * unit[j] * variance)
        };
        let mut covariance = scaled(covariance(&normal).ok_or(ModelError::Undetermined)?);
        for axis in (0..PARAMETERS).filter(|axis| !free[*axis]) {
            covariance[(axis, axis)] = 0.0;
        }
        // One thing that was held at a time: together they hide each other.
        let mut if_free = Sigma::default();
        for group in [vec![FOCAL], vec![FOCAL + 1, FOCAL + 2], vec![FOCAL + 3], vec![FOCAL + 4]] {
            if group.iter().any(|axis| free[*axis]) {
                continue;
            }
            let mut more = *free;
            group.iter().for_each(|axis| more[*axis] = true);
            let freed = levenberg::normal(&self, &state, weights, &more).and_then(|normal| levenberg::covariance(&normal));
            if let Some(freed) = freed.map(scaled) {
                let told = sigma(&freed, &more, &state, lasers);
                match group[0] {
                    FOCAL => if_free.focal_px = told.focal_px,
                    axis if axis == FOCAL + 1 => if_free.centre_px = told.centre_px,
                    axis if axis == FOCAL + 3 => if_free.k1 = told.k1,
                    _ => if_free.k2 = told.k2,
                }
            }
        }
        Ok(Rig {
            sigma: sigma(&covariance, free, &state, lasers),
            if_free,
            misses_mm: misses_mm.ok_or(ModelError::NoFit)?,
            scatter: variance.sqrt(),
            camera: Camera {
                focal_px: [state.focal_px; 2],
                centre_px: state.centre_px,
                distortion: Distortion { k1: state.k[0], k2: state.k[1], ..state.camera.distortion },
                ..state.camera
            },
            rotation: state.rotation,
            translation_mm: state.translation_mm,
            planes: state.planes[..lasers].to_vec(),
            covariance,
        })
    }
}

/// Each parameter's unit within the fit, in the unit that is told.
fn units(state: &State) -> SVector<f64, PARAMETERS> {
    SVector::from_fn(|axis, _| match axis {
        0..3 | 9..PLANES => 1.0,
        3..FOCAL => UNIT_MM,
        FOCAL..9 => state.focal_px,
        _ => 1.0 / UNIT_MM,
    })
}

/// Standard deviations out of a covariance.
fn sigma(covariance: &SMatrix<f64, PARAMETERS, PARAMETERS>, free: &[bool; PARAMETERS], state: &State, lasers: usize) -> Sigma {
    let of = |axis: usize| free[axis].then(|| covariance[(axis, axis)].max(0.0).sqrt());
    let plane = |laser: usize| {
        let (m, own) = (state.planes[laser], covariance.fixed_view::<3, 3>(PLANES + 3 * laser, PLANES + 3 * laser));
        let (length, normal) = (m.norm(), m.normalize());
        // d = 1 / |m|; n turns by what moves m square to itself, over its length.
        let offset_mm = normal.dot(&(own * normal)).max(0.0).sqrt() / (length * length);
        let square = Matrix3::identity() - normal * normal.transpose();
        let turned = (square * own * square).symmetric_eigenvalues().max().max(0.0).sqrt() / length;
        (offset_mm, turned)
    };
    let centre_px = of(FOCAL + 1).zip(of(FOCAL + 2)).map(|(u, v)| [u, v]);
    Sigma { focal_px: of(FOCAL), centre_px, k1: of(FOCAL + 3), k2: of(FOCAL + 4), planes: (0..lasers).map(plane).collect() }
}

/// A laser's position of a pixel in the gauge's frame, in millimetres, by a fitted rig; `None` where the ray misses the plane.
pub fn position_mm(rig: &Rig, laser: usize, [u, v]: [f64; 2]) -> Option<Point3<f64>> {
    let (ray, m) = (Lens::new(&rig.camera).ray(u, v), *rig.planes.get(laser)?);
    let s = m.dot(&ray);
    (s > 0.0).then(|| Point3::from(rig.rotation.inverse() * (ray / s - rig.translation_mm)))
}
