//! The bound against what it claims: profiles against rendered images, motions of the stripes against moved robots, and the scatter of
//! efficient estimates, over columns made by its own model and over rendered frames, against the bound itself.

use ductloop::accuracy::bound::column::{Noise, Stripe, information as column_information};
use ductloop::accuracy::bound::light::Light;
use ductloop::accuracy::bound::{information, motion, wall_block};
use ductloop::engine::Engine;
use ductloop::stage_scores::{Scan, StageTruth, TrueCentre, TruthScene};
use ductloop::viewpoint::{still, world_from_camera};
use ductloop::{GreyImage, Scenario};
use ductloop_duct::Transform;
use ductloop_nav::messages::Pixels;
use ductloop_nav::perception::Wall;
use ductloop_sensor::renderer::View;
use ductloop_sensor::truth::SceneTruth;
use nalgebra::{Matrix2, Matrix3, Translation3, UnitQuaternion, Vector2, Vector3};

fn scenario(rig: &str, more: &str) -> Scenario {
    let surface = if more.contains("surface.sheet") { "sheet" } else { "galvanised" };
    let text = format!(
        "format = 1\nkind = \"scenario\"\nname = \"x\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{{ straight_m = 16.0 }}]\n\
         surface = \"{surface}\"\n[sensor]\npreset = \"{rig}\"\n{more}\n"
    );
    Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{wrong}"))
}

/// A robot in the middle of the duct.
struct Stand {
    scene: TruthScene,
    base: Transform,
    camera: Transform,
}

impl Stand {
    fn at(scenario: &Scenario, lateral_m: f64, heading_deg: f64) -> Self {
        let scene = TruthScene::new(scenario).expect("a duct");
        let base = Transform::from_parts(
            Translation3::new(6.0, lateral_m, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading_deg.to_radians()),
        );
        let camera = world_from_camera(scene.rig(), &base, scenario.rig.mount.rest, Default::default());
        Self { scene, base, camera }
    }

    fn truth(&self, laser_power: &[f64]) -> StageTruth {
        self.scene.of(&self.base, &self.camera, 0, laser_power).expect("a camera in the duct")
    }

    fn view(&self, scenario: &Scenario, frame: u64, laser_power: [f64; 4]) -> View {
        View { frame, laser_power, ..still(self.camera, scenario.first_exposure_s()) }
    }
}

/// Where rays through every pixel say that the stripes are.
#[test]
fn stripes_are_where_rays_find_them() {
    for (rig, lens) in [("wide", [0.0; 2]), ("incra1", [0.0; 2]), ("wide", [-0.2, 0.02])] {
        let scenario = scenario(rig, &format!("[sensor.camera]\ndistortion = [{:?}, {:?}, 0.0, 0.0, 0.0]", lens[0], lens[1]));
        for (lateral_m, heading_deg) in [(0.0, 0.0), (0.07, 5.0), (-0.05, -6.0)] {
            let stand = Stand::at(&scenario, lateral_m, heading_deg);
            let truth = stand.truth(&[1.0; 4]);
            let rays = SceneTruth::new(&scenario.duct.network().unwrap(), stand.scene.rig()).of(&stand.camera).unwrap();
            let (mut square, mut matched) = (0.0, 0);
            for point in &rays.centres {
                let down = point.u_px.fract() == 0.0;
                let (scan, line, at_px) =
                    if down { (Scan::Column, point.u_px, point.v_px) } else { (Scan::Row, point.v_px, point.u_px) };
                let found = truth.in_line(scan, line as usize).map(|i| &truth.centres[i]);
                let off = found.filter(|c| c.laser == point.laser).map(|c| (c.at_px - at_px).abs()).fold(f64::INFINITY, f64::min);
                if off < 0.5 {
                    square += off * off;
                    matched += 1;
                }
            }
            let (counted, rms) = (truth.centres.iter().filter(|c| c.counts()).count(), (square / f64::from(matched)).sqrt());
            println!("{rig} {lateral_m} {heading_deg}: {matched} of {}, {counted} here, {rms:.6} px", rays.centres.len());
            // Interpolation over a pixel, through a lens that bends by 20 %.
            assert!(rms < 1e-3, "{rms}");
            // The ends of pieces are left out: a pixel for each end of each laser on each plane.
            let missing = rays.centres.len() as i64 - i64::from(matched);
            assert!(missing <= 24 && (counted as i64 - rays.centres.len() as i64).abs() <= 24, "{missing} {counted}");
        }
    }
}

