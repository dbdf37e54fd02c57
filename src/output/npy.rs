//! Arrays as NPY files, version 1.0 (NumPy Enhancement Proposal 1), little-endian, in C order.

/// A kind of number that an array may hold.
pub trait Element: Copy {
    /// Its name in the file's head.
    const DESCR: &'static str;
    /// Appends its bytes.
    fn put(self, bytes: &mut Vec<u8>);
}

impl Element for f32 {
    const DESCR: &'static str = "<f4";
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Element for u16 {
    const DESCR: &'static str = "<u2";
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

/// The file of an array of this shape; `values` are as many as the product of its sides.
pub fn npy<T: Element>(shape: &[usize], values: impl IntoIterator<Item = T>) -> Vec<u8> {
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let mut head = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({sides}), }}", T::DESCR);
    // Magic, version and length take 10 bytes; data start at a multiple of 64, after a line's end.
    let padding = 64 - (10 + head.len() + 1) % 64;
    head.push_str(&" ".repeat(padding % 64));
    head.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    // A head of a few sides is far below 65536 bytes.
    file.extend((head.len() as u16).to_le_bytes());
    file.extend(head.as_bytes());
    values.into_iter().for_each(|value| value.put(&mut file));
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_is_as_numpy_reads_it() {
        let file = npy(&[2, 3], [1u16, 2, 3, 4, 5, 0x1234]);
        // NEP 1: magic, version, length of the head, a Python dictionary, spaces up to a multiple of 64, a line's end.
        let head = format!("{{'descr': '<u2', 'fortran_order': False, 'shape': (2, 3, ), }}{}\n", " ".repeat(56));
        assert_eq!(&file[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(std::str::from_utf8(&file[10..128]), Ok(head.as_str()));
        assert_eq!(&file[128..], &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 0x34, 0x12]);
        assert_eq!((npy(&[1], [1.5f32]).len() - 4) % 64, 0);
    }
}
