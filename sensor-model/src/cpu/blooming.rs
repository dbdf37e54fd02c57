//! Charge that runs over along the columns of a CCD.
//!
//! Of what a pixel holds beyond the full well the share `blooming` spills, half up and half down the column; the rest is drained.
//! On its way the charge fills what room it finds in each pixel, and what is left at the column's end is lost. First all that
//! runs down is dealt with, from the top; then all that runs up, from the bottom, into the room that is left.

/// Moves the charge of an image of mean electrons, rows of `stride` values.
pub(super) fn bloom(mean_e: &mut [f32], stride: usize, well_e: f32, blooming: f32, spilt: &mut Spilt) {
    let share = 0.5 * blooming;
    let Spilt { own, carried } = spilt;
    own.clear();
    own.extend_from_slice(mean_e);
    carried.clear();
    carried.resize(stride, 0.0);
    let rows = mean_e.len() / stride;
    let order = |upward: bool| (0..rows).map(move |i| if upward { rows - 1 - i } else { i });
    for upward in [false, true] {
        carried.fill(0.0);
        for row in order(upward) {
            let line = row * stride..(row + 1) * stride;
            for ((mean, own), carried) in mean_e[line.clone()].iter_mut().zip(&own[line]).zip(carried.iter_mut()) {
                let room = if *mean < well_e { well_e - *mean } else { 0.0 };
                let taken = if *carried < room { *carried } else { room };
                let beyond = if *own > well_e { *own - well_e } else { 0.0 };
                *mean += taken;
                *carried = *carried - taken + share * beyond;
            }
        }
    }
}

/// Working memory.
#[derive(Debug, Default)]
pub(super) struct Spilt {
    /// The image before.
    own: Vec<f32>,
    /// Charge on its way in each column.
    carried: Vec<f32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charge_spills_evenly_fills_the_nearest_pixels_and_is_not_lost_inside() {
        // One column: 1000 beyond a full well of 100, in rooms of 100; 80 % spill.
        let mut column = vec![0.0; 21];
        column[10] = 1100.0;
        bloom(&mut column, 1, 100.0, 0.8, &mut Spilt::default());
        for away in 1..=4 {
            assert_eq!((column[10 - away], column[10 + away]), (100.0, 100.0));
        }
        assert_eq!((column[5], column[15]), (0.0, 0.0));
        assert_eq!(column.iter().sum::<f32>(), 1100.0 + 800.0);
    }

    #[test]
    fn columns_keep_to_themselves_and_nothing_moves_below_the_full_well() {
        let mut image = vec![50.0, 50.0, 500.0, 50.0, 50.0, 50.0];
        bloom(&mut image, 2, 100.0, 1.0, &mut Spilt::default());
        assert_eq!(image, [100.0, 50.0, 500.0, 50.0, 100.0, 50.0]);
        let mut dim = vec![99.0, 1.0, 3.0];
        bloom(&mut dim, 1, 100.0, 1.0, &mut Spilt::default());
        assert_eq!(dim, [99.0, 1.0, 3.0]);
    }

    /// Two full pixels with a single one between them: what the upper spills downward takes the room first, and all that the lower
    /// spills upward goes on beyond the upper.
    #[test]
    fn what_runs_down_goes_before_what_runs_up() {
        let mut column = vec![0.0; 21];
        column[8] = 100.0 + 2.0 * 200.0;
        column[10] = 100.0 + 2.0 * 400.0;
        bloom(&mut column, 1, 100.0, 1.0, &mut Spilt::default());
        let full = |rows: std::ops::Range<usize>| column[rows].iter().filter(|charge| **charge >= 100.0).count();
        // Down: 200, of which 100 stay in between; with 400 more that is 500 below. Up: 400 and 200 above, all beyond the upper.
        assert_eq!((full(0..8), column[9], full(11..21)), (6, 100.0, 5));
        assert_eq!(column.iter().sum::<f32>(), 500.0 + 900.0 + 2.0 * 200.0 + 2.0 * 400.0);
    }
}