/// Each stripe's profile against the image without noise: what the pixels of a column add up to, and the brightest of them.
#[test]
fn profiles_are_those_of_the_images() {
    const SHINY: &str = "albedo = 0.3\nspecular = 0.3\nroughness = 0.4\nfriction = 0.7";
    const MATT: &str = "albedo = 0.5\nfriction = 0.7";
    for (rig, surface) in [("wide", SHINY), ("incra1", SHINY), ("wide", MATT)] {
        let scenario = scenario(rig, &format!("noise = false\n[sensor.ccd]\nbits = 12\n[surface.sheet]\n{surface}"));
        let stand = Stand::at(&scenario, 0.03, 3.0);
        let power = [1.0, 0.0, 0.0, 0.0];
        let truth = stand.truth(&power);
        let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        let mut renderer = Engine::Cpu.renderer(&scenario, 1).unwrap();
        renderer.render(&stand.view(&scenario, 0, power), image.room()).unwrap();
        let light = Light::new(&scenario, &stand.scene, &power);
        let noise = Noise::of(&scenario.optics, scenario.first_exposure_s());
        let (mut worst_sum, mut worst_peak, mut square_background, mut count) = (0.0_f64, 0.0_f64, 0.0, 0);
        for centre in inner(&truth, 12) {
            let Some(stripe) = light.stripe(&truth, centre) else { continue };
            let Some(pixels) = column(&image, centre, &stripe) else { continue };
            let expected: Vec<f64> = pixels.iter().map(|(at, _)| stripe.light(*at).0 + stripe.background_dn).collect();
            // Neither full, nor so faint that steps of a sixteenth count.
            let peak_dn = stripe.light(stripe.centre_px).0;
            if peak_dn < 20.0 || expected.iter().any(|dn| *dn > 0.97 * noise.full_dn) {
                continue;
            }
            let shown: Vec<f64> = pixels.iter().map(|(_, dn)| dn - scenario.optics.ccd.black_level_dn).collect();
            let light_of = |values: &[f64]| values.iter().map(|v| v - stripe.background_dn).sum::<f64>();
            worst_sum = worst_sum.max((light_of(&shown) / light_of(&expected) - 1.0).abs());
            let peak = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
            worst_peak = worst_peak.max((peak(&shown) / peak(&expected) - 1.0).abs());
            let background = shown[0] - stripe.background_dn;
            square_background += background * background;
            count += 1;
        }
        let background = (square_background / f64::from(count.max(1))).sqrt();
        println!(
            "{rig} on {surface:?}: sums {worst_sum:.4}, peaks {worst_peak:.4}, background {background:.3} DN, {count} columns"
        );
        assert!(count > 100, "{count}");
        // The light changes across a stripe that is met at a grazing angle; the profile takes it as even.
        assert!(worst_sum < 0.01 && worst_peak < 0.01, "{worst_sum} {worst_peak}");
        // Half a step of 12 bits, and headlamp light that changes over the reach of a stripe.
        assert!(background < 0.4, "{background}");
    }
}

/// True centres on side walls, those near the ends of their piece left out.
fn inner(truth: &StageTruth, margin: usize) -> Vec<&TrueCentre> {
    let on_side = |c: &&TrueCentre| matches!(truth.planes[c.plane].wall, Some(Wall::Left | Wall::Right)) && c.counts();
    let like = |a: &TrueCentre, b: &TrueCentre| (a.scan, a.laser, a.plane) == (b.scan, b.laser, b.plane);
    let all: Vec<&TrueCentre> = truth.centres.iter().filter(on_side).collect();
    let has = |c: &TrueCentre, line: usize| all.iter().any(|other| like(other, c) && other.line == line);
    all.iter().copied().filter(|c| c.line >= margin && has(c, c.line - margin) && has(c, c.line + margin)).collect()
}

