//! What a pixel's square sees: the area of each region in it, by cutting polygons.

use ductloop_sensor::frame_geometry::FrameGeometry;
use nalgebra::{Vector2, Vector3};

type Polygon = Vec<Vector2<f64>>;

/// The part of a polygon where `inside` is not negative. `inside` must be linear.
fn cut(polygon: &[Vector2<f64>], inside: impl Fn(&Vector2<f64>) -> f64) -> Polygon {
    let mut kept = Polygon::new();
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let (from, to) = (inside(a), inside(b));
        if (from < 0.0) != (to < 0.0) {
            kept.push(a + (b - a) * (from / (from - to)));
        }
        if to >= 0.0 {
            kept.push(*b);
        }
    }
    kept
}

fn twice_area(polygon: &[Vector2<f64>]) -> f64 {
    (0..polygon.len()).map(|i| polygon[i].perp(&polygon[(i + 1) % polygon.len()])).sum()
}

/// What both polygons hold; `by` is convex, whichever way round.
fn both(polygon: &[Vector2<f64>], by: &[Vector2<f64>]) -> Polygon {
    let side = twice_area(by).signum();
    (0..by.len()).fold(polygon.to_vec(), |kept, i| {
        let (a, b) = (by[i], by[(i + 1) % by.len()]);
        cut(&kept, |p| side * (b - a).perp(&(p - a)))
    })
}

/// Shares of a pixel's square, each with the number of its region; behind the regions come the grilles. What bodies hide is taken from
/// what is behind them, each from each alone.
pub fn shares(geometry: &FrameGeometry, pixel: [f64; 2]) -> Vec<(usize, f64)> {
    let [x, y] = geometry.projection().ray(pixel);
    // Straight edges are straight within a pixel.
    let pixel_per_ray = geometry.projection().rays_per_pixel([x, y]).try_inverse().expect("a lens that does not fold");
    let square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(Vector2::from);
    let outlines = geometry.regions.iter().map(|region| region.outline.clone()).chain(geometry.grilles.iter().cloned());
    let pieces: Vec<Polygon> = outlines
        .map(|outline| {
            let corners = geometry.corners[outline].iter();
            let polygon: Polygon = corners.map(|c| pixel_per_ray * (c.coords.xy() / c.z - Vector2::new(x, y))).collect();
            if polygon.iter().all(|p| p.x > 0.5) || polygon.iter().all(|p| p.x < -0.5) {
                Polygon::new()
            } else {
                both(&polygon, &square)
            }
        })
        .collect();
    let ray_per_pixel = geometry.projection().rays_per_pixel([x, y]);
    let near = |index: usize, at: &Vector2<f64>| {
        let ray = ray_per_pixel * at + Vector2::new(x, y);
        let ray = Vector3::new(ray.x, ray.y, 1.0);
        geometry.regions.get(index).map_or(0.0, |r| r.plane.normal.dot(&ray) / r.plane.offset_m)
    };
    let is_body = |index: usize| geometry.regions.get(index).is_some_and(|region| region.body.is_some());
    // What a body hides of a region: where both are, if the body is the nearer one there.
    let hidden = |index: usize, other: usize| {
        if other == index || pieces[other].is_empty() || !is_body(other) {
            return 0.0;
        }
        let overlap = both(&pieces[index], &pieces[other]);
        if overlap.is_empty() {
            return 0.0;
        }
        let middle = overlap.iter().sum::<Vector2<f64>>() / overlap.len() as f64;
        if near(other, &middle) > near(index, &middle) { twice_area(&overlap).abs() } else { 0.0 }
    };
    let seen = |index: usize| {
        let hidden: f64 = (0..pieces.len()).map(|other| hidden(index, other)).sum();
        ((twice_area(&pieces[index]).abs() - hidden) / 2.0).max(0.0)
    };
    (0..pieces.len()).filter(|index| !pieces[*index].is_empty()).map(|index| (index, seen(index))).collect()
}
