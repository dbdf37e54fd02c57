//! Picture files to grey values.

use std::io;
use std::path::Path;

use ductloop::bounded_file;
use ductloop::photograph::{Channel, LARGEST_BYTES, Photograph, PhotographError};

use super::problem::Problem;

/// Reads a picture; `max_dn` is the value at which a pixel of 16 bits is full.
///
/// # Errors
/// Where there is no such file, or it is no picture of this kind.
pub(crate) fn read(path: &Path, channel: Channel, max_dn: Option<u16>) -> Result<Photograph, Problem> {
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message).about(path.display().to_string());
    let bytes = bytes(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            wrong("there is no such file".into()).help("check the name; relative paths start from the working directory")
        }
        io::ErrorKind::IsADirectory => {
            wrong("this is a folder, not a picture".into()).help("name the files in it, as in `FOLDER/*.png`")
        }
        io::ErrorKind::FileTooLarge => wrong(format!("{error}, which no picture is")).help("check the name of the file"),
        _ => wrong(format!("cannot be read: {error}")),
    })?;
    Photograph::decode(&bytes, channel, max_dn).map_err(|error| {
        let help = match &error {
            PhotographError::Picture(_) => "a PNG or JPEG of 8 or 16 bits, 8192 pixels a side at most",
            PhotographError::CutShort => "copy or download it again; what is missing may be half of it",
            PhotographError::Grey(_) => "read it with `--channel grey`, the default",
            PhotographError::TooBright { .. } => "more `--bits`",
        };
        wrong(error.to_string()).help(help)
    })
}

/// A file's bytes.
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    bounded_file::read(path, LARGEST_BYTES)
}
