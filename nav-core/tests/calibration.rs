//! Calibration against rigs that are known: what is put in comes out, noise and wrong points included.

use ductloop_nav::calibration::boards::{Board, BoardCentre, BoardsError, BoardsPlane};
use ductloop_nav::calibration::linear::{LinearCalibration, position_mm, with_last_one};
use ductloop_nav::calibration::model::{Free, ModelError, Rig, Scatter};
use ductloop_nav::calibration::pairs::{Pair, PairsError};
use ductloop_nav::perception::lens::Lens;
use ductloop_nav::rig::{Camera, Distortion};
use nalgebra::{Rotation3, Unit, Vector3};
use proptest::prelude::*;

fn camera(focal_px: f64, k1: f64) -> Camera {
    let distortion = Distortion { k1, ..Distortion::NONE };
    Camera { width_px: 640, height_px: 480, focal_px: [focal_px; 2], centre_px: [320.0, 240.0], distortion }
}

/// Evenly spread noise of standard deviation one, from a hash of its number.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bf0_3635;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let unit = (x >> 11) as f64 / (1_u64 << 53) as f64;
    (unit - 0.5) * 12_f64.sqrt()
}

/// A camera somewhere in a gauge's frame, and lasers.
#[derive(Clone, Debug)]
struct Truth {
    camera: Camera,
    rotation: Rotation3<f64>,
    translation_mm: Vector3<f64>,
    /// n / d in 1/mm.
    planes: Vec<Vector3<f64>>,
}

impl Truth {
    /// INCRA I's two planes, in a gauge's frame turned anyhow.
    fn incra1(focal_px: f64, k1: f64, turn: [f64; 3]) -> Self {
        Self {
            camera: camera(focal_px, k1),
            rotation: Rotation3::from_scaled_axis(Vector3::from(turn)),
            translation_mm: Vector3::new(1.4, 117.7, -31.2),
            planes: vec![
                Vector3::new(0.75130632, -0.61816050, 0.23111989) / 68.78742,
                Vector3::new(0.74444940, -0.60260520, 0.28751011) / 37.28516,
            ],
        }
    }

    /// Points of a laser on a grid of pixels from which its plane lies 150 to 900 mm away.
    fn pairs(&self, laser: usize, step: usize) -> Vec<Pair> {
        let (lens, m) = (Lens::new(&self.camera), self.planes[laser]);
        let mut pairs = Vec::new();
        for v in (10..480).step_by(step) {
            for u in (10..640).step_by(step) {
                let pixel_px = [f64::from(u), f64::from(v)];
                let ray = lens.ray(pixel_px[0], pixel_px[1]);
                let s = m.dot(&ray);
                if s > 1.0 / 900.0 && s < 1.0 / 150.0 {
                    let there = self.rotation.inverse() * (ray / s - self.translation_mm);
                    pairs.push(Pair { pixel_px, position_mm: there.into() });
                }
            }
        }
        pairs
    }
}

fn with_noise(pairs: &[Pair], sigma_px: f64, seed: u64) -> Vec<Pair> {
    let noisy = |(index, pair): (usize, &Pair)| {
        let number = seed.wrapping_mul(1 << 20).wrapping_add(2 * index as u64);
        let [u, v] = pair.pixel_px;
        Pair { pixel_px: [u + sigma_px * noise(number), v + sigma_px * noise(number + 1)], ..*pair }
    };
    pairs.iter().enumerate().map(noisy).collect()
}

