//! Picture files to grey values.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use ductloop::photograph::{Channel, Photograph, PhotographError};

use super::problem::Problem;

/// The largest file that is read: a device named by mistake does not fill the memory.
const LARGEST_BYTES: u64 = 512 << 20;

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
        _ => wrong(format!("cannot be read: {error}")),
    })?;
    if bytes.len() as u64 > LARGEST_BYTES {
        return Err(
            wrong(format!("larger than {} MiB, which no picture is", LARGEST_BYTES >> 20)).help("check the name of the file")
        );
    }
    Photograph::decode(&bytes, channel, max_dn).map_err(|error| {
        let help = match &error {
            PhotographError::Picture(_) => "a PNG or JPEG of 8 or 16 bits, 8192 pixels a side at most",
            PhotographError::Grey(_) => "read it with `--channel grey`, the default",
            PhotographError::TooBright { .. } => "more `--bits`",
        };
        wrong(error.to_string()).help(help)
    })
}

/// A file's bytes; one more than the bound shows that there are more.
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
