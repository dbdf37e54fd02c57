//! Past a thing that stands beside the way: out of the duct's middle into the middle of what is free at its side, and back.
//!
//! The path goes aside by the quintic A (10 t^3 - 15 t^4 + 6 t^5), whose slope and curvature are zero at both ends (N. Hogan's minimum-jerk
//! profile, J. Neuroscience 4, 1984), over at least half a metre: at 0.12 m aside its steepest is 0.45 rad and its tightest radius 0.36 m.

use super::bend::OnPath;
use super::{AT_REST_M, Course, End, Phase};
use crate::ahead::{DuctPlace, Fitting, Thing};

/// The path past it, in the coordinates of the duct that it stands in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detour {
    /// Where it leaves the middle, in metres along the duct.
    pub from_m: f64,
    /// From where to where it is aside, in metres along the duct.
    pub beside_m: [f64; 2],
    /// How far aside, to the left, in metres.
    pub aside_m: f64,
    /// Where something else stands across the middle behind it, in metres along the duct.
    pub next_m: Option<f64>,
}

/// The robot's width, what it keeps free on both sides, how far its nose reaches ahead and its tail behind its origin, in metres: those of
/// INCRA I.
const ROBOT_M: f64 = 0.215;
const MARGIN_M: f64 = 0.025;
const NOSE_M: f64 = 0.16;
const TAIL_M: f64 = 0.12;
/// It is all aside this long before the thing and behind it, in metres.
const CLEAR_M: f64 = 0.05;
/// Way in which it goes aside: at least, and at most, in metres; and back.
const SHIFT_M: f64 = 0.5;
const LONGEST_SHIFT_M: f64 = 0.8;
/// Its speed meanwhile, as a share of its usual one: it is nearer to something than otherwise.
pub(super) const SPEED_SHARE: f64 = 0.6;
/// The wall behind a thing is seen anew from so far behind it on, in metres.
const SHADOW_M: f64 = 0.1;

/// The quintic from 0 to 1 and its first two derivatives.
fn quintic(t: f64) -> [f64; 3] {
    let t = t.clamp(0.0, 1.0);
    let (t2, u) = (t * t, 1.0 - t);
    [t2 * t * (10.0 - 15.0 * t + 6.0 * t2), 30.0 * t2 * u * u, 60.0 * t * u * (1.0 - 2.0 * t)]
}

impl Detour {
    /// Past this thing, from where the robot is; `None` where there is no room, or not enough way left to go aside.
    pub(super) fn past(thing: &Thing, along_m: f64, width_m: f64) -> Option<Self> {
        let half_m = width_m / 2.0;
        let [right_m, left_m] = thing.reach_m;
        // What is free to the right of it, and to the left.
        let free_m = [right_m + half_m, half_m - left_m];
        let (room_m, aside_m) =
            if free_m[0] > free_m[1] { (free_m[0], (right_m - half_m) / 2.0) } else { (free_m[1], (left_m + half_m) / 2.0) };
        let beside_m = [thing.at_m - NOSE_M - CLEAR_M, thing.to_m + TAIL_M + CLEAR_M];
        let way_m = beside_m[0] - along_m;
        (room_m >= ROBOT_M + 2.0 * MARGIN_M && way_m >= SHIFT_M).then(|| Self {
            from_m: beside_m[0] - way_m.min(LONGEST_SHIFT_M),
            beside_m,
            aside_m,
            next_m: None,
        })
    }

    /// Where it is back in the middle, in metres along the duct.
    pub(super) fn back_m(&self) -> f64 {
        self.beside_m[1] + LONGEST_SHIFT_M
    }

    /// A pose in the duct, against the path.
    pub(super) fn project(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> OnPath {
        let [there_m, back_m] = self.beside_m;
        let (start_m, length_m, sign) =
            if along_m < there_m { (self.from_m, there_m - self.from_m, 1.0) } else { (back_m, LONGEST_SHIFT_M, -1.0) };
        let [share, slope, bend] = quintic((along_m - start_m) / length_m);
        let share = if sign > 0.0 { share } else { 1.0 - share };
        let slope = sign * self.aside_m * slope / length_m;
        let bend = sign * self.aside_m * bend / (length_m * length_m);
        let cos = 1.0 / (1.0 + slope * slope).sqrt();
        OnPath {
            way_m: along_m,
            lateral_m: (lateral_m - share * self.aside_m) * cos,
            heading_rad: heading_rad - libm::atan(slope),
            curvature_1_m: bend * cos * cos * cos,
        }
    }

    /// Where the thing hides the left and the right wall, in metres along the duct: it stands on the side that the path leaves.
    pub(super) fn hidden(&self) -> [Option<[f64; 2]>; 2] {
        let hidden = Some([self.beside_m[0] + NOSE_M, self.beside_m[1] - TAIL_M + SHADOW_M]);
        if self.aside_m < 0.0 { [hidden, None] } else { [None, hidden] }
    }
}

impl Course {
    /// Goes past what stands in the duct, if there is room; says whether it does.
    pub(super) fn pass_by(&mut self, place: &DuctPlace) -> bool {
        let Some(detour) = self.ahead.thing(place).and_then(|thing| Detour::past(&thing, self.along_m, place.width_m)) else {
            return false;
        };
        self.log.passed(Fitting::Obstacle, detour.beside_m[0] + NOSE_M + CLEAR_M);
        self.planned = None;
        self.phase = Phase::Passing(detour);
        true
    }

