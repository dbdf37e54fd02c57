//! What the filter believes, and the two things that change it: a step of the wheels, and a look at the walls.
//!
//! State: [lateral offset, heading, width, 1 / effective track, x_ICR, u1, u2, u3]. The last three carry the walls' coloured error. A
//! perception's errors are not new in every frame (stripes lie on the same spangles for a while, and are read with the same bias), and
//! a filter that takes them for white believes a mean of n frames sqrt(n) times better than it is. So the error of z = (heading, left
//! distance, right distance) is taken as
//!
//! e = L u + white,  L L^T = a R,  white ~ N(0, (1 - a) R),  u' = f u + sqrt(1 - f^2) N(0, I),  f = exp(-way / correlation length)
//!
//! with R as the perception states it for that frame, and a the share of it that persists (state augmentation for coloured measurement
//! noise: A. Gelb, "Applied Optimal Estimation", 1974, section 4.5). A robot that stands learns nothing more by looking again, but for
//! the white share. Order and Cholesky factor: u1 is the heading's error; u2 and u3 are what left and right err besides.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::motion::{HEADING, ICR, LATERAL, PER_TRACK, STATES, Step, Travel, WIDTH};
use super::params::EstimationParams;
use crate::perception::side_walls::SideWalls;

/// States with those of the walls' errors.
pub(super) const ALL: usize = STATES + 3;

/// Mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Belief {
    pub(super) mean: SVector<f64, ALL>,
    pub(super) covariance: SMatrix<f64, ALL, ALL>,
}

/// A look at the walls, as the filter takes it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    by_state: SMatrix<f64, 3, ALL>,
    white: Matrix3<f64>,
    off: Vector3<f64>,
    /// Of the covariance of `off`.
    inverse: Matrix3<f64>,
    /// Degrees of freedom.
    pub(super) freedom: usize,
}

impl Look {
    /// Normalised innovation squared.
    pub(super) fn nis(&self) -> f64 {
        self.off.dot(&(self.inverse * self.off))
    }
}

impl Belief {
    /// Before anything was seen: somewhere in a duct of this width.
    pub(super) fn unseen(params: &EstimationParams, width_m: f64, track_m: f64) -> Self {
        let mut mean = SVector::zeros();
        (mean[WIDTH], mean[PER_TRACK]) = (width_m, 1.0 / track_m);
        let mut deviation = SVector::<f64, ALL>::repeat(1.0);
        deviation[WIDTH] = params.width_m;
        deviation[PER_TRACK] = params.track_ratio / track_m;
        deviation[ICR] = params.icr_m;
        let mut belief = Self { mean, covariance: SMatrix::from_diagonal(&deviation.component_mul(&deviation)) };
        belief.lose_place(width_m);
        belief
    }

    /// Forgets where the robot stands, and with which errors the walls were seen; not what its duct and its wheels are like.
    pub(super) fn lose_place(&mut self, width_m: f64) {
        for (i, deviation) in [(LATERAL, width_m / 2.0), (HEADING, HEADING_UNSEEN_RAD), (5, 1.0), (6, 1.0), (7, 1.0)] {
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = deviation * deviation;
            self.mean[i] = 0.0;
        }
    }

    /// Takes up another place, each figure with its deviation, in another duct.
    pub(super) fn enter(&mut self, lateral_m: [f64; 2], heading_rad: [f64; 2], width_m: [f64; 2]) {
        self.lose_place(width_m[0]);
        for (i, [value, deviation]) in [(LATERAL, lateral_m), (HEADING, heading_rad), (WIDTH, width_m)] {
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = deviation * deviation;
            self.mean[i] = value;
        }
    }

    /// Holds the width for no surer than this deviation.
    pub(super) fn widen_width(&mut self, deviation_m: f64) {
        let variance = &mut self.covariance[(WIDTH, WIDTH)];
        *variance = variance.max(deviation_m * deviation_m);
    }

    /// The robot's own part of the mean.
    pub(super) fn state(&self) -> SVector<f64, STATES> {
        self.mean.fixed_rows::<STATES>(0).into_owned()
    }

