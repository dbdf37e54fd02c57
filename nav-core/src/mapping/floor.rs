//! What lies on the floor, and how thick.
//!
//! A slit that falls meets the floor ahead (1.1 m ahead of the base for the `wide` rig); on a deposit it meets it sooner, above the plane
//! of the wheels. Each lit point has a height, good for half a millimetre, and is counted in a cell of the floor, by where the robot
//! believes to be. Of a wall the robot lights another height from each place, so a cell whose heights scatter is none of the floor's.
//! Neighbouring cells that lie higher than [`THINNEST_M`] are a deposit, if they are enough in both directions. What goes across the whole
//! width and is nowhere level is none: there the floor goes uphill.
//!
//! What it does not do: a deposit thicker than [`THICKEST_M`] is an obstacle (`crate::ahead`). Cells within [`BESIDE_WALL_M`] of a wall are
//! left out, and so is the floor that is seen while the robot turns. A cell counts if two frames lit it, so the robot must not be faster
//! than half a cell a frame. A deposit that begins before the floor is first seen and never ends cannot be told from a floor.

use std::collections::BTreeMap;

use super::median;
use crate::ahead::DuctPlace;
use crate::perception::{RangePoint, Upon};

/// Edge of a cell, in metres.
pub const CELL_M: f64 = 0.025;
/// A cell that lies higher than this may be a deposit's, in metres. Of the cells of clean floors one in a thousand lies a millimetre off.
pub const THINNEST_M: f64 = 0.0025;
/// The thickest deposit, in metres.
pub const THICKEST_M: f64 = 0.06;
/// Cells nearer to a wall are left out, in metres.
pub const BESIDE_WALL_M: f64 = 0.02;
/// Fewest cells of a deposit: in all, along and across.
const FEWEST_CELLS: usize = 12;
const FEWEST_ALONG: i32 = 4;
const FEWEST_ACROSS: i32 = 2;
/// Cells so far apart along the duct hang together: the light is 40 mm long there, and in a cell at a step it lies on both.
const REACH_ALONG: i32 = 2;
/// A cell counts from so many points in so many frames.
const FEWEST_POINTS: u32 = 4;
const FEWEST_FRAMES: u32 = 2;
/// Heights in a cell of the floor scatter by less, in metres, standard deviation.
const SCATTER_M: f64 = 0.002;
/// Points farther ahead, or lower, are left out, in metres.
const FARTHEST_M: f64 = 1.5;
const LOWEST_M: f64 = -0.01;
/// Headings beyond which the robot is turning, in radians.
const TURNING_RAD: f64 = 0.3;
/// What is as wide as this share of the floor goes across the whole of it; ...
const WHOLE_SHARE: f64 = 0.8;
/// ... it is a deposit where so large a share of it is as thick as its middle one, up to this share of that, and else a floor that goes
/// uphill.
const EVEN_SHARE: f64 = 0.5;
const EVEN_WITHIN: f64 = 0.25;
/// Standard deviation of a thickness, in metres: what the cells have in common (a twentieth of a pixel, and the wheels on the floor), and a
/// share of it: at a step the light lies half beside it.
const SIGMA_M: f64 = 0.001;
const SIGMA_SHARE: f64 = 0.1;

/// A deposit on the floor of a duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deposit {
    /// The duct's number in the log.
    pub duct: usize,
    /// From where to where it lies along the duct, in its coordinates, in metres.
    pub along_m: [f64; 2],
    /// From where to where it lies across, to the left of the duct's middle, in metres: right end first.
    pub left_m: [f64; 2],
    /// Floor that it covers, in square metres.
    pub area_m2: f64,
    /// Its mean thickness, in metres.
    pub mean_m: f64,
    /// Standard deviation of that, in metres.
    pub sigma_m: f64,
    /// Its largest thickness, of a cell, in metres.
    pub largest_m: f64,
}

/// What was lit in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cell {
    points: u32,
    frames: u32,
    last: u64,
    sum_m: f64,
    squares_m2: f64,
}

impl Cell {
    /// Its height over the plane of the wheels, in metres, where it is a piece of a floor.
    fn height_m(&self) -> Option<f64> {
        let count = f64::from(self.points);
        let mean_m = self.sum_m / count;
        let variance = (self.squares_m2 / count - mean_m * mean_m).max(0.0);
        let counts = self.points >= FEWEST_POINTS && self.frames >= FEWEST_FRAMES;
        (counts && variance < SCATTER_M * SCATTER_M && mean_m <= THICKEST_M).then_some(mean_m)
    }
}

/// A cell's numbers: of its duct, along it, to the left.
type Key = (usize, i32, i32);

/// The floors of the ducts, in cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Floors {
    cells: BTreeMap<Key, Cell>,
    /// Width of each duct as it was held last, in metres.
    widths_m: Vec<f64>,
    frames: u64,
}

