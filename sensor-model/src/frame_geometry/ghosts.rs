//! Ghosts: stripes that a wall mirrors, once, on the light's way to a sheet or on its way from there to the camera.
//!
//! A flat mirror shows the mirror image of everything: of the laser (source, plane and fan), which then lights other sheets
//! through the part of the mirror that it reached; or of a lit sheet, which the camera then sees through the part of the mirror that is
//! in view. Either is a strip like any other, of mirrored things, cut off by the mirror's window and spread by its roughness.
//!
//! A ghost of a rough wall is sharp only where it starts, at the corner where the two walls meet. Where it is spread so wide that linear
//! interpolation between the glow's nodes is right to [`SMOOTH_DN`], it goes there: cut in two by an edge across it which the roughness
//! softens like its other edges, so that the two parts add up.
//!
//! Left out: light that is mirrored twice, so that of a sheet's own reflectance a ghost has the matt part only; mirrors that are
//! bodies' faces; for what goes to the glow, shadows of bodies.

use nalgebra::{Point3, Vector2, Vector3};

use super::ghost_parts::{Draft, cut};
use super::region::{Region, ridge};
use super::shadow::trace;
use super::sightings::{Apex, Sighting, Sightings};
use super::slit::{Slit, mirrored_plane, mirrored_point, mirrored_way};
use super::strips::{clip_to_sight, clip_to_slit, edges_near};
use super::wide_ghosts::WideGhost;
use super::{Frame, FrameGeometry};
use crate::band::{BandPoint, Middle};
use crate::beam::{clip_top, plane_of_edge};
use crate::coverage::Edge;
use crate::lens::Projection;
use crate::light::{CUT_SIGMAS, RANGE_M};
use crate::scenery::Scenery;
use crate::strip::{Blur, Mirror, MirroredWay, PixelRay, Strip, StripAt};
use crate::surface::Look;

/// Where a band may end: light below this, in grey values, is not followed.
const BAND_DN: f64 = 0.005;

/// Mirrors that the camera sees smaller than this, in square pixels, show nothing.
const MIRROR_MIN_PX2: f64 = 64.0;

/// Bodies' faces narrower than this, in metres, leave no ghosts: those of flange beads are many and small.
const FACE_MIN_M: f64 = 0.015;

/// How far beyond a mirror's window its lobe is followed, in the lobe's standard deviations, and at most, in radians.
const LOBES: f64 = 3.0;
const LOBES_MAX_RAD: f64 = 0.7;

/// Working memory, kept from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Ghosts {
    echo: Sightings,
    bounds: Vec<Vector3<f64>>,
    /// Inward normals of the planes, through the laser's mirror image, that bound the light which leaves a mirror.
    lit_window: Vec<Vector3<f64>>,
    edges: Vec<Edge>,
    window: Vec<Edge>,
    borders: Vec<(PixelRay, f64)>,
    /// A sighting's outline as it is seen mirrored.
    seen: Vec<Point3<f64>>,
}

/// A sheet as ghosts show it: without gloss, which would mirror the light once more.
fn matt(scenery: &Scenery, sheet: &Sighting) -> Look {
    Look::matt(scenery.looks[usize::from(sheet.surface.0)].albedo)
}

fn is_small(sheet: &Sighting) -> bool {
    sheet.body.is_some() && sheet.breadth_m < FACE_MIN_M
}

fn is_mirror(look: &Look, body: Option<usize>) -> bool {
    look.specular > 0.0 && body.is_none()
}

impl FrameGeometry {
    /// Adds all ghosts.
    pub(super) fn add_ghosts(&mut self, frame: &Frame) {
        let mut ghosts = std::mem::take(&mut self.ghosts);
        self.lit_by_sheet.clear();
        self.lit_by_sheet.extend(self.lit.list.iter().enumerate().map(|(index, lit)| (lit.sheet, index)));
        self.lit_by_sheet.sort_unstable();
        for lit in 0..self.lit.list.len() {
            self.add_lit_by_mirror(frame, lit, &mut ghosts);
        }
        for region in 0..self.regions.len() {
            self.add_seen_in_mirror(frame, region, &mut ghosts);
        }
        self.ghosts = ghosts;
    }

