//! The slow light: what walls get from the lasers' stripes about them (`bounce.rs`) and from open ends ([`crate::daylight`]).
//!
//! It varies slowly over the image and is computed on the nodes of the regions' [`GlowPatch`](crate::frame_geometry::GlowPatch)es
//! only. A node outside its region (a rectangle of nodes is larger than what it holds) gets the light of a point of the region
//! near it, so that what is interpolated at a region's border is the region's own.
//!
//! How well nodes 16 px apart hold the light (wide rig, default optics, duct of 0.5 x 0.3 m, pixels against nodes): 0.007 DN RMS in a
//! straight duct and in an elbow, 0.04 to 0.06 DN where a wall ahead is near. Within some 10 px of the places where a stripe meets
//! another wall, where the light grows as the inverse of the distance, one or two DN are lost of the light about a stripe of 100 DN
//! and more.

use ductloop_duct::cell::CellId;
use ductloop_nav::rig::Rig;
use nalgebra::{Point3, Vector3};

use crate::Transform;
use crate::bounce::{Bounce, FAINT_DN, Knot, Line};
use crate::daylight::{self, Daylight, Wall, bounds};
use crate::frame_geometry::Region;
use crate::glow_nodes::{NodeRays, Nodes};
use crate::lens::Projection;
use crate::line_light::{LANES, Lanes, Lighting, larger, shine, smaller};
use crate::optics::Optics;
use crate::passage::{Passage, Passages, Rim, volume};
use crate::renderer::MAX_LASERS;
use crate::scenery::Scenery;
use crate::strip::Blur;

/// Stripes light up cells whose openings have their middles at most this far from the camera, in metres: those that have their own
/// stripes within [`crate::bounce::REACH_M`], and a little beyond.
const BOUNCE_REACH_M: f64 = 5.0;

/// What is lit, and by what.
#[derive(Clone, Copy, Debug)]
pub struct GlowScene<'a> {
    /// The network.
    pub scenery: &'a Scenery,
    /// Where it is seen from.
    pub camera_from_world: &'a Transform,
    /// The camera's cell.
    pub cell: CellId,
    /// What the camera sees; those with a `glow` are lit.
    pub regions: &'a [Region],
    /// Corners of the regions' outlines.
    pub corners: &'a [Point3<f64>],
    /// Power of each laser as a share of nominal.
    pub laser_power: &'a [f64; MAX_LASERS],
}

/// The slow light of a camera. Kept from frame to frame for its memory.
#[derive(Debug)]
pub struct Glow {
    rays: NodeRays,
    bounce: Option<Bounce>,
    daylight: Option<Daylight>,
    passages: Passages,
    nodes: Nodes,
    hiding: Vec<Rim>,
    gates: Vec<Gate>,
    arch: pulp::Arch,
}

/// An edge of an opening that may hide a part of a line: volumes (see [`crate::passage`]) of a node, the edge and each of the line's
/// ends, as `constant + slope . node`.
#[derive(Clone, Copy, Debug)]
struct Gate {
    constant: [f32; 2],
    slope: [[f32; 3]; 2],
}

impl Glow {
    /// For a camera with this lens. `None` where there is no slow light.
    pub fn new(rig: &Rig, optics: &Optics, projection: &Projection, blur: &Blur) -> Option<Self> {
        let bounce = optics.bounce.then(|| Bounce::new(rig, optics));
        let daylight = (optics.ambient_dn > 0.0).then(|| Daylight::new(optics.ambient_dn));
        (bounce.is_some() || daylight.is_some()).then(|| Self {
            rays: NodeRays::new(projection, blur),
            bounce,
            daylight,
            passages: Passages::default(),
            nodes: Nodes::default(),
            hiding: Vec::new(),
            gates: Vec::new(),
            arch: pulp::Arch::new(),
        })
    }

    /// Adds the light on the regions' nodes to `out`, which holds the nodes of all patches (`GlowPatch::first`), in DN at nominal
    /// exposure, albedo and the lens' cos^4 included.
    pub fn gather(&mut self, scene: &GlowScene, out: &mut [f32]) {
        let reach_m = if self.daylight.is_some() { daylight::REACH_M } else { BOUNCE_REACH_M };
        self.passages.explore(scene.scenery, scene.camera_from_world, scene.cell, reach_m);
        if let Some(bounce) = &mut self.bounce {
            bounce.find(scene.scenery, scene.camera_from_world, scene.cell, scene.laser_power);
        }
        if let Some(daylight) = &mut self.daylight {
            daylight.find(scene.scenery, scene.camera_from_world, &self.passages);
        }
        for region in scene.regions {
            let Some(patch) = &region.glow else { continue };
            let albedo = scene.scenery.looks[usize::from(region.surface.0)].albedo;
            if albedo == 0.0 {
                continue;
            }
            let outline = &scene.corners[region.outline.clone()];
            let wall =
                Wall { cell: region.cell, away: region.plane.normal.into_inner(), offset_m: region.plane.offset_m, outline };
            self.nodes.lay(&self.rays, patch, &wall, albedo);
            self.shine_lines(&wall);
            let nodes = &mut self.nodes;
            if let Some(daylight) = &mut self.daylight {
                let points =
                    nodes.x.iter().zip(&nodes.y).zip(&nodes.z).map(|((x, y), z)| Vector3::new(*x, *y, *z).map(f64::from));
                daylight.shine(&self.passages, &wall, &mut self.hiding, points.take(nodes.factor.len()), &mut nodes.light);
            }
            for ((out, light), factor) in out[patch.first..].iter_mut().zip(&nodes.light).zip(&nodes.factor) {
                *out += light * factor;
            }
        }
    }