impl Floors {
    /// Takes in a frame that was exposed at `place` of the duct with this number.
    pub fn take(&mut self, duct: usize, place: &DuctPlace, ranges: &[RangePoint]) {
        if place.heading_rad.abs() > TURNING_RAD {
            return;
        }
        self.frames += 1;
        if self.widths_m.len() <= duct {
            self.widths_m.resize(duct + 1, 0.0);
        }
        self.widths_m[duct] = place.width_m;
        let inside_m = place.width_m / 2.0 - BESIDE_WALL_M;
        for point in ranges.iter().filter(|point| matches!(point.upon, Upon::Floor | Upon::Upright)) {
            let at = &point.point_in_base;
            let [along_m, left_m] = place.duct_from_base(at.x, at.y);
            // Twice the thickest, so that a wall that is lit above that shows as one.
            let is_low = (LOWEST_M..=2.0 * THICKEST_M).contains(&at.z);
            if !is_low || at.coords.xy().norm() > FARTHEST_M || left_m.abs() > inside_m {
                continue;
            }
            let cell = self.cells.entry((duct, number(along_m), number(left_m))).or_default();
            cell.points = cell.points.saturating_add(1);
            cell.sum_m += at.z;
            cell.squares_m2 += at.z * at.z;
            if cell.last < self.frames {
                (cell.last, cell.frames) = (self.frames, cell.frames.saturating_add(1));
            }
        }
    }

    /// The stretch of a duct whose floor was seen, in metres along it; `None` if none was.
    pub fn seen_m(&self, duct: usize) -> Option<[f64; 2]> {
        let along = || {
            self.cells
                .range((duct, i32::MIN, i32::MIN)..(duct + 1, i32::MIN, i32::MIN))
                .filter(|(_, cell)| cell.height_m().is_some())
        };
        let (first, last) = (along().next()?.0.1, along().next_back()?.0.1);
        Some([f64::from(first) * CELL_M, f64::from(last + 1) * CELL_M])
    }

    /// The deposits, duct by duct and along them.
    pub fn deposits(&self) -> Vec<Deposit> {
        let heights = self.cells.iter().filter_map(|(key, cell)| Some((*key, cell.height_m()?)));
        let mut high: BTreeMap<Key, f64> = heights.filter(|(_, high_m)| *high_m > THINNEST_M).collect();
        let mut deposits = Vec::new();
        while let Some(first) = high.keys().next().copied() {
            let patch = take_patch(&mut high, first);
            deposits.extend(self.deposit(&patch));
        }
        deposits
    }

    /// The deposit that a patch of cells is, if it is one.
    fn deposit(&self, patch: &[(Key, f64)]) -> Option<Deposit> {
        let (first, _) = patch.first()?;
        let range = |of: fn(&Key) -> i32| {
            patch.iter().map(|(key, _)| of(key)).fold((i32::MAX, i32::MIN), |(a, b), x| (a.min(x), b.max(x)))
        };
        let (along, left) = (range(|key| key.1), range(|key| key.2));
        let is_wide = along.1 - along.0 + 1 >= FEWEST_ALONG && left.1 - left.0 + 1 >= FEWEST_ACROSS;
        if patch.len() < FEWEST_CELLS || !is_wide || self.goes_uphill(patch, left) {
            return None;
        }
        // At its ends the light lies half beside it.
        let is_in = |(duct, along, left): Key| patch.binary_search_by_key(&(duct, along, left), |(key, _)| *key).is_ok();
        let within = || patch.iter().filter(|((duct, along, left), _)| [-1, 1].iter().all(|i| is_in((*duct, along + i, *left))));
        let (sum_m, count) = within().fold((0.0, 0.0), |(sum, count), (_, high_m)| (sum + high_m, count + 1.0));
        if count == 0.0 {
            return None;
        }
        let mean_m = sum_m / count;
        let edges = |(from, to): (i32, i32)| [f64::from(from) * CELL_M, f64::from(to + 1) * CELL_M];
        Some(Deposit {
            duct: first.0,
            along_m: edges(along),
            left_m: edges(left),
            area_m2: patch.len() as f64 * CELL_M * CELL_M,
            mean_m,
            sigma_m: SIGMA_M + SIGMA_SHARE * mean_m,
            largest_m: patch.iter().map(|(_, high_m)| *high_m).fold(0.0, f64::max),
        })
    }

