//! Every shape in several sizes, and what tests of them share.
// Each test uses a part of it.
#![allow(dead_code)]

use ductloop_duct::cell::{Cell, SurfaceId};
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{AcrossAlign, Blade, Fitting, GrilleSide, Hand, Shape, UprightAlign};
use ductloop_duct::network::{Join, Network, NetworkError, Piece};
use nalgebra::{Point3, Vector3};

pub(crate) const WIDTH: f64 = 0.5;
pub(crate) const HEIGHT: f64 = 0.3;

pub(crate) fn fitting(shape: Shape) -> Fitting {
    Fitting { shape, width_m: WIDTH, height_m: HEIGHT, surface: SurfaceId(0) }
}

pub(crate) fn straight(length_m: f64) -> Fitting {
    fitting(Shape::Straight { length_m })
}

pub(crate) fn mitre(deg: f64) -> Fitting {
    fitting(Shape::MitredElbow { angle_rad: deg.to_radians() })
}

pub(crate) fn tee(hand: Hand) -> Fitting {
    fitting(Shape::Tee { hand, branch_width_m: WIDTH })
}

/// A shape, its mirror image, and the volume of its cells by closed form.
pub(crate) struct Case {
    pub(crate) shape: Shape,
    pub(crate) mirrored: Shape,
    pub(crate) volume_m3: f64,
}

/// Area of a chain of gores of this radius, width and angle: each is an isosceles trapezium between two seams.
fn gores_m2(radius_m: f64, angle_rad: f64) -> f64 {
    let gores = (angle_rad / 7.5_f64.to_radians() - 1e-9).ceil();
    let step = angle_rad / gores;
    let (inner, outer) = (radius_m - WIDTH / 2.0, radius_m + WIDTH / 2.0);
    gores * (outer * outer - inner * inner) * libm::sin(step) / 2.0
}