    /// What the lit piece number `lit` throws on other sheets.
    fn add_lit_by_mirror(&mut self, frame: &Frame, lit: usize, ghosts: &mut Ghosts) {
        let lit = self.lit.list[lit].clone();
        let mirror = Mirror { plane: lit.plane, look: frame.scenery.looks[usize::from(lit.surface.0)], way: MirroredWay::Light };
        if !is_mirror(&mirror.look, lit.body) {
            return;
        }
        let lobe_rad = mirror.lobe_rad();
        let slit = self.slits[lit.by].mirrored(&lit.plane).scattered(lobe_rad);
        let apex = slit.source;
        // The mirror's lit part, and the pyramid of light that leaves it.
        self.points.clear();
        self.points.extend_from_slice(self.lit.outline(&lit));
        clip_to_slit(&mut self.points, &self.slits[lit.by], &mut self.spare);
        if self.points.len() < 3 {
            return;
        }
        let middle = middle_from(&apex, &self.points);
        ghosts.lit_window.clear();
        let edges = edges_near(self.lit.outline(&lit), &self.slits[lit.by]);
        ghosts.lit_window.extend(edges.filter_map(|(_, [a, b])| inward(&apex, &a, &b, &middle)));
        widened_pyramid(&apex, &self.points, lobe_rad, &mut ghosts.bounds);
        ghosts.echo.clear();
        let from = Apex { point: apex, cell: lit.cell, bounds: &ghosts.bounds, range_m: RANGE_M, wanted: Some(&self.by_sheet) };
        ghosts.echo.add(&mut self.beam, frame.scenery, &frame.camera_from_world, &from, lit.by);

        for index in 0..ghosts.echo.list.len() {
            if is_small(&ghosts.echo.list[index]) {
                continue;
            }
            let sheet = ghosts.echo.list[index].sheet;
            let mut next = self.by_sheet.partition_point(|(other, _)| *other < sheet);
            while let Some((_, region)) = self.by_sheet.get(next).filter(|(other, _)| *other == sheet) {
                let region = *region;
                next += 1;
                let sighting = &ghosts.echo.list[index];
                let seen = &self.corners[self.regions[region].outline.clone()];
                self.points.clear();
                self.points.extend_from_slice(ghosts.echo.outline(sighting));
                if misses(&self.points, &slit) {
                    continue;
                }
                clip_to_sight(&mut self.points, seen, &mut self.spare);
                let plane = self.regions[region].plane;
                ghosts.edges.clear();
                ghosts.edges.extend(real_edges(&self.points, &slit, &apex, &ghosts.bounds));
                clip_to_slit(&mut self.points, &slit, &mut self.spare);
                if self.points.len() < 3 {
                    continue;
                }
                ghosts.window.clear();
                ghosts.window.extend(ghosts.lit_window.iter().filter_map(|q| trace(q, &apex, &plane)));
                let (ridge, sweep) = frame.ridge_and_sweep(|now| {
                    let laser = mirrored_plane(&self.slits[lit.by].plane, &lit.plane.transformed(now));
                    ridge(&plane.transformed(now), &laser)
                });
                let draft = Draft {
                    strip: Strip {
                        plane,
                        ridge,
                        sweep,
                        look: matt(frame.scenery, sighting),
                        mirror: Some(mirror),
                        ..unplaced(&slit, lit.by)
                    },
                    laser: slit.plane.normal.into_inner(),
                    region,
                    strength: self.strength * frame.laser_power[lit.by],
                };
                let sighting = sighting.clone();
                self.finish(frame, draft, ghosts, &lit, &sighting);
            }
        }
    }

