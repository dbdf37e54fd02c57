//! `frames/*.png`: the key frames of a run, each plain and with the lines that the navigator found in it. The plain ones hold
//! the grey values as they are, in 16 bits where the CCD has 10 or 12.

use image::ImageResult;

use crate::picture::{grey_png, overlay_png};
use crate::record::RunRecord;

/// Names within the run's folder, and the files' bytes.
///
/// # Errors
/// None that is known of.
pub fn pictures(run: &RunRecord) -> ImageResult<Vec<(String, Vec<u8>)>> {
    let mut pictures = Vec::new();
    for key in run.key_frames.spread() {
        pictures.push((format!("frames/{:06}.png", key.frame), grey_png(&key.image)?));
        pictures.push((format!("frames/{:06}-lines.png", key.frame), overlay_png(&key.image, &key.lines)?));
    }
    Ok(pictures)
}