proptest! {
    /// Any rig, any gauge frame, even a mirrored one: exact points give T back, and T gives other pixels' positions.
    #[test]
    fn equation_14_gives_the_matrix_of_any_rig(
        focal in 400.0..1500.0f64, turn in prop::array::uniform3(-3.0..3.0f64), mirrored in any::<bool>(),
    ) {
        let truth = Truth::incra1(focal, 0.0, turn);
        let mut pairs = truth.pairs(0, 97);
        prop_assume!(pairs.len() >= 8);
        if mirrored {
            pairs.iter_mut().for_each(|pair| pair.position_mm[1] *= -1.0);
        }
        let (own, others): (Vec<_>, Vec<_>) = pairs.iter().enumerate().partition(|(index, _)| index % 2 == 0);
        let own: Vec<_> = own.into_iter().map(|(_, pair)| *pair).collect();
        match LinearCalibration::of(&own) {
            Ok(solved) => {
                prop_assert!(solved.rms_mm() < 1e-6, "{}", solved.rms_mm());
                prop_assert!(solved.conditioning.rank == 11 && solved.conditioning.condition < solved.condition_unscaled);
                let printed = with_last_one(&solved.t);
                for (_, pair) in others {
                    for t in [Some(&solved.t), printed.as_ref()].into_iter().flatten() {
                        let there = position_mm(t, pair.pixel_px).expect("in front");
                        // Beyond the points that T was solved for, rounding grows with the condition.
                        prop_assert!((there.coords - Vector3::from(pair.position_mm)).norm() < 1e-5, "{there} {pair:?}");
                    }
                }
            }
            Err(error) => {
                // A grid seen through a long lens may leave two columns, or one.
                let collinear = matches!(error, ductloop_nav::calibration::linear::LinearError::Pairs(PairsError::Collinear { .. }));
                prop_assert!(collinear, "{error}");
            }
        }
    }

    /// Whatever numbers: a reason, or finite results. No panic.
    #[test]
    fn any_numbers_are_survived(
        rows in prop::collection::vec(prop::array::uniform5(prop_oneof![
            -1e3..1e3f64, any::<f64>(), Just(0.0), Just(f64::NAN), Just(1e300), Just(-1.0),
        ]), 0..12),
    ) {
        let pairs: Vec<_> =
            rows.iter().map(|[u, v, x, y, z]| Pair { pixel_px: [*u, *v], position_mm: [*x, *y, *z] }).collect();
        if let Ok(solved) = LinearCalibration::of(&pairs) {
            prop_assert!(solved.t.iter().all(|value| value.is_finite()));
            prop_assert!(solved.rms_mm().is_finite());
        }
        if let Ok(rig) = Rig::fit(&[pairs], &camera(1081.0, 0.0), Free::default(), Scatter { pixel_px: 1.0, position_mm: 0.5 }) {
            prop_assert!(rig.covariance.iter().all(|value| value.is_finite()));
        }
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Any rig in any right-handed frame comes back from exact points of both lasers, the focal length too where it is free.
    #[test]
    fn the_model_gives_any_rig_back(focal in 600.0..1400.0f64, turn in prop::array::uniform3(-1.5..1.5f64), k1 in -0.2..0.2f64) {
        let truth = Truth::incra1(focal, k1, turn);
        let lasers = [truth.pairs(0, 60), truth.pairs(1, 60)];
        prop_assume!(lasers.iter().all(|pairs| pairs.len() >= 12));
        let free = Free { focal: true, k1: true, ..Free::default() };
        let start = camera(focal * 1.05, 0.0);
        let rig = Rig::fit(&lasers, &start, free, Scatter { pixel_px: 0.1, position_mm: 0.1 }).expect("a rig");
        prop_assert!((rig.camera.focal_px[0] - focal).abs() < 1e-3 * focal, "{} {focal}", rig.camera.focal_px[0]);
        for (laser, plane) in truth.planes.iter().enumerate() {
            let (normal, offset_mm) = rig.plane(laser);
            prop_assert!((normal - plane.normalize()).norm() < 1e-3 && (offset_mm * plane.norm() - 1.0).abs() < 1e-3);
        }
        let worst = rig.misses_mm.iter().flatten().map(|miss| miss.norm()).fold(0.0, f64::max);
        prop_assert!(worst < 0.05, "{worst}");
    }
}

/// What the model states for a plane and for the focal length is what they scatter by over many draws of noise.
#[test]
fn the_models_deviations_are_what_it_scatters_by() {
    let truth = Truth::incra1(1081.0, 0.0, [0.07, -0.1, -3.1]);
    let free = Free { focal: true, ..Free::default() };
    let scatter = Scatter { pixel_px: 0.3, position_mm: 0.01 };
    const DRAWS: u64 = 60;
    let mut squares = [0.0; 3];
    for draw in 0..DRAWS {
        let lasers = [0, 1].map(|laser| with_noise(&truth.pairs(laser, 60), scatter.pixel_px, 2 * draw + laser as u64));
        let rig = Rig::fit(&lasers, &truth.camera, free, scatter).expect("a rig");
        let over = |value: f64, sigma: f64| (value / sigma) * (value / sigma);
        squares[0] += over(rig.camera.focal_px[0] - 1081.0, rig.sigma.focal_px.expect("free"));
        for laser in 0..2 {
            let offset = 1.0 / truth.planes[laser].norm();
            squares[1 + laser] += over(rig.plane(laser).1 - offset, rig.sigma.planes[laser].0);
        }
    }
    for sum in squares {
        let ratio = (sum / DRAWS as f64).sqrt();
        // Sixty draws tell a deviation to a tenth; evenly spread noise and the robust loss shift it by less than that.
        assert!((0.7..1.35).contains(&ratio), "{squares:?}");
    }
}

#[test]
fn wrong_points_do_not_bend_the_model() {
    let truth = Truth::incra1(1081.0, 0.0, [0.07, -0.1, -3.1]);
    let mut lasers = [0, 1].map(|laser| with_noise(&truth.pairs(laser, 60), 0.2, 7 + laser as u64));
    for pairs in &mut lasers {
        pairs[3].pixel_px[0] += 60.0;
        pairs[11].position_mm[2] += 80.0;
    }
    let rig = Rig::fit(&lasers, &truth.camera, Free::default(), Scatter { pixel_px: 0.2, position_mm: 0.1 }).expect("a rig");
    for laser in 0..2 {
        let offset = 1.0 / truth.planes[laser].norm();
        assert!((rig.plane(laser).1 - offset).abs() < 4.0 * rig.sigma.planes[laser].0.max(0.05), "{:?}", rig.plane(laser));
        assert!(rig.misses_mm[laser][11].norm() > 60.0, "the wrong point shows as such");
    }
}

#[test]
fn a_model_of_too_little_is_refused() {
    let truth = Truth::incra1(1081.0, 0.0, [0.07, -0.1, -3.1]);
    let pairs = truth.pairs(0, 60);
    let scatter = Scatter { pixel_px: 0.2, position_mm: 0.1 };
    let fit = |lasers: &[Vec<Pair>], free| Rig::fit(lasers, &truth.camera, free, scatter);
    assert!(matches!(fit(&[], Free::default()), Err(ModelError::Lasers(0))));
    assert!(matches!(fit(&[pairs.clone(), pairs[..3].to_vec()], Free::default()), Err(ModelError::Pairs { laser: 1, .. })));
    // Twelve equations for thirteen unknowns.
    let four = vec![pairs[0], pairs[5], pairs[pairs.len() / 2], pairs[pairs.len() - 1]];
    let all = Free { focal: true, centre: true, k1: true, k2: true };
    assert!(matches!(fit(&[four], all), Err(ModelError::Undetermined | ModelError::NoFit)));
}

/// Boards held before a laser's plane, each with a row of centres on its stripe.
fn boards(plane: (Vector3<f64>, f64), lens: &Lens, tilts: &[[f64; 2]]) -> (Vec<Board>, Vec<BoardCentre>) {
    let (mut boards, mut centres) = (Vec::new(), Vec::new());
    for (number, [x, y]) in tilts.iter().enumerate() {
        let normal = Unit::new_normalize(Vector3::new(*x, *y, 1.0));
        let board = Board { normal, distance_mm: 480.0 + 30.0 * number as f64 };
        // The line in which board and plane meet.
        let direction = plane.0.cross(&normal).normalize();
        let both = nalgebra::Matrix3::from_rows(&[plane.0.transpose(), normal.transpose(), direction.transpose()]);
        let foot = both.try_inverse().expect("planes that meet") * Vector3::new(plane.1, board.distance_mm, 0.0);
        for step in -60..60 {
            let at = foot + direction * f64::from(step) * 2.0;
            let [u, v] = lens.pixel(&at);
            centres.push(BoardCentre { board: number, pixel_px: [u, v], sigma_px: 0.1 });
        }
        boards.push(board);
    }
    (boards, centres)
}

const TILTS: [[f64; 2]; 6] = [[0.1, 0.3], [0.1, 0.07], [-0.2, 0.35], [0.3, -0.1], [-0.1, -0.3], [0.0, 0.2]];

#[test]
fn boards_give_the_plane_whatever_else_is_in_the_image() {
    let lens = Lens::new(&camera(600.0, -0.2));
    let plane = (Vector3::new(0.05, 0.98, -0.19).normalize(), 39.0);
    let (boards, mut centres) = boards(plane, &lens, &TILTS);
    let exact = BoardsPlane::of(&lens, &boards, &centres).expect("a plane");
    assert!((exact.normal.into_inner() - plane.0).norm() < 1e-9 && (exact.offset_mm - 39.0).abs() < 1e-6, "{exact:?}");
    for (index, centre) in centres.iter_mut().enumerate() {
        centre.pixel_px[1] += 0.1 * noise(index as u64);
        if index % 4 == 0 {
            centre.pixel_px[1] += 25.0 * noise(index as u64 + 9000);
        }
    }
    let found = BoardsPlane::of(&lens, &boards, &centres).expect("a plane");
    let sigma = found.covariance.matrix.diagonal().map(f64::sqrt);
    assert!((found.offset_mm - 39.0).abs() < 4.0 * sigma[2], "{} {sigma}", found.offset_mm);
    for (towards, sigma) in found.covariance.towards.iter().zip(sigma.iter()) {
        assert!(towards.dot(&plane.0).abs() < 4.0 * sigma, "{sigma}");
    }
    // Stated 0.1 px, and 0.1 px it is; a quarter of the centres is lamps, of which few come to lie on the stripe.
    assert!((0.7..1.2).contains(&found.scatter), "{}", found.scatter);
    let kept = found.used.iter().enumerate().filter(|(index, used)| index % 4 != 0 && **used).count();
    assert!(kept > 530, "{kept} of 540");
    assert!(found.covariance_by_board.is_some());
}

#[test]
fn boards_that_leave_the_plane_open_are_refused() {
    let lens = Lens::new(&camera(600.0, 0.0));
    let plane = (Vector3::new(0.05, 0.98, -0.19).normalize(), 39.0);
    let (board, centres) = boards(plane, &lens, &TILTS[..1]);
    assert_eq!(BoardsPlane::of(&lens, &board, &centres), Err(BoardsError::OneBoard));
    assert_eq!(BoardsPlane::of(&lens, &board, &centres[..2]), Err(BoardsError::TooFew(2)));
    let wild = [&centres[..5], &[BoardCentre { pixel_px: [f64::NAN, 1.0], ..centres[0] }]].concat();
    assert_eq!(BoardsPlane::of(&lens, &board, &wild), Err(BoardsError::NotFinite(5)));
    let nowhere = [&centres[..5], &[BoardCentre { board: 1, ..centres[0] }]].concat();
    assert_eq!(BoardsPlane::of(&lens, &board, &nowhere), Err(BoardsError::NotFinite(5)));
    let behind = [Board { normal: board[0].normal, distance_mm: -400.0 }];
    assert_eq!(BoardsPlane::of(&lens, &behind, &centres), Err(BoardsError::Misses { centre: 0, board: 0 }));
    let through = (plane.0, 0.2);
    let (many, centres) = boards(through, &lens, &TILTS);
    assert!(matches!(BoardsPlane::of(&lens, &many, &centres), Err(BoardsError::ThroughCamera(_))));
}

/// A stripe that is not quite straight has its points on the board's plane to the last digit: this is not the laser's.
#[test]
fn noise_is_not_taken_for_a_plane() {
    let lens = Lens::new(&camera(600.0, -0.2));
    let plane = (Vector3::new(0.05, 0.98, -0.19).normalize(), 39.0);
    let shaken = |mut centres: Vec<BoardCentre>, sigma_px: f64| {
        for (index, centre) in centres.iter_mut().enumerate() {
            centre.pixel_px[1] += sigma_px * noise(index as u64);
        }
        centres
    };
    let (one, centres) = boards(plane, &lens, &TILTS[..1]);
    let centres = shaken(centres, 0.2);
    assert_eq!(BoardsPlane::of(&lens, &one, &centres), Err(BoardsError::OneBoard));
    // The same board photographed twice.
    let again = centres.iter().map(|centre| BoardCentre {
        board: 1,
        pixel_px: [centre.pixel_px[0] + 0.3, centre.pixel_px[1]],
        ..*centre
    });
    let twice: Vec<_> = centres.iter().copied().chain(again).collect();
    assert_eq!(BoardsPlane::of(&lens, &[one[0], one[0]], &twice), Err(BoardsError::OneBoard));
    // Boards turned about one line of the laser's plane meet it nowhere else, whatever the centres state.
    let (foot, direction) = (plane.0 * plane.1 + plane.0.cross(&Vector3::x()).normalize() * 480.0, Vector3::x());
    let direction = (direction - plane.0 * plane.0.dot(&direction)).normalize();
    let foot = if foot.z > 0.0 { foot } else { plane.0 * plane.1 * 2.0 - foot };
    for sigma_px in [1.0, 0.01] {
        let (mut about, mut centres) = (Vec::new(), Vec::new());
        for (board, lean) in [-0.4, 0.0, 0.3, 0.6].into_iter().enumerate() {
            let normal = Unit::new_normalize(direction.cross(&(Vector3::y() + Vector3::z() * lean)));
            about.push(Board { normal, distance_mm: normal.dot(&foot) });
            for step in -60..60 {
                let [u, v] = lens.pixel(&(foot + direction * f64::from(step) * 2.0));
                centres.push(BoardCentre { board, pixel_px: [u, v], sigma_px });
            }
        }
        let found = BoardsPlane::of(&lens, &about, &shaken(centres, 1.0));
        assert!(matches!(found, Err(BoardsError::Noise { .. })), "{found:?}");
    }
    // Two boards, and a pixel of noise: a plane, if not a good one.
    let (two, centres) = boards(plane, &lens, &[TILTS[0], TILTS[4]]);
    let found = BoardsPlane::of(&lens, &two, &shaken(centres, 1.0)).expect("a plane");
    assert!((found.offset_mm - 39.0).abs() < 4.0 * found.covariance.matrix[(2, 2)].sqrt(), "{found:?}");
}
