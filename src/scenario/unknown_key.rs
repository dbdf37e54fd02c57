//! What may have been meant by a key that nobody knows.

use super::check::{inside, quoted};
use super::diagnostic::Finding;
use super::fields::{Field, TableShape, fields};
use super::tree::Entry;
use super::value;

/// Units that end a key, each with the SI unit it stands for and its size in that.
const UNITS: &[(&str, &str, f64)] = &[
    ("m", "m", 1.0),
    ("cm", "m", 1e-2),
    ("mm", "m", 1e-3),
    ("um", "m", 1e-6),
    ("s", "s", 1.0),
    ("ms", "s", 1e-3),
    ("us", "s", 1e-6),
    ("hz", "hz", 1.0),
    ("khz", "hz", 1e3),
    ("rad", "rad", 1.0),
    ("mrad", "rad", 1e-3),
    ("deg", "rad", std::f64::consts::PI / 180.0),
    ("kg", "kg", 1.0),
    ("g", "kg", 1e-3),
    ("m_s", "m/s", 1.0),
    ("mm_s", "m/s", 1e-3),
    ("cm_s", "m/s", 1e-2),
];

/// The error for a key that does not belong in a table.
pub(super) fn finding(shape: &TableShape, path: &str, entry: &Entry) -> Finding {
    finding_beside(shape, path, entry, &[])
}

/// The same where other keys may stand beside those of a scenario: an accuracy study's.
pub(super) fn finding_beside(shape: &TableShape, path: &str, entry: &Entry, others: &[&'static str]) -> Finding {
    let finding = Finding::new(entry.key_span, format!("unknown key `{}` {}", entry.key, inside(path)));
    let known: Vec<_> = shape.keys().chain(others.iter().copied()).collect();
    if let Some(field) = other_unit(shape, entry) {
        return finding.help(in_unit(field, entry));
    }
    if let Some(near) = nearest(&entry.key, known.iter().copied()) {
        let about = shape.leaves().find(|f| f.key() == near).map_or_else(String::new, |f| format!(" {}", f.sentence()));
        return finding.help(format!("did you mean `{near}`?{about}"));
    }
    let elsewhere: Vec<_> = fields().filter(|f| f.key() == entry.key).map(|f| f.path).collect();
    if !elsewhere.is_empty() {
        return finding.help(format!("it belongs elsewhere: {}", quoted(&elsewhere)));
    }
    finding.help(format!("known here: {}", quoted(&known)))
}

/// The key that was probably meant by an unknown one.
pub(super) fn meant(shape: &TableShape, entry: &Entry) -> Option<&'static str> {
    if shape.child(&entry.key).is_some() {
        return None;
    }
    other_unit(shape, entry).map(Field::key).or_else(|| nearest(&entry.key, shape.keys()))
}

/// The field for the same quantity in another unit: `width_m` for `width_mm`.
fn other_unit(shape: &TableShape, entry: &Entry) -> Option<&'static Field> {
    let (stem, unit) = split(&entry.key)?;
    shape.leaves().find(|field| split(field.key()).is_some_and(|(known, in_unit)| known == stem && in_unit.1 == unit.1))
}

/// The field's unit, and the value in it.
fn in_unit(field: &Field, entry: &Entry) -> String {
    let example = || {
        let (typed, known) = (split(&entry.key)?.1, split(field.key())?.1);
        let x = entry.node.as_number().filter(|x| x.is_finite())?;
        // Twelve digits: what a person typed, without what the division rounds.
        let converted: f64 = format!("{:.11e}", x * typed.2 / known.2).parse().ok()?;
        Some(format!(", as in `{} = {}`", field.key(), value::shown(converted)))
    };
    format!("the key is `{}`, in {}{}", field.key(), unit_name(field), example().unwrap_or_default())
}

fn unit_name(field: &Field) -> &'static str {
    if field.unit.is_empty() { "its own unit" } else { field.unit }
}