    /// Beside it its far end is seen: it is passed only behind that. Before what else stands behind it the robot stops.
    pub(super) fn look_along(&mut self, mut detour: Detour, place: &DuctPlace) {
        let at_m = detour.beside_m[0] + NOSE_M + CLEAR_M;
        if self.along_m < detour.beside_m[1] {
            detour.beside_m[1] = detour.beside_m[1].max(self.ahead.thing_to_m(at_m) + TAIL_M + CLEAR_M);
        }
        let seen = *self.ahead.outlook();
        // The wall of a dead end may be taken for a part of the thing, which then seems to go on up to it: it ends the way all the same.
        let ends_m = seen.blocked_m.filter(|_| matches!(seen.fitting, Fitting::DeadEnd | Fitting::Drop));
        let stands_m = self.ahead.stands_beyond(detour.beside_m[1] - TAIL_M + SHADOW_M);
        detour.next_m = ends_m.into_iter().chain(stands_m).min_by(f64::total_cmp);
        self.phase = Phase::Passing(detour);
        // Behind it a fitting is more than the way back into the middle, which the law finds by itself.
        let is_fitting = !matches!(seen.fitting, Fitting::Unknown | Fitting::Straight | Fitting::Obstacle);
        if self.along_m > detour.beside_m[1] && is_fitting {
            self.trail.push(super::backing::Step::Aside(detour));
            self.phase = Phase::Along;
            return;
        }
        if let Some(at_m) = detour.next_m.filter(|at_m| place.along_m >= at_m - self.params.stand_off_m - AT_REST_M) {
            self.log.blocked(Fitting::Obstacle, at_m);
            self.phase = Phase::AtTheEnd(End::Obstacle);
        } else if place.along_m > detour.back_m() {
            self.trail.push(super::backing::Step::Aside(detour));
            self.phase = Phase::Along;
            self.ahead.passed();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thing along the left wall of a duct of 0.5 m, 0.2 m wide: the path goes into the middle of the 0.3 m beside it, and back.
    #[test]
    fn the_path_goes_into_the_middle_of_what_is_free() {
        let thing = Thing { at_m: 3.0, to_m: 3.2, reach_m: [0.05, 0.25] };
        let detour = Detour::past(&thing, 2.0, 0.5).expect("room");
        assert!((detour.aside_m + 0.1).abs() < 1e-12, "{detour:?}");
        for along_m in [detour.beside_m[0], 3.1, detour.beside_m[1]] {
            let on = detour.project([along_m, -0.1, 0.0]);
            assert!(on.lateral_m.abs() < 1e-12 && on.heading_rad.abs() < 1e-12 && on.curvature_1_m.abs() < 1e-12, "{on:?}");
        }
        for along_m in [detour.from_m, detour.back_m()] {
            assert!(detour.project([along_m, 0.0, 0.0]).lateral_m.abs() < 1e-12);
        }
        // Its slope and curvature are those of its own line.
        let middle = |along_m: f64| -detour.project([along_m, 0.0, 0.0]).lateral_m;
        for along_m in [2.2, 2.45, 2.6, 3.6, 3.9] {
            let heading = -detour.project([along_m, 0.0, 0.0]).heading_rad;
            let step = 1e-4;
            let line = |at: f64| middle(at) / libm::cos(detour.project([at, 0.0, 0.0]).heading_rad);
            let slope = (line(along_m + step) - line(along_m - step)) / (2.0 * step);
            assert!((libm::atan(slope) - heading).abs() < 1e-6, "{along_m}: {slope} {heading}");
            let turned =
                -detour.project([along_m + step, 0.0, 0.0]).heading_rad + detour.project([along_m - step, 0.0, 0.0]).heading_rad;
            let curvature = turned / (2.0 * step) * libm::cos(heading);
            assert!((curvature - detour.project([along_m, 0.0, 0.0]).curvature_1_m).abs() < 1e-5, "{along_m}");
        }
        assert!(Detour::past(&Thing { reach_m: [-0.1, 0.25], ..thing }, 2.0, 0.5).is_none(), "no room");
        assert!(Detour::past(&thing, 2.5, 0.5).is_none(), "no way to go aside");
        let other = Detour::past(&Thing { reach_m: [-0.25, -0.05], ..thing }, 2.0, 0.5).expect("room");
        assert!((other.aside_m - 0.1).abs() < 1e-12 && other.hidden()[0].is_none());
    }
}
