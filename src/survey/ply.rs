//! `survey.ply`: the cloud in the binary form of the polygon file format (G. Turk, "The PLY Polygon File Format", 1994), little-endian.

use super::cloud::{Class, CloudPoint, VOXEL_M};
use super::notes::Notes;

/// Colours: walls of ducts with even and with odd numbers, ...
const WALLS: [[u8; 3]; 2] = [[31, 119, 180], [255, 127, 14]];
/// ... the floor, ...
const FLOOR: [u8; 3] = [150, 150, 150];
/// ... what lies on the floor, ...
const DEPOSIT: [u8; 3] = [44, 160, 44];
/// ... what stands between the walls, ...
const INSIDE: [u8; 3] = [214, 39, 40];
/// ... and what is beyond them.
const BEYOND: [u8; 3] = [148, 103, 189];

/// The file's bytes; `None` where no cloud was kept.
pub fn bytes(notes: &Notes) -> Option<Vec<u8>> {
    let deposits = notes.floors.deposits();
    let points: Vec<CloudPoint> = notes.cloud.as_ref()?.surveyed(notes, &notes.closure(), &deposits);
    let named = |name: &str, [red, green, blue]: [u8; 3]| format!("comment colour {red} {green} {blue}: {name}\n");
    let header = [
        "ply\nformat binary_little_endian 1.0\n".to_owned(),
        "comment lit points of a run of ductloop, placed by estimated poses; frame: the world of the scenario, z up; unit: metre\n".to_owned(),
        format!("comment at most one point a voxel of {} mm\n", VOXEL_M * 1e3),
        named("floor", FLOOR),
        named("deposits on the floor", DEPOSIT),
        named("walls of the first, third, ... duct of survey.json", WALLS[0]),
        named("walls of the second, fourth, ... duct", WALLS[1]),
        named("between the walls: what stands in a duct or across it, and ceilings", INSIDE),
        named("beyond the walls' lines: seen through openings and in bends", BEYOND),
        format!("element vertex {}\n", points.len()),
        "property float x\nproperty float y\nproperty float z\n".to_owned(),
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n".to_owned(),
    ];
    let mut bytes = header.concat().into_bytes();
    for point in &points {
        bytes.extend(point.in_world_m.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(colour(point.class));
    }
    Some(bytes)
}

fn colour(class: Class) -> [u8; 3] {
    match class {
        Class::Floor => FLOOR,
        Class::Deposit => DEPOSIT,
        Class::Wall(duct) => WALLS[duct % 2],
        Class::Inside => INSIDE,
        Class::Beyond => BEYOND,
    }
}
