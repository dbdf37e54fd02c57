//! What fittings there are, dimensioned as the sheet-metal trade does.

/// What a fitting is. Angles are positive for a turn to the left. Dimensions are inside ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight duct.
    Straight {
        /// Its length, in metres.
        length_m: f64,
    },
    /// An elbow with curved throat and heel, made as a chain of gores.
    RadiusElbow {
        /// Turn, in radians, within (0, pi] either way.
        angle_rad: f64,
        /// Radius of the inner wall, in metres.
        throat_radius_m: f64,
    },
    /// An elbow of two straight ducts cut and joined at half the angle. The reference path through it is the arc about the
    /// inner corner, tangent to both centrelines, of half the width as radius.
    MitredElbow {
        /// Turn, in radians, within (0, 2 pi / 3] either way.
        angle_rad: f64,
    },
    /// A mitred elbow with turning vanes on the mitre line: air passes, a robot does not.
    VanedElbow {
        /// Turn, in radians, within (0, 2 pi / 3] either way.
        angle_rad: f64,
    },
    /// A change of width, of height, or of both.
    Transition {
        /// Its length, in metres.
        length_m: f64,
        /// Width at `out`.
        to_width_m: f64,
        /// Height at `out`.
        to_height_m: f64,
        /// Which side stays flush.
        across: AcrossAlign,
        /// Whether the floor stays flat.
        upright: UprightAlign,
    },
    /// An S-bend of two equal, opposite arcs, each made of gores.
    Offset {
        /// Its length along the duct, in metres.
        length_m: f64,
        /// By how much `out` lies to the left of `in`, in metres; negative to the right.
        aside_m: f64,
    },
    /// A straight duct that climbs or falls between two upright ports. Its height is measured upright.
    Slope {
        /// Its length seen from above, in metres.
        length_m: f64,
        /// Angle against the horizontal, in radians; positive climbs.
        angle_rad: f64,
    },
    /// A branch at right angles, flush with the wall; the duct goes straight on. As long as the branch is wide.
    Tee {
        /// The side on which the branch leaves.
        hand: Hand,
        /// Width of the branch, in metres.
        branch_width_m: f64,
    },
    /// Two branches at right angles, left and right, at the end of the stem; nothing goes straight on.
    BullheadTee {
        /// Width of both branches, in metres.
        branch_width_m: f64,
    },
    /// A branch at right angles behind a shoe: an opening widened upstream by a wall of 45 degrees.
    SideBranch {
        /// The side on which the branch leaves.
        hand: Hand,
        /// Width of the branch, in metres.
        branch_width_m: f64,
        /// By how much the shoe widens the opening; it stands out from the wall by as much.
        shoe_m: f64,
    },
    /// Two like branches, left and right, that part at an angle.
    Wye {
        /// Angle of each branch against the stem, in radians.
        half_angle_rad: f64,
        /// Width of both branches, in metres.
        branch_width_m: f64,
    },
    /// Branches at right angles on both sides, flush with the walls; the duct goes straight on.
    Cross {
        /// Width of both branches, in metres.
        branch_width_m: f64,
    },
    /// A curtain fire damper in a straight duct.
    Damper {
        /// Its length, in metres.
        length_m: f64,
        /// Whether it lets anything through.
        blade: Blade,
    },
    /// A straight duct with a grille in a wall or in the ceiling; beyond it is the open.
    Grille {
        /// Length of the duct, in metres.
        length_m: f64,
        /// Where the grille is; it sits in the middle there.
        side: GrilleSide,
        /// Length of the opening along the duct, in metres.
        opening_length_m: f64,
        /// Height of the opening in a wall, width of one in the ceiling.
        opening_height_m: f64,
    },
    /// A straight duct with a hole in the middle of its floor, and a shaft below.
    Drop {
        /// Length of the duct, in metres.
        length_m: f64,
        /// Length of the hole along the duct, in metres.
        hole_length_m: f64,
        /// Width of the hole across the duct, in metres; as wide as the duct: from wall to wall.
        hole_width_m: f64,
        /// Depth of the shaft, in metres.
        depth_m: f64,
    },
}

/// A side, seen along the way into the fitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// Positive y.
    Left,
    /// Negative y.
    Right,
}

/// What of a transition stays in line in the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AcrossAlign {
    /// The middle: both walls draw in alike.
    #[default]
    Concentric,
    /// The left wall.
    Left,
    /// The right wall.
    Right,
}

/// What of a transition stays in line upright.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UprightAlign {
    /// The floor stays level: only the ceiling slants.
    #[default]
    FlatBottom,
    /// The middle: floor and ceiling slant alike.
    Concentric,
}

/// How a damper stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blade {
    /// The folded curtain hangs at the ceiling.
    Open,
    /// The curtain closes the whole section.
    Shut,
}

/// Where a grille is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrilleSide {
    /// In the left wall.
    Left,
    /// In the right wall.
    Right,
    /// In the ceiling.
    Ceiling,
}

impl Hand {
    /// Positive on the left.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

impl Shape {
    /// What the trade calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Straight { .. } => "straight",
            Self::RadiusElbow { .. } => "radius elbow",
            Self::MitredElbow { .. } => "mitred elbow",
            Self::VanedElbow { .. } => "vaned elbow",
            Self::Transition { .. } => "transition",
            Self::Offset { .. } => "offset",
            Self::Slope { .. } => "slope",
            Self::Tee { .. } => "tee",
            Self::BullheadTee { .. } => "bull-head tee",
            Self::SideBranch { .. } => "side branch",
            Self::Wye { .. } => "wye",
            Self::Cross { .. } => "cross",
            Self::Damper { .. } => "damper",
            Self::Grille { .. } => "grille",
            Self::Drop { .. } => "drop",
        }
    }
}