    /// Whether a patch goes across the whole duct and is nowhere level.
    fn goes_uphill(&self, patch: &[(Key, f64)], left: (i32, i32)) -> bool {
        let width_m =
            patch.first().and_then(|(key, _)| self.widths_m.get(key.0)).map_or(0.0, |width_m| width_m - 2.0 * BESIDE_WALL_M);
        let mut heights: Vec<f64> = patch.iter().map(|(_, high_m)| *high_m).collect();
        let Some(middle_m) = median(&mut heights) else { return false };
        let even = heights.iter().filter(|high_m| (**high_m - middle_m).abs() <= EVEN_WITHIN * middle_m).count();
        f64::from(left.1 - left.0 + 1) * CELL_M >= WHOLE_SHARE * width_m && (even as f64) < EVEN_SHARE * patch.len() as f64
    }
}

/// Takes out of `high` the cell `first` and all that hang together with it, over corners too, ordered.
fn take_patch(high: &mut BTreeMap<Key, f64>, first: Key) -> Vec<(Key, f64)> {
    let mut patch: Vec<(Key, f64)> = high.remove_entry(&first).into_iter().collect();
    let mut next = 0;
    while next < patch.len() {
        let (duct, along, left) = patch[next].0;
        for key in (-REACH_ALONG..=REACH_ALONG).flat_map(|i| (-1..=1).map(move |j| (duct, along + i, left + j))) {
            patch.extend(high.remove_entry(&key));
        }
        next += 1;
    }
    patch.sort_unstable_by_key(|(key, _)| *key);
    patch
}

fn number(at_m: f64) -> i32 {
    libm::floor(at_m / CELL_M) as i32
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    const WIDTH_M: f64 = 0.5;

    /// Drives 3 m by steps of 8 mm over a floor of this height, with half a millimetre of noise, and a slit that falls by 0.16.
    fn driven(height_m: impl Fn(f64, f64) -> f64) -> Floors {
        let mut floors = Floors::default();
        for frame in 0..375 {
            let place = DuctPlace { along_m: 0.008 * f64::from(frame), lateral_m: 0.01, heading_rad: 0.0, width_m: WIDTH_M };
            let point = |block: i32| {
                let y = -0.25 + 0.01 * f64::from(block);
                // Where the slit's plane meets the floor: by halving, for the height hangs on the place.
                let (mut near, mut far) = (0.2, 1.2);
                for _ in 0..30 {
                    let x = (near + far) / 2.0;
                    let is_above = 0.17 - 0.16 * x > height_m(place.along_m + x, place.lateral_m + y);
                    (near, far) = if is_above { (x, far) } else { (near, x) };
                }
                let noise_m = 0.0005 * f64::from((frame * 7 + block * 13) % 5 - 2) / 2.0;
                let z = 0.17 - 0.16 * near + noise_m;
                RangePoint { point_in_base: Point3::new(near, y, z), laser: 1, block: block as usize, upon: Upon::Floor }
            };
            let ranges: Vec<RangePoint> = (0..48).map(point).collect();
            floors.take(0, &place, &ranges);
        }
        floors
    }

    #[test]
    fn a_clean_floor_has_no_deposit() {
        let floors = driven(|_, _| 0.0);
        assert_eq!(floors.deposits(), []);
        assert!(floors.seen_m(0).is_some_and(|[from_m, to_m]| from_m < 1.1 && to_m > 3.9), "{:?}", floors.seen_m(0));
    }

    #[test]
    fn a_patch_is_found_where_it_lies_and_as_thick_as_it_is() {
        let floors = driven(|x, y| if (2.0..2.4).contains(&x) && (0.05..0.2).contains(&y) { 0.01 } else { 0.0 });
        let [deposit] = floors.deposits()[..] else { panic!("{:?}", floors.deposits()) };
        assert!((deposit.mean_m - 0.01).abs() < 0.001 && (deposit.largest_m - 0.01).abs() < 0.001, "{deposit:?}");
        let ends = [deposit.along_m[0] - 2.0, deposit.along_m[1] - 2.4, deposit.left_m[0] - 0.05, deposit.left_m[1] - 0.2];
        assert!(ends.iter().all(|off_m| off_m.abs() <= CELL_M + 1e-9), "{deposit:?}");
        assert!((deposit.area_m2 - 0.06).abs() < 0.015, "{deposit:?}");
    }

    /// A wall is lit at every height, a hill is nowhere level, a screw is small; an even layer across the whole width is a deposit.
    #[test]
    fn walls_hills_and_small_things_are_none() {
        assert_eq!(driven(|x, _| if x > 3.0 { 0.3 } else { 0.0 }).deposits(), []);
        assert_eq!(driven(|x, _| if x > 2.0 { 0.02 * (x - 2.0) } else { 0.0 }).deposits(), []);
        assert_eq!(driven(|x, y| if (2.0..2.05).contains(&x) && y.abs() < 0.01 { 0.01 } else { 0.0 }).deposits(), []);
        let layer = driven(|x, _| if (2.0..2.8).contains(&x) { 0.01 } else { 0.0 });
        assert_eq!(layer.deposits().len(), 1, "{:?}", layer.deposits());
    }
}
