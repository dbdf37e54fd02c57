//! Every kind of fitting as the renderers' geometry has it, against rays cast through the network.

mod common;

use common::scenes::{Scene, fittings};
use ductloop_sensor::frame_geometry::{FrameGeometry, Region, Sweep};
use ductloop_sensor::renderer::MAX_LASERS;
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::truth::{OPEN, SceneTruth};
use nalgebra::Vector3;

/// Pixels apart that are looked at, along both axes.
const STEP_PX: usize = 3;

fn geometry(scene: &Scene) -> FrameGeometry {
    let scenery = Scenery::new(&scene.network, &scene.looks).expect("sound looks");
    let mut geometry = FrameGeometry::new(&scene.rig, &scene.optics).expect("a sound lens");
    geometry.build(&scenery, &Sweep::still(scene.view.world_from_camera), &[1.0; MAX_LASERS]).expect("a camera in the duct");
    geometry
}

/// Depth of a region at a ray (x, y, 1), if the ray meets it.
fn depth_m(geometry: &FrameGeometry, region: &Region, ray: &Vector3<f64>) -> Option<f64> {
    /// A corner that clipping made twice has an edge without a direction, as a share of its ends' distance.
    const SAME_CORNER: f64 = 1e-7;
    let outline = &geometry.corners[region.outline.clone()];
    let sides = (0..outline.len()).filter_map(|i| {
        let (a, b) = (outline[i].coords, outline[(i + 1) % outline.len()].coords);
        Some(a.cross(&b).try_normalize(SAME_CORNER * a.norm() * b.norm())?.dot(ray))
    });
    let (low, high) = sides.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), side| (low.min(side), high.max(side)));
    (low >= 0.0 || high <= 0.0).then(|| region.plane.offset_m / region.plane.normal.dot(ray))
}

#[test]
fn depth_and_surface_are_those_that_rays_meet() {
    for scene in fittings() {
        let geometry = geometry(&scene);
        let truth = SceneTruth::new(&scene.network, &scene.rig).of(&scene.view.world_from_camera).expect("a camera in the duct");
        let (mut looked_at, mut open, mut wrong) = (0, 0, Vec::new());
        for v in (0..truth.height_px).step_by(STEP_PX) {
            for u in (0..truth.width_px).step_by(STEP_PX) {
                let [x, y] = geometry.projection().ray([u as f64, v as f64]);
                let ray = Vector3::new(x, y, 1.0);
                let met =
                    geometry.regions.iter().filter_map(|region| Some((depth_m(&geometry, region, &ray)?, region.surface.0)));
                let (depth_m, surface) = met.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, OPEN));
                let at = v * truth.width_px + u;
                let expected_m = f64::from(truth.depth_m[at]);
                looked_at += 1;
                open += usize::from(surface == OPEN);
                // The truth's depths are in single precision.
                let same = depth_m == expected_m || (depth_m / expected_m - 1.0).abs() < 1e-6;
                if !same || surface != truth.surface[at] {
                    wrong.push(format!("({u}, {v}): {depth_m} m of {surface}, ray {expected_m} m of {}", truth.surface[at]));
                }
            }
        }
        println!("{:20} {looked_at} rays, {open} into the open, {} wrong", scene.name, wrong.len());
        // Rounding decides about a ray through an edge.
        assert!(wrong.len() <= looked_at / 2000, "{}: {}\n{}", scene.name, wrong.len(), wrong[..10.min(wrong.len())].join("\n"));
        assert_eq!(open > 0, scene.name.starts_with("grille"), "{}: {open}", scene.name);
    }
}
