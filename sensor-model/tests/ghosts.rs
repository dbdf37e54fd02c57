//! Ghosts against what a mirror does, ray by ray: where they are, how bright, how a rough mirror spreads them.

mod common;
mod ray_cast;

use common::{base_at, duct, quiet, straight, view, wide};
use ductloop_duct::cell::{Plane, Solid, SurfaceId};
use ductloop_duct::network::{Hit, Network};
use ductloop_nav::rig::Rig;
use ductloop_sensor::Transform;
use ductloop_sensor::frame_geometry::FrameGeometry;
use ductloop_sensor::light::FWHM_PER_SIGMA;
use ductloop_sensor::optics::Optics;
use ductloop_sensor::strip::{MirroredWay, SQRT_TAU, Strip};
use ductloop_sensor::surface::Look;
use nalgebra::{Point3, Unit, Vector3};
use ray_cast::{View, of_glow, of_strips};

const HALF_WIDTH_M: f64 = 0.25;
const MIRROR: SurfaceId = SurfaceId(1);
const LOW: usize = 0;
const ROUGHNESSES: [f64; 3] = [0.03, 0.06, 0.12];

/// A straight duct whose left wall is a mirror.
fn mirror_duct() -> Network {
    let mut network = duct(&[straight(4.0, 2.0 * HALF_WIDTH_M, 0.3)]);
    let left = network.cells[0].faces.iter_mut().find(|face| face.plane.normal.y > 0.9).expect("a left wall");
    left.surface = MIRROR;
    network
}

fn looks(roughness: f64) -> [Look; 2] {
    [Look::matt(0.5), Look { specular: 0.8, roughness, ..Look::matt(0.1) }]
}

fn optics() -> Optics {
    Optics { ghosts: true, ..quiet() }
}

fn schlick(cosine: f64) -> f64 {
    let miss = 1.0 - cosine;
    0.8 + 0.2 * miss * miss * miss * miss * miss
}

fn mirrored(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, -v.y, v.z)
}

/// A point in the mirror at y = `HALF_WIDTH_M`.
fn image_of(p: &Point3<f64>) -> Point3<f64> {
    Point3::new(p.x, 2.0 * HALF_WIDTH_M - p.y, p.z)
}

/// One way of light by the mirror to a pixel.
struct Path {
    /// On the sheet that scatters it.
    hit: Hit,
    /// Share that the mirror keeps.
    kept: f64,
    /// The point of the laser's fan, as if there were no mirror.
    aimed: Point3<f64>,
    cos_light: f64,
    distance_m: f64,
}

fn path(view: &View, way: MirroredWay, pixel: [f64; 2]) -> Option<Path> {
    let first = view.seen(pixel)?;
    let source = view.source(LOW);
    match way {
        MirroredWay::View => {
            let seen = view.way(pixel);
            let on = Unit::new_normalize(mirrored(&seen));
            let hit = (first.surface == MIRROR).then(|| view.cast(&first.point, &on))??;
            let light = hit.point - source;
            let distance_m = light.norm();
            let cos_light = -hit.normal.dot(&light) / distance_m;
            Some(Path { hit, kept: schlick(seen.y.abs()), aimed: hit.point, cos_light, distance_m })
        }
        MirroredWay::Light => {
            // The laser aims at the point's mirror image; what it meets first must be the mirror.
            let aimed = image_of(&first.point);
            let light = Unit::new_normalize(aimed - source);
            let met = view.cast(&source, &light)?;
            let cos_light = -first.normal.dot(&mirrored(&light));
            let kept = schlick(light.y.abs());
            let distance_m = (aimed - source).norm();
            (met.surface == MIRROR && first.surface != MIRROR).then_some(Path { hit: first, kept, aimed, cos_light, distance_m })
        }
    }
}

/// Row in a column at which the ghost's middle is seen, found by following rays.
fn middle_row(view: &View, way: MirroredWay, column: f64) -> Option<f64> {
    let off = |row: f64| path(view, way, [column, row]).map(|path| view.off_plane(LOW, &path.aimed));
    let rows = view.rig.camera.height_px;
    let mut from = (10..rows - 10).map(|row| row as f64).find(|row| {
        let (a, b) = (off(*row), off(row + 1.0));
        a.zip(b).is_some_and(|(a, b)| a * b <= 0.0 && (a - b).abs() < 0.05)
    })?;
    let mut to = from + 1.0;
    for _ in 0..40 {
        let between = (from + to) / 2.0;
        if off(from)? * off(between)? <= 0.0 { to = between } else { from = between }
    }
    Some(from)
}