    /// What the camera sees in the wall of region number `region`.
    fn add_seen_in_mirror(&mut self, frame: &Frame, region: usize, ghosts: &mut Ghosts) {
        let Region { plane: mirror_plane, surface, body, cell, ref outline, .. } = self.regions[region];
        let mirror = Mirror { plane: mirror_plane, look: frame.scenery.looks[usize::from(surface.0)], way: MirroredWay::View };
        if !is_mirror(&mirror.look, body) {
            return;
        }
        let apex = mirrored_point(&Point3::origin(), &mirror_plane).coords;
        let seen = &self.corners[outline.clone()];
        if self.area_px2(seen) < MIRROR_MIN_PX2 {
            return;
        }
        widened_pyramid(&apex, seen, mirror.lobe_rad(), &mut ghosts.bounds);
        ghosts.echo.clear();
        let from = Apex { point: apex, cell, bounds: &ghosts.bounds, range_m: RANGE_M, wanted: Some(&self.lit_by_sheet) };
        ghosts.echo.add(&mut self.beam, frame.scenery, &frame.camera_from_world, &from, region);
        // Seen from the camera, all is mirrored: the planes too that the search was bounded by.
        for bound in &mut ghosts.bounds {
            *bound = mirrored_way(bound, &mirror_plane);
        }
        for index in 0..ghosts.echo.list.len() {
            if is_small(&ghosts.echo.list[index]) {
                continue;
            }
            let sheet = ghosts.echo.list[index].sheet;
            let mut next = self.lit_by_sheet.partition_point(|(other, _)| *other < sheet);
            while let Some((_, lit)) = self.lit_by_sheet.get(next).filter(|(other, _)| *other == sheet) {
                next += 1;
                let (sighting, lit) = (&ghosts.echo.list[index], &self.lit.list[*lit]);
                // The lit piece as far as it is seen in the mirror.
                let mirrored = |p: &Point3<f64>| mirrored_point(p, &mirror_plane);
                self.points.clear();
                self.points.extend(self.lit.outline(lit).iter().map(mirrored));
                ghosts.seen.clear();
                ghosts.seen.extend(ghosts.echo.outline(sighting).iter().map(mirrored));
                let slit = self.slits[lit.by].mirrored(&mirror_plane);
                let hidden = |bound: &Vector3<f64>| ghosts.seen.iter().all(|p| bound.dot(&p.coords) > 0.0);
                if misses(&ghosts.seen, &slit) || self.frustum.iter().any(hidden) {
                    continue;
                }
                clip_to_sight(&mut self.points, &ghosts.seen, &mut self.spare);
                ghosts.edges.clear();
                ghosts.edges.extend(real_edges(&self.points, &slit, &Vector3::zeros(), &ghosts.bounds));
                clip_to_slit(&mut self.points, &slit, &mut self.spare);
                for bound in &self.frustum {
                    clip_top(&mut self.points, 0, &mut self.spare, |p| bound.dot(&p.coords));
                }
                if self.points.len() < 3 {
                    continue;
                }
                let seen = &self.corners[self.regions[region].outline.clone()];
                let middle = middle_from(&Vector3::zeros(), seen);
                ghosts.window.clear();
                ghosts.window.extend((0..seen.len()).filter_map(|i| {
                    let line = plane_of_edge(&seen[i], &seen[(i + 1) % seen.len()])?;
                    Some(if line.dot(&middle) > 0.0 { line } else { -line })
                }));
                let (ridge, sweep) = frame.ridge_and_sweep(|now| {
                    let mirror = mirror_plane.transformed(now);
                    let sheet = mirrored_plane(&lit.plane.transformed(now), &mirror);
                    ridge(&sheet, &mirrored_plane(&self.slits[lit.by].plane, &mirror))
                });
                let draft = Draft {
                    strip: Strip {
                        plane: mirrored_plane(&lit.plane, &mirror_plane),
                        ridge,
                        sweep,
                        look: matt(frame.scenery, lit),
                        mirror: Some(mirror),
                        ..unplaced(&slit, lit.by)
                    },
                    laser: slit.plane.normal.into_inner(),
                    region,
                    strength: self.strength * frame.laser_power[lit.by],
                };
                let (sighting, lit) = (sighting.clone(), lit.clone());
                self.finish(frame, draft, ghosts, &lit, &sighting);
            }
        }
    }

    /// Area of an outline in the image, as a pinhole sees it.
    fn area_px2(&self, outline: &[Point3<f64>]) -> f64 {
        let ray = |p: &Point3<f64>| Vector2::new(p.x / p.z, p.y / p.z);
        let doubled: f64 = (0..outline.len()).map(|i| ray(&outline[i]).perp(&ray(&outline[(i + 1) % outline.len()]))).sum();
        doubled.abs() / 2.0 * self.blur.focal_px * self.blur.focal_px
    }

