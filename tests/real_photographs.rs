//! The rig-free extractor on real photographs of a laser stripe, where they are.
//!
//! They are nobody's to give away, so they stand beside the project and not in it: `DUCTLOOP_REAL_IMAGES` names the folder that holds
//! `light-stripe/`, else `../shared/data/real` is tried. Where there is none the test says so and passes.
//!
//! Six photographs of a green stripe on a board; the board's plane in each is known from its corners (`boards.csv`). A first, simple
//! centroid leaves 0.11 to 0.30 px RMS about a line through a frame's undistorted centres, and all six frames' points within 0.27 mm RMS
//! of one plane. The extractor must do as well in both.
#![cfg(feature = "cli")]

use std::fs;
use std::path::{Path, PathBuf};

use ductloop::photograph::{Channel, Photograph};
use ductloop_nav::perception::lens::Lens;
use ductloop_nav::perception::ridge::{Region, Ridge, RidgeParams};
use ductloop_nav::rig::{Camera, Distortion};
use nalgebra::{Matrix3, Vector3};

/// A row of `boards.csv`: the photograph's board n . p = d, in millimetres, and its corners in the image.
struct Board {
    file: String,
    normal: Vector3<f64>,
    distance_mm: f64,
    corners_px: Vec<[f64; 2]>,
}

fn folder() -> Option<PathBuf> {
    let named = std::env::var_os("DUCTLOOP_REAL_IMAGES").map(PathBuf::from);
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/real");
    let tried = named.clone().unwrap_or(beside).join("light-stripe");
    if tried.is_dir() {
        return Some(tried);
    }
    assert!(named.is_none(), "DUCTLOOP_REAL_IMAGES is set, and there is no folder {}", tried.display());
    println!("skipped: there are no photographs in {}; DUCTLOOP_REAL_IMAGES names the folder above them", tried.display());
    None
}

fn boards(folder: &Path) -> Vec<Board> {
    let table = fs::read_to_string(folder.join("boards.csv")).expect("boards.csv");
    let rows = table.lines().filter(|line| !line.starts_with('#')).skip(1).filter(|line| !line.is_empty());
    let board = |row: &str| {
        let mut cells = row.split(',');
        let file = cells.next().expect("a name").to_owned();
        let x: Vec<f64> = cells.map(|cell| cell.parse().expect("a number")).collect();
        let corners_px = x[5..].chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        Board { file, normal: Vector3::new(x[0], x[1], x[2]), distance_mm: x[3], corners_px }
    };
    rows.map(board).collect()
}

/// The camera, from the photographs' own source.
fn camera() -> Camera {
    Camera {
        width_px: 640,
        height_px: 480,
        focal_px: [514.41205, 685.92876],
        centre_px: [329.83671, 237.71471],
        distortion: Distortion { k1: -0.350373, k2: 0.158447, p1: 0.000735, p2: -0.000231, k3: 0.0 },
    }
}

fn lens() -> Lens {
    Lens::new(&camera())
}

/// RMS distance of points in a plane from their best line.
fn off_line(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / n);
    let moment = |i: usize, k: usize| points.iter().map(|p| (p[i] - mean[i]) * (p[k] - mean[k])).sum::<f64>() / n;
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    // The smaller eigenvalue.
    let (half, spread) = ((xx + yy) / 2.0, ((xx - yy) * (xx - yy) / 4.0 + xy * xy).sqrt());
    (half - spread).max(0.0).sqrt()
}

/// RMS distance of points from their best plane, and that plane's distance from the camera.
fn off_plane(points: &[Vector3<f64>]) -> [f64; 2] {
    let n = points.len() as f64;
    let mean = points.iter().sum::<Vector3<f64>>() / n;
    let scatter: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum::<Matrix3<f64>>() / n;
    let eigen = scatter.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    [eigen.eigenvalues[least].max(0.0).sqrt(), eigen.eigenvectors.column(least).dot(&mean).abs()]
}

#[test]
fn a_real_stripe_is_straight_and_its_points_lie_on_one_plane() {
    let Some(folder) = folder() else { return };
    let (lens, boards) = (lens(), boards(&folder));
    assert_eq!(boards.len(), 6);
    let [focal_u_px, _] = lens.focal_px();
    let mut ridge = Ridge::new(RidgeParams::default());
    let mut all_mm = Vec::new();
    for board in &boards {
        let bytes = fs::read(folder.join(&board.file)).expect("a photograph");
        let photograph = Photograph::decode(&bytes, Channel::GreenExcess, None).expect("a photograph");
        let region = Region::polygon(&board.corners_px).expect("corners");
        let centres = ridge.extract(&photograph.frame(), Some(&region));
        let rays: Vec<Vector3<f64>> = centres.iter().map(|centre| lens.ray(centre.u_px, centre.v_px)).collect();
        // The pixels are not square: across the stripe, which stands upright, one is 1/fx.
        let undistorted: Vec<[f64; 2]> = rays.iter().map(|ray| [focal_u_px * ray.x, focal_u_px * ray.y]).collect();
        let residual_px = off_line(&undistorted);
        all_mm.extend(rays.iter().map(|ray| ray * (board.distance_mm / board.normal.dot(ray))));
        let mean = |of: fn(&ductloop_nav::perception::ridge::RidgeCentre) -> f64| {
            centres.iter().map(of).sum::<f64>() / centres.len() as f64
        };
        let rows = board.corners_px.iter().map(|c| c[1]).fold(f64::MIN, f64::max)
            - board.corners_px.iter().map(|c| c[1]).fold(f64::MAX, f64::min);
        println!(
            "{}: {} centres in {rows:.0} rows, line residual {residual_px:.3} px RMS, stated {:.3} px, {:.1} px wide",
            board.file,
            centres.len(),
            mean(|c| c.sigma_px),
            mean(|c| c.fwhm_px),
        );
        assert!(centres.len() as f64 > 0.75 * rows, "{}: {} centres in {rows} rows", board.file, centres.len());
        assert!(residual_px < 0.30, "{}: {residual_px} px", board.file);
    }
    let [rms_mm, distance_mm] = off_plane(&all_mm);
    println!("all {} points: {rms_mm:.3} mm RMS off one plane, {distance_mm:.2} mm from the camera", all_mm.len());
    assert!(rms_mm < 0.27, "{rms_mm} mm");
    assert!((distance_mm - 39.0).abs() < 2.0, "{distance_mm} mm");
}

/// `ductloop calibrate --boards` finds the laser's plane in them.
#[test]
fn the_photographs_calibrate_the_lasers_plane() {
    use ductloop::calibrate::boards::{Boards, Centres, Found};
    use ductloop::calibrate::pictures::centres_of_image;
    let Some(folder) = folder() else { return };
    let boards = Boards::read(&folder.join("boards.csv")).expect("boards");
    let mut centres = Centres::of(Vec::new(), &boards).expect("none so far");
    for file in &boards.files {
        let found = centres_of_image(&folder.join(file), &camera(), &boards, Channel::GreenExcess).expect("a stripe");
        centres.extend(found, &boards);
    }
    let found = Found::fit(&camera(), boards, centres, "green").expect("a plane");
    let (rms_mm, rms_px, used) = found.rms(None);
    println!("plane {:.3} mm from the camera, {rms_mm:.3} mm RMS, {rms_px:.3} px, {used} centres", found.plane.offset_mm);
    // What a simple centroid reached.
    assert!(rms_mm < 0.27 && used > 1000, "{rms_mm} {used}");
    assert!((found.plane.offset_mm - 39.0).abs() < 1.0, "{}", found.plane.offset_mm);
}
