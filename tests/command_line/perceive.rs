//! `perceive`: picture files through the perception.

use image::{DynamicImage, ImageBuffer, Luma, Rgb};
use proptest::prelude::*;
use serde_json::{Value, json};

use super::workshop::{Ran, Workshop, keys, scenario};

/// A workshop with a frame of a run in it, `frame.png`, and what was the case, `frame.json`.
fn with_frame() -> Workshop {
    let workshop = Workshop::new();
    let offset = format!("{}[start]\nlateral_m = 0.03\nheading_deg = 2.0\n", scenario("offset", 3.0));
    workshop.write("offset.toml", offset);
    workshop.run(&["render", "offset.toml", "--at-s", "0", "--renderer", "cpu", "--out", "frame.png", "--quiet"]).expect(0);
    workshop
}

/// A picture of one level stripe at v = 40.25, half width at half maximum about 2 px.
fn stripe(size: u32) -> ImageBuffer<Luma<u8>, Vec<u8>> {
    ImageBuffer::from_fn(size, 80, |_, v| {
        let off = (f64::from(v) - 40.25) / 1.7;
        Luma([(20.0 + 150.0 * libm::exp(-off * off / 2.0)).round() as u8])
    })
}

fn save(workshop: &Workshop, name: &str, picture: impl Into<DynamicImage>) {
    picture.into().save(workshop.path(name)).expect("a picture");
}

/// The one error of a refused call, which writes nothing.
#[track_caller]
fn refused(workshop: &Workshop, args: &[&str]) -> Value {
    let args: Vec<_> = ["perceive", "--json"].iter().chain(args).copied().collect();
    let ran = workshop.run(&args).expect(2);
    assert!(!workshop.path("out").exists());
    let document = ran.json();
    assert_eq!((keys(&document), &document["images"]), (vec!["images", "errors"], &json!([])));
    let errors = document["errors"].as_array().expect("errors");
    assert_eq!(errors.len(), 1, "{document}");
    errors[0].clone()
}

#[track_caller]
fn assert_says(error: &Value, file: &str, words: &str) {
    assert_eq!(error["file"], file, "{error}");
    assert!(error["message"].as_str().is_some_and(|message| message.contains(words)), "{error}");
    assert!(error["help"].as_str().is_some_and(|help| !help.is_empty()), "{error}");
}

#[test]
fn a_rendered_frame_shows_its_walls() {
    let workshop = with_frame();
    let ran = workshop.run(&["perceive", "frame.png", "--rig", "offset.toml", "--time", "3", "--json"]).expect(0);
    let document = ran.json();
    let image = &document["images"][0];
    let agreed = ["file", "size_px", "max_dn", "channel", "pipeline", "centres", "lines", "planes", "lateral_m", "heading_rad"];
    assert_eq!(keys(image)[..10], agreed);
    assert_eq!(keys(&image["centres"][0]), ["u_px", "v_px", "sigma_px", "laser", "wall"]);
    assert_eq!(keys(&image["planes"][0])[..4], ["wall", "normal_in_camera", "distance_m", "sigma_m"]);
    assert_eq!((&image["file"], &image["pipeline"]), (&json!("frame.png"), &json!("robust")));
    // What `render` says was the case. An error of these sizes is three times the pipeline's.
    let truth: Value = serde_json::from_str(&workshop.read("frame.json")).expect("a document");
    let apart = |key: &str| (image[key].as_f64().expect(key) - truth["truth"][key].as_f64().expect(key)).abs();
    assert!(apart("lateral_m") < 5e-4 && apart("heading_rad") < 1e-3, "{image:#}");
    assert!(image["perceive_ms"].as_f64().is_some_and(|ms| ms > 0.0));
    let lasers: Vec<_> = image["centres"].as_array().expect("centres").iter().filter_map(|c| c["laser"].as_str()).collect();
    assert!(lasers.contains(&"low") && lasers.contains(&"high"));
    // The same beside the picture.
    let written: Value = serde_json::from_str(&workshop.read("out/perceive/frame.json")).expect("a document");
    assert_eq!(&written, image);
    let overlay = image::open(workshop.path("out/perceive/frame.overlay.png")).expect("a picture").into_rgb8();
    assert_eq!(overlay.dimensions(), (1280, 960));
    // The first laser's colour is on it.
    assert!(overlay.pixels().filter(|pixel| pixel.0 == [230, 159, 0]).count() > 200);

    let ran = workshop.run(&["perceive", "frame.png", "--rig", "offset.toml"]).expect(0);
    assert!(
        ran.stdout.contains("lateral") && ran.stdout.contains("heading") && ran.stdout.contains("overlay.png"),
        "{}",
        ran.stdout
    );
}