    /// Makes of a draft a strip, an entry of the wide ghosts, or both. `lit` is what the laser lights directly, `sighting` what
    /// is seen from the mirrored point.
    fn finish(&mut self, frame: &Frame, draft: Draft, ghosts: &mut Ghosts, lit: &Sighting, sighting: &Sighting) {
        let Some(middle) = Middle::new(&draft.strip, &self.points, &draft.laser) else { return };
        let soft = match draft.strip.mirror.map(|mirror| mirror.way) {
            Some(MirroredWay::View) => &ghosts.edges,
            _ => &ghosts.window,
        };
        let parts = self.parts(&draft, &middle, &ghosts.window);
        for part in parts.smooth.iter().flatten() {
            let cut = part.cut.map(|(share, side)| cut(&middle, share) * side);
            self.wide_ghosts.add(WideGhost::new(&draft.strip, draft.region, draft.strength, part.coarse), soft, cut);
        }
        let Some([from, to]) = parts.sharp else { return };
        let across = [(from, 1.0), (to, -1.0)].map(|(share, side)| {
            let within = share > 0.0 && share < 1.0;
            within.then(|| cut(&middle, share) * side)
        });

        let mut strip = draft.strip;
        let first_point = self.band.len();
        let strength = draft.strength;
        let reach = |at: &StripAt| {
            let peak_dn = strength * at.peak * at.sigma_px / at.spread_px;
            (2.0 * libm::log((peak_dn / BAND_DN).max(1.0))).sqrt().clamp(1.0, CUT_SIGMAS)
        };
        let sharp_part = Middle { first: middle.at(from), last: middle.at(to) };
        if !sharp_part.lay(&strip, reach, &self.projection, &self.blur, &mut self.band) {
            self.band.truncate(first_point);
            return;
        }
        strip.band = first_point..self.band.len();
        let first_edge = self.edges.len();
        let view = matches!(strip.mirror, Some(Mirror { way: MirroredWay::View, .. }));
        borders(&self.band[strip.band.clone()], &strip, &self.projection, &self.blur, &mut ghosts.borders);
        let matters = |edge: &&Edge| cuts(edge, &ghosts.borders);
        self.edges.extend(ghosts.edges.iter().filter(matters));
        if view {
            self.edges.extend(across.into_iter().flatten());
        }
        let first_window = self.edges.len();
        self.edges.extend(ghosts.window.iter().filter(matters));
        if !view {
            self.edges.extend(across.into_iter().flatten());
        }
        strip.edges = first_edge..first_window;
        strip.window = first_window..self.edges.len();
        let first_hole = self.holes.len();
        self.add_ghost_shadows(frame, &strip, &ghosts.echo, lit, sighting);
        strip.holes = first_hole..self.holes.len();
        self.strips.push(strip);
    }

    /// Holes for the bodies on each part of the way: laser, mirror, sheet, camera or laser, sheet, mirror, camera.
    fn add_ghost_shadows(&mut self, frame: &Frame, strip: &Strip, echo: &Sightings, lit: &Sighting, sighting: &Sighting) {
        let Some(mirror) = &strip.mirror else { return };
        let bodies = &frame.scenery.bodies;
        let (edges, holes, shadows) = (&mut self.edges, &mut self.holes, &mut self.shadows);
        let camera = Vector3::zeros();
        // Up to the mirror, and on from there; the camera sees whatever is in front of the sheet, or of the mirror.
        let (beyond, beyond_mirror, front, own) = match mirror.way {
            MirroredWay::Light => (strip.source, None, &strip.plane, sighting.body),
            MirroredWay::View => (camera, Some(&mirror.plane), &mirror.plane, None),
        };
        if self.shadows_on {
            shadows.aim(frame, &strip.source, Some(&mirror.plane), &self.points);
            for id in self.lit.bodies(lit, frame.scenery) {
                shadows.add(&bodies[id], &strip.plane, edges, holes);
            }
        }
        // What is beyond the mirror is the laser's light, or what the camera sees.
        if self.shadows_on || mirror.way == MirroredWay::View {
            shadows.aim(frame, &beyond, beyond_mirror, &self.points);
            for id in echo.bodies(sighting, frame.scenery).filter(|id| Some(*id) != sighting.body) {
                shadows.add(&bodies[id], &strip.plane, edges, holes);
            }
        }
        shadows.aim(frame, &camera, None, &self.points);
        for id in self.seen_bodies.iter().copied().filter(|id| Some(*id) != own) {
            shadows.add(&bodies[id], front, edges, holes);
        }
    }
}

