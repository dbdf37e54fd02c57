//! Nonlinear least squares in fixed memory (Levenberg 1944, Marquardt 1963), with weights of a robust loss, and covariance.
//!
//! Parameters may be held: their columns are left out. Derivatives are central differences: for functions that are smooth over
//! [`STEP`], exact to ten digits.

use nalgebra::{SMatrix, SVector, Vector3};

/// Step of the differences, in each parameter's own unit: choose units in which the function bends little over it.
pub const STEP: f64 = 1e-5;
/// Most accepted steps; well-posed problems take ten.
const STEPS: usize = 60;
/// Most refused steps in a row.
const REFUSALS: usize = 12;

/// What is to be made small: N parameters, and observations that each leave three residuals.
pub trait Problem<const N: usize> {
    /// Where parameters are: a point of some manifold.
    type State: Clone;

    /// How many observations there are.
    fn observations(&self) -> usize;

    /// The residual of an observation, in units of its standard deviation; `None` where it has none.
    fn residual(&self, state: &Self::State, observation: usize) -> Option<Vector3<f64>>;

    /// The state moved by small amounts of each parameter.
    fn moved(&self, state: &Self::State, by: &SVector<f64, N>) -> Self::State;
}

/// Normal equations at a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Normal<const N: usize> {
    /// Sum of w J^T J; one on the diagonal of held parameters.
    pub information: SMatrix<f64, N, N>,
    /// Sum of w J^T r.
    pub gradient: SVector<f64, N>,
    /// Sum of w r^2.
    pub cost: f64,
}

/// Sum of w r^2; `None` where a residual does not exist.
fn cost<const N: usize, P: Problem<N>>(problem: &P, state: &P::State, weights: &[f64]) -> Option<f64> {
    let mut sum = 0.0;
    for (observation, weight) in weights.iter().enumerate() {
        sum += weight * problem.residual(state, observation)?.norm_squared();
    }
    sum.is_finite().then_some(sum)
}

/// The normal equations of the parameters that are free.
pub fn normal<const N: usize, P: Problem<N>>(
    problem: &P,
    state: &P::State,
    weights: &[f64],
    free: &[bool; N],
) -> Option<Normal<N>> {
    let beside = |axis: usize, step: f64| {
        let mut by = SVector::<f64, N>::zeros();
        by[axis] = step;
        problem.moved(state, &by)
    };
    let sides: Vec<_> = (0..N).filter(|axis| free[*axis]).map(|axis| (axis, beside(axis, STEP), beside(axis, -STEP))).collect();
    let mut normal = Normal { information: SMatrix::zeros(), gradient: SVector::zeros(), cost: 0.0 };
    for (observation, weight) in weights.iter().enumerate() {
        let residual = problem.residual(state, observation)?;
        let mut slope = SMatrix::<f64, 3, N>::zeros();
        for (axis, ahead, behind) in &sides {
            let change = problem.residual(ahead, observation)? - problem.residual(behind, observation)?;
            slope.set_column(*axis, &(change / (2.0 * STEP)));
        }
        normal.information += slope.transpose() * slope * *weight;
        normal.gradient += slope.transpose() * residual * *weight;
        normal.cost += weight * residual.norm_squared();
    }
    for axis in (0..N).filter(|axis| !free[*axis]) {
        normal.information[(axis, axis)] = 1.0;
    }
    normal.cost.is_finite().then_some(normal)
}

/// The state of least weighted squares near `state`; `None` where residuals do not exist there.
pub fn minimise<const N: usize, P: Problem<N>>(
    problem: &P,
    mut state: P::State,
    weights: &[f64],
    free: &[bool; N],
) -> Option<P::State> {
    let mut damping = 1e-4;
    for _ in 0..STEPS {
        let here = normal(problem, &state, weights, free)?;
        let mut refusals = 0;
        let better = loop {
            let mut damped = here.information;
            for axis in 0..N {
                damped[(axis, axis)] *= 1.0 + damping;
            }
            let step = damped.cholesky().map(|cholesky| -cholesky.solve(&here.gradient));
            let there = step.map(|step| problem.moved(&state, &step));
            let after = there.as_ref().and_then(|there| cost(problem, there, weights));
            match (there, after) {
                (Some(there), Some(after)) if after < here.cost => break Some((there, after)),
                _ if refusals == REFUSALS => break None,
                _ => (damping, refusals) = (damping * 10.0, refusals + 1),
            }
        };
        let Some((there, after)) = better else { break };
        state = there;
        damping = (damping * 0.1).max(1e-12);
        if here.cost - after <= 1e-12 * here.cost {
            break;
        }
    }
    Some(state)
}

