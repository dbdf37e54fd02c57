//! Scenes for comparing renderers: drawn by seed, and by hand where something is likely to go wrong.

use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{AcrossAlign, Blade, Fitting, GrilleSide, Hand, Shape, UprightAlign};
use ductloop_duct::network::{End, Network};
use ductloop_nav::rig::{Distortion, MountAngles, Rig};
use ductloop_sensor::Transform;
use ductloop_sensor::noise::finalise;
use ductloop_sensor::optics::{FanProfile, Lens, Optics};
use ductloop_sensor::renderer::{MAX_LASERS, Motion, View};
use ductloop_sensor::surface::Look;
use nalgebra::{UnitQuaternion, Vector3};

use super::{base_at, incra1, wide};

/// What the presets' surfaces are made of, and a mirror: matt, rough metal, dust over metal, paint, grease, rubber, polished.
pub const SURFACES: [Look; 7] = [
    Look::matt(0.5),
    Look { albedo: 0.3, specular: 0.4, roughness: 0.35, ..Look::matt(0.3) },
    Look { albedo: 0.35, specular: 0.1, roughness: 0.45, ..Look::matt(0.3) },
    Look { albedo: 0.75, specular: 0.04, roughness: 0.15, ..Look::matt(0.3) },
    Look { albedo: 0.15, specular: 0.06, roughness: 0.1, ..Look::matt(0.3) },
    Look { albedo: 0.04, specular: 0.04, roughness: 0.5, ..Look::matt(0.3) },
    Look { albedo: 0.3, specular: 0.4, roughness: 0.3, spangle: 0.15, spangle_m: 0.012, seam_m: 1.5e-3 },
];

/// A scene to be rendered.
#[derive(Clone)]
pub struct Scene {
    pub name: String,
    pub rig: Rig,
    pub network: Network,
    pub optics: Optics,
    pub looks: Vec<Look>,
    pub view: View,
}

/// Numbers from 0 to 1 by counter.
struct Draws(u32);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        f64::from(finalise(self.0) >> 8) / f64::from(1 << 24)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

fn fitting(shape: Shape, width_m: f64, height_m: f64, surface: usize) -> Fitting {
    Fitting { shape, width_m, height_m, surface: SurfaceId(surface as u16) }
}

/// A camera of this rig on a base that stands so, with nominal light.
fn view(rig: &Rig, world_from_base: &Transform, angles: MountAngles) -> View {
    View {
        world_from_camera: world_from_base * rig.mount.base_from_camera(angles),
        motion: Motion::default(),
        frame: 7,
        exposure_s: 4e-3,
        laser_power: [1.0; MAX_LASERS],
        headlamp_power: 1.0,
    }
}

/// A box of this size standing at (x, y) of the floor, turned by an angle in degrees.
pub fn cuboid(x: f64, y: f64, turned_deg: f64, size: [f64; 3], surface: u16) -> Solid {
    let stand = Transform::translation(x, y, 0.0) * base_at(0.0, 0.0, turned_deg);
    Solid::cuboid(&stand, Vector3::from(size), SurfaceId(surface))
}

