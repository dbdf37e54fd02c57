//! From what was typed to a complete scenario: check, lay presets beneath, fill in defaults, check what fields say of each
//! other.

use ductloop_duct::network::End;
use ductloop_nav::estimation::EstimationParams;
use ductloop_nav::messages::MountSweep;
use ductloop_nav::perception::paper::PaperParams;
use ductloop_nav::perception::robust::RobustParams;
use ductloop_nav::rig::{Camera, Distortion, LineWidth, Mount, MountAngles, Rig};
use ductloop_nav::wheel_controller::board::Arithmetic;
use ductloop_sensor::optics::Optics;
use ductloop_sim::spec::RobotSpec;
use nalgebra::Point3;

use super::check::Checked;
use super::criteria::{Bound, Criteria, Criterion};
use super::diagnostic::{Diagnostics, Finding};
use super::fields::{self, Default, Field, Scale, Slot};
use super::model::{
    AutoExposure, Control, Duct, Estimation, EstimatorKind, Finish, Navigation, Perception, Pipeline, Rates, RigDeviation, Route,
    Start,
};
use super::model::{LinkParams, MountControl, WheelControl};
use super::source::{Sources, Span};
use super::tree::{Node, Table, Value};
use super::typed::Typed;
use super::{Scenario, cross, elements, faults, parse, presets, random_network};

/// The scenario, or every error found.
pub(super) fn resolve(typed: &Typed) -> Result<Scenario, Diagnostics> {
    resolve_with(typed, cross::check)
}

/// The same of a rig's file with what it may leave out beneath: duct, robot and course are not looked at.
pub(super) fn resolve_rig(typed: &Typed) -> Result<Scenario, Diagnostics> {
    resolve_with(typed, cross::check_rig)
}

fn resolve_with(typed: &Typed, cross_check: fn(&Scenario, &Typed, &mut Checked)) -> Result<Scenario, Diagnostics> {
    let fail = |findings| {
        let mut all = typed.unreadable.clone();
        all.extend(Diagnostics::from_findings(findings, &typed.sources).0);
        Err(Diagnostics(all))
    };
    if !typed.unreadable.is_empty() {
        return fail(typed.findings.clone());
    }
    let mut root = typed.root.clone();
    let mut checked = Checked::default();
    checked.table(fields::root(), &mut root, "", Span::default());
    if !checked.is_sound(&[fields::KIND, fields::FORMAT]) {
        // Of a file of another kind or format nothing else can be said. If neither is there, but a key like it, that one is told of.
        let of_kind = |f: &Finding| [fields::KIND, fields::FORMAT].iter().any(|path| typed.span(path) == f.span);
        if checked.findings.iter().any(of_kind) {
            checked.findings.retain(of_kind);
        }
        return fail([typed.findings.clone(), checked.findings].concat());
    }
    if !typed.findings.is_empty() {
        // What is missing may stand in a broken line.
        checked.findings.retain(|f| typed.findings.iter().all(|broken| !overshadows(broken.span, f.span, &typed.sources)));
        return fail([typed.findings.clone(), checked.findings].concat());
    }
    let mut layered = beneath(&root);
    random_network::lay(&mut layered, typed, &mut checked);
    checked.missing(fields::root(), Some(&layered), "", &|path| typed.span(path));
    let scenario = build(&layered, &root, typed, &mut checked);
    cross_check(&scenario, typed, &mut checked);
    if checked.findings.is_empty() { Ok(scenario) } else { fail(checked.findings) }
}

/// Whether what the parser made of a text says nothing about its author's intent, because the syntax before it is broken: on
/// the same line, and after a broken table header up to the next header.
fn overshadows(broken: Span, span: Span, sources: &Sources) -> bool {
    if broken.source != span.source {
        return false;
    }
    let text = sources.text(span.source);
    let (broken, place) = (sources.place(broken), sources.place(span));
    let is_header = |line: &str| line.trim_start().starts_with('[');
    let from_broken_on = text.lines().skip(broken.line).take((place.line).saturating_sub(broken.line));
    broken.line == place.line
        || (is_header(&broken.text) && broken.line < place.line && !from_broken_on.into_iter().any(is_header))
}