/// Light of the ghosts of one way in a column about a row, and its centre.
fn column(view: &View, geometry: &FrameGeometry, way: MirroredWay, column: f64, row: f64) -> (f64, f64) {
    const REACH_PX: i32 = 14;
    let (mut sum, mut moment) = (0.0, 0.0);
    for step in -REACH_PX..=REACH_PX {
        let at = row.round() + f64::from(step);
        let light = of_strips(view, geometry, [column, at], |strip| strip.mirror.is_some_and(|mirror| mirror.way == way));
        sum += light;
        moment += light * (at - row);
    }
    (sum, moment / sum)
}

/// What the tests look at: a duct with a mirror of this roughness, seen by the rig `wide`.
struct Scene {
    network: Network,
    rig: Rig,
    optics: Optics,
    looks: [Look; 2],
}

impl Scene {
    fn of(roughness: f64, optics: Optics) -> Self {
        Self { network: mirror_duct(), rig: wide(), optics, looks: looks(roughness) }
    }

    fn view(&self) -> View<'_> {
        let Self { network, rig, optics, looks } = self;
        let world_from_camera = view(rig, &base_at(1.0, 0.04, 3.0)).world_from_camera;
        View { network, rig, optics, looks, world_from_camera }
    }
}

/// So bright that neither of a ghost's parts, pixels and nodes, is left out as too faint.
fn bright() -> Optics {
    Optics { stripe_peak_dn: 18_000.0, ..optics() }
}

/// Light of the ghosts of one way at a pixel: of strips, and of the nodes of the surface seen there.
fn ghost_light(view: &View, geometry: &FrameGeometry, way: MirroredWay, pixel: [f64; 2], seen: &Hit) -> f64 {
    let sharp = of_strips(view, geometry, pixel, |strip| strip.mirror.is_some_and(|mirror| mirror.way == way));
    let toward = view.world_from_camera.inverse_transform_vector(&seen.normal);
    sharp + of_glow(geometry, pixel, &toward)
}

/// Columns in which both the mirror shows a stripe, or the mirrored laser throws one, well away from the ends of either.
fn columns(way: MirroredWay) -> [f64; 5] {
    match way {
        MirroredWay::View => [20.0, 60.0, 100.0, 140.0, 180.0],
        MirroredWay::Light => [400.0, 430.0, 460.0, 490.0, 520.0],
    }
}

#[test]
fn a_mirror_shows_the_ghost_where_the_mirrored_laser_says() {
    let scene = Scene::of(0.005, optics());
    let view = scene.view();
    let geometry = view.geometry(LOW);
    for way in [MirroredWay::View, MirroredWay::Light] {
        for u in columns(way) {
            let row = middle_row(&view, way, u).expect("a ghost in this column");
            let (light, off) = column(&view, &geometry, way, u, row);
            // 0.02 px is what perception would notice; the stripe's own slight lopsidedness is within it.
            assert!(light > 0.5 && off.abs() < 0.02, "{way:?} in column {u}: {off:.4} px off, light {light}");
        }
    }
}

/// The sum over a column is the light across the stripe, whatever lens and roughness: P / (r w) F cos(i) sqrt(2 pi) s over the slope of the
/// distance from the laser's plane.
#[test]
fn a_ghost_has_the_share_of_the_light_that_the_mirror_keeps() {
    let scene = Scene::of(0.005, optics());
    let view = scene.view();
    let geometry = view.geometry(LOW);
    for way in [MirroredWay::View, MirroredWay::Light] {
        for u in columns(way) {
            let row = middle_row(&view, way, u).expect("a ghost in this column");
            let at = |row: f64| path(&view, way, [u, row]).expect("a path by the mirror");
            const STEP_PX: f64 = 0.25;
            let slope = (view.off_plane(LOW, &at(row + STEP_PX).aimed) - view.off_plane(LOW, &at(row - STEP_PX).aimed)).abs()
                / (2.0 * STEP_PX);
            let path = at(row);
            let across = view.strength() / path.distance_m * SQRT_TAU / FWHM_PER_SIGMA;
            let expected = across * path.kept * view.fan(LOW, &path.aimed) * path.cos_light * view.albedo(path.hit.surface)
                / slope
                * view.falloff([u, row]);
            let (light, _) = column(&view, &geometry, way, u, row);
            // The stripe's brightness changes along the column by a few percent in its own width, nearly evenly.
            assert!((light / expected - 1.0).abs() < 0.01, "{way:?} in column {u}: {light} instead of {expected}");
        }
    }
}