/// The pixels of a column (or row) that a stripe's light reaches: place and grey value of 8 bits. `None` where they are not all in
/// the image.
fn column(image: &GreyImage, centre: &TrueCentre, stripe: &Stripe) -> Option<Vec<(f64, f64)>> {
    let [width, height] = image.size_px();
    let (from, to) = ((centre.at_px - stripe.reach_px()).floor(), (centre.at_px + stripe.reach_px()).ceil());
    let room = if centre.scan == Scan::Column { height } else { width };
    if from < 0.0 || to >= room as f64 {
        return None;
    }
    let scale = 255.0 / f64::from(image.bits().max_dn());
    let value = |at: usize| {
        let index = if centre.scan == Scan::Column { at * width + centre.line } else { centre.line * width + at };
        scale
            * match image.pixels() {
                Pixels::Grey8(values) => f64::from(values[index]),
                Pixels::Grey16(values) => f64::from(values[index]),
            }
    };
    Some((from as usize..=to as usize).map(|at| (at as f64, value(at))).collect())
}

/// How middles move with distance and heading of their wall, against a robot that is moved and turned.
#[test]
fn middles_move_as_the_robot_does() {
    const STEP_M: f64 = 1e-4;
    const STEP_DEG: f64 = 0.01;
    for rig in ["wide", "incra1"] {
        let scenario = scenario(rig, "");
        let (lateral_m, heading_deg) = (0.04, -3.0);
        let stand = Stand::at(&scenario, lateral_m, heading_deg);
        let truth = stand.truth(&[1.0; 4]);
        let moved = |lateral_m: f64, heading_deg: f64| Stand::at(&scenario, lateral_m, heading_deg).truth(&[1.0; 4]);
        let sideways = [moved(lateral_m + STEP_M, heading_deg), moved(lateral_m - STEP_M, heading_deg)];
        let turned = [moved(lateral_m, heading_deg + STEP_DEG), moved(lateral_m, heading_deg - STEP_DEG)];
        let mut compared = 0;
        for centre in inner(&truth, 6) {
            let wall = truth.planes[centre.plane].wall;
            let of = |other: &StageTruth| {
                let same = |i: &usize| {
                    let c = &other.centres[*i];
                    c.laser == centre.laser && other.planes[c.plane].wall == wall && (c.at_px - centre.at_px).abs() < 3.0
                };
                other.in_line(centre.scan, centre.line).find(same).map(|i| other.centres[i].at_px)
            };
            let slope = |pair: &[StageTruth; 2], step: f64| Some((of(&pair[0])? - of(&pair[1])?) / (2.0 * step));
            let (Some(by_lateral), Some(by_turn)) = (slope(&sideways, STEP_M), slope(&turned, STEP_DEG.to_radians())) else {
                continue;
            };
            // The base moves to the left: the left wall comes nearer, the right one goes away.
            let by_distance = if wall == Some(Wall::Left) { -by_lateral } else { by_lateral };
            let by = motion(&stand.scene, &truth, centre);
            // Distances across the duct are 1 / cos(heading) longer than along the wall's normal.
            let scale = by.abs().max();
            assert!((by.x - by_distance).abs() < 2e-3 * scale, "{rig} {centre:?}: {by} for {by_distance}");
            assert!((by.y - by_turn).abs() < 2e-3 * scale, "{rig} {centre:?}: {by} for {by_turn}");
            compared += 1;
        }
        assert!(compared > 200, "{rig}: {compared}");
    }
}

/// Normal numbers by a congruential generator and the sum of twelve: enough for a second moment.
struct Normal(u64);

impl Normal {
    fn next(&mut self) -> f64 {
        let uniform = |state: &mut u64| {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut self.0)).sum::<f64>() - 6.0
    }
}

