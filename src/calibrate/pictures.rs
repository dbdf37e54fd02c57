//! Stripe centres on boards out of pictures themselves.

use std::path::Path;

use ductloop_nav::calibration::boards::BoardCentre;
use ductloop_nav::perception::ridge::{Region, Ridge, RidgeParams};
use ductloop_nav::rig::Camera;

use super::boards::{Boards, base_name};
use crate::bounded_file;
use crate::photograph::{Channel, LARGEST_BYTES, Photograph};
use crate::scenario::{Diagnostic, Diagnostics};

/// The centres of a picture's stripes, inside its board's corners where they are known.
///
/// # Errors
/// A file that is no picture, one of another size than the camera's, and one that no board is known of.
pub fn centres_of_image(
    path: &Path,
    camera: &Camera,
    boards: &Boards,
    channel: Channel,
) -> Result<Vec<BoardCentre>, Diagnostics> {
    let file = path.display().to_string();
    let wrong = |message: String, help: Option<String>| Diagnostics(vec![Diagnostic::new(file.clone(), None, message, help)]);
    let Some(board) = boards.files.iter().position(|known| *known == base_name(&file)) else {
        return Err(wrong("no board is known of this picture".into(), Some(format!("boards of: {}", boards.files.join(", ")))));
    };
    let bytes = bounded_file::read(path, LARGEST_BYTES).map_err(|error| wrong(format!("cannot be read: {error}"), None))?;
    let picture = Photograph::decode(&bytes, channel, None).map_err(|error| wrong(error.to_string(), None))?;
    let ([width, height], wanted) = (picture.size_px(), [camera.width_px, camera.height_px]);
    if [width, height] != wanted {
        let message = format!("is {width} x {height} pixels; the camera has {} x {}", wanted[0], wanted[1]);
        return Err(wrong(message, Some("a picture that was cropped or scaled is another camera's".into())));
    }
    let region = boards.corners_px.as_ref().and_then(|corners| Region::polygon(&corners[board]));
    let mut ridge = Ridge::new(RidgeParams::default());
    let found = ridge.extract(&picture.frame(), region.as_ref());
    if found.is_empty() {
        return Err(wrong("no stripe was found".into(), Some("--channel says what of a coloured picture is read".into())));
    }
    let centre = |found: &ductloop_nav::perception::ridge::RidgeCentre| BoardCentre {
        board,
        pixel_px: [found.u_px, found.v_px],
        sigma_px: found.sigma_px,
    };
    Ok(found.iter().map(centre).collect())
}