/// All shapes, at several angles and sizes.
pub(crate) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |shape, mirrored, volume_m3| cases.push(Case { shape, mirrored, volume_m3 });
    let section = WIDTH * HEIGHT;
    let same = Shape::Straight { length_m: 1.2 };
    add(same, same, 1.2 * section);
    for deg in [15.0_f64, 45.0, 60.0, 90.0, 180.0] {
        let angle_rad = deg.to_radians();
        for throat_radius_m in [0.05, 0.375] {
            add(
                Shape::RadiusElbow { angle_rad, throat_radius_m },
                Shape::RadiusElbow { angle_rad: -angle_rad, throat_radius_m },
                gores_m2(throat_radius_m + WIDTH / 2.0, angle_rad) * HEIGHT,
            );
        }
    }
    for deg in [20.0_f64, 45.0, 90.0, 120.0] {
        let angle_rad = deg.to_radians();
        // Two right triangles: the width, and the heel.
        let volume = WIDTH * WIDTH * libm::tan(angle_rad / 2.0) * HEIGHT;
        add(Shape::MitredElbow { angle_rad }, Shape::MitredElbow { angle_rad: -angle_rad }, volume);
        add(Shape::VanedElbow { angle_rad }, Shape::VanedElbow { angle_rad: -angle_rad }, volume);
    }
    for (to_width_m, to_height_m) in [(0.3, 0.3), (0.5, 0.2), (0.3, 0.2), (0.8, 0.4)] {
        let length_m = 0.6;
        // The section's area is a product of two linear functions along the length.
        let product = WIDTH * HEIGHT + to_width_m * to_height_m + (WIDTH + to_width_m) * (HEIGHT + to_height_m);
        for (across, mirror) in [
            (AcrossAlign::Concentric, AcrossAlign::Concentric),
            (AcrossAlign::Left, AcrossAlign::Right),
            (AcrossAlign::Right, AcrossAlign::Left),
        ] {
            for upright in [UprightAlign::FlatBottom, UprightAlign::Concentric] {
                let shape = |across| Shape::Transition { length_m, to_width_m, to_height_m, across, upright };
                add(shape(across), shape(mirror), length_m * product / 6.0);
            }
        }
    }
    for (length_m, aside_m) in [(1.0, 0.3), (1.5, 0.1), (0.8, 0.7)] {
        let radius_m = (length_m * length_m + aside_m * aside_m) / (4.0 * aside_m);
        let angle_rad = 2.0 * libm::atan2(aside_m, length_m);
        add(
            Shape::Offset { length_m, aside_m },
            Shape::Offset { length_m, aside_m: -aside_m },
            2.0 * gores_m2(radius_m, angle_rad) * HEIGHT,
        );
    }
    for deg in [-10.0_f64, 3.0, 10.0] {
        let slope = Shape::Slope { length_m: 1.5, angle_rad: deg.to_radians() };
        add(slope, slope, 1.5 * section);
    }
    for branch_width_m in [0.2, 0.5, 0.7] {
        let body = branch_width_m * section;
        let (left, right) = (Hand::Left, Hand::Right);
        add(Shape::Tee { hand: left, branch_width_m }, Shape::Tee { hand: right, branch_width_m }, body);
        add(Shape::BullheadTee { branch_width_m }, Shape::BullheadTee { branch_width_m }, body);
        add(Shape::Cross { branch_width_m }, Shape::Cross { branch_width_m }, body);
        let shoe_m = 0.15;
        add(
            Shape::SideBranch { hand: left, branch_width_m, shoe_m },
            Shape::SideBranch { hand: right, branch_width_m, shoe_m },
            ((branch_width_m + shoe_m) * WIDTH + shoe_m * (branch_width_m + shoe_m / 2.0)) * HEIGHT,
        );
    }
    for (deg, branch_width_m) in [(30.0_f64, 0.5), (45.0, 0.5), (60.0, 0.5), (45.0, 0.3), (60.0, 0.3), (30.0, 0.25), (45.0, 0.7)]
    {
        let half_angle_rad = deg.to_radians();
        let (s, c) = libm::sincos(half_angle_rad);
        let leg = (branch_width_m * c - WIDTH / 2.0) / s;
        let tangent = WIDTH.min(branch_width_m) / 2.0 * libm::tan(half_angle_rad / 2.0);
        let stem = (tangent - (branch_width_m - WIDTH * c) / (2.0 * s)).max(0.0);
        let area = if leg > 0.0 {
            // The triangle to the crotch, and two triangles of leg and port.
            WIDTH * (branch_width_m * s + leg * c) / 2.0 + branch_width_m * leg
        } else {
            // A trapezium between the stem and the flat wall.
            branch_width_m * s * (2.0 * WIDTH - 2.0 * branch_width_m * c) / 2.0
        };
        let wye = Shape::Wye { half_angle_rad, branch_width_m };
        add(wye, wye, (area + stem * WIDTH) * HEIGHT);
    }
    for blade in [Blade::Open, Blade::Shut] {
        let damper = Shape::Damper { length_m: 0.3, blade };
        add(damper, damper, 0.3 * section);
    }
    let grille = |side| Shape::Grille { length_m: 0.6, side, opening_length_m: 0.4, opening_height_m: 0.2 };
    add(grille(GrilleSide::Left), grille(GrilleSide::Right), 0.6 * section);
    add(grille(GrilleSide::Ceiling), grille(GrilleSide::Ceiling), 0.6 * section);
    for hole_width_m in [0.3, WIDTH] {
        let drop = Shape::Drop { length_m: 0.8, hole_length_m: 0.4, hole_width_m, depth_m: 1.0 };
        add(drop, drop, 0.8 * section + 0.4 * hole_width_m);
    }
    cases
}

/// Every shape and its mirror image.
pub(crate) fn shapes() -> Vec<Shape> {
    let mut shapes = Vec::new();
    for case in cases() {
        shapes.push(case.shape);
        if case.mirrored != case.shape {
            shapes.push(case.mirrored);
        }
    }
    shapes
}

/// A fitting alone, each of its ports closed by a straight of its size.
pub(crate) fn with_stubs(shape: Shape) -> Result<Network, NetworkError> {
    let fitting = fitting(shape);
    let mut pieces = vec![Piece { fitting, name: "it".to_owned() }];
    let mut joins = Vec::new();
    for port in fitting.ports() {
        let stub = Fitting {
            shape: Shape::Straight { length_m: 0.3 },
            width_m: port.width_m,
            height_m: port.height_m,
            surface: SurfaceId(1),
        };
        joins.push(Join { a: (0, port.name), b: (pieces.len(), PortName::In) });
        pieces.push(Piece { fitting: stub, name: format!("stub at {}", port.name) });
    }
    Network::assemble(&pieces, &joins, &[])
}

pub(crate) fn corners(cell: &Cell) -> impl Iterator<Item = &Point3<f64>> {
    cell.faces.iter().flat_map(|face| &face.outline)
}

/// Volume of a cell: pyramids from the origin over its faces.
pub(crate) fn volume_m3(cell: &Cell) -> f64 {
    let mut volume = 0.0;
    for face in &cell.faces {
        let o = &face.outline;
        let area = (1..o.len() - 1).fold(Vector3::zeros(), |sum, i| sum + (o[i] - o[0]).cross(&(o[i + 1] - o[0]))) / 2.0;
        volume += area.dot(&o[0].coords) / 3.0;
    }
    volume
}
