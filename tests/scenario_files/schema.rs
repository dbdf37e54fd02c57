//! The JSON Schema and the reader say the same of what a schema can say.

use ductloop::Scenario;
use ductloop::scenario::accuracy_file::{self, AccuracyFile};
use ductloop::scenario::study_file::{self, StudyFile};
use ductloop::scenario::sweep_file::{self, SweepFile};
use ductloop::scenario::{FileKind, fields, schema};
use serde_json::Value;

use super::{LEAST, files};

/// What is wrong with `value` by `schema`, as far as the keywords that the schema uses go; `None` if nothing is.
fn violation(schema: &Value, value: &Value, at: &str) -> Option<String> {
    let known = [
        "$schema",
        "title",
        "description",
        "default",
        "x-unit",
        "type",
        "properties",
        "patternProperties",
        "additionalProperties",
        "required",
        "minimum",
        "maximum",
        "const",
        "enum",
        "items",
        "minItems",
        "maxItems",
        "minProperties",
        "maxProperties",
        "oneOf",
        "not",
        "pattern",
        "uniqueItems",
    ];
    for keyword in schema.as_object().expect("a schema is an object").keys() {
        assert!(known.contains(&keyword.as_str()), "this validator does not know `{keyword}`");
    }
    let wrong = |what: String| Some(format!("{at}: {what}"));
    let is_of_type = match schema["type"].as_str() {
        None => true,
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("integer") => value.is_i64(),
        Some("number") => value.is_number(),
        Some(other) => panic!("type {other}"),
    };
    if !is_of_type {
        return wrong(format!("not of type {}", schema["type"]));
    }
    if schema.get("const").is_some_and(|constant| constant != value) {
        return wrong(format!("not {}", schema["const"]));
    }
    if schema["enum"].as_array().is_some_and(|words| !words.contains(value)) {
        return wrong(format!("none of {}", schema["enum"]));
    }
    if let Some(x) = value.as_f64()
        && (schema["minimum"].as_f64().is_some_and(|min| x < min) || schema["maximum"].as_f64().is_some_and(|max| x > max))
    {
        return wrong(format!("{x} is out of bounds"));
    }
    if let (Some(_), Some(text)) = (schema["pattern"].as_str(), value.as_str())
        && !schema["pattern"].as_str().is_some_and(|pattern| matches(pattern, text))
    {
        return wrong(format!("`{text}` does not match"));
    }
    if let Some(schemas) = schema["oneOf"].as_array() {
        let matching = schemas.iter().filter(|s| violation(s, value, at).is_none()).count();
        if matching != 1 {
            return wrong(format!("{matching} of oneOf match"));
        }
    }
    if schema.get("not").is_some_and(|not| violation(not, value, at).is_none()) {
        return wrong("what must not match does".to_owned());
    }
    if let Some(items) = value.as_array() {
        let len = items.len() as u64;
        if schema["minItems"].as_u64().is_some_and(|min| len < min) || schema["maxItems"].as_u64().is_some_and(|max| len > max) {
            return wrong(format!("{len} elements"));
        }
        if schema["uniqueItems"] == true && (1..items.len()).any(|i| items[..i].contains(&items[i])) {
            return wrong("the same twice".to_owned());
        }
        let schema = schema.get("items")?;
        return items.iter().enumerate().find_map(|(i, item)| violation(schema, item, &format!("{at}[{i}]")));
    }
    let object = value.as_object()?;
    let len = object.len() as u64;
    let [fewest, most] = ["minProperties", "maxProperties"].map(|key| schema[key].as_u64());
    if fewest.is_some_and(|fewest| len < fewest) || most.is_some_and(|most| len > most) {
        return wrong(format!("{len} properties"));
    }
    for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if !object.contains_key(key) {
            return wrong(format!("`{key}` is missing"));
        }
    }
    object.iter().find_map(|(key, inner)| {
        let named = schema["patternProperties"].as_object().into_iter().flatten().find(|(pattern, _)| matches(pattern, key));
        match schema["properties"].get(key).or(named.map(|(_, schema)| schema)) {
            Some(schema) => violation(schema, inner, &format!("{at}.{key}")),
            None if schema["additionalProperties"] == false => wrong(format!("`{key}` is not known")),
            None if schema["additionalProperties"].is_object() => {
                violation(&schema["additionalProperties"], inner, &format!("{at}.{key}"))
            }
            None => None,
        }
    })
}

