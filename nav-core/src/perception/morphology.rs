//! Opening and closing of a binary image (section 4.1, "noises are rejected by morphology expansion and reduction").
//!
//! The element is a box of odd sides. What lies outside the image counts as unset.

use super::bit_image::BitImage;

/// Sides of the structuring element, both odd.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    /// Along the rows, along the stripe.
    pub along_px: usize,
    /// Across the rows.
    pub across_px: usize,
}

/// Erosion, then dilation: removes what the element does not fit into. `spare` is room to work in.
pub fn open(image: &mut BitImage, element: Element, spare: &mut BitImage) {
    pass(image, element, spare, Pass::Erode);
    pass(image, element, spare, Pass::Dilate);
}

/// Dilation, then erosion: fills gaps that the element does not fit into. `spare` is room to work in.
pub fn close(image: &mut BitImage, element: Element, spare: &mut BitImage) {
    pass(image, element, spare, Pass::Dilate);
    pass(image, element, spare, Pass::Erode);
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Pass {
    Erode,
    Dilate,
}

/// Erodes or dilates by the box, first along the rows, then across them.
fn pass(image: &mut BitImage, element: Element, spare: &mut BitImage, pass: Pass) {
    spare.reset(image.width, image.height);
    let mask = image.last_word_mask();
    let combine = |a: u64, b: u64| if pass == Pass::Erode { a & b } else { a | b };
    for y in 0..image.height {
        let source = image.row(y);
        let target = spare.row_mut(y);
        target.copy_from_slice(source);
        for reach in 1..=element.along_px / 2 {
            for j in 0..source.len() {
                let before = if j > 0 { source[j - 1] } else { 0 };
                let after = source.get(j + 1).copied().unwrap_or(0);
                let left = source[j] << reach | before >> (64 - reach);
                let right = source[j] >> reach | after << (64 - reach);
                target[j] = combine(combine(target[j], left), right);
            }
        }
        if let Some(last) = target.last_mut() {
            *last &= mask;
        }
    }
    let reach = element.across_px / 2;
    for y in 0..image.height {
        let complete = y >= reach && y + reach < image.height;
        let rows = y.saturating_sub(reach)..=(y + reach).min(image.height - 1);
        for (j, word) in image.row_mut(y).iter_mut().enumerate() {
            *word = match pass {
                Pass::Erode if !complete => 0,
                Pass::Erode => rows.clone().fold(u64::MAX, |all, r| all & spare.row(r)[j]),
                Pass::Dilate => rows.clone().fold(0, |any, r| any | spare.row(r)[j]),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Element = Element { along_px: 3, across_px: 3 };

    /// The definition, pixel by pixel.
    fn reference(image: &BitImage, element: Element, erode: bool) -> BitImage {
        let mut out = BitImage::default();
        out.reset(image.width, image.height);
        let (hx, hy) = (element.along_px as isize / 2, element.across_px as isize / 2);
        for y in 0..image.height as isize {
            for x in 0..image.width as isize {
                let mut values = (-hy..=hy).flat_map(|dy| (-hx..=hx).map(move |dx| (x + dx, y + dy))).map(|(x, y)| {
                    let inside = x >= 0 && y >= 0 && x < image.width as isize && y < image.height as isize;
                    inside && image.get(x as usize, y as usize)
                });
                if if erode { values.all(|v| v) } else { values.any(|v| v) } {
                    out.set(x as usize, y as usize);
                }
            }
        }
        out
    }

    fn pattern(width: usize, height: usize, seed: u64) -> BitImage {
        let mut image = BitImage::default();
        image.reset(width, height);
        let mut state = seed;
        for y in 0..height {
            for x in 0..width {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                if state >> 61 > 2 {
                    image.set(x, y);
                }
            }
        }
        image
    }

    #[test]
    fn opening_and_closing_agree_with_their_definition() {
        for (seed, element) in [(1, BOX), (2, Element { along_px: 5, across_px: 1 }), (3, Element { along_px: 1, across_px: 5 })]
        {
            let image = pattern(131, 40, seed);
            let mut spare = BitImage::default();
            let mut opened = image.clone();
            open(&mut opened, element, &mut spare);
            assert_eq!(opened, reference(&reference(&image, element, true), element, false), "{element:?}");
            let mut closed = image.clone();
            close(&mut closed, element, &mut spare);
            assert_eq!(closed, reference(&reference(&image, element, false), element, true), "{element:?}");
        }
    }

    #[test]
    fn opening_removes_a_speck_and_keeps_a_stripe() {
        let mut image = BitImage::default();
        image.reset(100, 30);
        image.set(50, 3);
        image.set(51, 3);
        for x in 10..90 {
            for y in 14..17 {
                image.set(x, y);
            }
        }
        open(&mut image, BOX, &mut BitImage::default());
        assert!(!image.get(50, 3) && image.get(10, 14) && image.get(89, 16));
        assert_eq!(image.count(), 80 * 3);
    }
}
