//! Counts of what was true against what was named, as a table whose fields are coloured by their share of the row, as SVG.

use std::fmt::Write;

use super::heat_map::colour;
use super::plot::escaped;
use crate::ahead_scores::Confusion;
use crate::ahead_scores::confusion::{FITTINGS, NOTHING};

/// Size of a field, room for the words of the rows and, slanting, for those of the columns.
const FIELD: [f64; 2] = [46.0, 28.0];
const LEFT: f64 = 100.0;
const TOP: f64 = 92.0;
const RIGHT: f64 = 62.0;
const BOTTOM: f64 = 8.0;
/// Shares from here on are light: text on them is dark.
const LIGHT_SHARE: f64 = 0.55;

/// The drawing; rows and columns that did not occur are left out.
pub(super) fn svg(confusion: &Confusion) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = draw(&mut out, confusion);
    out
}

fn draw(out: &mut String, confusion: &Confusion) -> std::fmt::Result {
    let words: Vec<&str> = FITTINGS.iter().map(|fitting| fitting.word()).chain([NOTHING]).collect();
    let sum = |pick: &dyn Fn(&str, &str) -> bool| -> u64 {
        confusion.pairs.iter().filter(|pair| pick(pair.truth, pair.named)).map(|pair| pair.count).sum()
    };
    let rows: Vec<&str> = words.iter().copied().filter(|word| sum(&|truth, _| truth == *word) > 0).collect();
    let columns: Vec<&str> = words.iter().copied().filter(|word| sum(&|_, named| named == *word) > 0).collect();
    let width = LEFT + columns.len() as f64 * FIELD[0] + RIGHT;
    let height = TOP + rows.len() as f64 * FIELD[1] + BOTTOM;
    writeln!(
        out,
        r#"<svg class="confusion" viewBox="0 0 {width} {height}" style="max-width:{width}px" role="img" aria-label="What was true against what was named">"#
    )?;
    writeln!(out, r#"<text x="{:.1}" y="{:.1}" text-anchor="end">true \ named</text>"#, LEFT - 8.0, TOP - 8.0)?;
    for (column, word) in columns.iter().enumerate() {
        let (x, y) = (LEFT + (column as f64 + 0.5) * FIELD[0], TOP - 6.0);
        writeln!(out, r#"<text transform="translate({x:.1} {y:.1}) rotate(-45)">{}</text>"#, escaped(word))?;
    }
    for (row, truth) in rows.iter().enumerate() {
        let all = sum(&|other, _| other == *truth);
        let y = TOP + row as f64 * FIELD[1];
        let middle = y + FIELD[1] / 2.0 + 4.0;
        writeln!(out, r#"<text x="{:.1}" y="{middle:.1}" text-anchor="end">{}</text>"#, LEFT - 8.0, escaped(truth))?;
        for (column, named) in columns.iter().enumerate() {
            let x = LEFT + column as f64 * FIELD[0];
            let [wide, high] = FIELD.map(|side| side - 1.5);
            let count = confusion.of(truth, named);
            let right = if truth == named { " right" } else { "" };
            if count == 0 {
                writeln!(out, r#"<rect class="none{right}" x="{x:.1}" y="{y:.1}" width="{wide}" height="{high}"/>"#)?;
                continue;
            }
            let share = count as f64 / all as f64;
            let (fill, ink) = (colour(share), if share > LIGHT_SHARE { "#111" } else { "#fff" });
            let title = format!("{truth} named {named}: {count} of {all}");
            writeln!(
                out,
                r#"<rect class="some{right}" x="{x:.1}" y="{y:.1}" width="{wide}" height="{high}" fill="{fill}"><title>{title}</title></rect>"#
            )?;
            let x = x + FIELD[0] / 2.0;
            writeln!(out, r#"<text x="{x:.1}" y="{middle:.1}" text-anchor="middle" style="fill:{ink}">{count}</text>"#)?;
        }
        let x = LEFT + columns.len() as f64 * FIELD[0] + 8.0;
        let share = 100.0 * confusion.of(truth, truth) as f64 / all as f64;
        writeln!(out, r#"<text x="{x:.1}" y="{middle:.1}">{share:.0} %</text>"#)?;
    }
    writeln!(out, "</svg>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_show_counts_and_rows_their_share_of_right_names() {
        let mut confusion = Confusion::default();
        confusion.count("cross", "cross", 3);
        confusion.count("cross", "unknown", 1);
        let drawing = svg(&confusion);
        assert!(drawing.contains("<title>cross named cross: 3 of 4</title>") && drawing.contains(">75 %<"), "{drawing}");
        // Two columns, one row: no field for what did not occur.
        assert_eq!(drawing.matches("<rect").count(), 2);
        assert!(!svg(&Confusion::default()).contains("NaN"));
    }
}
