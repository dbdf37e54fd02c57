//! Scores of a perception that is made up from the truth: what is known to be wrong with it must come out.

use ductloop::Scenario;
use ductloop::stage_scores::{Scan, Score, StageTruth, TruthScene, score};
use ductloop::viewpoint::world_from_camera;
use ductloop_duct::Transform;
use ductloop_nav::perception::wall_plane::WallPlane;
use ductloop_nav::perception::{
    Deviation, Measurement, SeenPlane, Stages, StripeCentre, StripeLine, Wall, WallDeviation, WallMeasurement,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

const LATERAL_M: f64 = 0.04;
const HEADING_RAD: f64 = 0.05;

struct Shown {
    scene: TruthScene,
    truth: StageTruth,
}

fn shown(rig: &str) -> Shown {
    let text = format!(
        "format = 1\nkind = \"scenario\"\nname = \"x\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{{ straight_m = 3.0 }}, \
         {{ straight_m = 9.0 }}]\n[sensor]\npreset = \"{rig}\"\n"
    );
    let scenario = Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{wrong}"));
    let scene = TruthScene::new(&scenario).expect("a duct");
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), HEADING_RAD);
    // The stripes cross from one fitting to the next.
    let base = Transform::from_parts(Translation3::new(2.5, LATERAL_M, 0.0), turned);
    let camera = world_from_camera(scene.rig(), &base, scenario.rig.mount.rest, Default::default());
    let truth = scene.of(&base, &camera, 0, &[1.0; 4]).expect("a camera in the duct");
    Shown { scene, truth }
}

impl Shown {
    /// Every true centre on a wall, `off_px` away along its column or row.
    fn centres(&self, off_px: f64, sigma_px: f64) -> Vec<StripeCentre> {
        let centre = |c: &ductloop::stage_scores::TrueCentre| {
            let wall = self.truth.planes[c.plane].wall?;
            let [u_px, v_px] = match c.scan {
                Scan::Column => [c.line as f64, c.at_px + off_px],
                Scan::Row => [c.at_px + off_px, c.line as f64],
            };
            Some(StripeCentre { u_px, v_px, sigma_px, assigned: Some((c.laser, wall)) })
        };
        self.truth.centres.iter().filter(|c| c.counts()).filter_map(centre).collect()
    }

    fn score(&self, stages: &Stages<'_>, measurement: &Measurement) -> Score {
        score(&self.scene, &self.truth, stages, measurement, LATERAL_M, HEADING_RAD)
    }
}

#[test]
fn centres_score_as_they_were_displaced() {
    for rig in ["wide", "incra1"] {
        let shown = shown(rig);
        let centres = shown.centres(0.2, 0.1);
        assert!(centres.len() > 400, "{rig}: {}", centres.len());
        let found = shown.score(&Stages { centres: &centres, ..Stages::default() }, &Measurement::default()).centres;
        assert_eq!((found.precision(), found.recall()), (Some(1.0), Some(1.0)), "{rig}: {found:?}");
        // Where two pieces of one stripe meet in a column, the nearer one may be the other.
        assert!(
            (found.rms_px().unwrap() - 0.2).abs() < 1e-3 && (found.mean_nees().unwrap() - 4.0).abs() < 0.05,
            "{rig}: {found:?}"
        );

        // Beyond the gate, for the other laser, or for another wall, they are no centres of that stripe.
        let wrong = |change: &dyn Fn(&mut StripeCentre)| {
            let mut centres = shown.centres(0.0, 0.1);
            centres.iter_mut().for_each(change);
            shown.score(&Stages { centres: &centres, ..Stages::default() }, &Measurement::default()).centres
        };
        let swapped = wrong(&|c| c.assigned = c.assigned.map(|(laser, wall)| (1 - laser, wall)));
        let other_wall = wrong(&|c| c.assigned = c.assigned.map(|(laser, _)| (laser, Wall::Ahead)));
        // Stripes cross, and then a centre is on both: a few columns.
        assert!(swapped.precision().unwrap() < 0.1, "{rig}: {swapped:?}");
        assert_eq!((other_wall.right, other_wall.found), (0, 0), "{rig}");
        // What was found and left is not claimed.
        let left = wrong(&|c| c.assigned = None);
        assert_eq!((left.claimed, left.precision(), left.recall()), (0, None, Some(0.0)), "{rig}");
    }
}