/// The patterns that there are.
fn matches(pattern: &str, key: &str) -> bool {
    match pattern {
        "^[A-Za-z0-9_-]{1,64}$" => is_name(key),
        "[.\\[]" => key.contains(['.', '[']),
        other => panic!("pattern {other}"),
    }
}

fn is_name(text: &str) -> bool {
    (1..=64).contains(&text.len()) && text.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
}

fn to_json(text: &str) -> Value {
    let table: toml::Table = toml::from_str(text).expect("TOML");
    serde_json::to_value(table).expect("JSON")
}

#[test]
fn it_accepts_what_the_reader_accepts() {
    let schema = schema();
    for entry in ductloop::library::all() {
        assert_eq!(violation(&schema, &to_json(entry.text), ""), None, "{}", entry.name);
        let resolved = Scenario::from_toml_str(entry.text).unwrap_or_else(|errors| panic!("{errors}")).to_toml();
        assert_eq!(violation(&schema, &to_json(&resolved), ""), None, "{} resolved", entry.name);
    }
    let every_way = format!(
        "{}\nbead_mm = 3\n[[duct.object]]\nshape = \"box\"\nsize_m = [0.1, 0.2, 0.05]\nat_m = 2\nsurface = \"painted\"\n\
         [sensor.camera]\nfocal_px = [378.0, 379.0]\n[sensor.laser.low]\noffset_m = 0.059676\npower = 0\n[sensor.light]\n\
         shadows = false\n[surface.painted]\nalbedo = 0.7\n",
        LEAST.replace(" }]", " }, { elbow_deg = 90 }, { mitre_deg = -45.0, surface = \"painted\" }, { straight_m = 2 }]"),
    );
    Scenario::from_toml_str(&every_way).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(violation(&schema, &to_json(&every_way), ""), None);
}

#[test]
fn it_rejects_what_the_reader_rejects() {
    let schema = schema();
    for (what, text) in [
        ("a missing table", LEAST.split("[duct]").next().expect("the head").to_owned()),
        ("a missing key", LEAST.replace("width_m = 0.5\n", "")),
        ("an unknown key", LEAST.replace("width_m", "breadth_m")),
        ("an unknown table", format!("{LEAST}[sensr]\n")),
        ("a wrong type", LEAST.replace("0.5", "\"0.5\"")),
        ("a bound", LEAST.replace("0.5", "-0.5")),
        ("a word", format!("{LEAST}[perception]\npipeline = \"robots\"\n")),
        ("a name", LEAST.replace("\"least\"", "\"the least\"")),
        ("two kinds of fitting", LEAST.replace(" }]", ", elbow_deg = 90 }]")),
        ("no kind of fitting", LEAST.replace("straight_m = 6.0", "")),
        ("no fitting", LEAST.replace("{ straight_m = 6.0 }", "")),
        ("an object without a size", format!("{LEAST}[[duct.object]]\nat_m = 2.0\n")),
        ("an object of no thickness", format!("{LEAST}[[duct.object]]\nat_m = 2.0\nsize_m = [0.1, 0.1, 0.0]\n")),
        ("an unknown shape", format!("{LEAST}[[duct.object]]\nat_m = 2.0\nsize_m = [0.1, 0.1, 0.1]\nshape = \"ball\"\n")),
        ("a bead", format!("{LEAST}bead_mm = 11.0\n")),
        ("a laser's power", format!("{LEAST}[sensor.laser.low]\npower = 10.5\n")),
        ("another format", LEAST.replace("format = 1", "format = 2")),
        ("another kind", LEAST.replace("\"scenario\"", "\"sweep\"")),
        ("a laser's name", format!("{LEAST}[sensor.laser.\"a b\"]\nnormal = [0, 1, 0]\noffset_m = 0.1\n")),
        ("too few numbers", format!("{LEAST}[sensor.camera]\ncentre_px = [1.0]\n")),
        (
            "a source given twice",
            format!("{LEAST}[sensor.laser.low]\nsource_in_base_m = [0, 0, 0]\nsource_in_camera_m = [0, 0.06, 0]\n"),
        ),
    ] {
        assert!(violation(&schema, &to_json(&text), "").is_some(), "the schema accepts {what}:\n{text}");
        assert!(Scenario::from_toml_str(&text).is_err(), "the reader accepts {what}:\n{text}");
    }
}

