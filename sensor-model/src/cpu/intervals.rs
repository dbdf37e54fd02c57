//! Which columns of each row a strip lights: the inside of its band's outline.

use std::ops::Range;

use nalgebra::Vector2;

use crate::band::BandPoint;

/// The columns of a strip, row by row. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(super) struct Intervals {
    /// Columns from, up to and with the last, of each row of each strip.
    columns: Vec<[i32; 2]>,
    strips: Vec<Rows>,
}

/// The rows of a strip.
#[derive(Debug)]
struct Rows {
    rows: Range<usize>,
    /// The first row's place in the columns.
    first: usize,
}

impl Intervals {
    pub(super) fn clear(&mut self) {
        self.columns.clear();
        self.strips.clear();
    }

    /// Adds a strip's rows: between the leftmost and the rightmost crossing of a row with the outline of its band.
    pub(super) fn push(&mut self, band: &[BandPoint], width: usize, height: usize) {
        let borders = |i: usize| band[i].borders();
        let rows_of = |y: f64| (y.ceil().max(0.0) as usize).min(height);
        let (mut top, mut bottom) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in band.iter().flat_map(BandPoint::borders) {
            (top, bottom) = (top.min(point.y), bottom.max(point.y));
        }
        // A row on the lowest point counts.
        let rows = rows_of(top)..if bottom < 0.0 { 0 } else { (bottom.floor() as usize + 1).min(height) };
        let first = self.columns.len();
        let rows = rows.start..rows.end.max(rows.start);
        self.columns.resize(first + rows.len(), [i32::MAX, i32::MIN]);
        let columns = &mut self.columns[first..];
        let mut add = |a: Vector2<f64>, b: Vector2<f64>| {
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            let from = rows_of(a.y).max(rows.start);
            let slope = if b.y > a.y { (b.x - a.x) / (b.y - a.y) } else { 0.0 };
            let mut row = from;
            while row < rows.end && row as f64 <= b.y {
                let x = (a.x + (row as f64 - a.y) * slope).clamp(-1.0, width as f64);
                let [low, high] = &mut columns[row - rows.start];
                (*low, *high) = ((*low).min(x.ceil() as i32), (*high).max(x.floor() as i32));
                row += 1;
            }
        };
        for i in 1..band.len() {
            let (before, here) = (borders(i - 1), borders(i));
            add(before[0], here[0]);
            add(before[1], here[1]);
        }
        for end in [0, band.len() - 1] {
            let [a, b] = borders(end);
            add(a, b);
        }
        self.strips.push(Rows { rows, first });
    }

    /// The columns of a strip in a row, if any.
    pub(super) fn columns(&self, strip: usize, row: usize, width: usize) -> Option<Range<usize>> {
        let Rows { rows, first } = &self.strips[strip];
        if !rows.contains(&row) {
            return None;
        }
        let [low, high] = self.columns[first + row - rows.start];
        let (from, to) = (low.max(0), high.min(width as i32 - 1));
        (from <= to).then(|| from as usize..to as usize + 1)
    }
}
