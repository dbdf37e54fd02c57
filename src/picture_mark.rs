//! A mark in a PNG that says which program made it, so that it knows its own pictures from somebody else's.
//!
//! It is a `tEXt` chunk of the keyword `Software` right after the header (PNG specification, third edition, 11.3.3.2): no viewer shows it
//! and no decoder minds it.

/// The signature and the header: no PNG begins otherwise, and every header is this long.
const HEADER_LEN: usize = 8 + 12 + 13;
const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// The picture with the mark of `program` (a few Latin letters); what is no PNG stays as it is.
pub(crate) fn marked(mut png: Vec<u8>, program: &str) -> Vec<u8> {
    if png.len() >= HEADER_LEN && png.starts_with(&SIGNATURE) {
        png.splice(HEADER_LEN..HEADER_LEN, chunk(program));
    }
    png
}

/// Whether a picture, or the first few hundred bytes of one, holds the mark of `program`.
pub(crate) fn is_marked(first: &[u8], program: &str) -> bool {
    first.starts_with(&SIGNATURE) && first.get(HEADER_LEN..).is_some_and(|rest| rest.starts_with(&chunk(program)))
}

/// Length, kind, words, checksum.
fn chunk(program: &str) -> Vec<u8> {
    let words = [b"Software\0", program.as_bytes()].concat();
    let body = [b"tEXt", &words[..]].concat();
    [&(words.len() as u32).to_be_bytes()[..], &body, &checksum(&body).to_be_bytes()].concat()
}

/// CRC-32 as PNG has it (annex D), bit by bit: it is for a few bytes.
fn checksum(bytes: &[u8]) -> u32 {
    let step = |rest: u32| if rest & 1 == 1 { 0xedb8_8320 ^ (rest >> 1) } else { rest >> 1 };
    !bytes.iter().fold(!0, |rest, byte| (0..8).fold(rest ^ u32::from(*byte), |rest, _| step(rest)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Canvas;

    #[test]
    fn a_marked_picture_is_the_same_picture_and_is_known() {
        let plain = Canvas::new(20, 10).png().expect("a picture");
        let ours = marked(plain.clone(), "ductloop perceive");
        assert!(is_marked(&ours, "ductloop perceive"));
        for other in [&plain[..], &ours[..40], b"", b"\x89PNG\r\n\x1a\n"] {
            assert!(!is_marked(other, "ductloop perceive"));
        }
        assert!(!is_marked(&ours, "ductloop render"));
        let picture = |bytes: &[u8]| image::load_from_memory(bytes).expect("a PNG");
        assert_eq!(picture(&ours), picture(&plain));
        assert_eq!(marked(b"no picture".to_vec(), "x"), b"no picture");
    }

    /// The checksum of the chunk that ends every PNG.
    #[test]
    fn the_checksum_is_pngs() {
        assert_eq!(checksum(b"IEND"), 0xae42_6082);
    }
}
