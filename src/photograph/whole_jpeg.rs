//! Whether a JPEG is all there. Decoders go on where its data break off, with grey for the rest.

/// Start of a scan, end of the image (ITU-T T.81, table B.1).
const SCAN: u8 = 0xda;
const END: u8 = 0xd9;

/// Whether an end of image follows the first scan. Segments are passed over by their lengths, so that a thumbnail's end does not
/// count; within a scan 0xff stands before a zero or is a marker (T.81, B.1.1.5), so scans after the first are found alike.
pub(super) fn has_end(jpeg: &[u8]) -> bool {
    let mut at = 0;
    let mut is_in_scan = false;
    while let Some(&[marker, code]) = jpeg.get(at..at + 2) {
        at += match (marker, code) {
            (0xff, END) if is_in_scan => return true,
            // A marker may be filled up with more of these.
            (0xff, 0xff) => 1,
            // Stuffing, and markers without a segment.
            (0xff, 0x00 | 0x01 | 0xd0..=0xd9) => 2,
            (0xff, code) => {
                is_in_scan |= code == SCAN;
                let length = jpeg.get(at + 2..at + 4).map_or(0, |two| usize::from(two[0]) << 8 | usize::from(two[1]));
                2 + length
            }
            _ => 1,
        };
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_counts_behind_a_scan_only() {
        let of = |parts: &[&[u8]]| has_end(&parts.concat());
        let start: &[u8] = &[0xff, 0xd8];
        // A segment of application data that holds a whole small JPEG, a table, a scan's header of no bytes, data with stuffing.
        let thumbnail: &[u8] = &[0xff, 0xe1, 0, 10, 0xff, 0xd8, 0xff, 0xda, 0, 2, 0xff, 0xd9];
        let table: &[u8] = &[0xff, 0xc4, 0, 4, 0xff, 0xd9];
        let scan: &[u8] = &[0xff, 0xda, 0, 2, 1, 2, 0xff, 0, 0xd9, 0xff, 0xd0, 7];
        let end: &[u8] = &[0xff, 0xff, 0xd9];
        assert!(of(&[start, thumbnail, table, scan, end]));
        assert!(of(&[start, scan, table, scan, end, b"what cameras write behind it"]));
        assert!(!of(&[start, thumbnail, table, scan]));
        assert!(!of(&[start, scan, table, scan]) && !of(&[start, scan, thumbnail, &scan[..4]]));
        assert!(!of(&[start, end]) && !of(&[]) && !of(&[start, &[0xff]]));
    }
}
