//! `frames/*.png`: the key frames of a run, each plain and with the lines that the navigator found in it.

use ductloop_nav::rig::Camera;
use image::ImageResult;

use crate::picture::{grey_png, overlay_png};
use crate::record::RunRecord;

/// Names within the run's folder, and the files' bytes.
///
/// # Errors
/// When an image has another size than the camera's.
pub fn pictures(run: &RunRecord, camera: &Camera) -> ImageResult<Vec<(String, Vec<u8>)>> {
    let mut pictures = Vec::new();
    for key in run.key_frames.spread() {
        let (width, height) = (camera.width_px, camera.height_px);
        pictures.push((format!("frames/{:06}.png", key.frame), grey_png(&key.image, width, height)?));
        pictures.push((format!("frames/{:06}-lines.png", key.frame), overlay_png(&key.image, width, height, &key.lines)?));
    }
    Ok(pictures)
}
