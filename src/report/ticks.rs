//! Round numbers along an axis.

/// Round numbers within [`from`, `to`], at most about `count` of them, and how many decimals they need.
pub fn ticks(from: f64, to: f64, count: usize) -> (Vec<f64>, usize) {
    let step = step((to - from) / count.max(1) as f64);
    let first = libm::ceil(from / step - 1e-9);
    let last = libm::floor(to / step + 1e-9);
    let values = (0..=(last - first).max(0.0) as usize).map(|i| (first + i as f64) * step).collect();
    let decimals = (-libm::floor(libm::log10(step) + 1e-9)).clamp(0.0, 12.0) as usize;
    (values, decimals)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`; 1 where that is not positive.
pub fn step(least: f64) -> f64 {
    if !(least > 0.0 && least.is_finite()) {
        return 1.0;
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(least)));
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn axes_have_round_numbers() {
        assert_eq!(ticks(0.0, 20.0, 10), (vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0], 0));
        let (values, decimals) = ticks(-0.07, 0.11, 5);
        let text: Vec<_> = values.iter().map(|v| format!("{v:.decimals$}")).collect();
        assert_eq!(text, ["-0.05", "0.00", "0.05", "0.10"]);
        assert_eq!(ticks(3.0, 3.0, 4).0, [3.0]);
    }

    proptest! {
        #[test]
        fn there_are_some_and_not_too_many(from in -1e3f64..1e3, span in 1e-3f64..1e4, count in 2usize..12) {
            let (values, _) = ticks(from, from + span, count);
            // 1, 2, 5, 10: a step is at most 2.5 times the one asked for, so at least two fifths of the ticks are there.
            prop_assert!(values.len() <= count + 1 && values.len() + 1 >= count * 2 / 5, "{values:?}");
        }
    }
}