/// Of one wall alone the lateral error hangs on the duct's width. A rig that does not say it has none to assume: then there is no such
/// error, and heading and wall are as they were. Two walls tell the width themselves.
#[test]
fn one_wall_gives_no_lateral_error_without_a_width() {
    let workshop = Workshop::new();
    let offset = format!("{}[start]\nlateral_m = 0.03\nheading_deg = 2.0\n", scenario("offset", 3.0));
    let one = format!("{offset}[sensor]\npreset = \"incra1\"\n");
    for (name, text) in [("both", &offset), ("one", &one)] {
        workshop.write(&format!("{name}.toml"), text);
        let png = format!("{name}.png");
        workshop
            .run(&["render", &format!("{name}.toml"), "--at-s", "0", "--renderer", "cpu", "--out", &png, "--quiet"])
            .expect(0);
    }
    workshop.write("incra1.toml", "[sensor]\npreset = \"incra1\"\n");
    workshop.write("wide.toml", "[sensor]\npreset = \"wide\"\n");
    workshop.write("width.toml", "[navigation]\nwidth_m = 0.5\n");
    let read = |args: &[&str]| {
        let args: Vec<_> = ["perceive", "--json"].iter().chain(args).copied().collect();
        workshop.run(&args).expect(0).json()["images"][0].clone()
    };
    for pipeline in ["robust", "paper"] {
        let unknown = read(&["one.png", "--rig", "incra1.toml", "--pipeline", pipeline]);
        let walls: Vec<_> =
            unknown["planes"].as_array().expect("planes").iter().filter_map(|plane| plane["wall"].as_str()).collect();
        assert!(walls.contains(&"right") && !walls.contains(&"left"), "{walls:?}");
        assert_eq!((&unknown["lateral_m"], &unknown["sigma"]["lateral_m"]), (&Value::Null, &Value::Null), "{pipeline}");
        let known = read(&["one.png", "--rig", "incra1.toml", "--rig", "width.toml", "--pipeline", pipeline]);
        assert_eq!(known, read(&["one.png", "--rig", "one.toml", "--pipeline", pipeline]));
        assert!((known["lateral_m"].as_f64().expect("a number") - 0.03).abs() < 2e-3, "{pipeline}: {}", known["lateral_m"]);
        assert!(known["heading_rad"].is_number());
        assert_eq!((&known["heading_rad"], &known["planes"]), (&unknown["heading_rad"], &unknown["planes"]));
    }
    let both = read(&["both.png", "--rig", "wide.toml"]);
    assert!((both["lateral_m"].as_f64().expect("a number") - 0.03).abs() < 5e-4, "{}", both["lateral_m"]);
    let told = workshop.run(&["perceive", "one.png", "--rig", "incra1.toml"]).expect(0).stdout;
    assert!(told.contains("lateral not known") && told.contains("[navigation] width_m"), "{told}");
    assert!(!workshop.run(&["perceive", "both.png", "--rig", "wide.toml"]).expect(0).stdout.contains("not known"));
}

