//! A laser's plane from its stripe on boards of known pose.
//!
//! A stripe's centre seen along the ray r on a board n . x = d lies at x = r d / (n . r). All such points lie on the laser's plane
//! k . x = o, and the plane is fitted to them in the image, where the noise is: with e = k . x - o and its gradient g by the pixel,
//! e / |g| is the centre's distance from the stripe that the plane would make, in pixels (Sampson 1982). It is divided by the
//! centre's standard deviation, and points beyond a few times the scatter lose their weight (Tukey's biweight), so that lamps and
//! reflections among the centres do no harm while most of them are the stripe's. Where most centres lie farther off than they state
//! (the boards' poses are not exact, nor is the lens), what is missing is added to the variance of each: else the weights would be of
//! errors that are not the ones that count.
//!
//! Centres of one board share the error of its pose; six boards of a thousand centres each are six witnesses, not six thousand.
//! So beside the covariance from single points there is one from whole boards (a "sandwich" with a board a cluster; Liang and
//! Zeger 1986), where there are five of them at least. State the latter.

use nalgebra::{Matrix2x3, Matrix3, Unit, Vector2, Vector3};

use crate::perception::lens::Lens;

/// A board's plane in the camera frame: n . x = d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Unit normal n.
    pub normal: Unit<Vector3<f64>>,
    /// Distance d, in millimetres.
    pub distance_mm: f64,
}

/// A stripe's centre on a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardCentre {
    /// The board's number.
    pub board: usize,
    /// Column and row, in pixels, as the camera shows it.
    pub pixel_px: [f64; 2],
    /// Standard deviation across the stripe, in pixels.
    pub sigma_px: f64,
}

/// Why there is no plane.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoardsError {
    /// Numbers that are not finite, a deviation that is not positive, a board that does not exist.
    #[error("centre {0}, numbered from 0, is not finite, has no positive deviation, or names no board")]
    NotFinite(usize),
    /// The ray of a centre does not meet its board in front of the camera.
    #[error("the ray of centre {centre}, numbered from 0, does not meet board {board} in front of the camera")]
    Misses {
        /// The centre.
        centre: usize,
        /// Its board.
        board: usize,
    },
    /// Fewer than three points.
    #[error("{0} centres are too few for a plane")]
    TooFew(usize),
    /// Stripes on one board's plane alone, however many pictures of it: only the board's own plane goes through them.
    #[error("all centres, or all that agree, lie on one board's plane: two boards of different poses are needed at least")]
    OneBoard,
    /// All points lie on one line: boards that all meet the laser's plane in one line.
    #[error("all points lie on one line in space: boards of other poses are needed to tell the plane")]
    OneLine,
    /// Off one line the points lie hardly farther than their noise has them.
    #[error(
        "the points lie {spread_mm:.3} mm RMS off one line in space, which is not {TELLING} times what their noise makes of it, \
         {noise_mm:.3} mm: boards of other poses are needed to tell the plane"
    )]
    Noise {
        /// RMS distance from the line, along the plane, in millimetres.
        spread_mm: f64,
        /// RMS of what is noise of it, in millimetres.
        noise_mm: f64,
    },
    /// The plane passes the camera's centre too closely.
    #[error("the plane passes {0:.3} mm from the camera's centre: its stripe shows no depth; at least 1 mm is needed")]
    ThroughCamera(f64),
}

/// Uncertainty of a plane: of its normal turned about two directions, in radians, and of its offset, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneCovariance {
    /// The directions u and v, unit vectors in the plane, toward which a turn moves the normal.
    pub towards: [Vector3<f64>; 2],
    /// Covariance of (turn toward u, turn toward v, offset).
    pub matrix: Matrix3<f64>,
}

/// A laser's plane, and how well it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardsPlane {
    /// Unit normal k in the camera frame; the offset is positive.
    pub normal: Unit<Vector3<f64>>,
    /// Offset o of k . x = o, in millimetres.
    pub offset_mm: f64,
    /// Points that count, centre by centre.
    pub used: Vec<bool>,
    /// Signed distance of each point from the plane, in millimetres.
    pub residuals_mm: Vec<f64>,
    /// Signed distance of each centre from the plane's stripe, in pixels.
    pub residuals_px: Vec<f64>,
    /// Scatter of the centres that count, over their stated deviations: 1 where these are right.
    pub scatter: f64,
    /// From single points, scaled by how far they lie off.
    pub covariance: PlaneCovariance,
    /// From whole boards; `None` of fewer than five.
    pub covariance_by_board: Option<PlaneCovariance>,
}

/// A point on a board, and how it moves with its pixel.
struct Seen {
    board: usize,
    at: Vector3<f64>,
    /// d at / d u, d at / d v, as rows.
    by_pixel: Matrix2x3<f64>,
    /// As stated.
    sigma_px: f64,
    /// With what the stated deviations leave out.
    deviation_px: f64,
}