    /// Adds the light of all stripes to the nodes.
    fn shine_lines(&mut self, wall: &Wall) {
        let Some(bounce) = &self.bounce else { return };
        let (low, high) = bounds(wall.outline);
        for line in &bounce.lines {
            if brightest(line, wall, &low, &high) < FAINT_DN {
                continue;
            }
            let Some(lighting) = Lighting::new(line, &wall.away, wall.offset_m) else { continue };
            let passage = self.passages.look((wall.cell, wall.outline), (line.cell, &line.ends), &mut self.hiding);
            if passage == Passage::Blocked {
                continue;
            }
            self.gates.clear();
            self.gates.extend(self.hiding.iter().map(|rim| Gate::new(rim, &line.ends)));
            let knots = &bounce.knots[line.knots.clone()];
            let length_m = knots[knots.len() - 1].at_m;
            let whole = self.gates.is_empty() && lighting.before[0] <= 0.0 && lighting.before[1] >= length_m;
            let (nodes, gates) = (&mut self.nodes, &self.gates);
            if whole {
                self.arch.dispatch(LineOnNodes::<false> { lighting: &lighting, knots, gates, nodes });
            } else {
                self.arch.dispatch(LineOnNodes::<true> { lighting: &lighting, knots, gates, nodes });
            }
        }
    }
}

/// A bound of what a line gives any point of a wall, in DN: all of its light from as near, and as high above one another, as the two
/// come. `low` and `high` are the corners of the box about the wall.
fn brightest(line: &Line, wall: &Wall, low: &Vector3<f64>, high: &Vector3<f64>) -> f64 {
    /// A wall nowhere farther above the line's sheet than this, in metres, is that sheet or one in line with it.
    const IN_PLANE_M: f64 = 1e-6;
    let highest = |heights: f64, height: f64| heights.max(height);
    let above_line = wall.outline.iter().map(|p| line.normal.dot(&(p - line.ends[0]))).fold(0.0, highest);
    if above_line < IN_PLANE_M {
        return 0.0;
    }
    let above_wall = line.ends.iter().map(|p| wall.offset_m - wall.away.dot(&p.coords)).fold(0.0, highest);
    let (line_low, line_high) = bounds(&line.ends);
    let apart2 = (line_low - high).sup(&(low - line_high)).sup(&Vector3::zeros()).norm_squared();
    if apart2 == 0.0 {
        return f64::INFINITY;
    }
    line.power / apart2 * (above_line * above_wall / apart2).min(1.0)
}

/// The light of one line on the nodes, to be made with the processor's own vectors. With HIDDEN, not all of the line is seen from all
/// nodes.
struct LineOnNodes<'a, const HIDDEN: bool> {
    lighting: &'a Lighting,
    knots: &'a [Knot],
    gates: &'a [Gate],
    nodes: &'a mut Nodes,
}

// A closure would do, but for its being too large to be inlined, and so compiled for the oldest processor.
impl<const HIDDEN: bool> pulp::WithSimd for LineOnNodes<'_, HIDDEN> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { lighting, knots, gates, nodes } = self;
        let [x, y, z, near_m2] = [&nodes.x, &nodes.y, &nodes.z, &nodes.near_m2].map(|values| values.as_chunks::<LANES>().0);
        let light = nodes.light.as_chunks_mut::<LANES>().0;
        for ((((x, y), z), near_m2), light) in x.iter().zip(y).zip(z).zip(near_m2).zip(light) {
            let mut part = lighting.before.map(|end| [end; LANES]);
            if HIDDEN {
                let length_m = knots[knots.len() - 1].at_m;
                for gate in gates {
                    gate.narrow([x, y, z], length_m, &mut part);
                }
            }
            shine::<HIDDEN>(lighting, knots, [x, y, z, near_m2], [&part[0], &part[1]], light);
        }
    }
}

impl Gate {
    fn new(rim: &Rim, ends: &[Point3<f64>; 2]) -> Self {
        let volumes = ends.map(|p| volume(rim, &p.coords));
        Self { constant: volumes.map(|v| v.0 as f32), slope: volumes.map(|v| v.1.map(|c| c as f32).into()) }
    }