/// Presets laid beneath what was typed.
fn beneath(root: &Table) -> Table {
    let word = |path: &str| match root.at(path).map(|node| &node.value) {
        Some(Value::Text(word)) => word.clone(),
        _ => default_of(path).and_then(|node| node.as_text().map(str::to_owned)).unwrap_or_default(),
    };
    let (robot, sensor) = (word("robot.preset"), word("sensor.preset"));
    let named = [presets::robot(&robot), presets::sensor(&sensor)];
    let mut layered = Table::default();
    for text in named.into_iter().flatten().chain(presets::SURFACES.iter().map(|(_, text)| *text)) {
        let mut sources = Sources::default();
        let source = sources.add("preset", text);
        layered.merge(parse::document(&sources, source).0);
    }
    layered.merge(root.clone());
    layered
}

/// The default of the field at a path, if it has one.
pub(super) fn default_of(path: &str) -> Option<Node> {
    literal(fields::fields().find(|f| f.path == path)?)
}

fn literal(field: &Field) -> Option<Node> {
    if let Default::Value(toml) = field.default { parse::value(toml, 0, 0).ok() } else { None }
}

/// Puts everything in its place. Where a value is missing or was wrong, which `checked` knows, something harmless stands in.
fn build(layered: &Table, root: &Table, typed: &Typed, checked: &mut Checked) -> Scenario {
    let mut scenario = blank();
    for field in fields::fields() {
        if let Some(node) = layered.at_field(field).cloned().or_else(|| literal(field)) {
            store(field, &mut scenario, &node);
        }
    }
    (scenario.rig.lasers, scenario.laser_power) = elements::lasers(layered, &scenario.rig, typed, checked).into_iter().unzip();
    if layered.at("sensor.error.laser_plane_deg").is_none() {
        scenario.rig_error.laser_plane_rad = vec![0.0; scenario.rig.lasers.len()];
    }
    if layered.at("navigation.width_m").is_none() {
        scenario.navigation.width_m = scenario.navigation.fixed_width_m.unwrap_or(scenario.duct.width_m);
    }
    if layered.at("wheel_control.silence_s").is_none() {
        scenario.wheel_control.silence_s = f64::max(0.5, 5.0 / f64::from(scenario.rates.camera_hz));
    }
    elements::duct(layered, root, &mut scenario, typed, checked);
    scenario.faults = faults::read(layered, &scenario.rig, typed, checked);
    scenario
}

impl Table {
    /// The value of a field that stands in no array and under no name of the file's choosing.
    fn at_field(&self, field: &Field) -> Option<&Node> {
        if matches!(field.slot, Slot::ByTable | Slot::Fixed(_)) { None } else { self.at(field.path) }
    }
}