/// Posts take light from both kinds of ghost; without shadows only what they hide from the camera stays dark.
#[test]
fn without_shadows_posts_take_no_light_from_ghosts() {
    let mut posted = mirror_duct();
    for (x, y) in [(1.5, -0.12), (1.9, 0.17), (2.3, -0.08)] {
        posted.add_solid(&Solid::cuboid(&Transform::translation(x, y, 0.0), Vector3::new(0.06, 0.06, 0.3), SurfaceId(0)));
    }
    let unshaded = Optics { shadows: false, ..optics() };
    let scenes = [(mirror_duct(), optics()), (posted.clone(), optics()), (posted, unshaded)]
        .map(|(network, optics)| Scene { network, ..Scene::of(0.005, optics) });
    let scenes = scenes.each_ref().map(Scene::view);
    let geometries = scenes.each_ref().map(|scene| scene.geometry(LOW));
    for way in [MirroredWay::View, MirroredWay::Light] {
        // Of the walls; the posts have stripes of their own.
        let is_of = |strip: &Strip| strip.mirror.is_some_and(|mirror| mirror.way == way);
        let walls: Vec<Plane> = geometries[0].strips.iter().filter(|strip| is_of(strip)).map(|strip| strip.plane).collect();
        let same = |a: &Plane, b: &Plane| (a.offset_m - b.offset_m).abs() < 1e-9 && (a.normal.dot(&b.normal) - 1.0).abs() < 1e-9;
        let counts = |strip: &Strip| is_of(strip) && walls.iter().any(|wall| same(wall, &strip.plane));
        // Whether the camera sees what it would see without posts, by the mirror or not.
        let is_seen = |pixel: [f64; 2]| {
            let point = |view: &View| match way {
                MirroredWay::Light => view.seen(pixel).map(|hit| hit.point),
                MirroredWay::View => path(view, way, pixel).map(|path| path.hit.point),
            };
            point(&scenes[0]).zip(point(&scenes[1])).is_some_and(|(a, b)| (a - b).norm() < 1e-6)
        };
        let (mut in_shadow, mut hidden, mut free) = (0, 0, 0);
        for u in (8..632).step_by(2).map(f64::from) {
            let Some(row) = middle_row(&scenes[0], way, u) else { continue };
            let [whole, with, without] = [0, 1, 2].map(|i| of_strips(&scenes[i], &geometries[i], [u, row.round()], counts));
            // Near the edge of what is hidden the lens takes a part.
            let about =
                [[-8.0, 0.0], [0.0, -5.0], [0.0, 0.0], [0.0, 5.0], [8.0, 0.0]].map(|[du, dv]| is_seen([u + du, row + dv]));
            if whole > 0.5 && about == [true; 5] {
                assert!((without / whole - 1.0).abs() < 1e-3, "{way:?} in column {u}: {without} instead of {whole}");
                free += 1;
                in_shadow += usize::from(with < 0.1 * whole);
            } else if whole > 0.5 && about == [false; 5] {
                assert!(without < 0.02 * whole, "{way:?} in column {u}: {without} of {whole} where a post is in the way");
                hidden += 1;
            }
        }
        assert!(in_shadow > 3 && hidden > 3 && free > 20, "{way:?}: {in_shadow} in shadow, {hidden} hidden, {free} free");
    }
}

/// Posts in the duct, thin ones, whose own faces leave no ghosts.
fn posted() -> Network {
    let mut network = mirror_duct();
    for (x, y) in [(1.5, 0.1), (1.7, -0.05), (1.45, -0.1), (1.62, 0.21)] {
        let stand = Transform::translation(x, y, 0.0);
        network.add_solid(&Solid::cuboid(&stand, Vector3::new(0.014, 0.014, 0.3), SurfaceId(0)));
    }
    network
}