    /// Cuts off the part of the line that each node cannot see past the edge.
    #[inline(always)]
    fn narrow(&self, [x, y, z]: [&Lanes; 3], length_m: f32, part: &mut [Lanes; 2]) {
        for i in 0..LANES {
            let volume_of = |end: usize| {
                let slope = &self.slope[end];
                self.constant[end] + (slope[0] * x[i] + slope[1] * y[i] + slope[2] * z[i])
            };
            let (first, last) = (volume_of(0), volume_of(1));
            // Meaningless where both ends are on one side, and not used there.
            let crossing = length_m * (first / (first - last));
            let from = if first >= 0.0 { 0.0 } else { crossing };
            let to = if last >= 0.0 { length_m } else { crossing };
            let nothing = (first < 0.0) & (last < 0.0);
            part[0][i] = larger(part[0][i], if nothing { length_m } else { from });
            part[1][i] = smaller(part[1][i], if nothing { 0.0 } else { to });
        }
    }
}

#[cfg(test)]
mod tests {
    use ductloop_duct::cell::SurfaceId;
    use ductloop_duct::fitting::{Fitting, Shape};
    use ductloop_duct::network::{End, Network};
    use ductloop_nav::rig::{Camera, Distortion, Laser, LineWidth, Mount, MountAngles};
    use nalgebra::Unit;

    use super::*;
    use crate::frame_geometry::{FrameGeometry, GlowPatch, Sweep};
    use crate::surface::Look;

    /// The same bits with each of the processor's vectors as with none.
    #[test]
    fn every_vector_path_gives_the_same_bits() {
        let piece = |shape| Fitting { shape, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) };
        let elbow = piece(Shape::RadiusElbow { angle_rad: 1.5, throat_radius_m: 0.375 });
        let network = Network::from_run(&[piece(Shape::Straight { length_m: 1.0 }), elbow], End::Open, End::Cap).unwrap();
        let scenery = Scenery::new(&network, &[Look::matt(0.6)]).unwrap();
        let mount = Mount { position_in_base_m: Point3::new(0.4, 0.03, 0.12), roll_rad: 0.1, rest: MountAngles::default() };
        let source_in_camera = Point3::new(0.0, 0.06, 0.0);
        let normal_in_camera = Unit::new_normalize(Vector3::new(-0.03, 0.99, 0.1));
        let slit = Laser {
            name: "slit".into(),
            normal_in_camera,
            offset_m: normal_in_camera.dot(&source_in_camera.coords),
            source_in_camera,
            fan_rad: 1.8,
        };
        let camera = Camera {
            width_px: 640,
            height_px: 480,
            focal_px: [378.4; 2],
            centre_px: [319.5, 239.5],
            distortion: Distortion::NONE,
        };
        let rig = Rig { camera, mount, lasers: vec![slit], line: LineWidth { width_m: 2e-3, growth_rad: 4e-3 } };
        let optics = Optics { bounce: true, ..Optics::default() };
        let world_from_camera = rig.mount.base_from_camera(rig.mount.rest);
        let mut geometry = FrameGeometry::new(&rig, &optics).unwrap();
        geometry.build(&scenery, &Sweep::still(world_from_camera), &[1.0; MAX_LASERS]).expect("the camera is in the duct");
        // All of the image for each region: most nodes are outside it.
        let mut regions = geometry.regions.clone();
        for (i, region) in regions.iter_mut().enumerate() {
            region.glow = Some(GlowPatch { first: i * 41 * 31, column: 0, row: 0, columns: 41, rows: 31 });
        }
        let mut glow = Glow::new(&rig, &optics, geometry.projection(), geometry.blur()).unwrap();
        let camera_from_world = world_from_camera.inverse();
        let mut lit = |arch: pulp::Arch| {
            glow.arch = arch;
            let mut out = vec![0.0; regions.len() * 41 * 31];
            let scene = GlowScene {
                scenery: &scenery,
                camera_from_world: &camera_from_world,
                cell: 0,
                regions: &regions,
                corners: &geometry.corners,
                laser_power: &[1.0; MAX_LASERS],
            };
            glow.gather(&scene, &mut out);
            out
        };
        let plain = lit(pulp::Arch::Scalar);
        assert!(plain.iter().all(|light| (0.0..10.0).contains(light)));
        assert!(plain.iter().filter(|light| **light > 0.05).count() > 2000, "most nodes are lit");
        let best = lit(pulp::Arch::new());
        assert!(plain.iter().zip(&best).all(|(a, b)| a.to_bits() == b.to_bits()));
        #[cfg(target_arch = "x86_64")]
        if let Some(vectors) = pulp::x86::V3::try_new() {
            let v3 = lit(pulp::Arch::V3(vectors));
            assert!(plain.iter().zip(&v3).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}