/// Planes through three points that are tried as a start.
const TRIES: usize = 400;
/// Refits with new weights.
const REFITS: usize = 30;
/// Tukey's constant, in standard deviations: 95 % efficient on Gaussian noise.
const TUKEY: f64 = 4.685;
/// Median of |x| of a Gaussian, over its deviation.
const MEDIAN: f64 = 0.674_489_75;
/// Fewest boards whose scatter says anything: three parameters are taken from it.
const CLUSTERS: usize = 5;
/// Points within this share of their length of a line lie on it.
const STRAIGHT: f64 = 1e-3;
/// What tells a plane, the spread of its points across their main line, must be this many times the spread that noise gives them.
/// Where all boards meet the laser's plane in one line, the two are the same but for chance: 1.
const TELLING: f64 = 3.0;
/// Boards of normals and distances as near as this, as a share, are one plane given twice: tables have no more digits.
const SAME: f64 = 1e-6;

impl BoardsPlane {
    /// Fits the plane.
    ///
    /// # Errors
    /// Centres that cannot be, and sets that leave the plane open.
    pub fn of(lens: &Lens, boards: &[Board], centres: &[BoardCentre]) -> Result<Self, BoardsError> {
        let mut seen =
            centres.iter().enumerate().map(|(index, centre)| see(lens, boards, index, centre)).collect::<Result<Vec<_>, _>>()?;
        if seen.len() < 3 {
            return Err(BoardsError::TooFew(seen.len()));
        }
        let plane_of = same_planes(boards);
        if !has_several(seen.iter().map(|seen| plane_of[seen.board])) {
            return Err(BoardsError::OneBoard);
        }
        let mut plane = start(&seen, &plane_of).ok_or(BoardsError::OneLine)?;
        let mut weights = vec![0.0; seen.len()];
        for _ in 0..REFITS {
            admit_what_is_missing(&mut seen, &plane);
            let scale = scale(&seen, &plane);
            for (weight, seen) in weights.iter_mut().zip(&seen) {
                let reach = plane.residual_px(seen) / (seen.deviation_px * TUKEY * scale);
                let keep = (1.0 - reach * reach).max(0.0);
                let precision = 1.0 / (seen.deviation_px * plane.gradient(seen).max(f64::MIN_POSITIVE));
                *weight = keep * keep * precision * precision;
            }
            plane = fit(&seen, &weights).ok_or(BoardsError::OneLine)?;
        }
        let used = seen.iter().zip(&weights).filter(|(_, weight)| **weight > 0.0);
        if !has_several(used.map(|(seen, _)| plane_of[seen.board])) {
            return Err(BoardsError::OneBoard);
        }
        is_told(&seen, &weights)?;
        if plane.offset.abs() < 1.0 {
            return Err(BoardsError::ThroughCamera(plane.offset.abs()));
        }
        Ok(plane.told(&seen, &weights))
    }
}

/// The point that a centre shows.
fn see(lens: &Lens, boards: &[Board], index: usize, centre: &BoardCentre) -> Result<Seen, BoardsError> {
    let BoardCentre { board, pixel_px: [u, v], sigma_px } = *centre;
    let sound = u.abs() < 1e6 && v.abs() < 1e6 && sigma_px > 0.0 && sigma_px < 1e6;
    let Some(plane) = boards.get(board).filter(|_| sound) else { return Err(BoardsError::NotFinite(index)) };
    let ray = lens.ray(u, v);
    let (n, slant) = (plane.normal.into_inner(), plane.normal.dot(&ray));
    let at = ray * (plane.distance_mm / slant);
    let in_front = at.z > 0.0 && at.iter().all(|x| x.is_finite());
    if !in_front {
        return Err(BoardsError::Misses { centre: index, board });
    }
    // The point stays on the board: x = r d / (n . r).
    let [by_u, by_v] = lens.ray_by_pixel(&ray).map(|by| (by - ray * (n.dot(&by) / slant)) * (plane.distance_mm / slant));
    let by_pixel = Matrix2x3::from_rows(&[by_u.transpose(), by_v.transpose()]);
    Ok(Seen { board, at, by_pixel, sigma_px, deviation_px: sigma_px })
}

/// A plane k . x = offset on trial.
#[derive(Clone, Copy)]
struct Trial {
    normal: Vector3<f64>,
    offset: f64,
}

impl Trial {
    fn residual_mm(&self, seen: &Seen) -> f64 {
        self.normal.dot(&seen.at) - self.offset
    }

    /// Millimetres off the plane a pixel across the stripe.
    fn gradient(&self, seen: &Seen) -> f64 {
        let by: Vector2<f64> = seen.by_pixel * self.normal;
        by.norm()
    }

