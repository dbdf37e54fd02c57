//! What `ductloop render --truth` writes beside the picture OUT.png: `OUT.truth.png` for people, and for programs
//! `OUT.centres.parquet`, `OUT.depth.npy` (f4, metres, infinite where the view is open), `OUT.surface.npy` (u2, 65535 there) and
//! `OUT.normal.npy` (f4, camera frame, zeros there). A later picture of that name takes them away: they would show another frame.

use std::fs;
use std::path::{Path, PathBuf};

use ductloop::output::{centres, npy::npy};
use ductloop::{GreyImage, Scenario, truth_picture};
use ductloop_sensor::renderer::View;
use ductloop_sensor::truth::SceneTruth;
use serde_json::Value;

/// The files' names.
pub(crate) fn names(out: &Path) -> [PathBuf; 5] {
    ["truth.png", "centres.parquet", "depth.npy", "surface.npy", "normal.npy"].map(|ending| out.with_extension(ending))
}

/// The truth that an earlier call has written beside the picture: files of these names, where the picture's document is one of
/// `render`. Beside anything else they are somebody else's.
pub(crate) fn of_earlier_call(out: &Path) -> Vec<PathBuf> {
    let document = fs::read(out.with_extension("json")).ok().and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
    // A contact sheet has no truth, so what lies beside one is no more of that call.
    if !document.is_some_and(|document| document.get("scenario").is_some() && document.get("camera").is_some()) {
        return Vec::new();
    }
    names(out).into_iter().filter(|name| name.is_file()).collect()
}

/// The files of a frame that was rendered as `image`.
///
/// # Errors
/// Where the camera is outside the duct, or a file cannot be made.
pub(crate) fn of(scenario: &Scenario, view: &View, image: &GreyImage, out: &Path) -> anyhow::Result<Vec<(PathBuf, Vec<u8>)>> {
    let scene = SceneTruth::new(&scenario.duct.network()?, &scenario.actual_rig());
    let scene = if scenario.optics.shadows { scene } else { scene.without_shadows() };
    let mut truth = scene.of(&view.world_from_camera)?;
    // A laser that is off lights nothing.
    truth.centres.retain(|centre| view.laser_power[centre.laser] > 0.0);
    let lasers: Vec<&str> = scenario.rig.lasers.iter().map(|laser| laser.name.as_str()).collect();
    let surfaces: Vec<&str> = scenario.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    let rows_columns = [truth.height_px, truth.width_px];
    let files = [
        truth_picture::png(image, &truth, &lasers, &surfaces)?,
        centres::parquet(&truth.centres, &lasers)?,
        npy(&rows_columns, truth.depth_m.iter().copied()),
        npy(&rows_columns, truth.surface.iter().copied()),
        npy(&[truth.height_px, truth.width_px, 3], truth.normal.as_flattened().iter().copied()),
    ];
    Ok(names(out).into_iter().zip(files).collect())
}