/// Puts a value of the right type into its place.
fn store(field: &Field, scenario: &mut Scenario, node: &Node) {
    let numbers = |scale: Scale| -> Vec<f64> {
        node.as_list().into_iter().flatten().filter_map(Node::as_number).map(|x| scale.si(x)).collect()
    };
    match (field.slot, &node.value) {
        (Slot::Number(at, scale), Value::Number(_) | Value::Integer(_)) => {
            *at(scenario) = scale.si(node.as_number().unwrap_or_default());
        }
        (Slot::NumberOr(at, scale), value) => {
            *at(scenario) = if let Value::Text(_) = value { None } else { node.as_number().map(|x| scale.si(x)) };
        }
        (Slot::Part { set, .. }, Value::Number(_) | Value::Integer(_)) => set(scenario, node.as_number().unwrap_or_default()),
        (Slot::Values { set, .. }, Value::List(_)) => set(scenario, &numbers(Scale::Si)),
        (Slot::Choice { set, .. }, Value::Integer(x)) => set(scenario, *x),
        (Slot::Numbers(at, scale), Value::List(_)) => {
            at(scenario).iter_mut().zip(numbers(scale)).for_each(|(slot, x)| *slot = x);
        }
        (Slot::Numbers(at, scale), Value::Number(_) | Value::Integer(_)) => {
            at(scenario).fill(scale.si(node.as_number().unwrap_or_default()));
        }
        (Slot::List(at, scale), Value::List(_)) => *at(scenario) = numbers(scale),
        // The bounds of the table of fields are within each type.
        (Slot::Usize(at), Value::Integer(x)) => *at(scenario) = usize::try_from(*x).unwrap_or_default(),
        (Slot::Sizes(at), Value::List(list)) => {
            let sizes = list.iter().filter_map(Node::as_integer).map(|x| usize::try_from(x).unwrap_or_default());
            at(scenario).iter_mut().zip(sizes).for_each(|(slot, size)| *slot = size);
        }
        (Slot::U32(at), Value::Integer(x)) => *at(scenario) = u32::try_from(*x).unwrap_or_default(),
        (Slot::U64(at), Value::Integer(x)) => *at(scenario) = u64::try_from(*x).unwrap_or_default(),
        (Slot::Flag(at), Value::Flag(flag)) => *at(scenario) = *flag,
        (Slot::Text(at), Value::Text(text)) => at(scenario).clone_from(text),
        (Slot::Word { set, .. }, Value::Text(word)) => set(scenario, word),
        (Slot::Criterion(metric, scale), value) => {
            let bound = match value {
                Value::Flag(flag) => Bound::Is(*flag),
                Value::Text(word) => Bound::Word(word.clone()),
                _ => {
                    let si = scale.si(node.as_number().unwrap_or_default());
                    if field.key().split('_').any(|part| part == "min") { Bound::AtLeast(si) } else { Bound::AtMost(si) }
                }
            };
            scenario.pass.list.push(Criterion { key: field.key(), metric, unit: field.unit, scale, bound });
        }
        // `Checked` has taken out every value of a wrong type.
        _ => {}
    }
}

/// What fields are written into.
fn blank() -> Scenario {
    Scenario {
        name: String::new(),
        about: String::new(),
        seed: 0,
        time_limit_s: 1.0,
        rates: Rates { physics_hz: 1, wheel_control_hz: 1, camera_hz: 1 },
        robot: RobotSpec::incra1(),
        speed_m_s: 1.0,
        rig: Rig {
            camera: Camera { width_px: 16, height_px: 16, focal_px: [1.0; 2], centre_px: [0.0; 2], distortion: Distortion::NONE },
            mount: Mount { position_in_base_m: Point3::origin(), roll_rad: 0.0, rest: MountAngles::default() },
            lasers: Vec::new(),
            line: LineWidth { width_m: 1e-3, growth_rad: 0.0 },
        },
        laser_power: Vec::new(),
        rig_error: RigDeviation::default(),
        exposure_s: None,
        auto_exposure: AutoExposure { target_dn: 1.0, exposure_s: [1e-3; 2], laser_power: [1.0; 2] },
        optics: Optics::default(),
        perception: Perception { pipeline: Pipeline::Robust, paper: PaperParams::default(), robust: RobustParams::default() },
        estimation: Estimation { kind: EstimatorKind::Kalman, params: EstimationParams::default() },
        control: Control::default(),
        wheel_control: WheelControl {
            arithmetic: Arithmetic::Fixed,
            pwm_bits: 8,
            current_limit_a: 1.0,
            voltage_limit_v: None,
            silence_s: 1.0,
            ramp_m_s2: 1.0,
            follow_s: 0.25,
        },
        mount_control: MountControl {
            acceleration_rad_s2: None,
            backlash_rad: 0.0,
            encoder_step_rad: 0.0,
            sweep: MountSweep { amplitude: MountAngles::default(), period_s: 1.0 },
        },
        link: LinkParams::default(),
        navigation: Navigation { width_m: 1.0, fixed_width_m: None, coast_s: 0.0, frozen_frames: 0 },
        duct: Duct {
            width_m: 1.0,
            height_m: 1.0,
            surface: ductloop_duct::cell::SurfaceId(0),
            run: Vec::new(),
            branches: Vec::new(),
            route: Route::default(),
            entry: End::Cap,
            exit: End::Open,
            bead_m: 0.0,
            bead_width_m: 0.0,
            objects: Vec::new(),
        },
        surfaces: Vec::new(),
        start: Start { distance_m: 0.0, lateral_m: 0.0, heading_rad: 0.0 },
        finish: Finish { before_end_m: 0.0 },
        faults: Vec::new(),
        pass: Criteria::default(),
    }
}