/// Weights of Cauchy's loss, log(1 + r^2 / c^2), for residuals of this length: 1 for small ones, and what lies far off counts
/// no more the farther it lies. `c` in the residuals' unit.
pub fn cauchy(squared: f64, c: f64) -> f64 {
    1.0 / (1.0 + squared / (c * c))
}

/// The inverse of the information; `None` where a free combination of parameters is not determined.
pub fn covariance<const N: usize>(normal: &Normal<N>) -> Option<SMatrix<f64, N, N>> {
    // By its diagonal first: units of parameters differ.
    let scale = normal.information.diagonal().map(|value| if value > 0.0 { 1.0 / value.sqrt() } else { 0.0 });
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| normal.information[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    let covariance = SMatrix::<f64, N, N>::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]);
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    /// y = a exp(b x) through three points an observation.
    struct Growth(Vec<[(f64, f64); 3]>);

    impl Problem<2> for Growth {
        type State = Vector2<f64>;

        fn observations(&self) -> usize {
            self.0.len()
        }

        fn residual(&self, state: &Self::State, observation: usize) -> Option<Vector3<f64>> {
            let miss = |(x, y): (f64, f64)| state[0] * libm::exp(state[1] * x) - y;
            let [p, q, r] = self.0[observation];
            Some(Vector3::new(miss(p), miss(q), miss(r)))
        }

        fn moved(&self, state: &Self::State, by: &SVector<f64, 2>) -> Self::State {
            state + by
        }
    }

    fn growth(wild: f64) -> Growth {
        let at = |x: f64| (x, 2.0 * libm::exp(-0.7 * x));
        let mut points: Vec<_> = (0..8).map(|i| f64::from(i) * 0.3).map(|x| [at(x), at(x + 0.1), at(x + 0.2)]).collect();
        points[3][1].1 += wild;
        Growth(points)
    }

    #[test]
    fn a_curve_is_found_from_afar_and_a_held_parameter_stays() {
        let problem = growth(0.0);
        let weights = vec![1.0; problem.observations()];
        let found = minimise(&problem, Vector2::new(0.3, 0.5), &weights, &[true; 2]).expect("a curve");
        assert!((found - Vector2::new(2.0, -0.7)).norm() < 1e-8, "{found}");
        let held = minimise(&problem, Vector2::new(0.3, 0.5), &weights, &[true, false]).expect("a curve");
        assert_eq!(held[1], 0.5);
    }

    #[test]
    fn one_wild_observation_is_weighed_down() {
        let problem = growth(1.0);
        let mut state = Vector2::new(1.0, 0.0);
        for _ in 0..30 {
            let weights: Vec<_> = (0..problem.observations())
                .map(|i| cauchy(problem.residual(&state, i).expect("one").norm_squared(), 0.02))
                .collect();
            state = minimise(&problem, state, &weights, &[true; 2]).expect("a curve");
        }
        assert!((state - Vector2::new(2.0, -0.7)).norm() < 2e-3, "{state}");
    }

    /// The covariance of a straight mean: N observations of three residuals each.
    #[test]
    fn covariance_is_the_inverse_of_information() {
        let problem = growth(0.0);
        let weights = vec![1.0; problem.observations()];
        let normal = normal(&problem, &Vector2::new(2.0, -0.7), &weights, &[true, true]).expect("equations");
        let covariance = covariance(&normal).expect("determined");
        assert!((covariance * normal.information - SMatrix::<f64, 2, 2>::identity()).norm() < 1e-9);
        let blind = Normal { information: SMatrix::<f64, 2, 2>::new(1.0, 1.0, 1.0, 1.0), ..normal };
        assert_eq!(super::covariance(&blind), None);
    }
}