const STUDY: &str = "format = 1\nkind = \"accuracy\"\nname = \"rigs\"\n[poses]\ncount = 7\nwall_m = [0.15, 0.5]\n[grid]\n\
                     duct.surface = [\"galvanised\", \"painted\"]\n[pass.robust]\nheading_rms_deg = 0.1\n[duct]\nheight_m = 0.3\n\
                     run = [{ straight_m = 20.0 }]\n";

/// The grid may give what the file leaves out, and what no table of it can hold goes by its path.
#[test]
fn that_of_studies_accepts_what_their_reader_accepts() {
    let schema = accuracy_file::schema();
    for path in files("scenarios/studies", "toml") {
        let typed = std::fs::read_to_string(&path).expect("a study");
        if FileKind::of(&typed) != Some(FileKind::Accuracy) {
            continue;
        }
        assert_eq!(violation(&schema, &to_json(&typed), ""), None, "{}", path.display());
    }
    let surface = "duct.surface = [\"galvanised\", \"painted\"]";
    for (from, to) in [
        ("", ""),
        ("height_m = 0.3\n", ""),
        (surface, "duct.height_m = [0.3, 0.4]"),
        (surface, "\"duct.run[0].straight_m\" = [20.0, 30.0]"),
        (surface, "[grid.duct]\n\"run[0].straight_m\" = [20.0, 30.0]"),
        (surface, "sensor.laser.low.power = [0.5, 1.0]\nsensor.exposure = [\"auto\", 4]\nseed = [1, 2]"),
        ("wall_m = [0.15, 0.5]", "width_m = [0.4, 0.5]\nlateral_m = [-0.1, 0]\nheading_deg = [0, 0]\ndistance_m = [8, 9]"),
        ("[poses]", "pipelines = [\"paper\"]\n[poses]"),
    ] {
        assert!(STUDY.contains(from), "{from}");
        let mut text = STUDY.replacen(from, to, 1);
        if from.starts_with("height_m") {
            text = text.replace("[grid]", "[grid]\nduct.height_m = [0.3, 0.4]");
        }
        if to.starts_with("width_m") {
            text = text.replace("height_m = 0.3", "height_m = 0.3\nwidth_m = 0.5");
        }
        AccuracyFile::from_toml_str(&text).unwrap_or_else(|errors| panic!("{text}: {errors}"));
        assert_eq!(violation(&schema, &to_json(&text), ""), None, "{text}");
    }
}