    fn residual_px(&self, seen: &Seen) -> f64 {
        self.residual_mm(seen) / self.gradient(seen).max(f64::MIN_POSITIVE)
    }

    fn told(self, seen: &[Seen], weights: &[f64]) -> BoardsPlane {
        let Self { normal, offset } = if self.offset < 0.0 { Self { normal: -self.normal, offset: -self.offset } } else { self };
        let plane = Self { normal, offset };
        // Any direction that is not near the normal's.
        let aside = if normal.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let first = normal.cross(&aside).normalize();
        let towards = [first, normal.cross(&first)];
        let mut information = Matrix3::zeros();
        let mut of_board = vec![Vector3::zeros(); seen.iter().map(|seen| seen.board + 1).max().unwrap_or(0)];
        let (mut squares, mut stated, mut count) = (0.0, 0.0, 0_usize);
        for (seen, weight) in seen.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
            let slope = Vector3::new(towards[0].dot(&seen.at), towards[1].dot(&seen.at), -1.0);
            information += slope * slope.transpose() * *weight;
            of_board[seen.board] += slope * (*weight * plane.residual_mm(seen));
            let over = |deviation: f64| plane.residual_px(seen) / deviation;
            squares += over(seen.deviation_px) * over(seen.deviation_px);
            stated += over(seen.sigma_px) * over(seen.sigma_px);
            count += 1;
        }
        let free = count.saturating_sub(3).max(1) as f64;
        let (variance, scatter) = (squares / free, (stated / free).sqrt());
        let inverse = inverse(&information);
        let boards: Vec<_> = of_board.iter().filter(|sum| sum.norm_squared() > 0.0).collect();
        let by_board = (boards.len() >= CLUSTERS).then(|| {
            let meat: Matrix3<f64> = boards.iter().map(|sum| *sum * sum.transpose()).sum();
            let few = boards.len() as f64 / (boards.len() - 3) as f64;
            PlaneCovariance { towards, matrix: inverse * meat * inverse * few }
        });
        BoardsPlane {
            normal: Unit::new_normalize(normal),
            offset_mm: offset,
            used: weights.iter().map(|weight| *weight > 0.0).collect(),
            residuals_mm: seen.iter().map(|seen| plane.residual_mm(seen)).collect(),
            residuals_px: seen.iter().map(|seen| plane.residual_px(seen)).collect(),
            scatter,
            covariance: PlaneCovariance { towards, matrix: inverse * variance },
            covariance_by_board: by_board,
        }
    }
}

/// The inverse of a positive matrix whose entries differ in size.
fn inverse(information: &Matrix3<f64>) -> Matrix3<f64> {
    let scale = information.diagonal().map(|value| 1.0 / value.max(f64::MIN_POSITIVE).sqrt());
    let scaled = Matrix3::from_fn(|i, j| information[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.try_inverse().unwrap_or_else(|| Matrix3::from_element(f64::INFINITY));
    Matrix3::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j])
}

/// Adds to each centre's variance what the middle of all centres is off beyond the middle of what they state.
fn admit_what_is_missing(seen: &mut [Seen], plane: &Trial) {
    let mut sizes: Vec<_> = seen.iter().map(|seen| plane.residual_px(seen).abs()).collect();
    let mut stated: Vec<_> = seen.iter().map(|seen| seen.sigma_px).collect();
    let (found, stated) = (median(&mut sizes) / MEDIAN, median(&mut stated));
    let missing = (found * found - stated * stated).max(0.0);
    seen.iter_mut().for_each(|seen| seen.deviation_px = (seen.sigma_px * seen.sigma_px + missing).sqrt());
}

/// Robust scatter of the residuals over their deviations: the median of their size.
fn scale(seen: &[Seen], plane: &Trial) -> f64 {
    let mut sizes: Vec<_> = seen.iter().map(|seen| (plane.residual_px(seen) / seen.deviation_px).abs()).collect();
    // Not quite nothing: exact centres have a plane too.
    (median(&mut sizes) / MEDIAN).max(1e-9)
}

fn median(sizes: &mut [f64]) -> f64 {
    let middle = sizes.len() / 2;
    *sizes.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Of each board the first one that has the same plane.
fn same_planes(boards: &[Board]) -> Vec<usize> {
    let is_same = |a: &Board, b: &Board| {
        let apart = (a.normal.into_inner() * a.distance_mm - b.normal.into_inner() * b.distance_mm).norm();
        apart <= SAME * a.distance_mm.abs()
    };
    boards.iter().map(|board| boards.iter().position(|other| is_same(board, other)).unwrap_or(0)).collect()
}

fn has_several(mut planes: impl Iterator<Item = usize>) -> bool {
    planes.next().is_some_and(|first| planes.any(|other| other != first))
}

/// Weighted scatter of points about their middle, and the sum of the weights.
fn scatter<'s>(points: impl Iterator<Item = (&'s Seen, &'s f64)> + Clone) -> (Matrix3<f64>, f64, Vector3<f64>) {
    let total: f64 = points.clone().map(|(_, weight)| *weight).sum();
    let middle = points.clone().map(|(seen, weight)| seen.at * *weight).sum::<Vector3<f64>>() / total;
    (points.map(|(seen, weight)| (seen.at - middle) * (seen.at - middle).transpose() * *weight).sum(), total, middle)
}

