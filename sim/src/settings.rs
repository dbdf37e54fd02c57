//! The engine's settings.

use rapier3d::prelude::{FrictionModel, IntegrationParameters, SpringCoefficients};

/// Settings for a tick of 1 / `physics_hz` s. Each that is not the default says why.
pub fn parameters(physics_hz: u32) -> IntegrationParameters {
    let hz = f64::from(physics_hz);
    IntegrationParameters {
        dt: 1.0 / hz,
        // One friction cone a contact point. The default merges points and distorts turning.
        friction_model: FrictionModel::Coulomb,
        // Tolerances for a machine of decimetres: slop 0.5 mm, prediction 2 mm. The defaults are for people.
        length_unit: 0.1,
        // On, it freezes the wheels' contacts while they creep.
        contact_recycling: false,
        // At a millimetre a tick nothing can pass a 2.5 mm slab.
        max_ccd_substeps: 0,
        // As stiff as the tick allows: at 1200 Hz, 300 Hz lets the robot sink 0.03 mm, the default's 60 Hz 0.7 mm, which makes
        // it 0.9 % slower than its wheels. 400 Hz at the default's damping ratio of 10 is unstable.
        static_contact_softness: SpringCoefficients { natural_frequency: hz / 4.0, damping_ratio: 3.0 },
        // Substeps times sweeps, measured: 2 x 2 drifts 0.014 mm in 10 m at 108 000 steps/s, 2 x 1 0.075 mm at 115 000, the
        // default 4 x 1 0.019 mm at 52 000; 1 x 1 swerves.
        num_solver_iterations: 2,
        num_internal_pgs_iterations: 2,
        ..IntegrationParameters::default()
    }
}