#[test]
fn that_of_studies_rejects_what_their_reader_rejects() {
    let schema = accuracy_file::schema();
    let surface = "duct.surface = [\"galvanised\", \"painted\"]";
    for (from, to) in [
        ("\"accuracy\"", "\"scenario\""),
        ("name = \"rigs\"\n", ""),
        ("[poses]", "pipelines = [\"truth\"]\n[poses]"),
        ("[poses]", "pipelines = [\"paper\", \"paper\"]\n[poses]"),
        ("[poses]", "pipelines = []\n[poses]"),
        ("[poses]", "[positions]"),
        ("count = 7", "count = 0"),
        ("count = 7", "counts = 7"),
        ("[0.15, 0.5]", "[0.15, 5.5]"),
        ("[0.15, 0.5]", "0.5"),
        (surface, "duct.surface = \"painted\""),
        (surface, "duct.surface = []"),
        (surface, "duct.surfaces = [\"painted\"]"),
        (surface, "duct.height_m = [0.3, -0.3]"),
        (surface, "name = [\"a\", \"b\"]"),
        ("[pass.robust]", "[pass.truth]"),
        ("heading_rms_deg", "heading_rms_rad"),
        ("heading_rms_deg = 0.1", "heading_rms_deg = \"0.1\""),
        ("height_m = 0.3", "height_mm = 300"),
    ] {
        assert!(STUDY.contains(from), "{from}");
        let text = STUDY.replacen(from, to, 1);
        assert!(violation(&schema, &to_json(&text), "").is_some(), "the schema accepts {to}:\n{text}");
        assert!(AccuracyFile::from_toml_str(&text).is_err(), "the reader accepts {to}:\n{text}");
    }
}

#[test]
fn that_of_sweeps_and_their_reader_agree() {
    let schema = sweep_file::schema();
    for path in files("scenarios/sweeps", "toml") {
        let typed = std::fs::read_to_string(&path).expect("a sweep");
        assert_eq!(violation(&schema, &to_json(&typed), ""), None, "{}", path.display());
        let read = SweepFile::read(&path, &Default::default()).unwrap_or_else(|wrong| panic!("{wrong}"));
        assert_eq!(path.file_stem().and_then(|stem| stem.to_str()), Some(read.name.as_str()));
    }
    const SWEEP: &str = "format = 1\nkind = \"sweep\"\nname = \"s\"\nbase = \"b.toml\"\ndesign = \"random\"\nsamples = 4\n[factor]\n\
                         duct.width_m = { from = 0.4, to = 0.6 }\n[scenario.pass]\nsettle_m = 1.0\n";
    let read = |text: &str| SweepFile::from_toml_str(text, &[("b.toml", LEAST)]);
    let width = "duct.width_m = { from = 0.4, to = 0.6 }";
    for (from, to, taken) in [
        ("", "", true),
        (width, "duct.width_m = [0.4, 0.5]\nsensor.exposure = [\"auto\", 4]", true),
        (width, "sensor.error.pan_deg = { mean = 0, deviation = 0.1, least = -0.2, most = 0.2 }", true),
        (width, "\"duct.run[0].straight_m\" = { from = 2.0, to = 3.0, scale = \"log\" }", true),
        ("samples = 4", "samples = 4\n[stop]\npass_rate_half_width = 0.1\n[pass]\npass_rate_min = 0.5", true),
        ("kind = \"sweep\"", "kind = \"scenario\"", false),
        ("name = \"s\"\n", "", false),
        ("base = \"b.toml\"\n", "", false),
        ("\"random\"", "\"orthogonal\"", false),
        ("samples = 4", "samples = 0", false),
        ("samples = 4", "samples = 4\nreplicates = 0", false),
        ("samples = 4", "samples = 4\nmetrics = [\"speed\"]", false),
        ("samples = 4", "samples = 4\nstop = { pass_rate_half_width = 0.9 }", false),
        ("samples = 4", "samples = 4\npass = { pass_rate = 0.9 }", false),
        (width, "duct.width_m = { from = 0.4 }", false),
        (width, "duct.width_m = { from = 0.4, to = 0.6, step = 0.1 }", false),
        (width, "duct.width = [0.4, 0.5]", false),
        (width, "seed = [1, 2]", false),
        ("settle_m = 1.0", "settle = 1.0", false),
    ] {
        assert!(SWEEP.contains(from), "{from}");
        let text = SWEEP.replacen(from, to, 1);
        assert_eq!(violation(&schema, &to_json(&text), "").is_none(), taken, "the schema and {to}:\n{text}");
        assert_eq!(read(&text).is_ok(), taken, "the reader and {to}:\n{text}");
    }
}

