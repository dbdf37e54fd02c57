//! The renderers against each other, over scenes drawn by seed and by hand: images without noise pixel by pixel, stripe centres,
//! and what noise looks like on the mean.
#![cfg(feature = "wgpu")]

mod common;

use common::scenes::{Scene, scenes};
use ductloop_sensor::optics::{Bits, Optics};
use ductloop_sensor::renderer::Renderer;
use ductloop_sensor::truth::SceneTruth;
use ductloop_sensor::{CpuRenderer, WgpuRenderer};

/// Largest difference that one pixel in a thousand may exceed, in DN of 8 bits.
const PIXEL_DN: f64 = 1.0;
/// Of the stripes' centres, root mean square, in pixels.
const CENTRE_PX: f64 = 0.02;
/// Centres of a scene from which on they are compared.
const ENOUGH_CENTRES: usize = 30;
/// Scenes whose centres are compared, at least: in the others no stripe is seen, or none bright enough.
const SCENES_WITH_CENTRES: usize = 72;
/// Grey values of 12 bits for one of 8: what is compared is not the rounding.
const FINE: f64 = 4095.0 / 255.0;

fn fine(optics: &Optics) -> Optics {
    let mut optics = optics.clone();
    optics.ccd.bits = Bits::Twelve;
    optics
}

/// Images of both renderers, as floating-point grey values of 8 bits.
fn both(scene: &Scene, optics: &Optics, frame: u64) -> Option<[Vec<f64>; 2]> {
    let gpu = common::gpu()?;
    let Scene { rig, network, looks, .. } = scene;
    let mut view = scene.view.clone();
    view.frame = frame;
    let mut cpu = CpuRenderer::new(network, rig, optics, looks, 3, 1).expect("a sound scene");
    let mut wgpu = WgpuRenderer::new(gpu, network, rig, optics, looks, 3).expect("a sound scene");
    let engines: [&mut dyn Renderer; 2] = [&mut cpu, &mut wgpu];
    Some(engines.map(|engine| {
        let mut image = vec![0_u16; rig.camera.width_px * rig.camera.height_px];
        engine.render(&view, image.as_mut_slice().into()).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        image.iter().map(|value| f64::from(*value) / FINE).collect()
    }))
}

/// The value that a share of all values does not exceed.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

/// Centroid of the light about a place on a line of the image (a column where `down`), above the lower of the two ends of the window.
fn centroid(image: &[f64], width: usize, height: usize, u: f64, v: f64, down: bool, half: i64) -> Option<f64> {
    let (along, line, length) = if down { (v, u, height) } else { (u, v, width) };
    let (middle, line) = (along.round() as i64, line.round() as usize);
    if middle < half || middle + half >= length as i64 {
        return None;
    }
    let at = |k: i64| if down { image[k as usize * width + line] } else { image[line * width + k as usize] };
    let floor = at(middle - half).min(at(middle + half));
    let (mut sum, mut first) = (0.0, 0.0);
    for k in middle - half..=middle + half {
        let light = (at(k) - floor).max(0.0);
        sum += light;
        first += light * (k - middle) as f64;
    }
    // A faint stripe's centroid is the rounding's.
    (sum > 60.0).then(|| middle as f64 + first / sum)
}

/// Root mean square of the differences of the stripes' centroids, and their number; `None` where there are too few to tell.
fn centres(scene: &Scene, images: &[Vec<f64>; 2]) -> Option<(f64, usize)> {
    let truth = SceneTruth::new(&scene.network, &scene.rig).of(&scene.view.world_from_camera).expect("a camera in the duct");
    let (width, height) = (scene.rig.camera.width_px, scene.rig.camera.height_px);
    let mut squares = Vec::new();
    for point in &truth.centres {
        let down = (point.u_px - point.u_px.round()).abs() < 1e-6;
        let half = if scene.rig.camera.focal_px[0] > 700.0 { 16 } else { 7 };
        let [a, b] = [0, 1].map(|i| centroid(&images[i], width, height, point.u_px, point.v_px, down, half));
        if let (Some(a), Some(b)) = (a, b) {
            squares.push((a - b) * (a - b));
        }
    }
    (squares.len() >= ENOUGH_CENTRES).then(|| ((squares.iter().sum::<f64>() / squares.len() as f64).sqrt(), squares.len()))
}

