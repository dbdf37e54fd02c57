//! The chi-square distribution: what a normalised square may be by chance.

/// Probability that a chi-square of `freedom` degrees stays below `x`: the regularised lower incomplete gamma function
/// P(freedom / 2, x / 2) (Abramowitz and Stegun 26.4.19), by its series (6.5.29), whose terms are all positive.
///
/// Good to 1e-10 up to a thousand degrees of freedom; `freedom` of 0 gives 1.
pub fn probability(freedom: usize, x: f64) -> f64 {
    if freedom == 0 {
        return 1.0;
    }
    if x.is_nan() || x <= 0.0 {
        return 0.0;
    }
    let (a, x) = (freedom as f64 / 2.0, x / 2.0);
    // Far beyond the mean the series would need many terms for a one.
    if x > a + 40.0 * (a.sqrt() + 1.0) {
        return 1.0;
    }
    let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
    while term > 1e-16 * sum {
        n += 1.0;
        term *= x / n;
        sum += term;
    }
    (sum * libm::exp(a * libm::log(x) - x - libm::lgamma(a))).min(1.0)
}

/// The x below which a chi-square of `freedom` degrees stays with probability `p`, 0 < p < 1, by bisection.
pub fn quantile(freedom: usize, p: f64) -> f64 {
    let (mut low, mut high) = (0.0, freedom as f64 + 40.0 * ((freedom as f64).sqrt() + 1.0));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if probability(freedom, middle) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The two-sided band that the mean of `samples` independent chi-squares of `freedom` degrees stays in with probability `p`
/// (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, section 5.4.2).
pub fn mean_band(freedom: usize, samples: usize, p: f64) -> [f64; 2] {
    let of = |tail: f64| quantile(freedom * samples, tail) / samples as f64;
    [of((1.0 - p) / 2.0), of((1.0 + p) / 2.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz and Stegun, table 26.8.
        for (freedom, p, x) in
            [(1, 0.95, 3.84146), (2, 0.99, 9.21034), (3, 0.025, 0.215795), (3, 0.999, 16.2662), (100, 0.95, 124.342)]
        {
            assert!((quantile(freedom, p) / x - 1.0).abs() < 1e-5, "{freedom} {p}: {}", quantile(freedom, p));
        }
        // Two degrees: 1 - exp(-x / 2).
        assert!((probability(2, 5.0) - (1.0 - libm::exp(-2.5))).abs() < 1e-12);
    }

    #[test]
    fn a_hundred_runs_of_three_states() {
        let [low, high] = mean_band(3, 100, 0.95);
        // Normal approximation: 3 +- 1.96 sqrt(6 / 100), 2.52 to 3.48; the chi-square is a little skewed.
        assert!((low - 2.54).abs() < 0.02 && (high - 3.50).abs() < 0.02, "{low} {high}");
    }
}
