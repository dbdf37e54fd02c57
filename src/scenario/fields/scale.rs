//! Between the units of the file and SI, without losing a bit on the way out and in again.

/// How a number of the file becomes SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// It is SI already.
    Si,
    /// Thousandths: mm, ms, mrad.
    Milli,
    /// Degrees to radians.
    Degrees,
}

impl Scale {
    /// SI of a number of the file.
    pub fn si(self, in_file: f64) -> f64 {
        match self {
            Self::Si => in_file,
            // Divided, not multiplied by 0.001: 5 mm is then the double nearest to 0.005.
            Self::Milli => in_file / 1e3,
            Self::Degrees => in_file.to_radians(),
        }
    }

    /// The number of the file for an SI value: the shortest that [`Scale::si`] turns into the same bits again.
    ///
    /// Every value that came from a file has one. Of one that did not, the nearest is returned; reading it is then off by at
    /// most one unit in the last place.
    pub fn in_file(self, si: f64) -> f64 {
        let near = match self {
            Self::Si => return si,
            Self::Milli => si * 1e3,
            Self::Degrees => si.to_degrees(),
        };
        let reads_back = |x: &f64| self.si(*x).to_bits() == si.to_bits();
        let shortened = (0..17).filter_map(|digits| format!("{near:.digits$e}").parse().ok());
        // Multiplication and division each round once, so the number sought is within a few units in the last place.
        let neighbours = (0..4).flat_map(|n| [step(near, n), step(near, -n)]);
        shortened.chain(neighbours).find(reads_back).unwrap_or(near)
    }
}

/// The double `n` steps further from zero.
fn step(x: f64, n: i64) -> f64 {
    f64::from_bits(x.to_bits().wrapping_add_signed(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn round_numbers_come_out_round() {
        assert_eq!(Scale::Degrees.in_file(Scale::Degrees.si(6.0)), 6.0);
        assert_eq!(Scale::Degrees.in_file(90f64.to_radians()), 90.0);
        assert_eq!(Scale::Milli.in_file(0.005), 5.0);
        assert_eq!(Scale::Milli.in_file(0.0), 0.0);
    }

    proptest! {
        #[test]
        fn what_was_read_is_written_so_that_it_reads_the_same(x in -1e6f64..1e6) {
            for scale in [Scale::Si, Scale::Milli, Scale::Degrees] {
                let si = scale.si(x);
                prop_assert_eq!(scale.si(scale.in_file(si)).to_bits(), si.to_bits());
            }
        }
    }
}
