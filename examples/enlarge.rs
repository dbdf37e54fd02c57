//! Cuts a window out of a grey PNG, stretches its grey values and enlarges its pixels, so that what is faint or small is seen on a
//! page. `docs/gallery.sh` calls it.
//!
//! ```text
//! cargo run --release --example enlarge -- IN.png OUT.png X,Y,WIDTH,HEIGHT TIMES [BLACK,WHITE]
//! ```
//!
//! The window is in pixels from the top left, each of which becomes TIMES x TIMES. BLACK and WHITE are the values of the file (of 8
//! or 16 bits) that become 0 and 255; without them an 8-bit file keeps its own.

use std::error::Error;

use image::{DynamicImage, GrayImage, ImageReader, Luma};

/// The picture's values, 16 bits wide, as they are in the file.
fn values(image: DynamicImage) -> (u32, u32, Vec<u16>) {
    let (width, height) = (image.width(), image.height());
    let values = match image {
        DynamicImage::ImageLuma8(image) => image.into_raw().into_iter().map(u16::from).collect(),
        other => other.into_luma16().into_raw(),
    };
    (width, height, values)
}

/// So many whole numbers between commas.
fn numbers<const N: usize>(text: &str) -> Result<[u32; N], Box<dyn Error>> {
    let numbers: Vec<u32> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| format!("`{text}` is not {N} numbers").into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to, window, times, range @ ..] = &arguments[..] else {
        return Err("IN.png OUT.png X,Y,WIDTH,HEIGHT TIMES [BLACK,WHITE]".into());
    };
    let [x, y, width, height] = numbers(window)?;
    let [times] = numbers(times)?;
    let [black, white] = match range {
        [] => [0, 255],
        [range] => numbers(range)?,
        _ => return Err("one range at most".into()),
    };
    let (columns, rows, values) = values(ImageReader::open(from)?.decode()?);
    if x + width > columns || y + height > rows || times == 0 || white <= black {
        return Err(format!("the window must be within {columns} x {rows}, TIMES 1 or more, WHITE above BLACK").into());
    }
    let stretched = GrayImage::from_fn(width * times, height * times, |u, v| {
        let value = u32::from(values[((y + v / times) * columns + x + u / times) as usize]);
        // Both differences are of 16 bits: the product of one with 255 fits.
        Luma([((value.clamp(black, white) - black) * 255 / (white - black)) as u8])
    });
    stretched.save(to)?;
    Ok(())
}