#[test]
fn without_a_rig_there_are_centres_and_lines() {
    let workshop = Workshop::new();
    save(&workshop, "stripe.png", stripe(200));
    // 12 bits, as `render --bits 12` writes them; and the stripe as the green of a grey scene, as JPEG.
    let deep = ImageBuffer::from_fn(200, 80, |u, v| Luma([16 * u16::from(stripe(200).get_pixel(u, v)[0])]));
    save(&workshop, "deep.png", DynamicImage::ImageLuma16(deep));
    let green = ImageBuffer::from_fn(200, 80, |u, v| {
        let grey = if u / 20 % 2 == 0 { 40 } else { 100 };
        Rgb([grey, u8::saturating_add(grey, stripe(200).get_pixel(u, v)[0] - 20), grey])
    });
    save(&workshop, "green.jpg", green);
    for (file, channel, max_dn, exact_px) in
        [("stripe.png", "grey", 255, 0.02), ("deep.png", "grey", 4095, 0.02), ("green.jpg", "green-excess", 1020, 0.15)]
    {
        let document = workshop.run(&["perceive", file, "--channel", channel, "--json"]).expect(0).json();
        let image = &document["images"][0];
        assert_eq!((&image["max_dn"], &image["pipeline"]), (&json!(max_dn), &json!(null)));
        assert!(["lateral_m", "heading_rad"].iter().all(|key| image[key].is_null()) && image["planes"] == json!([]));
        let centres = image["centres"].as_array().expect("centres");
        assert!(centres.len() >= 180, "{file}: {}", centres.len());
        for centre in centres {
            assert!((centre["v_px"].as_f64().expect("a number") - 40.25).abs() < exact_px, "{file}: {centre}");
            assert!(centre["laser"].is_null() && centre["sigma_px"].as_f64().is_some_and(|s| s > 0.0));
        }
        assert_eq!(image["lines"].as_array().expect("lines").len(), 1, "{file}");
    }
}

#[test]
fn regions_leave_out_what_is_beside_them() {
    let workshop = Workshop::new();
    save(&workshop, "a.png", stripe(200));
    save(&workshop, "b.png", stripe(300));
    let columns = |args: &[&str]| {
        let args: Vec<_> = ["perceive", "a.png", "b.png", "--json"].iter().chain(args).copied().collect();
        let document = workshop.run(&args).expect(0).json();
        let count = |image: &Value| image["centres"].as_array().expect("centres").len();
        document["images"].as_array().expect("images").iter().map(count).collect::<Vec<_>>()
    };
    assert_eq!(columns(&[]), [200, 300]);
    assert_eq!(columns(&["--roi", "50,0,150,80"]), [100, 100]);
    assert_eq!(columns(&["--roi", "50,0,150,0,150,80,50,80"]), [100, 100]);
    workshop
        .write("rois.csv", "file,a_u,a_v,b_u,b_v,c_u,c_v,d_u,d_v\nb.png,10,0,250,0,250,80,10,80\na.png,10,0,50,0,50,80,10,80\n");
    assert_eq!(columns(&["--rois", "rois.csv"]), [40, 240]);
}

#[test]
fn what_is_wrong_is_named() {
    let workshop = Workshop::new();
    save(&workshop, "stripe.png", stripe(200));
    workshop.write("noise.png", [0x89, b'P', b'N', b'G', 1, 2, 3, 4]);
    workshop.write("noise.jpg", [0xff, 0xd8, 0xff, 0xe0, 9, 9, 9, 9]);
    workshop.write("text.png", "no picture");
    workshop.write("empty.png", "");
    for file in ["noise.png", "noise.jpg", "text.png", "empty.png"] {
        assert_says(&refused(&workshop, &[file]), file, "cannot be read as PNG or JPEG");
    }
    assert_says(&refused(&workshop, &["missing.png"]), "missing.png", "no such file");
    assert_says(&refused(&workshop, &["."]), ".", "a folder");
    assert_says(&refused(&workshop, &["stripe.png", "--channel", "green-excess"]), "stripe.png", "grey");
    assert_says(
        &refused(&workshop, &["stripe.png", "--rig", "short.toml"]),
        "stripe.png",
        "200 x 80 pixels, the camera of short.toml 640 x 480",
    );
    assert_says(&refused(&workshop, &["stripe.png", "--roi", "1,2,3"]), "--roi 1,2,3", "3 numbers");
    assert_says(&refused(&workshop, &["stripe.png", "--roi", "300,0,400,80"]), "stripe.png", "beside it");
    workshop.write("rois.csv", "file,a_u,a_v,b_u,b_v,c_u,c_v\nother.png,1,1,2,2,3,x\n");
    let error = refused(&workshop, &["stripe.png", "--rois", "rois.csv"]);
    assert_says(&error, "rois.csv", "`x`");
    assert_eq!(error["line"], 2);
    assert_says(&refused(&workshop, &["stripe.png", "--rois", "/dev/zero"]), "/dev/zero", "larger than");
    workshop.write("rois.csv", "file,a_u,a_v,b_u,b_v,c_u,c_v\nother.png,1,1,2,2,3,4\n");
    assert_says(&refused(&workshop, &["stripe.png", "--rois", "rois.csv"]), "stripe.png", "no row");
    workshop.write("below/stripe.png", std::fs::read(workshop.path("stripe.png")).expect("a file"));
    assert_says(&refused(&workshop, &["stripe.png", "below/stripe.png"]), "below/stripe.png", "stripe.png");
    // A pipeline without a rig, a channel that is none: the command line itself.
    for args in [["stripe.png", "--pipeline", "paper"], ["stripe.png", "--channel", "infrared"]] {
        refused(&workshop, &args);
    }
}