/// Eigenvalues of a scatter, the least first, and their directions.
fn axes(scatter: Matrix3<f64>) -> [(f64, Vector3<f64>); 3] {
    let eigen = scatter.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    order.map(|i| (eigen.eigenvalues[i], eigen.eigenvectors.column(i).into_owned()))
}

/// Whether the points that count span a plane, and do not only seem to by their noise.
///
/// What is noise is judged twice, and the larger counts: by what the centres' deviations make of a point across the main line, and, without
/// any word of theirs, by how far the points of each board lie off a line of their own, which a flat sheet of light makes there.
fn is_told(seen: &[Seen], weights: &[f64]) -> Result<(), BoardsError> {
    let counting = || seen.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    let (all, total, _) = scatter(counting());
    let [_, (second, across), _] = axes(all / total);
    let stated = counting().map(|(seen, weight)| {
        let deviation_mm = seen.deviation_px * (seen.by_pixel * across).norm();
        deviation_mm * deviation_mm * weight
    });
    let stated = stated.sum::<f64>() / total;
    let boards = seen.iter().map(|seen| seen.board + 1).max().unwrap_or(0);
    let (mut off_line, mut free) = (0.0, 0.0);
    for board in 0..boards {
        let points = counting().filter(|(seen, _)| seen.board == board);
        let count = points.clone().count();
        // Through two points there is always a line.
        if count > 2 {
            let (of_board, share, _) = scatter(points);
            let [_, (off, _), _] = axes(of_board);
            off_line += off.max(0.0);
            free += share * (count - 2) as f64 / count as f64;
        }
    }
    let seen_mm2 = if free > 0.0 { off_line / free } else { 0.0 };
    let (spread_mm, noise_mm) = (second.max(0.0).sqrt(), stated.max(seen_mm2).sqrt());
    // Numbers that are not finite are refused, too.
    let is_enough = spread_mm > TELLING * noise_mm;
    if is_enough { Ok(()) } else { Err(BoardsError::Noise { spread_mm, noise_mm }) }
}

/// The plane through three points from which the middle one of all points is least far (Rousseeuw 1984).
///
/// Three stretches of a low-discrepancy sequence choose the points: the same ones every time. Not all of them are of one board: from the
/// board's own plane each of its points is nothing far.
fn start(seen: &[Seen], plane_of: &[usize]) -> Option<Trial> {
    let count = seen.len();
    let mut best: Option<(f64, Trial)> = None;
    // Of thousands, some hundreds tell the median well enough.
    let stride = count.div_ceil(600);
    for attempt in 0..TRIES {
        let index = |step: f64, start: f64| {
            let share = start + step * (attempt + 1) as f64;
            (((share - share.floor()) * count as f64) as usize).min(count - 1)
        };
        // Powers of the plastic number's inverse (Roberts 2018), and of its kin in three dimensions.
        let chosen = [index(0.819_172_5, 0.0), index(0.671_043_6, 0.3), index(0.549_700_5, 0.7)];
        if !has_several(chosen.iter().map(|i| plane_of[seen[*i].board])) {
            continue;
        }
        let [a, b, c] = chosen.map(|i| seen[i].at);
        let cross = (b - a).cross(&(c - a));
        let longest = (b - a).norm_squared().max((c - a).norm_squared());
        // Not of points that coincide, either.
        let is_triangle = cross.norm() > STRAIGHT * longest;
        if !is_triangle {
            continue;
        }
        let normal = cross.normalize();
        let trial = Trial { normal, offset: normal.dot(&a) };
        let mut sizes: Vec<_> = seen.iter().step_by(stride).map(|seen| (trial.residual_px(seen) / seen.sigma_px).abs()).collect();
        let middle = median(&mut sizes);
        if best.as_ref().is_none_or(|(least, _)| middle < *least) {
            best = Some((middle, trial));
        }
    }
    best.map(|(_, trial)| trial)
}

/// The plane of least weighted squares; `None` where the points lie on a line.
fn fit(seen: &[Seen], weights: &[f64]) -> Option<Trial> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let (scatter, _, middle) = scatter(seen.iter().zip(weights));
    let [(_, normal), (second, _), (third, _)] = axes(scatter / total);
    let spread = second > STRAIGHT * STRAIGHT * third;
    spread.then(|| Trial { normal, offset: normal.dot(&middle) })
}
