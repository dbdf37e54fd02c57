//! Where the stripes are: images without noise against the intersection of laser plane, wall, and pixel row or column, worked
//! out here from the walls of a straight duct, with a camera pose of its own.
#![cfg(feature = "wgpu")]

mod common;

use common::{LOOKS, base_at, duct, image, incra1, quiet, straight, view, wide};
use ductloop_nav::rig::{Laser, Rig};
use ductloop_sensor::WgpuRenderer;
use nalgebra::{Matrix3, Point3, Vector3};

const LENGTH_M: f64 = 6.0;
const WIDTH_M: f64 = 0.5;
const HEIGHT_M: f64 = 0.3;

/// Walls as (world axis, coordinate): n . p = d with n that axis.
const WALLS: [(usize, f64); 5] = [(1, WIDTH_M / 2.0), (1, -WIDTH_M / 2.0), (2, 0.0), (2, HEIGHT_M), (0, LENGTH_M)];

/// The camera's axes and centre in the world, from its heading, pan and roll: z along the view, x and y turned by the roll from
/// right and down.
struct Pose {
    axes: [Vector3<f64>; 3],
    centre: Point3<f64>,
}

impl Pose {
    fn new(rig: &Rig, x: f64, y: f64, heading_deg: f64) -> Self {
        let heading = heading_deg.to_radians();
        let ahead = Vector3::new(libm::cos(heading), libm::sin(heading), 0.0);
        let yaw = heading + rig.mount.rest.pan_rad;
        let view = Vector3::new(libm::cos(yaw), libm::sin(yaw), 0.0);
        let (right, down) = (Vector3::new(view.y, -view.x, 0.0), Vector3::new(0.0, 0.0, -1.0));
        let (s, c) = libm::sincos(rig.mount.roll_rad);
        let position = rig.mount.position_in_base_m;
        assert!(position.y == 0.0 && rig.mount.rest.tilt_rad == 0.0, "this pose knows neither");
        Self {
            axes: [right * c + down * s, down * c - right * s, view],
            centre: Point3::new(x, y, position.z) + ahead * position.x,
        }
    }

    fn in_world(&self, p: &Vector3<f64>) -> Point3<f64> {
        self.centre + self.axes[0] * p.x + self.axes[1] * p.y + self.axes[2] * p.z
    }

    /// Where the stripe of `laser` crosses line `line` of the image (a column for `along` = 1, a row for 0), as the pixel
    /// coordinate on that line; `None` where the stripe is not on this wall or not in view.
    fn crossing(&self, rig: &Rig, laser: &Laser, wall: (usize, f64), along: usize, line: f64) -> Option<f64> {
        let across = 1 - along;
        let slope = (line - rig.camera.centre_px[across]) / rig.camera.focal_px[across];
        let mut in_line = Vector3::new(0.0, 0.0, -slope);
        in_line[across] = 1.0;
        let normal = Vector3::new(self.axes[0][wall.0], self.axes[1][wall.0], self.axes[2][wall.0]);
        let rows = [laser.normal_in_camera.into_inner(), normal, in_line].map(|v| v.transpose());
        let right = Vector3::new(laser.offset_m, wall.1 - self.centre[wall.0], 0.0);
        let p = Matrix3::from_rows(&rows).try_inverse()? * right;
        let q = self.in_world(&p);
        let inside = |v: f64, low: f64, high: f64| v > low - 1e-9 && v < high + 1e-9;
        let on_wall = inside(q.x, 0.0, LENGTH_M) && inside(q.y.abs(), 0.0, WIDTH_M / 2.0) && inside(q.z, 0.0, HEIGHT_M);
        let pixel = rig.camera.centre_px[along] + rig.camera.focal_px[along] * p[along] / p.z;
        (p.z > 0.0 && on_wall).then_some(pixel)
    }
}

/// (root mean square, largest, number) of the differences between the centroids of `pixels` and the exact crossings, over all
/// lines of the image where the stripe's whole cross-section is on one wall.
fn differences(rig: &Rig, laser: &Laser, pose: &Pose, pixels: &[u8], along: usize, half_window: i64) -> (f64, f64, usize) {
    let size = [rig.camera.width_px as i64, rig.camera.height_px as i64];
    let at = |line: i64, k: i64| {
        let (u, v) = if along == 1 { (line, k) } else { (k, line) };
        f64::from(pixels[(v * size[0] + u) as usize]) - 8.0
    };
    let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for line in 0..size[1 - along] {
        let crossings: Vec<f64> = WALLS.iter().filter_map(|wall| pose.crossing(rig, laser, *wall, along, line as f64)).collect();
        let [exact] = crossings[..] else { continue };
        let middle = exact.round() as i64;
        if middle < half_window || middle >= size[along] - half_window {
            continue;
        }
        let window = (middle - half_window)..=(middle + half_window);
        let light: f64 = window.clone().map(|k| at(line, k)).sum();
        let first: f64 = window.clone().map(|k| at(line, k) * (k - middle) as f64).sum();
        let peak = window.clone().map(|k| at(line, k)).fold(0.0, f64::max);
        // Light at the window's ends: a corner of the duct is near. A faint stripe shows its rounding to grey values.
        if peak < 30.0 || at(line, middle - half_window) > 1.0 || at(line, middle + half_window) > 1.0 {
            continue;
        }
        let error = middle as f64 + first / light - exact;
        squares += error * error;
        largest = largest.max(error.abs());
        count += 1;
    }
    ((squares / count as f64).sqrt(), largest, count)
}

fn check(rig: &Rig, along: usize, half_window: i64, longer: f64, poses: &[(f64, f64, f64)], lines_min: usize) {
    let Some(gpu) = common::gpu() else { return };
    let network = duct(&[straight(LENGTH_M, WIDTH_M, HEIGHT_M)]);
    let mut renderer = WgpuRenderer::new(gpu, &network, rig, &quiet(), &LOOKS, 1).expect("the rig and the optics are sound");
    for &(x, y, heading_deg) in poses {
        for (index, laser) in rig.lasers.iter().enumerate() {
            let mut view = view(rig, &base_at(x, y, heading_deg));
            view.headlamp_power = 0.0;
            view.exposure_s *= longer;
            view.laser_power = [0.0; 4];
            view.laser_power[index] = 1.0;
            let pixels = image(&mut renderer, rig, &view);
            let pose = Pose::new(rig, x, y, heading_deg);
            let (rms, largest, count) = differences(rig, laser, &pose, &pixels, along, half_window);
            println!("{} at ({x}, {y}, {heading_deg}): {rms:.4} px RMS, {largest:.4} px at most, {count} lines", laser.name);
            assert!(count >= lines_min, "{}: only {count} lines were compared", laser.name);
            // 8-bit rounding of a stripe of some 30 DN leaves about 0.02 px. The light falls off within the stripe's own width,
            // which moves its centroid toward the source by as much again.
            assert!(rms < 0.05, "{}: {rms} px", laser.name);
        }
    }
}

#[test]
fn stripes_of_the_wide_rig_are_where_plane_and_wall_meet() {
    // At the sides of this short lens' image a third of the light is left.
    check(&wide(), 1, 12, 3.0, &[(1.5, 0.0, 0.0), (1.5, 0.06, 6.0), (2.2, -0.08, -9.0)], 60);
}

#[test]
fn stripes_of_incra1_are_where_plane_and_wall_meet() {
    check(&incra1(), 0, 40, 1.0, &[(1.5, 0.0, 0.0), (1.5, -0.05, 4.0), (3.0, 0.06, -3.0)], 200);
}