/// A key without its unit, and the unit.
fn split(key: &str) -> Option<(&str, &'static (&'static str, &'static str, f64))> {
    let fits = |(unit, ..): &&(&str, &str, f64)| key.strip_suffix(*unit).is_some_and(|stem| stem.ends_with('_'));
    let unit = UNITS.iter().filter(fits).max_by_key(|(unit, ..)| unit.len())?;
    Some((key[..key.len() - unit.0.len()].trim_end_matches('_'), unit))
}

/// The nearest of some words, if it is near enough to have been meant.
pub(super) fn nearest<'w>(typed: &str, words: impl Iterator<Item = &'w str>) -> Option<&'w str> {
    let limit = 1 + typed.chars().count() / 4;
    words.map(|word| (distance(typed, word), word)).filter(|(d, _)| *d <= limit).min_by_key(|(d, _)| *d).map(|(_, word)| word)
}

/// The words that may have been meant, nearest first: what is within a few edits of what was typed, then what holds all of its parts
/// (`left-elbow` for `elbow-left`), or is held by it. Five at most.
pub fn near<'w>(typed: &str, words: impl Iterator<Item = &'w str>) -> Vec<&'w str> {
    let typed = typed.to_lowercase();
    let limit = 1 + typed.chars().count() / 4;
    let parts: Vec<&str> = typed.split(|c: char| !c.is_alphanumeric()).filter(|part| part.len() > 2).collect();
    let alike = |word: &str| !parts.is_empty() && parts.iter().all(|part| word.contains(part));
    let rank = |word: &str| {
        let edits = distance(&typed, word);
        (edits <= limit || alike(word) || word.split('-').all(|part| parts.contains(&part))).then_some((edits > limit, edits))
    };
    let mut found: Vec<_> = words.filter_map(|word| Some((rank(word)?, word))).collect();
    found.sort();
    found.dedup();
    found.into_iter().take(5).map(|(_, word)| word).collect()
}

/// Edits from one word to another: characters put in, left out, replaced, or two neighbours exchanged (optimal string
/// alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.to_lowercase().chars().collect(), b.to_lowercase().chars().collect());
    // Only the start of a text of a length that no word has is compared: an absurd key must not cost quadratic time.
    let a = &a[..a.len().min(80)];
    let mut rows: [Vec<usize>; 3] = [vec![0; b.len() + 1], (0..=b.len()).collect(), vec![0; b.len() + 1]];
    for i in 1..=a.len() {
        rows[2][0] = i;
        for j in 1..=b.len() {
            let replaced = rows[1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(rows[1][j] + 1).min(rows[2][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[0][j - 2] + 1);
            }
            rows[2][j] = best;
        }
        rows.rotate_left(1);
    }
    rows[1][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_found_and_far_ones_are_not() {
        assert_eq!(distance("sped_m_s", "speed_m_s"), 1);
        assert_eq!(distance("hieght_m", "height_m"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(nearest("galvanized", ["painted", "galvanised"].into_iter()), Some("galvanised"));
        assert_eq!(nearest("banana", ["painted", "galvanised"].into_iter()), None);
    }

    #[test]
    fn names_are_near_by_their_letters_or_by_their_parts() {
        let near = |typed| near(typed, ["elbow-left", "elbow-right", "tee-left", "elbows", "drop"].into_iter());
        assert_eq!(near("elbow-lfet"), ["elbow-left"]);
        assert_eq!(near("left-elbow"), ["elbow-left"]);
        assert_eq!(near("elbow"), ["elbows", "elbow-left", "elbow-right"]);
        assert_eq!(near("drop-in-the-floor"), ["drop"]);
        assert_eq!(near("Tee-Left"), ["tee-left"]);
        assert_eq!(near("banana"), [""; 0]);
        assert_eq!(near(""), [""; 0]);
    }

    #[test]
    fn a_key_splits_into_stem_and_unit() {
        assert_eq!(split("width_mm").map(|(stem, unit)| (stem, unit.0)), Some(("width", "mm")));
        assert_eq!(split("speed_m_s").map(|(stem, unit)| (stem, unit.0)), Some(("speed", "m_s")));
        assert_eq!(split("surface"), None);
    }
}