/// Half of the centres: half the recall.
#[test]
fn recall_is_the_share_of_what_is_there() {
    let shown = shown("wide");
    let half: Vec<StripeCentre> = shown.centres(0.0, 0.1).into_iter().step_by(2).collect();
    let found = shown.score(&Stages { centres: &half, ..Stages::default() }, &Measurement::default()).centres;
    assert_eq!(found.precision(), Some(1.0));
    assert!((found.recall().unwrap() - 0.5).abs() < 0.03, "{found:?}");
}

#[test]
fn lines_walls_and_the_answer_score_as_they_were_displaced() {
    let shown = shown("wide");
    let plane_of = |wall: Wall| shown.truth.planes[shown.truth.only_plane(wall).expect("one plane")];
    let on_left: Vec<_> = shown
        .truth
        .centres
        .iter()
        .filter(|c| c.laser == 0 && shown.truth.planes[c.plane].wall == Some(Wall::Left) && c.scan == Scan::Column)
        .collect();
    let (first, last) = (on_left[0], on_left[on_left.len() - 1]);
    let ends_px = [first, last].map(|c| [c.line as f64, c.at_px + 0.5]);
    let lines = [StripeLine { ends_px, assigned: Some((0, Wall::Left)), points: 10, residual_px: 0.1 }];
    let left = plane_of(Wall::Left);
    let plane = WallPlane { normal: left.normal_in_camera, distance_m: left.camera_distance_m };
    let planes = [SeenPlane { wall: Wall::Left, plane, covariance: None, points: 10 }];
    let measurement = Measurement {
        lateral_m: Some(LATERAL_M + 0.003),
        heading_rad: Some(HEADING_RAD - 0.002),
        deviation: Deviation { lateral_m: Some(0.001), heading_rad: Some(0.001), ..Deviation::default() },
        left: Some(WallMeasurement {
            distance_m: left.distance_m + 0.004,
            heading_rad: HEADING_RAD + 0.01,
            points: 10,
            deviation: Some(WallDeviation { distance_m: 0.002, heading_rad: 0.01 }),
        }),
        ..Measurement::default()
    };
    let score = shown.score(&Stages { lines: &lines, planes: &planes, ..Stages::default() }, &measurement);
    // Half a pixel along the column is less across a slanted stripe.
    let across = 0.5 / (1.0 + first.slope * first.slope).sqrt();
    assert!((score.lines.rms_px().unwrap() - across).abs() < 1e-3, "{:?} {across}", score.lines);
    let wall = score.wall(Wall::Left).expect("the left wall");
    assert!((wall.distance_m - (0.25 - LATERAL_M)).abs() < 1e-9, "{wall:?}");
    assert!((wall.distance_error_m.unwrap() - 0.004).abs() < 1e-12, "{wall:?}");
    assert!((wall.heading_error_rad.unwrap() - 0.01).abs() < 1e-9, "{wall:?}");
    assert!(wall.normal_error_rad.unwrap() < 1e-9, "{wall:?}");
    let ratios: Vec<f64> = wall.normalised().collect();
    assert!((ratios[0] - 2.0).abs() < 1e-9 && (ratios[1] - 1.0).abs() < 1e-6, "{ratios:?}");
    // Three and two deviations: (9 + 4) / 2.
    assert!((score.nees().unwrap() - 6.5).abs() < 1e-9, "{score:?}");
    // The right wall is there and was not measured.
    assert_eq!(score.wall(Wall::Right).expect("the right wall").distance_error_m, None);
    // Both fittings' walls are one plane, and one that answers without a centre is not scored for its centres.
    assert!((plane_of(Wall::Right).distance_m - (0.25 + LATERAL_M)).abs() < 1e-9);
    assert_eq!(score.centres.recall(), None);
}