/// A strip of a laser's light without its places.
fn unplaced(slit: &Slit, laser: usize) -> Strip {
    Strip {
        laser,
        plane: slit.plane,
        ridge: Vector3::zeros(),
        sweep: Vector3::zeros(),
        source: slit.source,
        fan: slit.fan,
        line: slit.line,
        look: Look::matt(0.0),
        mirror: None,
        edges: 0..0,
        window: 0..0,
        holes: 0..0,
        band: 0..0,
    }
}

fn middle_from(apex: &Vector3<f64>, outline: &[Point3<f64>]) -> Vector3<f64> {
    outline.iter().map(|p| p.coords - apex).sum::<Vector3<f64>>().normalize()
}

/// Unit normal of the plane through the apex and two points, toward `middle`.
fn inward(apex: &Vector3<f64>, a: &Point3<f64>, b: &Point3<f64>, middle: &Vector3<f64>) -> Option<Vector3<f64>> {
    let normal = plane_of_edge(&(a - apex), &(b - apex))?;
    Some(if normal.dot(middle) > 0.0 { normal } else { -normal })
}

/// Outward normals of the pyramid from an apex over an outline, leaning outward by what a mirror's lobe scatters.
fn widened_pyramid(apex: &Vector3<f64>, outline: &[Point3<f64>], lobe_rad: f64, bounds: &mut Vec<Vector3<f64>>) {
    let middle = middle_from(apex, outline);
    let lean = libm::tan((LOBES * lobe_rad).min(LOBES_MAX_RAD));
    bounds.clear();
    bounds.extend((0..outline.len()).filter_map(|i| {
        let normal = inward(apex, &outline[i], &outline[(i + 1) % outline.len()], &middle)?;
        Some((-normal - middle * lean).normalize())
    }));
}

/// Whether a piece is wholly on one side of a slit's light.
fn misses(piece: &[Point3<f64>], slit: &Slit) -> bool {
    let mut beside = [true; 2];
    for outside in piece.iter().map(|p| slit.outside(p)) {
        beside = [beside[0] && outside[0] > 0.0, beside[1] && outside[1] > 0.0];
    }
    beside[0] || beside[1]
}

/// The edges of a piece near the slit's light, without those that only the bounds of a search made.
fn real_edges<'a>(
    piece: &'a [Point3<f64>],
    slit: &'a Slit,
    apex: &'a Vector3<f64>,
    bounds: &'a [Vector3<f64>],
) -> impl Iterator<Item = Edge> + 'a {
    /// What is nearer to a bound than this, in metres, was cut off by it.
    const ROUNDING_M: f64 = 1e-9;
    edges_near(piece, slit).filter_map(move |(line, ends)| {
        let on = |q: &Vector3<f64>| ends.iter().all(|end| q.dot(&(end.coords - apex)).abs() < ROUNDING_M);
        (!bounds.iter().any(on)).then_some(line)
    })
}

/// The borders of a band, each with how far the edges' softness reaches there, in pixels.
fn borders(band: &[BandPoint], strip: &Strip, projection: &Projection, blur: &Blur, borders: &mut Vec<(PixelRay, f64)>) {
    let pixel = |at: Vector2<f64>| PixelRay::of(projection, projection.ray(at.into()).into());
    borders.clear();
    for point in band {
        let at = strip.at(&pixel(point.pixel), blur);
        let reach_px = CUT_SIGMAS * at.ridge.blur_px.max(at.window.blur_px);
        borders.extend(point.borders().map(|border| (pixel(border), reach_px)));
    }
}

/// Whether an edge takes light from anywhere within these borders.
fn cuts(edge: &Edge, borders: &[(PixelRay, f64)]) -> bool {
    borders.iter().any(|(pixel, reach_px)| {
        let steepness = pixel.rays_per_pixel.tr_mul(&edge.xy()).norm();
        edge.dot(&pixel.ray) < reach_px * steepness
    })
}