/// Bodies on any part of the light's way, mirrored or not, take a ghost's light away, and nothing else does.
#[test]
fn bodies_shade_and_hide_ghosts_on_every_part_of_the_way() {
    let free = Scene::of(0.005, optics());
    let posts = Scene { network: posted(), ..Scene::of(0.005, optics()) };
    let (free, posts) = (free.view(), posts.view());
    let geometries = [&free, &posts].map(|view| view.geometry(LOW));
    for (way, all) in [(MirroredWay::View, 5..200), (MirroredWay::Light, 380..530)] {
        // Whether light comes by the mirror to a pixel, as rays go.
        let is_lit = |pixel: [f64; 2]| {
            let unhidden = path(&free, way, pixel)?;
            let hit = path(&posts, way, pixel)?.hit;
            let same = |a: &Point3<f64>, b: &Point3<f64>| (a - b).norm() < 1e-6;
            let reached = match way {
                // The laser reaches what is seen in the mirror.
                MirroredWay::View => {
                    let to = Unit::new_normalize(hit.point - posts.source(LOW));
                    posts.cast(&posts.source(LOW), &to).is_some_and(|met| same(&met.point, &hit.point))
                }
                // From the laser the mirror sends it on to what is seen.
                MirroredWay::Light => {
                    let to = Unit::new_normalize(image_of(&hit.point) - posts.source(LOW));
                    let on = posts.cast(&posts.source(LOW), &to)?;
                    let on = posts.cast(&on.point, &Unit::new_normalize(mirrored(&to)));
                    on.is_some_and(|met| same(&met.point, &hit.point))
                }
            };
            Some(reached && same(&hit.point, &unhidden.hit.point))
        };
        let mut counts = [0; 2];
        for u in all.step_by(2).map(f64::from) {
            let Some(row) = middle_row(&free, way, u) else { continue };
            // Near the edge of a shadow it is partly there.
            let near: Vec<bool> = (-7..=7).map(|off| is_lit([u + f64::from(off), row]).unwrap_or(false)).collect();
            if near.contains(&true) && near.contains(&false) {
                continue;
            }
            let [all, kept] = [(&free, 0), (&posts, 1)].map(|(view, i)| column(view, &geometries[i], way, u, row).0);
            let expected = if near[0] { all } else { 0.0 };
            assert!((kept - expected).abs() < 0.02 * all, "{way:?} in column {u}: {kept} of {all}, by rays {expected}");
            counts[usize::from(near[0])] += 1;
        }
        println!("{way:?}: {counts:?} columns are hidden and seen");
        assert!(counts[0] >= 4 && counts[1] >= 20, "{way:?}: {counts:?}");
    }
}

/// Pixels in the middle of those ghosts that nodes are not enough for.
fn narrow(geometry: &FrameGeometry, way: MirroredWay) -> Vec<[f64; 2]> {
    let strips = geometry.strips.iter().filter(|strip| strip.mirror.is_some_and(|mirror| mirror.way == way));
    let middles = strips.map(|strip| geometry.band[(strip.band.start + strip.band.end) / 2].pixel.map(f64::round).into());
    let seen = |[u, v]: &[f64; 2]| (0.0..640.0).contains(u) && (0.0..480.0).contains(v);
    middles.filter(seen).collect()
}

/// Pairs of light found and light expected. The model takes the lobe as round in the image (or about the laser's plane), as wide all
/// along a ghost as it is at the pixel, which is right to a tenth; and at a ghost's soft end to a few hundredths of its brightest.
fn assert_close(lights: &[[f64; 2]]) {
    let brightest = lights.iter().map(|[_, expected]| *expected).fold(0.0, f64::max);
    assert!(brightest > 5.0, "there is something to compare");
    for [found, expected] in lights {
        assert!((found - expected).abs() < 0.13 * expected + 0.03 * brightest, "{found} instead of {expected}");
    }
}

/// A rough mirror: each pixel is the mean over rays scattered about the mirrored one, by as many pixels' worth as the lobe says.
#[test]
fn a_rough_mirror_blurs_what_it_shows() {
    // Where the nodes of the glow do, where every pixel is needed, and between.
    ROUGHNESSES.into_iter().for_each(blurs_what_it_shows);
}