/// Weighted least squares for middle, amplitude and background of one stripe, the weights being the true variances: efficient where
/// the noise is normal. Begins at the truth, so that it converges and nothing but noise moves it.
fn fit(pixels: &[(f64, f64)], truth: &Stripe, noise: &Noise) -> f64 {
    let mut at = Vector3::new(truth.centre_px, 1.0, truth.background_dn);
    for _ in 0..6 {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (place, dn) in pixels {
            let (light, _) = truth.light(*place);
            let (value, slope) = Stripe { centre_px: at.x, ..*truth }.light(*place);
            let by = Vector3::new(at.y * slope, value, 1.0);
            let weight = 1.0 / noise.variance_dn2(light, truth.background_dn);
            normal += by * by.transpose() * weight;
            right += by * (dn - at.y * value - at.z) * weight;
        }
        at += normal.lu().solve(&right).expect("three unknowns that differ");
    }
    at.x
}

/// Columns made by the bound's own model: the efficient estimate scatters by the bound.
#[test]
fn an_efficient_estimate_of_a_column_attains_the_bound() {
    const COLUMNS: usize = 6000;
    let optics = scenario("wide", "").optics;
    let noise = Noise::of(&optics, 4e-3);
    let mut random = Normal(7);
    for (peak_dn, sigma_px, cosine) in [(120.0, 2.0, 1.0), (60.0, 1.3, 0.94), (150.0, 6.0, 0.8)] {
        let mut square = 0.0;
        let mut bound = 0.0;
        for column in 0..COLUMNS {
            // Between two pixels, everywhere.
            let centre_px = 100.0 + column as f64 / COLUMNS as f64;
            let light_dn_px = peak_dn * sigma_px * (2.0 * std::f64::consts::PI).sqrt();
            let stripe = Stripe { centre_px, light_dn_px, sigma_px, cosine, background_dn: 12.0 };
            let reach = stripe.reach_px();
            let pixels: Vec<(f64, f64)> = ((centre_px - reach).floor() as i64..=(centre_px + reach).ceil() as i64)
                .map(|at| {
                    let light = stripe.light(at as f64).0;
                    let variance = noise.variance_dn2(light, 12.0);
                    (at as f64, light + 12.0 + variance.sqrt() * random.next())
                })
                .collect();
            let error = fit(&pixels, &stripe, &noise) - centre_px;
            square += error * error;
            bound += 1.0 / column_information(&[stripe], &[true], &noise)[(0, 0)];
        }
        let ratio = (square / bound).sqrt();
        println!("peak {peak_dn} DN, sigma {sigma_px} px: {:.4} px, {ratio:.4} of the bound", (square / COLUMNS as f64).sqrt());
        // The scatter of a deviation from 6000 numbers is 0.9 %; the fit is linear in the noise but for its square.
        assert!((0.97..1.04).contains(&ratio), "{ratio}");
    }
}

