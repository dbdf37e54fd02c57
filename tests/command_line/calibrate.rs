//! `ductloop calibrate` as its users meet it.

use serde_json::json;

use super::workshop::{Workshop, keys};

const RIGHT: &str = include_str!("../data/incra1/right.csv");
const LEFT: &str = include_str!("../data/incra1/left.csv");
const TABLE_1: &str = include_str!("../data/incra1/table1.csv");

fn workshop() -> Workshop {
    let workshop = Workshop::new();
    workshop.write("right.csv", RIGHT);
    workshop.write("left.csv", LEFT);
    workshop.write("table1.csv", TABLE_1);
    workshop
}

#[test]
fn a_table_gives_a_matrix_that_can_be_applied() {
    let workshop = workshop();
    let ran = workshop.run(&["calibrate", "right.csv", "--json", "--out", "made/T.csv"]).expect(0);
    let document = ran.json();
    let all = ["t", "rms_mm", "leave_one_out_rms_mm", "condition", "condition_unscaled", "points"];
    assert_eq!(keys(&document), all);
    assert_eq!(document["t"].as_array().map(Vec::len), Some(4));
    assert_eq!((&document["t"][3][2], document["points"].as_array().map(Vec::len)), (&json!(1.0), Some(13)));
    // The first point stands in line five of the file: two of comments, one of names.
    assert_eq!(document["points"][0]["line"], 4);
    let applied = workshop.run(&["calibrate", "right.csv", "--apply", "made/T.csv", "--json"]).expect(0).json();
    assert_eq!((&applied["t"], &applied["rms_mm"]), (&document["t"], &document["rms_mm"]));
    assert!(applied["condition"].is_null() && applied["leave_one_out_rms_mm"].is_null());
    let text = workshop.run(&["calibrate", "right.csv"]).expect(0).stdout;
    for words in ["t11", "3D RMS 3.767 mm", "leaving one point out at a time 6.428 mm", "rank 11 of 11"] {
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn a_model_is_a_rig_for_a_scenario() {
    let workshop = workshop();
    let ran = workshop.run(&["calibrate", "right.csv", "--model", "left.csv", "--json", "--out", "rig.toml"]).expect(0);
    let document = ran.json();
    assert_eq!(document["lasers"].as_array().map(Vec::len), Some(2));
    assert!(document["sigma"]["focal_px"].is_null() && document["sigma_if_free"]["focal_px"].is_number(), "{document:#}");
    let check = ["check", "short.toml", "--set", "sensor.preset=incra1", "--with", "rig.toml"];
    workshop.run(&check).expect(0);
}

#[test]
fn a_plane_is_found_from_boards() {
    let workshop = workshop();
    // The laser's plane is y = 40 mm; boards at z = 400, 500 and slanted. A camera of focal length 500.
    workshop.write("camera.toml", "[camera]\nwidth_px = 640\nheight_px = 480\nfocal_px = 500.0\ncentre_px = [320.0, 240.0]\n");
    workshop.write("boards.csv", "file,n_x,n_y,n_z,d_mm\na.png,0,0,1,400\nb.png,0,0,1,500\nc.png,0.6,0,0.8,400\n");
    let mut centres = String::from("file,u_px,v_px\n");
    for u in (200..440).step_by(20) {
        let ray = (f64::from(u) - 320.0) / 500.0;
        for (file, z) in [("a.png", 400.0), ("b.png", 500.0), ("c.png", 400.0 / (0.6 * ray + 0.8))] {
            centres += &format!("{file},{u},{}\n", 240.0 + 500.0 * 40.0 / z);
        }
    }
    workshop.write("centres.csv", &centres);
    let args = ["calibrate", "centres.csv", "--boards", "boards.csv", "--camera", "camera.toml", "--laser", "low"];
    let document = workshop.run(&[&args[..], &["--json", "--out", "laser.toml"]].concat()).expect(0).json();
    assert!((document["offset_m"].as_f64().expect("an offset") - 0.04).abs() < 1e-9, "{document:#}");
    assert_eq!((&document["used"], document["boards"].as_array().map(Vec::len)), (&json!(36), Some(3)));
    assert!(workshop.read("laser.toml").contains("[sensor.laser.low]"));
    workshop.write("centres.csv", centres.replacen("b.png", "d.png", 1));
    let ran = workshop.run(&args).expect(2).saying(&["no board is known of `d.png`", "centres.csv:3"]);
    assert_eq!(ran.stdout, "");
}

/// What `calibrate` writes, `perceive` reads pictures by: nothing is to be added by hand.
#[test]
fn a_calibration_is_a_rig_for_pictures() {
    let workshop = workshop();
    image::GrayImage::new(640, 480).save(workshop.path("black.png")).expect("a picture");
    workshop.run(&["calibrate", "right.csv", "--model", "left.csv", "--out", "rig.toml"]).expect(0);
    workshop.run(&["perceive", "black.png", "--rig", "rig.toml"]).expect(0);
    workshop.write("camera.toml", "[camera]\nwidth_px = 640\nheight_px = 480\nfocal_px = 500.0\ncentre_px = [320.0, 240.0]\n");
    workshop.write("boards.csv", "file,n_x,n_y,n_z,d_mm\na.png,0,0,1,400\nb.png,0,0,1,500\nc.png,0,0,1,600\n");
    for (laser, y_mm) in [("low", 40.0), ("high", -40.0)] {
        let rows = (200..440)
            .step_by(20)
            .flat_map(|u| [("a", 400.0), ("b", 500.0)].map(|(file, z_mm)| (file, u, 240.0 + 500.0 * y_mm / z_mm)));
        let table: String = rows.map(|(file, u, v)| format!("{file}.png,{u},{v}\n")).collect();
        workshop.write("centres.csv", format!("file,u_px,v_px\n{table}"));
        let out = format!("{laser}.toml");
        let args =
            ["calibrate", "centres.csv", "--boards", "boards.csv", "--camera", "camera.toml", "--laser", laser, "--out", &out];
        let said = workshop.run(&args).expect(0).stdout;
        // No picture of the third board: it has no residual, not one of zero.
        let third = said.lines().find(|line| line.starts_with("c.png")).expect("a row");
        assert_eq!(third.split_whitespace().collect::<Vec<_>>(), ["c.png", "0", "0", "-", "-"]);
    }
    let args = ["perceive", "black.png", "--rig", "low.toml", "--rig", "high.toml"];
    workshop.run(&args).expect(0);
    // One board is no plane.
    workshop.write("centres.csv", "file,u_px,v_px\na.png,200,290.1\na.png,300,289.9\na.png,400,290.1\na.png,420,290.0\n");
    let args = ["calibrate", "centres.csv", "--boards", "boards.csv", "--camera", "camera.toml"];
    workshop.run(&args).expect(2).saying(&["one board's plane"]);
}

#[test]
fn what_would_be_lost_or_ignored_is_refused() {
    let workshop = workshop();
    workshop.run(&["calibrate", "right.csv", "--out", "right.csv"]).expect(2).saying(&["--out right.csv", "which is read"]);
    assert_eq!(workshop.read("right.csv"), RIGHT);
    workshop.run(&["calibrate", "right.csv", "--out", "T.csv.d/"]).expect(2).saying(&["name of a folder"]);
    workshop.run(&["calibrate", "right.csv", "--sigma-px", "3"]).expect(2).saying(&["--model"]);
    workshop.run(&["calibrate", "right.csv", "--channel", "red"]).expect(2).saying(&["--boards"]);
    workshop.run(&["calibrate", "right.csv", "--camera", "camera.toml"]).expect(2).saying(&["--model", "--boards"]);
    #[cfg(unix)]
    {
        workshop.run(&["calibrate", "/dev/zero"]).expect(2).saying(&["/dev/zero", "larger than 64 MiB"]);
        let args = ["calibrate", "right.csv", "--model", "left.csv", "--camera", "/dev/zero"];
        workshop.run(&args).expect(2).saying(&["/dev/zero", "larger than 8 MiB"]);
        workshop.run(&["calibrate", "--gauge", "/dev/zero"]).expect(2).saying(&["/dev/zero", "larger than 8 MiB"]);
    }
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let workshop = workshop();
    let line = |number: usize| RIGHT.lines().nth(number - 1).expect("a line");
    let first: Vec<_> = RIGHT.lines().take(6).collect();
    for (text, at, words) in [
        (RIGHT.replace("u_px,v_px", "u,v_px"), json!(3), "column `u_px` missing"),
        (RIGHT.replace(line(7), "145,150,1,2,3,50.0,x,450.0"), json!(7), "`x` is not a number"),
        (RIGHT.replace(line(7), "145,nan,1,2,3,50.0,181.5,450.0"), json!(7), "not finite"),
        (RIGHT.replace(line(7), "145,150,54.34"), json!(7), "3 cells instead of 8"),
        (RIGHT.replace(line(7), line(5)), json!(7), "the pixel is that of line 5 again"),
        (first.join("\n"), json!(null), "3 points are too few"),
        (
            (1..9).fold("u_px,v_px,x_mm,y_mm,z_mm\n".into(), |t, i| format!("{t}{0},{0},{0},{1},5\n", i, i * i)),
            json!(null),
            "lie on a line",
        ),
        (String::new(), json!(null), "holds no line of names"),
    ] {
        workshop.write("wrong.csv", &text);
        for args in [vec!["calibrate", "wrong.csv", "--json"], vec!["calibrate", "left.csv", "--model", "wrong.csv", "--json"]] {
            let document = workshop.run(&args).expect(2).json();
            let error = &document["errors"][0];
            assert_eq!((&error["file"], &error["line"]), (&json!("wrong.csv"), &at), "{document:#}");
            assert!(error["message"].as_str().expect("words").contains(words), "{document:#}");
        }
    }
    workshop.run(&["calibrate", "missing.csv"]).expect(2).saying(&["missing.csv", "cannot be read"]);
    workshop.run(&["calibrate"]).expect(2).saying(&["POINTS.csv"]);
    workshop.run(&["calibrate", "right.csv", "left.csv"]).expect(2).saying(&["one is wanted", "--model"]);
    workshop
        .run(&["calibrate", "right.csv", "--apply", "table1.csv"])
        .expect(2)
        .saying(&["choose one by --laser", "right, left"]);
    workshop.run(&["calibrate", "right.csv", "--boards", "right.csv"]).expect(2).saying(&["--camera"]);
    workshop.run(&["calibrate", "right.csv", "--model", "right.csv"]).expect(2).saying(&["two tables are of a laser `right`"]);
    workshop.run(&["calibrate", "--gauge", "short.toml"]).expect(2).saying(&["no gauge experiment"]);
}

/// `ductloop run DIR` leaves gauges alone.
#[test]
fn a_gauge_is_no_scenario() {
    let workshop = workshop();
    workshop.write("gauge.toml", include_str!("../../scenarios/gauge/incra1.toml"));
    let document = workshop.run(&["check", ".", "--json"]).expect(0).json();
    assert_eq!(document["scenarios"].as_array().map(Vec::len), Some(1), "{document:#}");
    workshop.run(&["run", "gauge.toml"]).expect(2).saying(&["ductloop calibrate --gauge FILE"]);
    // Named, it is checked as what it is.
    let ran = workshop.run(&["check", "gauge.toml", "short.toml"]).expect(0);
    assert!(ran.stdout.contains("gauge.toml: ok") && ran.stdout.contains("lasers: 2, points: 19"), "{}", ran.stdout);
    workshop.run(&["check", "gauge.toml", "--seed", "3"]).expect(2).saying(&["gauge.toml", "laid over"]);
    let wrong = workshop.read("gauge.toml").replace("surface = \"block\"", "surface = \"blok\"");
    workshop.write("gauge.toml", wrong);
    workshop.run(&["check", "gauge.toml"]).expect(2).saying(&["gauge.toml", "names no surface"]);
}
