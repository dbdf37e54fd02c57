//! What a bend turns along, in the coordinates of the duct before it.

/// What a bend turns along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outer {
    /// A straight wall: of a mitred elbow, of a branch.
    Wall(OuterWall),
    /// An arc: of a radius elbow.
    Arc(OuterArc),
}

/// A straight wall: the outer one of an elbow, the far one of a branch, the one across a bull-head tee's stem. Its direction is that of the
/// duct behind the bend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterWall {
    /// Direction along the wall, out of the bend, against the duct's: the bend's angle, positive to the left, in radians.
    pub turn_rad: f64,
    /// A point on it: along the duct and to the left, in metres.
    pub point_m: [f64; 2],
    /// Width of the duct behind the bend, in metres.
    pub width_m: f64,
}

/// The outer wall of a radius elbow, which leaves the far side wall tangentially.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterArc {
    /// Where it begins to turn, in metres along the duct.
    pub start_m: f64,
    /// Its radius, in metres.
    pub radius_m: f64,
    /// The bend's angle, positive to the left, in radians.
    pub turn_rad: f64,
}