fn blurs_what_it_shows(roughness: f64) {
    let scene = Scene::of(roughness, bright());
    let view = scene.view();
    let geometry = view.geometry(LOW);
    let lobe_px = 2.0_f64.sqrt() * roughness * scene.rig.camera.focal_px[0];
    let mut lights = Vec::new();
    for pixel in
        [[30.0, 240.0], [60.0, 230.0], [60.0, 170.0], [110.0, 200.0]].into_iter().chain(narrow(&geometry, MirroredWay::View))
    {
        let first = view.seen(pixel).expect("the mirror");
        assert_eq!(first.surface, MIRROR);
        let mut sum = (0.0, 0.0);
        // The stripe's standard deviation is more than a pixel: steps of a pixel catch all of it.
        let steps = (4.0 * lobe_px) as i32;
        for i in -steps..=steps {
            for j in -steps..=steps {
                let (du, dv) = (f64::from(i), f64::from(j));
                let weight = libm::exp(-(du * du + dv * dv) / (2.0 * lobe_px * lobe_px));
                let on = Unit::new_normalize(mirrored(&view.way([pixel[0] + du, pixel[1] + dv])));
                sum.0 += weight;
                if on.y < 0.0
                    && let Some(hit) = view.cast(&first.point, &on)
                {
                    sum.1 += weight * view.lit(LOW, &hit);
                }
            }
        }
        let expected = sum.1 / sum.0 * schlick(view.way(pixel).y.abs()) * view.falloff(pixel);
        lights.push([ghost_light(&view, &geometry, MirroredWay::View, pixel, &first), expected]);
    }
    assert_close(&lights);
}

/// The same for light thrown by a rough mirror: the fan's rays, each scattered about its mirrored way.
#[test]
fn a_rough_mirror_spreads_the_light_it_throws() {
    ROUGHNESSES.into_iter().for_each(spreads_the_light_it_throws);
}

fn spreads_the_light_it_throws(roughness: f64) {
    let scene = Scene::of(roughness, bright());
    let view = scene.view();
    let geometry = view.geometry(LOW);
    let lobe_rad = 2.0_f64.sqrt() * roughness;
    let source = view.source(LOW);
    let fan = ductloop_sensor::light::Fan::of(&scene.rig.lasers[LOW], scene.optics.fan_profile);
    let mut lights = Vec::new();
    for pixel in
        [[500.0, 190.0], [520.0, 220.0], [460.0, 225.0], [420.0, 210.0]].into_iter().chain(narrow(&geometry, MirroredWay::Light))
    {
        let hit = view.seen(pixel).expect("a wall");
        assert_ne!(hit.surface, MIRROR);
        let mut irradiance = 0.0;
        const STEP_RAD: f64 = 1e-3;
        let reach = (fan.reach_rad / STEP_RAD) as i32;
        for i in -reach..=reach {
            let angle = f64::from(i) * STEP_RAD;
            let (s, c) = libm::sincos(angle);
            let way = Unit::new_normalize(view.world_from_camera.rotation * (fan.along * c + fan.across * s));
            let Some(met) = view.cast(&source, &way).filter(|met| met.surface == MIRROR) else { continue };
            let to = hit.point - met.point;
            let (distance_m, cos_light) = (to.norm(), -hit.normal.dot(&to) / to.norm());
            let turn = libm::acos((mirrored(&way).dot(&to) / distance_m).clamp(-1.0, 1.0));
            let lobe = libm::exp(-turn * turn / (2.0 * lobe_rad * lobe_rad)) / (std::f64::consts::TAU * lobe_rad * lobe_rad);
            // Power a radian of the fan, scattered over the lobe.
            let power = view.strength() * SQRT_TAU / FWHM_PER_SIGMA * fan.profile(angle) * STEP_RAD;
            irradiance += power * schlick(way.y.abs()) * lobe * cos_light.max(0.0) / (distance_m * distance_m);
        }
        let expected = irradiance * view.albedo(hit.surface) * view.falloff(pixel);
        lights.push([ghost_light(&view, &geometry, MirroredWay::Light, pixel, &hit), expected]);
    }
    assert_close(&lights);
}
