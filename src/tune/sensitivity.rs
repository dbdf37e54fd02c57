//! How the costs of what was tried hang together with a parameter.

use super::search::{Search, Trial};

/// Value of a parameter and cost by an objective, of all candidates that had all of their runs and kept the constraints.
pub fn against(search: &Search, parameter: usize, objective: usize) -> Vec<[f64; 2]> {
    let of = |trial: &Trial| Some([trial.values.as_ref()?[parameter].number()?, trial.costs.objectives[objective]]);
    search
        .trials
        .iter()
        .filter(|trial| trial.is_full && trial.costs.is_feasible() && trial.costs.is_measured())
        .filter_map(of)
        .collect()
}

/// Spearman's rank correlation; `None` where one of the two does not vary.
pub fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    let ranks = |which: usize| {
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| pairs[*a][which].total_cmp(&pairs[*b][which]));
        let mut ranks = vec![0.0; pairs.len()];
        let mut from = 0;
        while from < order.len() {
            // Equal ones share their mean rank.
            let equal = order[from..].iter().take_while(|i| pairs[**i][which] == pairs[order[from]][which]).count();
            for index in &order[from..from + equal] {
                ranks[*index] = from as f64 + (equal - 1) as f64 / 2.0;
            }
            from += equal;
        }
        ranks
    };
    let (x, y) = (ranks(0), ranks(1));
    let middle = (pairs.len() as f64 - 1.0) / 2.0;
    let sum = |of: &dyn Fn(usize) -> f64| (0..pairs.len()).map(of).sum::<f64>();
    let covariance = sum(&|i| (x[i] - middle) * (y[i] - middle));
    let spread = (sum(&|i| (x[i] - middle) * (x[i] - middle)) * sum(&|i| (y[i] - middle) * (y[i] - middle))).sqrt();
    (spread > 0.0).then(|| covariance / spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_correlated() {
        let of = |values: &[[f64; 2]]| rank_correlation(values);
        assert_eq!(of(&[[1.0, 10.0], [2.0, 100.0], [3.0, 1e6]]), Some(1.0));
        assert_eq!(of(&[[1.0, 3.0], [2.0, 2.0], [3.0, 1.0]]), Some(-1.0));
        assert_eq!(of(&[[1.0, 3.0], [2.0, 3.0]]), None);
        // Spearman 1904's formula with one tie: ranks 0, 1.5, 1.5, 3 against 0 to 3.
        let tied = of(&[[1.0, 0.0], [2.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).expect("they vary");
        assert!((tied - 4.5 / (4.5_f64 * 5.0).sqrt()).abs() < 1e-12, "{tied}");
    }
}