/// Rendered frames of one pose, again and again: speckle and the sensor's noise scatter the efficient estimates of each column, and of
/// the wall through all of them, by the bound.
#[test]
fn rendered_frames_scatter_by_the_bound() {
    const FRAMES: u64 = 120;
    for (rig, speckle) in [("wide", 0.12), ("incra1", 0.12), ("wide", 0.3)] {
        // Unequal pixels are the same in every frame: they would be a bias here.
        let scenario =
            scenario(rig, &format!("[sensor.ccd]\nprnu = 0.0\nbits = 12\n[sensor.light]\nspeckle_contrast = {speckle:?}"));
        let stand = Stand::at(&scenario, 0.03, 3.0);
        // One laser: no stripe crosses another.
        let power = [1.0, 0.0, 0.0, 0.0];
        let mut truth = stand.truth(&power);
        // Only what can be fitted: whole columns on the right wall, away from the ends of the stripe.
        let kept: Vec<TrueCentre> =
            inner(&truth, 12).into_iter().filter(|c| truth.planes[c.plane].wall == Some(Wall::Right)).copied().collect();
        truth.centres = kept;
        let light = Light::new(&scenario, &stand.scene, &power);
        let noise = Noise::of(&scenario.optics, scenario.first_exposure_s());
        let stripes: Vec<Stripe> = truth.centres.iter().map(|centre| light.stripe(&truth, centre).unwrap()).collect();
        let mut renderer = Engine::Cpu.renderer(&scenario, 1).unwrap();
        let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        let (whole, stripes): (Vec<TrueCentre>, Vec<Stripe>) = truth
            .centres
            .iter()
            .zip(stripes)
            .filter(|(centre, stripe)| column(&image, centre, stripe).is_some())
            .filter(|(_, stripe)| stripe.light(stripe.centre_px).0 < 0.6 * noise.full_dn)
            .unzip();
        truth.centres = whole;
        let said: Vec<f64> = stripes.iter().map(|stripe| column_information(&[*stripe], &[true], &noise)[(0, 0)]).collect();
        let moves: Vec<Vector2<f64>> = truth.centres.iter().map(|centre| motion(&stand.scene, &truth, centre)).collect();

        // Each column's estimates and the wall's, frame by frame.
        let mut columns = vec![Vec::new(); stripes.len()];
        let mut walls = Vec::new();
        let black_dn = scenario.optics.ccd.black_level_dn;
        for frame in 0..FRAMES {
            renderer.render(&stand.view(&scenario, frame, power), image.room()).unwrap();
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for (i, (centre, stripe)) in truth.centres.iter().zip(&stripes).enumerate() {
                let mut pixels = column(&image, centre, stripe).unwrap();
                pixels.iter_mut().for_each(|(_, dn)| *dn -= black_dn);
                let error = fit(&pixels, stripe, &noise) - centre.at_px;
                columns[i].push(error);
                normal += moves[i] * moves[i].transpose() * said[i];
                right += moves[i] * error * said[i];
            }
            let wall: Vector2<f64> = normal.lu().solve(&right).unwrap();
            walls.push(wall);
        }
        let variance = |values: &mut dyn Iterator<Item = f64>| {
            let values: Vec<f64> = values.collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (values.len() - 1) as f64, mean)
        };
        let scattered: Vec<(f64, f64)> = columns.iter().map(|errors| variance(&mut errors.iter().copied())).collect();
        let normalised: f64 = scattered.iter().zip(&said).map(|((v, _), said)| v * said).sum::<f64>() / scattered.len() as f64;
        let bias = (scattered.iter().map(|(_, mean)| mean * mean).sum::<f64>() / scattered.len() as f64).sqrt();
        let bound_px = (said.iter().map(|said| 1.0 / said).sum::<f64>() / said.len() as f64).sqrt();

        let of_wall = wall_block(&information(&scenario, &stand.scene, &truth, &power), Wall::Right).unwrap();
        let covariance = of_wall.try_inverse().unwrap();
        let distance = variance(&mut walls.iter().map(|wall| wall.x));
        let heading = variance(&mut walls.iter().map(|wall| wall.y));
        let ratios = [(distance.0 / covariance.m11).sqrt(), (heading.0 / covariance.m22).sqrt()];
        println!(
            "{rig}, speckle {speckle}: {} columns, bound {bound_px:.4} px, scatter {:.4} of it, bias {bias:.4} px; wall bound \
             {:.4} mm, {:.5} deg, scatter {:.3} and {:.3} of it, bias {:+.4} mm, {:+.5} deg",
            stripes.len(),
            normalised.sqrt(),
            covariance.m11.sqrt() * 1e3,
            covariance.m22.sqrt().to_degrees(),
            ratios[0],
            ratios[1],
            distance.1 * 1e3,
            heading.1.to_degrees(),
        );
        assert!(stripes.len() > 100, "{}", stripes.len());
        // Some 20 000 independent numbers; the speckle's gamma distribution is skewed, and fits are not quite linear in it.
        assert!((0.95..1.1).contains(&normalised.sqrt()), "{}", normalised.sqrt());
        // A deviation from 120 numbers scatters by 6.5 %: three of that, and what columns have beyond.
        assert!(ratios.iter().all(|ratio| (0.78..1.3).contains(ratio)), "{ratios:?}");
    }
}