    /// Carries it on by what the wheels turned. `count_m`: way of one encoder count; `track_m`: the effective track as told.
    pub(super) fn advance(&mut self, travel: Travel, params: &EstimationParams, count_m: f64, track_m: f64) {
        let step = Step::of(&self.state(), travel);
        // Turning on the spot brings the walls other errors too.
        let way = (travel.left_m.abs() + travel.right_m.abs()) / 2.0;
        let persisting = libm::exp(-way / params.correlation_m);
        let mut by_state = SMatrix::<f64, ALL, ALL>::identity();
        by_state.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(&step.by_state);
        (STATES..ALL).for_each(|i| by_state[(i, i)] = persisting);

        let mut noise = SMatrix::<f64, ALL, ALL>::zeros();
        let square = |x: f64| x * x;
        // A period's count is the difference of two readings, each off by at most half a count: q^2 / 12 twice. Its errors cancel
        // from one period to the next, so that taking them for independent is on the safe side; a wheel that stands adds none.
        let of_side = |way_m: f64| {
            let counted = if way_m == 0.0 { 0.0 } else { square(count_m) / 6.0 };
            counted + square(params.wheel_slip_m) * way_m.abs()
        };
        let (left, right) = (of_side(travel.left_m), of_side(travel.right_m));
        let per_track = self.mean[PER_TRACK];
        // The sides' errors add up in the way and differ in the turn.
        let (way_way, turn_turn, way_turn) =
            ((left + right) / 4.0, (left + right) * square(per_track), (right - left) * per_track / 2.0);
        let turn_turn = turn_turn + square(params.turn_slip_rad) * step.turn_rad.abs();
        let [lateral_turn, heading_turn] = [step.by_turn[0], step.by_turn[1]];
        noise[(LATERAL, LATERAL)] = square(step.by_way) * way_way
            + 2.0 * step.by_way * lateral_turn * way_turn
            + square(lateral_turn) * turn_turn
            + square(params.side_slip_m) * way;
        noise[(LATERAL, HEADING)] = heading_turn * (step.by_way * way_turn + lateral_turn * turn_turn);
        noise[(HEADING, LATERAL)] = noise[(LATERAL, HEADING)];
        noise[(HEADING, HEADING)] = square(heading_turn) * turn_turn;
        noise[(WIDTH, WIDTH)] = square(params.width_walk_m) * way;
        noise[(PER_TRACK, PER_TRACK)] = square(params.track_walk_ratio / track_m) * way;
        noise[(ICR, ICR)] = square(params.icr_walk_m) * way;
        (STATES..ALL).for_each(|i| noise[(i, i)] = 1.0 - square(persisting));

        self.mean.fixed_rows_mut::<STATES>(0).copy_from(&step.state);
        (STATES..ALL).for_each(|i| self.mean[i] *= persisting);
        self.covariance = symmetric(&(by_state * self.covariance * by_state.transpose() + noise));
    }

    /// What these walls would be to it; `None` if their covariance is none.
    pub(super) fn look(&self, walls: &SideWalls, params: &EstimationParams) -> Option<Look> {
        let seen = [Some(walls.heading_rad), walls.left_m, walls.right_m];
        let mut stated = walls.covariance * (params.stated_ratio * params.stated_ratio);
        // What was not seen becomes a row that says nothing: no derivative, no error, variance one.
        for i in (0..3).filter(|i| seen[*i].is_none()) {
            stated.row_mut(i).fill(0.0);
            stated.column_mut(i).fill(0.0);
            stated[(i, i)] = 1.0;
        }
        let root = stated.cholesky()?.unpack() * params.correlated_share.sqrt();
        let mut by_state = SMatrix::<f64, 3, ALL>::zeros();
        by_state[(0, HEADING)] = 1.0;
        (by_state[(1, LATERAL)], by_state[(1, WIDTH)]) = (-1.0, 0.5);
        (by_state[(2, LATERAL)], by_state[(2, WIDTH)]) = (1.0, 0.5);
        by_state.fixed_view_mut::<3, 3>(0, STATES).copy_from(&root);
        let expected = by_state * self.mean;
        let mut off = Vector3::zeros();
        for i in 0..3 {
            match seen[i] {
                Some(value) => off[i] = value - expected[i],
                None => by_state.row_mut(i).fill(0.0),
            }
        }
        let mut white = stated * (1.0 - params.correlated_share);
        (0..3).filter(|i| seen[*i].is_none()).for_each(|i| white[(i, i)] = 1.0);
        let spread = by_state * self.covariance * by_state.transpose() + white;
        let inverse = spread.try_inverse()?;
        let sound = off.iter().chain(inverse.iter()).all(|value| value.is_finite());
        sound.then_some(Look { by_state, white, off, inverse, freedom: walls.freedom() })
    }

    /// Takes a look in, in Joseph's form: the covariance stays symmetric and positive whatever the gain's rounding (R. S. Bucy, P. D.
    /// Joseph, "Filtering for Stochastic Processes", 1968).
    pub(super) fn take(&mut self, look: &Look) {
        let gain = self.covariance * look.by_state.transpose() * look.inverse;
        self.mean += gain * look.off;
        let left = SMatrix::<f64, ALL, ALL>::identity() - gain * look.by_state;
        self.covariance = symmetric(&(left * self.covariance * left.transpose() + gain * look.white * gain.transpose()));
    }

    /// Whether every number of it is one, and the track one that a robot can have.
    pub(super) fn is_sound(&self, track_m: f64) -> bool {
        let finite = self.mean.iter().chain(self.covariance.iter()).all(|value| value.is_finite());
        finite && (0.25..4.0).contains(&(self.mean[PER_TRACK] * track_m))
    }
}

/// Deviation of the heading before anything was seen, in radians: wider than any heading at which both walls could be.
const HEADING_UNSEEN_RAD: f64 = 0.7;

fn symmetric(matrix: &SMatrix<f64, ALL, ALL>) -> SMatrix<f64, ALL, ALL> {
    (matrix + matrix.transpose()) * 0.5
}