/// Nothing that was there goes without its owner's will.
#[test]
fn results_replace_neither_what_is_read_nor_what_is_not_of_perceive() {
    let workshop = with_frame();
    let truth = workshop.read("frame.json");
    assert_says(&refused(&workshop, &["frame.png", "--out", "."]), "--out ./frame.json", "`perceive` did not write it");
    assert_eq!(workshop.read("frame.json"), truth);
    save(&workshop, "a.png", stripe(200));
    save(&workshop, "a.overlay.png", stripe(200));
    let before = std::fs::read(workshop.path("a.overlay.png")).expect("a file");
    assert_says(
        &refused(&workshop, &["a.png", "a.overlay.png", "--out", "."]),
        "--out ./a.overlay.png",
        "would replace a.overlay.png",
    );
    assert_eq!(std::fs::read(workshop.path("a.overlay.png")).expect("a file"), before);
    // Its own documents and pictures are replaced.
    for _ in 0..2 {
        workshop.run(&["perceive", "a.png"]).expect(0);
    }
    // Somebody else's picture is not, however it is called, unless it is told to.
    let overlay = workshop.path("out/perceive/a.overlay.png");
    let own = std::fs::read(&overlay).expect("a file");
    for other in [&before[..], b"no picture", b""] {
        workshop.write("out/perceive/a.overlay.png", other);
        let ran = workshop.run(&["perceive", "a.png"]).expect(2);
        ran.saying(&["--out out/perceive/a.overlay.png", "`perceive` did not write it", "`--force`"]);
        assert_eq!(std::fs::read(&overlay).expect("a file"), other);
    }
    workshop.run(&["perceive", "a.png", "--force"]).expect(0);
    assert_eq!(std::fs::read(&overlay).expect("a file"), own);
    // What is read stays, force or not.
    workshop
        .run(&["perceive", "a.png", "a.overlay.png", "--out", ".", "--force"])
        .expect(2)
        .saying(&["would replace a.overlay.png"]);
    let _ = std::fs::remove_dir_all(workshop.path("out"));
    // A place where nothing can be made is told before anything is read.
    #[cfg(target_os = "linux")]
    {
        let ran =
            workshop.run(&["perceive", "a.png", "--out", "/proc/q"]).expect(2).saying(&["--out /proc/q", "cannot be written"]);
        assert_eq!(ran.stdout, "");
    }
    workshop.run(&["perceive", "a.png", "--out", "frame.png/x"]).expect(2).saying(&["is not a folder"]);
}

/// Names that are no text are names all the same.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf_8_stay_apart() {
    use std::os::unix::ffi::OsStrExt;
    let workshop = Workshop::new();
    save(&workshop, "a.png", stripe(100));
    let names = [&b"\xff.png"[..], &b"\xfe.png"[..]].map(std::ffi::OsStr::from_bytes);
    let picture = std::fs::read(workshop.path("a.png")).expect("a file");
    for name in names {
        std::fs::write(workshop.path("").join(name), &picture).expect("a file");
    }
    let args = ["perceive".as_ref(), names[0], names[1], "--quiet".as_ref()];
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_ductloop")).args(args).current_dir(workshop.path("")).output();
    assert!(ran.expect("the program starts").status.success());
    assert_eq!(std::fs::read_dir(workshop.path("out/perceive")).expect("results").count(), 4);
}