/// A scene drawn by a seed: rig, duct, fitting ahead, surfaces, boxes, pose and effects.
fn drawn(seed: u32) -> Option<Scene> {
    let mut draw = Draws(finalise(seed));
    let mut rig = if seed % 3 == 2 { incra1() } else { wide() };
    let (width_m, height_m) = (draw.between(0.35, 1.0), draw.between(0.22, 0.45));
    let before_m = draw.between(0.8, 3.0);
    let mut surface = || draw.below(SURFACES.len());
    let surfaces = [surface(), surface(), surface()];
    let angle = draw.between(30.0, 90.0).to_radians() * if draw.next() < 0.5 { -1.0 } else { 1.0 };
    let middle = match draw.below(3) {
        0 => Shape::Straight { length_m: 1.0 },
        1 => Shape::RadiusElbow { angle_rad: angle, throat_radius_m: 0.75 * width_m },
        _ => Shape::MitredElbow { angle_rad: angle },
    };
    let fittings = [
        fitting(Shape::Straight { length_m: before_m + 0.5 }, width_m, height_m, surfaces[0]),
        fitting(middle, width_m, height_m, surfaces[1]),
        fitting(Shape::Straight { length_m: 2.0 }, width_m, height_m, surfaces[2]),
    ];
    let exit = if draw.next() < 0.5 { End::Cap } else { End::Open };
    let mut network = Network::from_run(&fittings, End::Open, exit).ok()?;
    let along_m = draw.between(0.1, before_m);
    for _ in 0..draw.below(3) {
        let side = draw.between(-0.4, 0.4) * width_m;
        let size = [draw.between(0.02, 0.08), draw.between(0.02, 0.08), draw.between(0.02, 0.12)];
        network.add_solid(&cuboid(along_m + draw.between(0.5, 1.5), side, draw.between(0.0, 90.0), size, surfaces[0] as u16));
    }
    if draw.next() < 0.4 {
        rig.camera.distortion = Distortion {
            k1: draw.between(-0.15, 0.08),
            k2: draw.between(0.0, 0.02),
            p1: draw.between(-1e-3, 1e-3),
            p2: draw.between(-1e-3, 1e-3),
            k3: 0.0,
        };
    }
    let free_m = (width_m / 2.0 - 0.12).max(0.01);
    let base = network.centreline.pose_at(along_m) * base_at(0.0, draw.between(-free_m, free_m), draw.between(-10.0, 10.0));
    let tilt_rad = draw.between(-3.0, 3.0).to_radians();
    let angles = MountAngles { tilt_rad, ..rig.mount.rest };
    let optics = Optics {
        noise: false,
        ghosts: draw.next() < 0.4,
        bounce: draw.next() < 0.4,
        ambient_dn: if draw.next() < 0.3 { 120.0 } else { 0.0 },
        fan_profile: if draw.next() < 0.3 { FanProfile::Cylinder } else { FanProfile::Powell { edge: 0.8 } },
        lens: Lens {
            psf_sigma_px: draw.between(0.3, 1.0),
            aperture_m: if draw.next() < 0.25 { 1.0e-3 } else { 0.0 },
            vignetting: draw.next() < 0.8,
            ..Lens::default()
        },
        ..Optics::default()
    };
    let mut view = view(&rig, &base, angles);
    if draw.next() < 0.3 {
        view.motion.angular_rad_s = Vector3::z() * draw.between(-1.5, 1.5);
        view.motion.linear_m_s = Vector3::new(draw.between(0.0, 0.6), 0.0, 0.0);
    }
    Some(Scene { name: format!("drawn-{seed}"), rig, network, optics, looks: SURFACES.to_vec(), view })
}

