//! How the ducts' surfaces grip.

use ductloop_duct::cell::SurfaceId;

/// Coulomb friction coefficient between a wheel and each surface, isotropic, the same at rest and sliding.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    friction: Vec<f64>,
}

impl Ground {
    /// Coefficient of [`SurfaceId`] i at index i.
    pub fn new(friction: Vec<f64>) -> Self {
        Self { friction }
    }

    /// The same coefficient on the surface with id 0, which is all that a plain network has.
    pub fn uniform(friction: f64) -> Self {
        Self { friction: vec![friction] }
    }

    /// Coefficient of a surface; `None` where none was given or it is not a number from 0 up.
    pub fn friction(&self, surface: SurfaceId) -> Option<f64> {
        self.friction.get(usize::from(surface.0)).copied().filter(|mu| mu.is_finite() && *mu >= 0.0)
    }
}