/// What decoders take for a picture of grey below.
#[test]
fn a_jpeg_that_is_cut_short_is_refused() {
    let workshop = Workshop::new();
    save(&workshop, "a.jpg", stripe(400));
    let whole = std::fs::read(workshop.path("a.jpg")).expect("a file");
    workshop.run(&["perceive", "a.jpg"]).expect(0);
    std::fs::remove_dir_all(workshop.path("out")).expect("results");
    workshop.write("a.jpg", &whole[..whole.len() * 4 / 5]);
    assert_says(&refused(&workshop, &["a.jpg"]), "a.jpg", "cut short");
}

/// Every error of every file at once, those of the rig with their lines.
#[test]
fn a_rig_that_cannot_be_is_refused_with_its_line() {
    let workshop = Workshop::new();
    save(&workshop, "stripe.png", stripe(640));
    let rig = "[camera]\nwidth_px = 640\nheight_px = 80\nfocal_px = 400.0\ncentre_px = [320.0, 40.0]\nroll_deg = 0.0\n\
               position_in_base_m = [0.1, 0.0, 0.1]\n[laser.low]\nnormal = [0.0, 1.0, 0.0]\noffset_m = 0.0001\n";
    workshop.write("rig.toml", rig);
    let error = refused(&workshop, &["stripe.png", "--rig", "rig.toml"]);
    assert_eq!((&error["file"], &error["line"]), (&json!("rig.toml"), &json!(10)), "{error}");
    assert!(error["message"].as_str().is_some_and(|message| message.contains("laser `low`")), "{error}");
    workshop.write("rig.toml", rig.replace("0.0001", "0.06"));
    workshop.run(&["perceive", "stripe.png", "--rig", "rig.toml"]).expect(0);
    let ran = workshop.run(&["perceive", "a.png", "b.png", "--rig", "none.toml", "--json"]).expect(2);
    assert_eq!(ran.json()["errors"].as_array().map(Vec::len), Some(3), "{}", ran.stdout);
}

/// Black, white, a pixel, a line of pixels: read, and nothing seen. With a rig too.
#[test]
fn pictures_without_a_stripe_show_none() {
    let workshop = Workshop::new();
    for (name, width, height, grey) in
        [("black", 640, 480, 0_u8), ("white", 640, 480, 255), ("pixel", 1, 1, 200), ("row", 700, 1, 9)]
    {
        let file = format!("{name}.png");
        save(&workshop, &file, ImageBuffer::from_pixel(width, height, Luma([grey])));
        let rigs: &[&[&str]] = if width == 640 {
            &[&[], &["--rig", "short.toml"], &["--rig", "short.toml", "--pipeline", "robust"]]
        } else {
            &[&[]]
        };
        for rig in rigs {
            let args: Vec<_> = ["perceive", &file, "--json"].iter().chain(*rig).copied().collect();
            let ran: Ran = workshop.run(&args).expect(0);
            let image = &ran.json()["images"][0];
            assert_eq!(
                (&image["centres"], &image["lines"], &image["lateral_m"]),
                (&json!([]), &json!([]), &json!(null)),
                "{name}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Random bytes as a picture: refused with its name; random bytes in a picture of the right form: read. Never a crash.
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), jpeg in any::<bool>(), cut in 0.0..1.0f64) {
        let workshop = Workshop::new();
        let name = if jpeg { "a.jpg" } else { "a.png" };
        save(&workshop, name, stripe(40));
        let mut file = std::fs::read(workshop.path(name)).expect("a file");
        let at = (cut * file.len() as f64) as usize;
        file.splice(at.., bytes);
        workshop.write(name, &file);
        let ran = workshop.run(&["perceive", name, "--json"]);
        prop_assert!(matches!(ran.code, Some(0 | 2)), "{ran:?}");
        prop_assert!(ran.json()["errors"].as_array().is_some_and(|errors| errors.is_empty() == (ran.code == Some(0))));
    }
}
