//! The strip of duct ahead: for each piece of the way, whether its side walls are closed or open and whether something stands across.
//!
//! Coordinates are those of the duct that the robot is in: s along it, by odometry, y to the left of its middle. A ray from the camera to a
//! lit point says three things: nothing stands on its way; where it crosses the line of a side wall, that wall is open; and where it ends,
//! something is. Rays are counted in bins along s, which remain while the robot goes by, so that what one frame leaves in doubt the next
//! ones settle (evidence grids: H. Moravec, A. Elfes, ICRA 1985; here one-dimensional, as ducts are).

use std::collections::VecDeque;

/// Length of a bin, in metres.
pub(super) const BIN_M: f64 = 0.02;
/// Pieces into which the duct's width is cut.
pub(super) const CELLS: usize = 25;
/// How far behind the robot and ahead of it bins are kept, in metres.
const BEHIND_M: f64 = 0.6;
const AHEAD_M: f64 = 3.0;
/// A point is on a side wall if it is within this of its line, in metres, and this times its range.
const ON_WALL_M: f64 = 0.015;
const ON_WALL_SHARE: f64 = 0.012;
/// A ray that ends farther behind a wall's line than this, in metres, has passed through the wall: more than a bead or a dent.
const THROUGH_M: f64 = 0.03;
/// So many rays through the middle make it known to be free, if they are so many times those that ended there.
const FREE_RAYS: f64 = 40.0;
const FREE_SHARE: f64 = 6.0;
/// A robot that has moved by less than this deviation tells nothing by it, in metres.
const STOOD_M: f64 = 0.01;
/// A ray counts as free up to this before its end, in metres.
const SHORT_OF_END_M: f64 = 0.05;

/// A side, as rays found it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Flank {
    /// Rays that ended on the wall.
    pub(super) closed: f64,
    /// Rays that passed through where it would be.
    pub(super) open: f64,
    /// Where these ended: the least and the greatest place along the duct and offset from its middle, in metres.
    pub(super) ends_m: Option<[[f64; 2]; 2]>,
    /// Points on this side, off the middle half, wherever across: how many, the sum of their offsets from the middle, the least and the
    /// greatest, in metres.
    pub(super) points: f64,
    pub(super) sum_m: f64,
    pub(super) reach_m: [f64; 2],
}

impl Flank {
    fn pass_through(&mut self, end_m: [f64; 2]) {
        self.open += 1.0;
        self.ends_m = Some(widened(self.ends_m, end_m.map(|at| [at; 2])));
    }

    fn note(&mut self, offset_m: f64) {
        self.reach_m =
            if self.points == 0.0 { [offset_m; 2] } else { [self.reach_m[0].min(offset_m), self.reach_m[1].max(offset_m)] };
        self.points += 1.0;
        self.sum_m += offset_m;
    }
}

/// Ranges that hold both.
pub(super) fn widened(ranges: Option<[[f64; 2]; 2]>, more: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let Some(ranges) = ranges else { return more };
    std::array::from_fn(|axis| [ranges[axis][0].min(more[axis][0]), ranges[axis][1].max(more[axis][1])])
}

/// The inside, as rays found it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Inside {
    /// Rays that ended here in the middle half of the duct ...
    pub(super) hits: f64,
    /// ... and those that went on through it.
    pub(super) free: f64,
    /// Where the robot was along the duct when it was first and last hit, in metres.
    pub(super) seen_from_m: [f64; 2],
    /// Sums over these rays of the robot's place, its square, where they ended, and the product of both: see [`Self::moving`].
    pub(super) sums: [f64; 4],
    /// The most to the right and to the left that it was hit, anywhere across the duct, in metres.
    pub(super) reach_m: [f64; 2],
    /// Rays that ended here in each piece of the width, from the right to the left.
    pub(super) cells: [f64; CELLS],
    /// Rays that ended here anywhere across the duct, off its walls.
    pub(super) any: f64,
}

/// A bin of the way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bin {
    /// Left and right.
    pub(super) flanks: [Flank; 2],
    pub(super) inside: Inside,
    /// How often the middle of the floor was seen lit here, at whatever height, and how often one at the robot's height should have been
    /// and was not.
    pub(super) floor: [f64; 2],
}

/// Where the robot is in its duct.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DuctPlace {
    /// Along it, by odometry, in metres.
    pub along_m: f64,
    /// Offset to the left of its middle, in metres.
    pub lateral_m: f64,
    /// Heading, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Width of the duct, in metres.
    pub width_m: f64,
}

impl DuctPlace {
    /// A point of the base frame in the duct: along and to the left of its middle, in metres.
    pub fn duct_from_base(&self, x_m: f64, y_m: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.heading_rad);
        [self.along_m + cos * x_m - sin * y_m, self.lateral_m + sin * x_m + cos * y_m]
    }
}

