//! A fitting seen from above, as walls, and how far a ray goes in it.

/// Most walls that a plan has.
const MOST: usize = 64;

/// A straight wall from one point to another, in metres along the duct and to the left of its middle.
type Wall = [[f64; 2]; 2];

/// Walls.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    walls: Vec<Wall>,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// How far away, in metres.
    pub(super) range_m: f64,
    /// Sine of the angle between ray and wall.
    pub(super) sin_incidence: f64,
}

impl Plan {
    /// Without walls, and with room for them.
    pub(super) fn new() -> Self {
        Self { walls: Vec::with_capacity(MOST) }
    }

    pub(super) fn clear(&mut self) {
        self.walls.clear();
    }

    pub(super) fn wall(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.walls.push([from, to]);
    }

    /// The nearest wall on a ray in the direction of a unit vector.
    pub(super) fn meets(&self, from: [f64; 2], way: [f64; 2]) -> Option<Meeting> {
        let mut nearest: Option<(f64, &Wall)> = None;
        for wall in &self.walls {
            let [a, b] = *wall;
            let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
            let determinant = way[1] * ex - way[0] * ey;
            let (dx, dy) = (a[0] - from[0], a[1] - from[1]);
            let range = (dy * ex - dx * ey) / determinant;
            let share = (dy * way[0] - dx * way[1]) / determinant;
            // A ray along a wall divides by nothing: not a number is within no bounds.
            if range > 0.0 && (0.0..=1.0).contains(&share) && nearest.is_none_or(|(least, _)| range < least) {
                nearest = Some((range, wall));
            }
        }
        nearest.map(|(range_m, [a, b])| {
            let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
            let sin_incidence = (way[1] * ex - way[0] * ey).abs() / (ex * ex + ey * ey).sqrt();
            Meeting { range_m, sin_incidence }
        })
    }
}
