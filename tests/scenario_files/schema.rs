//! The JSON Schema and the reader say the same of what a schema can say.

use ductloop::Scenario;
use ductloop::scenario::{fields, schema};
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
        "oneOf",
        "not",
        "pattern",
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
        && !is_name(text)
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
        let schema = schema.get("items")?;
        return items.iter().enumerate().find_map(|(i, item)| violation(schema, item, &format!("{at}[{i}]")));
    }
    let object = value.as_object()?;
    for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if !object.contains_key(key) {
            return wrong(format!("`{key}` is missing"));
        }
    }
    object.iter().find_map(|(key, inner)| {
        let named =
            schema["patternProperties"].as_object().and_then(|patterns| patterns.values().next()).filter(|_| is_name(key));
        match schema["properties"].get(key).or(named) {
            Some(schema) => violation(schema, inner, &format!("{at}.{key}")),
            None if schema["additionalProperties"] == false => wrong(format!("`{key}` is not known")),
            None => None,
        }
    })
}

/// The one pattern that there is.
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
    for path in files("scenarios", "toml") {
        let typed = std::fs::read_to_string(&path).expect("a scenario");
        assert_eq!(violation(&schema, &to_json(&typed), ""), None, "{}", path.display());
        let resolved = Scenario::from_toml_str(&typed).unwrap_or_else(|errors| panic!("{errors}")).to_toml();
        assert_eq!(violation(&schema, &to_json(&resolved), ""), None, "{} resolved", path.display());
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