/// The strip.
#[derive(Clone, Debug, Default)]
pub(super) struct Strip {
    bins: VecDeque<Bin>,
    /// Number of the first bin: it begins at this times [`BIN_M`].
    first: i64,
    /// Rays of this frame that are free up to each bin's end, before they are added up.
    reach: Vec<f64>,
}

/// A ray in the duct.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) from: [f64; 2],
    pub(super) to: [f64; 2],
    /// On what it ended.
    pub(super) end: RayEnd,
}

impl Ray {
    /// The part of it that is in the duct, which begins at zero and is `half_m` wide to each side; `None` if it does not come in there. A
    /// robot that is still in the fitting before it looks in through its mouth.
    pub(super) fn past_the_mouth(self, half_m: f64) -> Option<Self> {
        let Self { from, to, .. } = self;
        if from[0] >= 0.0 {
            return Some(self);
        }
        let across_m = from[1] + (to[1] - from[1]) * from[0] / (from[0] - to[0]);
        (to[0] > 0.0 && across_m.abs() < half_m).then_some(Self { from: [0.0, across_m], ..self })
    }
}

/// On what a ray ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RayEnd {
    /// The floor.
    Floor,
    /// Nothing, where the floor should be.
    NoFloor,
    /// Something else.
    Surface,
    /// Nothing so near: it was cut off here.
    Beyond,
}

impl Strip {
    /// Forgets everything: the robot is in another duct.
    pub(super) fn clear(&mut self) {
        self.bins.clear();
    }

    /// Number of the bin at `along_m`.
    pub(super) fn number(along_m: f64) -> i64 {
        libm::floor(along_m / BIN_M) as i64
    }

    /// The bin of this number, if it is kept.
    pub(super) fn bin(&self, number: i64) -> Option<&Bin> {
        self.bins.get(usize::try_from(number - self.first).ok()?)
    }

    fn bin_mut(&mut self, number: i64) -> Option<&mut Bin> {
        self.bins.get_mut(usize::try_from(number - self.first).ok()?)
    }

    /// Whether the middle of the duct at `along_m` is known to be free: many rays went through it, and few ended there.
    pub(super) fn is_free(&self, along_m: f64) -> bool {
        self.bin(Self::number(along_m))
            .is_some_and(|Bin { inside: Inside { free, hits, .. }, .. }| *free >= FREE_RAYS && *free > FREE_SHARE * hits)
    }

    /// Rays that ended in each piece of the width, off the walls, from here to there along the duct.
    pub(super) fn across_cells(&self, [from_m, to_m]: [f64; 2]) -> [f64; CELLS] {
        let bins = (Self::number(from_m)..=Self::number(to_m)).filter_map(|number| self.bin(number));
        bins.fold([0.0; CELLS], |sums, bin| std::array::from_fn(|cell| sums[cell] + bin.inside.cells[cell]))
    }

    /// Numbers of the bins from the robot on.
    pub(super) fn ahead_of(&self, along_m: f64) -> std::ops::Range<i64> {
        Self::number(along_m).max(self.first)..self.first + self.bins.len() as i64
    }

    /// Moves along with the robot.
    pub(super) fn follow(&mut self, along_m: f64) {
        let (first, end) = (Self::number(along_m - BEHIND_M), Self::number(along_m + AHEAD_M) + 1);
        if self.bins.is_empty() || first >= self.first + self.bins.len() as i64 || end <= self.first {
            self.bins.clear();
            self.first = first;
        }
        while self.first < first {
            self.bins.pop_front();
            self.first += 1;
        }
        while self.first > first {
            self.bins.push_front(Bin::default());
            self.first -= 1;
        }
        self.bins.resize((end - first) as usize, Bin::default());
    }

    /// Takes in the rays of a frame.
    pub(super) fn take(&mut self, place: &DuctPlace, rays: impl Iterator<Item = Ray>) {
        self.reach.clear();
        self.reach.resize(self.bins.len() + 1, 0.0);
        let half_m = place.width_m / 2.0;
        let from_number = Self::number(place.along_m);
        for ray in rays {
            self.ray(&ray, half_m, place.along_m);
        }
        // Those that reach a bin have passed through all before it, from the robot on.
        let mut beyond = 0.0;
        for index in (0..self.bins.len()).rev() {
            beyond += self.reach[index + 1];
            if self.first + index as i64 >= from_number {
                self.bins[index].inside.free += beyond;
            }
        }
    }