/// A thick stripe is not symmetric: with u = d / sigma_w = (t / s) (1 + kappa t) and E = E0 (1 + epsilon t) at t pixels from its middle,
/// its centroid is s^2 (epsilon - 3 kappa) off. On a matt wall all of that is geometry: how far, how squarely met, how wide.
#[test]
fn the_centroid_of_a_thick_stripe_is_off_as_geometry_says() {
    // No headlamp, no noise: a centroid is that of the stripe.
    let scenario = scenario(
        "incra1",
        "noise = false\n[sensor.ccd]\nbits = 12\n[sensor.light]\nheadlamp_peak_dn = 0.0\nstripe_peak_dn = 100.0\n[surface.sheet]\n\
         albedo = 0.5\nfriction = 0.7",
    );
    let stand = Stand::at(&scenario, 0.03, 3.0);
    let power = [1.0, 0.0, 0.0, 0.0];
    let truth = stand.truth(&power);
    let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
    let mut renderer = Engine::Cpu.renderer(&scenario, 1).unwrap();
    renderer.render(&stand.view(&scenario, 0, power), image.room()).unwrap();
    let light = Light::new(&scenario, &stand.scene, &power);
    let (rig, projection) = (stand.scene.rig(), stand.scene.projection());
    let (mut off2, mut left2, mut count) = (0.0, 0.0, 0.0);
    for centre in inner(&truth, 12) {
        let Some(stripe) = light.stripe(&truth, centre) else { continue };
        let Some(pixels) = column(&image, centre, &stripe).filter(|_| stripe.light(centre.at_px).0 > 15.0) else { continue };
        let shown = pixels.iter().map(|(at, dn)| (at - centre.at_px, dn - scenario.optics.ccd.black_level_dn));
        let (sum, moment) = shown.fold((0.0, 0.0), |(sum, moment), (at, dn)| (sum + dn, moment + dn * at));
        let off = moment / sum;

        let (plane, laser) = (&truth.planes[centre.plane], &rig.lasers[centre.laser]);
        let normal = plane.normal_in_camera.into_inner();
        // u and E of the wall's point at a place of the column.
        let at = |t: f64| {
            let place = centre.at_px + t;
            let pixel = if centre.scan == Scan::Column { [centre.line as f64, place] } else { [place, centre.line as f64] };
            let [x, y] = projection.ray(pixel);
            let ray = Vector3::new(x, y, 1.0);
            let point = ray * (plane.camera_distance_m / normal.dot(&ray));
            let way = point - laser.source_in_camera.coords;
            let width = rig.line.at(way.norm());
            let cos4 = 1.0 / (ray.norm_squared() * ray.norm_squared());
            let even = normal.dot(&way) / way.norm() * cos4 / (way.norm() * width);
            ((laser.normal_in_camera.dot(&point) - laser.offset_m) / (width / 2.354_820_045), even)
        };
        const STEP: f64 = 2.0;
        let (ahead, behind) = (at(STEP), at(-STEP));
        let per_s = (ahead.0 - behind.0) / (2.0 * STEP);
        let kappa = (ahead.0 + behind.0) / (2.0 * STEP * STEP) / per_s;
        let epsilon = (ahead.1 - behind.1) / (2.0 * STEP) / at(0.0).1;
        let left = off - (epsilon - 3.0 * kappa) / (per_s * per_s);
        off2 += off * off;
        left2 += left * left;
        count += 1.0;
    }
    let [off, left] = [off2, left2].map(|sum: f64| (sum / count).sqrt());
    println!("incra1, matt: centroids {off:.4} px RMS off, {left:.4} px beyond what geometry says, {count} columns");
    // Steps of 12 bits, over the sixty pixels of a stripe, leave some thousandths.
    assert!(count > 300.0 && off > 0.015 && left < 0.008 && left < off / 3.0, "{off} {left} {count}");
}
