//! A binary image, 64 pixels to a word, so that morphology handles 64 pixels with each operation.

/// A binary image. Bits past the width are always zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BitImage {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl BitImage {
    /// Sets the size and clears every pixel.
    pub fn reset(&mut self, width: usize, height: usize) {
        self.width = width;
        self.height = height;
        self.words_per_row = width.div_ceil(64);
        self.words.clear();
        self.words.resize(self.words_per_row * height, 0);
    }

    /// The words of a row; bit i of word j is column 64 j + i.
    pub fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_per_row..(y + 1) * self.words_per_row]
    }

    /// The words of a row, to change. Leave the bits past the width zero.
    pub fn row_mut(&mut self, y: usize) -> &mut [u64] {
        &mut self.words[y * self.words_per_row..(y + 1) * self.words_per_row]
    }

    /// One pixel.
    pub fn get(&self, x: usize, y: usize) -> bool {
        self.row(y)[x / 64] >> (x % 64) & 1 == 1
    }

    /// Sets one pixel.
    pub fn set(&mut self, x: usize, y: usize) {
        self.row_mut(y)[x / 64] |= 1 << (x % 64);
    }

    /// How many pixels are set.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// The bits of the last word of a row that lie within the width.
    pub fn last_word_mask(&self) -> u64 {
        match self.width % 64 {
            0 => u64::MAX,
            used => (1 << used) - 1,
        }
    }
}