/// Scenes in which one thing is carried far.
fn by_hand() -> Vec<Scene> {
    let run = |fittings: &[Fitting]| Network::from_run(fittings, End::Open, End::Cap).expect("the fittings fit");
    let duct = |surface| run(&[fitting(Shape::Straight { length_m: 6.0 }, 0.5, 0.3, surface)]);
    let joined = |surface| run(&vec![fitting(Shape::Straight { length_m: 0.6 }, 0.5, 0.3, surface); 8]);
    let elbow = || {
        run(&[
            fitting(Shape::Straight { length_m: 2.5 }, 0.5, 0.3, 1),
            fitting(Shape::RadiusElbow { angle_rad: 1.5, throat_radius_m: 0.375 }, 0.5, 0.3, 1),
            fitting(Shape::Straight { length_m: 2.0 }, 0.5, 0.3, 1),
        ])
    };
    let plain = Optics { noise: false, ..Optics::default() };
    let scene = |name: &str, rig: Rig, network: Network, optics: &Optics, base: Transform| {
        let view = view(&rig, &base, rig.mount.rest);
        Scene { name: name.to_owned(), rig, network, optics: optics.clone(), looks: SURFACES.to_vec(), view }
    };
    let mut boxed = duct(0);
    boxed.add_solid(&cuboid(2.0, 0.12, 20.0, [0.08, 0.06, 0.12], 1));
    boxed.add_solid(&cuboid(2.3, -0.1, 0.0, [0.05, 0.05, 0.2], 2));
    let mut thin = duct(0);
    for i in 0..3 {
        thin.add_solid(&cuboid(1.9 + 0.4 * f64::from(i), 0.0, 0.0, [0.02, 0.5, 0.003], 1));
    }
    let unshaded = Optics { shadows: false, ..plain.clone() };
    let everything = Optics {
        ghosts: true,
        bounce: true,
        ambient_dn: 100.0,
        lens: Lens { aperture_m: 8e-4, ..Lens::default() },
        ..plain.clone()
    };
    let mut barrel = wide();
    barrel.camera.distortion = Distortion { k1: -0.2, k2: 0.03, p1: 5e-4, p2: -5e-4, k3: 0.0 };
    let mut turning = scene("turning", wide(), joined(6), &plain, base_at(1.0, 0.05, 5.0));
    turning.view.motion = Motion { linear_m_s: Vector3::new(0.5, 0.0, 0.0), angular_rad_s: Vector3::new(0.0, 0.0, 2.0) };
    // Seams and spangles that pass by: 0.7 spangles, and 2.
    let mut driving = scene("driving", wide(), joined(6), &plain, base_at(1.0, 0.05, 5.0));
    driving.view.motion.linear_m_s = Vector3::new(2.0, 0.0, 0.0);
    let mut driving_bent = Scene { name: "driving-barrel".to_owned(), rig: barrel.clone(), ..driving.clone() };
    driving_bent.view.motion.linear_m_s = Vector3::new(6.0, 0.0, 0.0);
    let mut down = scene("looking-down", wide(), duct(1), &plain, base_at(1.5, 0.0, 0.0));
    down.view.world_from_camera *= UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -0.6);
    let open = || {
        let straight = [fitting(Shape::Straight { length_m: 3.0 }, 0.5, 0.3, 2)];
        Network::from_run(&straight, End::Open, End::Open).expect("the fitting fits")
    };
    let blurred = Optics { ambient_dn: 100.0, lens: Lens { aperture_m: 1e-3, focus_m: 3.0, ..Lens::default() }, ..plain.clone() };
    let mut glaring = Optics { stripe_peak_dn: 3000.0, ..plain.clone() };
    glaring.ccd.blooming = 0.5;
    let mut at_the_wall = scene("at-the-wall", wide(), duct(1), &plain, base_at(1.5, 0.0, 0.0));
    at_the_wall.view.world_from_camera =
        base_at(2.0, 0.131, 60.0) * at_the_wall.rig.mount.base_from_camera(MountAngles::default());
    vec![
        scene("out-of-focus", wide(), open(), &blurred, base_at(1.5, 0.0, 5.0)),
        scene("out-of-focus-near", wide(), open(), &blurred, base_at(2.5, 0.0, 15.0)),
        scene("blooming", wide(), duct(0), &glaring, base_at(1.5, 0.0, 0.0)),
        at_the_wall,
        scene("straight", wide(), duct(0), &plain, base_at(1.5, 0.0, 0.0)),
        scene("straight-incra1", incra1(), duct(0), &plain, base_at(1.5, 0.0, 0.0)),
        scene("facing", wide(), duct(3), &plain, base_at(5.5, 0.0, 0.0)),
        scene("near-the-cap", wide(), duct(3), &plain, base_at(5.75, 0.0, 12.0)),
        scene("near-the-wall", wide(), duct(1), &plain, base_at(1.5, 0.2, 0.0)),
        scene("boxes", wide(), boxed.clone(), &plain, base_at(1.5, 0.0, 0.0)),
        scene("boxes-without-shadows", wide(), boxed, &unshaded, base_at(1.5, 0.0, 0.0)),
        scene("beads", wide(), thin, &plain, base_at(1.5, 0.0, 0.0)),
        scene("elbow", wide(), elbow(), &plain, base_at(1.9, 0.0, 0.0)),
        scene("in-the-elbow", wide(), elbow(), &plain, base_at(2.4, 0.0, 5.0)),
        scene("elbow-incra1", incra1(), elbow(), &plain, base_at(2.2, 0.0, 0.0)),
        scene("seams", wide(), joined(6), &plain, base_at(1.0, 0.0, 0.0)),
        scene("seams-incra1", incra1(), joined(6), &plain, base_at(1.0, 0.0, 0.0)),
        scene("barrel", barrel, elbow(), &plain, base_at(1.8, 0.05, 3.0)),
        scene("everything", wide(), joined(6), &everything, base_at(1.0, 0.0, 3.0)),
        turning,
        driving,
        driving_bent,
        down,
    ]
}