/// The two images and twenty times their difference, side by side.
fn save(name: &str, scene: &Scene, images: &[Vec<f64>; 2]) -> String {
    let (width, height) = (scene.rig.camera.width_px, scene.rig.camera.height_px);
    let picture = image::GrayImage::from_fn(3 * width as u32, height as u32, |x, y| {
        let (part, at) = (x as usize / width, y as usize * width + x as usize % width);
        let value = match part {
            2 => 20.0 * (images[0][at] - images[1][at]).abs(),
            part => images[part][at],
        };
        image::Luma([value.clamp(0.0, 255.0) as u8])
    });
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("agreement");
    std::fs::create_dir_all(&folder).expect("the folder for pictures can be made");
    let file = folder.join(format!("{name}.png"));
    picture.save(&file).expect("the picture can be written");
    file.display().to_string()
}

#[test]
fn both_renderers_make_the_same_image_of_every_scene() {
    let scenes = scenes();
    assert!(scenes.len() >= 70, "only {} scenes", scenes.len());
    let (mut worst, mut wrong) = ((0.0, String::new()), Vec::new());
    let (mut compared, mut with_centres, mut without) = (0, 0, Vec::new());
    for scene in &scenes {
        let Some(images) = both(scene, &fine(&scene.optics), 7) else { return };
        let differences = || images[0].iter().zip(&images[1]).map(|(a, b)| (a - b).abs());
        let (pixels, largest) = (quantile(differences(), 0.999), quantile(differences(), 1.0));
        let found = centres(scene, &images);
        let words = found.map_or("no centres".to_owned(), |(off_px, count)| format!("centres {off_px:.4} px of {count}"));
        println!("{:18} 99.9 %: {pixels:.3} DN, worst {largest:.2} DN; {words}", scene.name);
        match found {
            Some((_, count)) => (compared, with_centres) = (compared + count, with_centres + 1),
            None => without.push(scene.name.as_str()),
        }
        if pixels > worst.0 {
            worst = (pixels, save("worst", scene, &images));
        }
        if pixels >= PIXEL_DN || found.is_some_and(|(off_px, _)| off_px >= CENTRE_PX) {
            wrong.push(format!("{}: {pixels:.2} DN, {words} ({})", scene.name, save(&scene.name, scene, &images)));
        }
    }
    println!("{} scenes, {compared} centres in {with_centres} of them; the worst: {} DN, {}", scenes.len(), worst.0, worst.1);
    assert!(with_centres >= SCENES_WITH_CENTRES, "{with_centres} scenes with centres; without: {}", without.join(", "));
    assert!(compared > 10_000, "only {compared} stripe centres were compared");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Mean and variance of the same scene's noise, by grey value: the same distribution, if not the same numbers.
#[test]
fn noise_has_the_same_statistics_in_both() {
    let scenes = scenes();
    let mut compared = 0;
    for name in ["straight", "everything", "facing", "looking-down"] {
        let scene = scenes.iter().find(|scene| scene.name == name).expect("a scene of this name");
        let mut noisy = fine(&scene.optics);
        noisy.noise = true;
        noisy.ccd.dsnu_e = 20.0;
        noisy.ccd.dark_current_e_s = 2e4;
        // By grey value: number, sum and sum of squares in each engine.
        let mut sums = [[[0.0_f64; 3]; 2]; 6];
        for frame in 0..6 {
            let Some(quiet) = both(scene, &fine(&scene.optics), frame) else { return };
            let Some(images) = both(scene, &noisy, frame) else { return };
            for (engine, image) in images.iter().enumerate() {
                for (noisy, quiet) in image.iter().zip(&quiet[0]) {
                    let [count, sum, squares] = &mut sums[((quiet / 40.0) as usize).min(5)][engine];
                    let off = noisy - quiet;
                    *count += 1.0;
                    *sum += off;
                    *squares += off * off;
                }
            }
        }
        for (class, engines) in sums.iter().enumerate() {
            let [(n, mean, variance), other] =
                engines.map(|[n, first, second]| (n, first / n, second / n - (first / n) * (first / n)));
            if n < 2000.0 {
                continue;
            }
            compared += usize::from(class > 0);
            println!(
                "{name}, from {} DN: {mean:.3} and {:.3} DN, variance {variance:.3} and {:.3}",
                40 * class,
                other.1,
                other.2
            );
            // Fixed patterns are the same pixels' in both, so the pixels are not independent draws: six standard errors of independent
            // ones, and for what their images without noise differ in half a step of 12 bits, and a percent of the variance.
            let (of_mean, of_variance) = (6.0 * (variance / n).sqrt() + 0.03, 6.0 * (2.0 / n).sqrt() + 0.01);
            assert!((mean - other.1).abs() < of_mean, "{name}, class {class}");
            assert!((variance / other.2 - 1.0).abs() < of_variance, "{name}, class {class}");
        }
    }
    assert!(compared >= 5, "light was compared in {compared} classes of grey values only");
}
