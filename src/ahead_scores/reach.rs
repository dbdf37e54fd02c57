//! How far ahead the sensor sees: to where its slits leave the walls for floor and ceiling.

use ductloop_nav::rig::Rig;

/// Farther is not asked for, in metres: a slit that lies level meets neither floor nor ceiling.
const MOST_M: f64 = 10.0;

/// Distance ahead of the base up to which a slit, seen in the middle plane of a straight level duct of this height, lights what stands
/// across, in metres. The mount is at rest. Beyond, both slits are on floor or ceiling, and nothing says what the walls do. What a robot's
/// own code does not trust (`nav-core` ranges beyond 2.3 m) is within the reach.
pub(super) fn reach_m(rig: &Rig, height_m: f64) -> f64 {
    let base_from_camera = rig.mount.base_from_camera(rig.mount.rest);
    let reach = |laser: &ductloop_nav::rig::Laser| {
        let normal = base_from_camera.rotation * laser.normal_in_camera.into_inner();
        let offset_m = laser.offset_m + normal.dot(&base_from_camera.translation.vector);
        let source_m = (base_from_camera * laser.source_in_camera).x;
        // Of the places at which the plane meets floor and ceiling, one is ahead of the source.
        let meets_m = [0.0, height_m].map(|z_m| (offset_m - normal.z * z_m) / normal.x);
        meets_m.into_iter().filter(|x_m| *x_m > source_m).fold(MOST_M, f64::min)
    };
    rig.lasers.iter().map(reach).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    /// Of the `wide` rig, `low` rises to a ceiling of 0.3 m within 2.6 m of the base (`docs/navigation.md`); a low ceiling is nearer, a
    /// high one farther, in proportion.
    #[test]
    fn the_rising_slit_ends_at_the_ceiling() {
        let text = "format = 1\nkind = \"scenario\"\nname = \"t\"\n[sensor]\npreset = \"wide\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
                    run = [{ straight_m = 6.0 }]\n";
        let rig = Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{wrong}")).rig;
        let [low, middle, high] = [0.25, 0.3, 0.35].map(|height_m| reach_m(&rig, height_m));
        assert!((2.4..2.8).contains(&middle), "{middle}");
        assert!(((high - middle) - (middle - low)).abs() < 1e-9 && low < middle, "{low} {middle} {high}");
    }
}