/// What a robot's camera sees of each kind of fitting: ahead of it, or from inside.
pub fn fittings() -> Vec<Scene> {
    use std::f64::consts::FRAC_PI_2;
    let deg = |angle: f64| angle.to_radians();
    let plain = Optics { noise: false, ..Optics::default() };
    let day = Optics { ambient_dn: 100.0, ..plain.clone() };
    // A straight of 2 m, the fitting, and one that fits its exit.
    let around = |shape: Shape| {
        let middle = fitting(shape, 0.5, 0.3, 1);
        let mut run = vec![fitting(Shape::Straight { length_m: 2.0 }, 0.5, 0.3, 1), middle];
        if let Some(exit) = middle.port(PortName::Out) {
            run.push(fitting(Shape::Straight { length_m: 1.5 }, exit.width_m, exit.height_m, 2));
        }
        Network::from_run(&run, End::Open, End::Cap).expect("the fittings fit")
    };
    let ahead = || base_at(1.6, 0.02, 3.0);
    let mut scenes = Vec::new();
    let mut add = |name: &str, shape: Shape, optics: &Optics, base: Transform, angles: MountAngles| {
        let (rig, network) = (wide(), around(shape));
        let view = view(&rig, &base, angles);
        scenes.push(Scene { name: name.to_owned(), rig, network, optics: optics.clone(), looks: SURFACES.to_vec(), view });
    };
    let rest = MountAngles::default();
    let looking = |pan_deg: f64, tilt_deg: f64| MountAngles { pan_rad: deg(pan_deg), tilt_rad: deg(tilt_deg) };
    let transition =
        |to_width_m, to_height_m, across, upright| Shape::Transition { length_m: 0.6, to_width_m, to_height_m, across, upright };
    let narrower = transition(0.35, 0.2, AcrossAlign::Concentric, UprightAlign::Concentric);
    let wider = transition(0.8, 0.4, AcrossAlign::Left, UprightAlign::FlatBottom);
    add("transition-narrower", narrower, &plain, ahead(), rest);
    add("transition-wider", wider, &plain, ahead(), rest);
    add("in-the-transition", narrower, &plain, base_at(2.05, 0.0, 4.0), rest);
    add("offset", Shape::Offset { length_m: 1.2, aside_m: 0.4 }, &plain, ahead(), rest);
    let slope = |angle_deg: f64| Shape::Slope { length_m: 1.5, angle_rad: deg(angle_deg) };
    add("slope-up", slope(10.0), &plain, ahead(), rest);
    add("slope-down", slope(-10.0), &plain, ahead(), rest);
    let on_the_slope = |angle_deg: f64| {
        let nose_up = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -deg(angle_deg));
        Transform::translation(2.6, 0.03, 0.6 * libm::tan(deg(angle_deg))) * nose_up
    };
    add("on-the-slope-up", slope(10.0), &plain, on_the_slope(10.0), rest);
    add("on-the-slope-down", slope(-10.0), &plain, on_the_slope(-10.0), rest);
    let tee = |hand, branch_width_m| Shape::Tee { hand, branch_width_m };
    add("tee-left", tee(Hand::Left, 0.5), &plain, ahead(), rest);
    add("tee-right-narrow", tee(Hand::Right, 0.3), &plain, base_at(1.8, 0.0, -5.0), rest);
    add("in-the-tee", tee(Hand::Left, 0.5), &plain, base_at(2.2, 0.0, 40.0), rest);
    add("bullhead", Shape::BullheadTee { branch_width_m: 0.5 }, &plain, ahead(), rest);
    let side = Shape::SideBranch { hand: Hand::Left, branch_width_m: 0.35, shoe_m: 0.15 };
    add("side-branch", side, &plain, ahead(), rest);
    add("in-the-side-branch", side, &plain, base_at(2.15, 0.05, 55.0), rest);
    add("wye", Shape::Wye { half_angle_rad: deg(45.0), branch_width_m: 0.5 }, &plain, ahead(), rest);
    add("wye-narrow", Shape::Wye { half_angle_rad: deg(30.0), branch_width_m: 0.25 }, &plain, ahead(), rest);
    add("in-the-wye", Shape::Wye { half_angle_rad: deg(30.0), branch_width_m: 0.5 }, &plain, base_at(2.15, 0.1, 25.0), rest);
    add("cross", Shape::Cross { branch_width_m: 0.4 }, &plain, ahead(), rest);
    add("vaned-elbow", Shape::VanedElbow { angle_rad: FRAC_PI_2 }, &plain, ahead(), rest);
    add("damper-open", Shape::Damper { length_m: 0.4, blade: Blade::Open }, &plain, ahead(), rest);
    add("damper-shut", Shape::Damper { length_m: 0.4, blade: Blade::Shut }, &plain, ahead(), rest);
    let grille = |side| Shape::Grille { length_m: 0.8, side, opening_length_m: 0.5, opening_height_m: 0.2 };
    add("grille-left", grille(GrilleSide::Left), &day, base_at(1.9, 0.0, 5.0), rest);
    add("grille-right", grille(GrilleSide::Right), &plain, base_at(2.1, 0.0, 0.0), looking(-50.0, 0.0));
    add("grille-ceiling", grille(GrilleSide::Ceiling), &day, base_at(1.9, 0.0, 0.0), looking(0.0, -15.0));
    let drop = |hole_width_m| Shape::Drop { length_m: 1.0, hole_length_m: 0.5, hole_width_m, depth_m: 0.6 };
    add("drop", drop(0.3), &plain, ahead(), rest);
    add("drop-wall-to-wall", drop(0.5), &day, base_at(1.8, 0.02, 3.0), looking(0.0, 15.0));
    add("down-the-drop", drop(0.3), &plain, base_at(2.05, 0.0, 0.0), looking(0.0, 50.0));
    let lying = Transform::translation(2.35, 0.0, -0.6) * base_at(0.0, 0.0, 30.0);
    add("in-the-shaft", drop(0.4), &plain, lying, looking(0.0, -40.0));
    scenes
}

/// Some eighty scenes.
pub fn scenes() -> Vec<Scene> {
    let mut scenes = by_hand();
    scenes.extend(fittings());
    scenes.extend((0..36).filter_map(drawn));
    scenes
}