    fn ray(&mut self, Ray { from, to, end }: &Ray, half_m: f64, robot_m: f64) {
        if *end == RayEnd::NoFloor {
            if to[1].abs() <= half_m / 2.0
                && let Some(bin) = self.bin_mut(Self::number(to[0]))
            {
                bin.floor[1] += 1.0;
            }
            return;
        }
        let (along, across) = (to[0] - from[0], to[1] - from[1]);
        let range_m = (along * along + across * across).sqrt();
        let on_wall_m = ON_WALL_M + ON_WALL_SHARE * range_m;
        let beyond_m = to[1].abs() - half_m;
        let side = usize::from(to[1] < 0.0);
        if *end == RayEnd::Surface
            && to[1].abs() > half_m / 2.0
            && let Some(bin) = self.bin_mut(Self::number(to[0]))
        {
            bin.flanks[side].note(to[1].abs());
        }
        // Where it leaves the duct's own strip, or ends in it.
        let mut leaves_m = to[0];
        if beyond_m > on_wall_m.max(THROUGH_M) {
            let share = (half_m.copysign(to[1]) - from[1]) / across;
            leaves_m = from[0] + share * along;
            if let Some(bin) = self.bin_mut(Self::number(leaves_m)) {
                bin.flanks[side].pass_through([to[0], to[1].abs()]);
            }
        } else if *end == RayEnd::Beyond {
            // It is free, and nothing more.
        } else if beyond_m > -on_wall_m {
            if let Some(bin) = self.bin_mut(Self::number(to[0])) {
                bin.flanks[side].closed += 1.0;
            }
        } else if *end == RayEnd::Floor {
            if to[1].abs() <= half_m / 2.0
                && let Some(bin) = self.bin_mut(Self::number(to[0]))
            {
                bin.floor[0] += 1.0;
            }
        } else if let Some(bin) = self.bin_mut(Self::number(to[0])) {
            bin.inside.hit(*to, half_m, robot_m);
        }
        // Only what passes the middle half says that the middle is free.
        let middle = |s_m: f64| (from[1] + across * (s_m - from[0]) / along).abs() <= half_m / 2.0;
        let mut free_m = leaves_m - SHORT_OF_END_M;
        if along > 0.0 {
            if !middle(free_m) {
                free_m = from[0] + (half_m / 2.0 - from[1] * across.signum()) * along / across.abs();
            }
            if let Ok(index) = usize::try_from(Self::number(free_m) - self.first)
                && index < self.reach.len()
            {
                self.reach[index] += 1.0;
            }
        }
    }
}

impl Inside {
    /// How far what these rays met moves on for each metre that the robot does, by least squares: a wall 0; a ceiling or floor that a laser
    /// meets ahead 1, and a part of that where it slopes towards the robot. `None` while the robot has not moved.
    pub(super) fn moving(of: impl Iterator<Item = Self>) -> Option<f64> {
        let (mut count, mut sums) = (0.0, [0.0; 4]);
        for inside in of {
            count += inside.hits;
            (0..4).for_each(|i| sums[i] += inside.sums[i]);
        }
        let [robot, squares, x, products] = sums.map(|sum| sum / count);
        let variance = squares - robot * robot;
        (count > 0.0 && variance > STOOD_M * STOOD_M).then(|| (products - x * robot) / variance)
    }

    fn hit(&mut self, [x_m, y_m]: [f64; 2], half_m: f64, robot_m: f64) {
        if self.any == 0.0 {
            self.reach_m = [y_m; 2];
        }
        self.any += 1.0;
        let cell = (y_m / half_m + 1.0) / 2.0 * CELLS as f64;
        self.cells[(cell.max(0.0) as usize).min(CELLS - 1)] += 1.0;
        self.reach_m = [self.reach_m[0].min(y_m), self.reach_m[1].max(y_m)];
        if y_m.abs() <= half_m / 2.0 {
            if self.hits == 0.0 {
                self.seen_from_m = [robot_m; 2];
            }
            self.hits += 1.0;
            let terms = [robot_m, robot_m * robot_m, x_m, x_m * robot_m];
            (0..4).for_each(|i| self.sums[i] += terms[i]);
            self.seen_from_m = [self.seen_from_m[0].min(robot_m), self.seen_from_m[1].max(robot_m)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_comes_in_through_the_mouth_or_not_at_all() {
        let ray = |from: [f64; 2], to: [f64; 2]| Ray { from, to, end: RayEnd::Surface }.past_the_mouth(0.25).map(|ray| ray.from);
        assert_eq!(ray([0.1, 0.2], [1.0, -0.2]), Some([0.1, 0.2]));
        assert_eq!(ray([-0.25, 0.25], [0.25, -0.25]), Some([0.0, 0.0]));
        assert_eq!(ray([-0.2, 0.4], [0.2, 0.3]), None, "past the corner");
        assert_eq!(ray([-0.2, 0.0], [-0.1, 0.1]), None, "short of it");
    }
}
