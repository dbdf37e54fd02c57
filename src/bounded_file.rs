//! Files read up to a bound: a device or an image named by mistake does not fill the memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// A file's bytes.
///
/// # Errors
/// What the system says, and [`ErrorKind::FileTooLarge`] where there are more than `most_bytes`, whole MiB.
pub fn read(path: &Path, most_bytes: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One more than the bound shows that there are more.
    File::open(path)?.take(most_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it is larger than {} MiB", most_bytes >> 20)));
    }
    Ok(bytes)
}

/// The same of a text.
///
/// # Errors
/// As [`read`], and [`ErrorKind::InvalidData`] where it is not UTF-8.
pub fn read_text(path: &Path, most_bytes: u64) -> Result<String> {
    String::from_utf8(read(path, most_bytes)?).map_err(|_| Error::new(ErrorKind::InvalidData, "it is not UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_the_bound_is_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        for (size, fits) in [(0, true), (1 << 20, true), ((1 << 20) + 1, false)] {
            std::fs::write(&path, vec![b'a'; size]).expect("a file");
            let read = read_text(&path, 1 << 20);
            assert_eq!(read.as_ref().map_or_else(|error| error.kind() == ErrorKind::FileTooLarge, |_| false), !fits, "{size}");
            assert!(!fits || read.is_ok_and(|text| text.len() == size));
        }
        std::fs::write(&path, [0xff]).expect("a file");
        assert_eq!(read_text(&path, 1 << 20).map_err(|error| error.kind()), Err(ErrorKind::InvalidData));
    }
}