#[test]
fn that_of_tuning_and_its_reader_agree() {
    let schema = study_file::schema();
    let mut seen = 0;
    for path in files("scenarios/studies", "toml") {
        let typed = std::fs::read_to_string(&path).expect("a study");
        if FileKind::of(&typed) != Some(FileKind::Study) {
            continue;
        }
        seen += 1;
        assert_eq!(violation(&schema, &to_json(&typed), ""), None, "{}", path.display());
        let read = StudyFile::read(&path, &Default::default()).unwrap_or_else(|wrong| panic!("{wrong}"));
        assert_eq!(path.file_stem().and_then(|stem| stem.to_str()), Some(read.name.as_str()));
        assert!(read.concerns().is_empty(), "{}: {:?}", path.display(), read.concerns());
    }
    assert!(seen >= 2, "{seen}");
    const STUDY: &str = "format = 1\nkind = \"study\"\nname = \"s\"\nruns = 9\n[parameter]\nrobot.speed_m_s = { from = 0.1, to = 0.5 }\n\
                         [train]\nbase = \"b.toml\"\n[held_out]\nbase = [\"b.toml\"]\nseed = 9\n[objective]\nweights = { lateral_rms_m = 1.0 }\n";
    let speed = "robot.speed_m_s = { from = 0.1, to = 0.5 }";
    let weights = "weights = { lateral_rms_m = 1.0 }";
    for (from, to, taken) in [
        ("", "", true),
        (speed, "robot.speed_m_s = { from = 0.1, to = 0.5, scale = \"log\" }", true),
        (weights, "over = 0.9\nweights = { lateral_rms_m = 1, collisions = 2.5 }", true),
        (weights, "weights = { lateral_rms_m = 1 }\n[constraints]\nfinishes = false\nmost = { collisions = 0 }", true),
        (weights, "weights = { lateral_rms_m = 1 }\n[stop]\nstep = 0.01\ngenerations_without_gain = 3", true),
        ("runs = 9", "runs = 9\noptimiser = \"sobol\"\nhalving = false", true),
        ("\"study\"", "\"sweep\"", false),
        ("runs = 9", "runs = 0", false),
        ("runs = 9", "optimiser = \"simplex\"", false),
        (speed, "robot.speed_m_s = { from = 0.1 }", false),
        (speed, "robot.speed_m_s = { from = 0.1, to = 0.5, scale = \"root\" }", false),
        ("[held_out]\nbase = [\"b.toml\"]\nseed = 9\n", "", false),
        ("seed = 9", "seeds = 9", false),
        (weights, "relative = true\nweights = { lateral_rms_m = 1 }", true),
        (weights, "relative = 1\nweights = { lateral_rms_m = 1 }", false),
        ("[objective]\nweights", "[objective.a]\nweights = { collisions = 1 }\n[objective.b]\nover = \"worst\"\nweights", true),
        ("[objective]\nweights", "[objective.a]\nover = \"worst\"\n[objective.b]\nweights", false),
        ("[objective]\nweights = { lateral_rms_m = 1.0 }", "[objective]", false),
        (weights, "weights = { lateral_rms_m = 1 }\n[constraints]\nmean_of_default = { control_effort = 1.0 }", true),
        (weights, "over = \"median\"\nweights = { lateral_rms_m = 1 }", false),
        (weights, "weights = { lateral_rms = 1.0 }", false),
        (weights, "weights = { lateral_rms_m = \"1\" }", false),
        (weights, "weights = { lateral_rms_m = 1 }\n[constraints]\nmaximum = { collisions = 0 }", false),
        (weights, "weights = { lateral_rms_m = 1 }\n[stop]\nstep = 2.0", false),
    ] {
        assert!(STUDY.contains(from), "{from}");
        let text = STUDY.replacen(from, to, 1);
        assert_eq!(violation(&schema, &to_json(&text), "").is_none(), taken, "the schema and {to}:\n{text}");
        assert_eq!(StudyFile::from_toml_str(&text, &[("b.toml", LEAST)]).is_ok(), taken, "the reader and {to}:\n{text}");
    }
}

