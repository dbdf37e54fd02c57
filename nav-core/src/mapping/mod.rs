//! What the robot's own ranges say of the ducts that it drives through, beside where they lead.
//!
//! - [`ceiling`]: how high a duct is, from the light that goes along on its ceiling;
//! - [`closure`]: which ducts are one, and where all of them are if they are;
//! - [`ends`]: where ducts end and by which angle they are left, and how sure both are;
//! - [`floor`]: how thick a deposit lies on the floor, from how far the light on it is above the wheels.
//!
//! Ceilings and floors take in a frame at a time and say what they hold when they are asked.

pub mod ceiling;
pub mod closure;
pub mod ends;
pub mod floor;

pub use ceiling::{Ceilings, Height};
pub use closure::{Closed, Closure};
pub use ends::{DuctEnds, Ends, Figure, Sureness};
pub use floor::{Deposit, Floors};

/// What all frames have in common, in 1/m: a twentieth of a pixel over focal length and base (380 px, 60 mm). Times two distances it is an
/// error of a length: of the nearer one's, or of a height.
const COMMON_1_M: f64 = 0.0022;

/// The middle one of some values, the upper one of two; `None` of none.
fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