#[cfg(feature = "cli")]
#[test]
fn that_of_gauges_and_their_reader_agree() {
    use ductloop::calibrate::gauge;
    let schema = gauge::schema();
    let text = std::fs::read_to_string("scenarios/gauge/incra1.toml").expect("the gauge");
    assert_eq!(violation(&schema, &to_json(&text), ""), None);
    assert!(gauge::file::GaugeFile::parse("g.toml", &text).is_ok());
    let rejected = |text: &str, what: &str| {
        assert!(violation(&schema, &to_json(text), "").is_some(), "the schema accepts {what}");
        assert!(gauge::file::GaugeFile::parse("g.toml", text).is_err(), "the reader accepts {what}");
    };
    // Without any one of its keys, and with another in its place.
    let keys = [
        "surface = \"block\"",
        "size_mm =",
        "origin_m =",
        "turn_rad =",
        "shift_mm =",
        "mark_sigma_px =",
        "window_px =",
        "heights_mm =",
    ];
    let more = ["depths_mm =", "height_m =", "points_mm = [[50.0"];
    for key in keys.iter().chain(&more) {
        assert_eq!(text.matches(key).count(), 1, "{key}");
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with(key)).collect();
        rejected(&lines.join("\n"), &format!("no {key}"));
        rejected(&text.replace(key, &format!("x{key}")), &format!("x{key}"));
    }
    for (from, to) in [
        ("[700.0, 800.0]", "[700.0, 8.0]"),
        ("window_px = 20 ", "window_px = 1 "),
        ("mark_sigma_px = 0.1", "mark_sigma_px = -0.1"),
        ("origin_m = [0.8, ", "origin_m = ["),
        ("origin_m = [0.8, ", "origin_m = [1e6, "),
        ("albedo = 0.5", "albedo = 5.0"),
    ] {
        assert!(text.contains(from), "{from}");
        rejected(&text.replace(from, to), to);
    }
    let (scene, _) = text.split_once("[gauge]").expect("a section");
    rejected(scene, "a scene alone");
}

/// The schema of a path of the table of fields.
fn at<'s>(schema: &'s Value, path: &str) -> Option<&'s Value> {
    path.split('.').try_fold(schema, |schema, step| match step.strip_suffix("[]") {
        Some(list) => schema["properties"].get(list)?.get("items"),
        None if step == "*" => schema["patternProperties"].as_object()?.values().next(),
        None => schema["properties"].get(step),
    })
}

#[test]
fn every_field_is_in_it_with_its_sentence_and_unit() {
    let schema = schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    for field in fields::fields() {
        let leaf = at(&schema, field.path).unwrap_or_else(|| panic!("{} is not in the schema", field.path));
        assert!(!field.about.is_empty() && field.about.ends_with('.'), "{} lacks its sentence", field.path);
        assert!(leaf["description"].as_str().expect("a description").starts_with(field.about), "{}", field.path);
        assert_eq!(leaf["x-unit"].as_str().unwrap_or_default(), field.unit, "{}", field.path);
    }
    for table in fields::tables() {
        assert!(at(&schema, table.path).is_some(), "{} is not in the schema", table.path);
    }
}

#[test]
fn paths_as_typed_find_their_fields() {
    for (typed, path) in [
        ("robot.speed_m_s", "robot.speed_m_s"),
        ("duct.run[12].elbow_deg", "duct.run[].elbow_deg"),
        ("sensor.laser.low.offset_m", "sensor.laser.*.offset_m"),
        ("fault[0].at_s", "fault[].at_s"),
        ("duct.object[3].size_m", "duct.object[].size_m"),
        ("seed", "seed"),
    ] {
        assert_eq!(fields::field(typed).map(|f| f.path), Some(path), "{typed}");
    }
    for nothing in ["", "robot", "robot.speed", "duct.run.elbow_deg", "duct.run[0]", "robot[0].speed_m_s", "robot.speed_m_s.x"] {
        assert!(fields::field(nothing).is_none(), "{nothing}");
    }
}
