//! Rules between the fields of the sensor and of the surfaces: exposures that fit between frames, optics and lenses that can be,
//! lasers that show depth.

use ductloop_duct::network::Network;
use ductloop_nav::rig::{Rig, RigError};
use ductloop_sensor::frame_geometry::{CLEAR_M, Obstacle, clear_cell};
use ductloop_sensor::lens::Projection;
use ductloop_sensor::optics::FanProfile;
use ductloop_sensor::renderer::MAX_LASERS;
use ductloop_sensor::scenery::Scenery;

use super::{Cross, FREE_M, up_mm};

/// Margin about the image that the renderers need rays for, in pixels: point spread and blur reach beyond its edge.
const MARGIN_PX: f64 = 4.0;

/// What rounding may take from a distance, in metres.
const ROUNDING_M: f64 = 1e-9;

impl Cross<'_> {
    pub(super) fn sensor(&mut self) {
        self.exposure();
        self.auto_exposure();
        self.optics();
        self.surfaces();
        self.camera();
        self.rig();
    }

    /// A width that holds all along is also the one to begin with, and the robot fits into what it is told.
    pub(super) fn told_width(&mut self) {
        let paths = ["navigation.width_m", "navigation.width"];
        let navigation = &self.scenario.navigation;
        let needs_m = self.scenario.robot.smallest_duct_m()[0] + 2.0 * FREE_M;
        for (path, told_m) in [(paths[0], Some(navigation.width_m)), (paths[1], navigation.fixed_width_m)] {
            let Some(told_m) = told_m.filter(|told_m| *told_m < needs_m && self.typed.root.at(path).is_some()) else { continue };
            if self.checked.is_sound(&["robot", path]) {
                let robot_m = needs_m - 2.0 * FREE_M;
                let message = format!("`{path}` is {told_m} m, narrower than the robot, which is {robot_m:.3} m wide");
                self.wrong(&[path], message, format!("{:.3} m or more, a millimetre of it free on each side", up_mm(needs_m)));
            }
        }
        let (Some(fixed_m), begin_m) = (navigation.fixed_width_m, navigation.width_m) else { return };
        if self.checked.is_sound(&paths) && fixed_m != begin_m {
            self.wrong(
                &paths,
                format!("navigation.width_m is {begin_m} m, and navigation.width, which holds all along, is {fixed_m} m"),
                "leave navigation.width_m out, or let navigation.width be \"measured\"".to_owned(),
            );
        }
    }

    fn exposure(&mut self) {
        let camera_hz = self.scenario.rates.camera_hz;
        let Some(exposure_s) = self.scenario.exposure_s else { return };
        if self.checked.is_sound(&["sensor.exposure", "rates"]) && exposure_s * f64::from(camera_hz) >= 1.0 {
            self.wrong(
                &["sensor.exposure", "rates.camera_hz"],
                format!("an exposure of {} ms is longer than a frame at {camera_hz} Hz", exposure_s * 1e3),
                format!("less than {:.3} ms", 1e3 / f64::from(camera_hz)),
            );
        }
    }

    fn auto_exposure(&mut self) {
        let auto = self.scenario.auto_exposure;
        for (keys, [least, most], per_si) in
            [(["min_ms", "max_ms"], auto.exposure_s, 1e3), (["min_power", "max_power"], auto.laser_power, 1.0)]
        {
            let [low, high] = keys.map(|key| format!("sensor.auto_exposure.{key}"));
            if self.checked.is_sound(&[&low, &high]) && least > most {
                let message = format!("`{}` is {} and `{}` is {}", keys[0], least * per_si, keys[1], most * per_si);
                self.wrong(&[&high, &low, "sensor.auto_exposure"], message, "the first must not be the larger one".to_owned());
            }
        }
        let (path, camera_hz) = ("sensor.auto_exposure.max_ms", self.scenario.rates.camera_hz);
        let is_auto =
            self.scenario.exposure_s.is_none() && self.checked.is_sound(&["sensor.auto_exposure", "sensor.exposure", "rates"]);
        if is_auto && auto.exposure_s[1] * f64::from(camera_hz) >= 1.0 {
            self.wrong(
                &[path, "rates.camera_hz"],
                format!("an exposure of {} ms is longer than a frame at {camera_hz} Hz", auto.exposure_s[1] * 1e3),
                format!("less than {:.3} ms", 1e3 / f64::from(camera_hz)),
            );
        }
        let [shortest_s, longest_s] = auto.exposure_s;
        let first_s = self.scenario.first_exposure_s();
        if is_auto && self.checked.is_sound(&["sensor.light.at_exposure_ms"]) && !(shortest_s..=longest_s).contains(&first_s) {
            let [first, shortest, longest] = [first_s, shortest_s, longest_s].map(|x| x * 1e3);
            self.wrong(
                &["sensor.light.at_exposure_ms", path, "sensor.exposure"],
                format!("automatic exposure starts from `sensor.light.at_exposure_ms`, {first} ms, and that is out of its range"),
                format!("from {shortest} to {longest} ms, or another `min_ms` or `max_ms` in [sensor.auto_exposure]"),
            );
        }
    }

    fn optics(&mut self) {
        let edge = "sensor.light.fan_edge";
        let is_cylinder = self.scenario.optics.fan_profile == FanProfile::Cylinder;
        if is_cylinder && self.checked.is_sound(&[edge]) && self.typed.root.at(edge).is_some() {
            let message = format!("`{edge}` beside `fan_profile = \"cylinder\"`");
            self.wrong(
                &[edge],
                message,
                "only a Powell lens has it: its fan ends at an edge, a cylinder lens' fades away".to_owned(),
            );
        }
        let tables = ["sensor.light", "sensor.lens", "sensor.ccd"];
        if !self.checked.is_sound(&tables) {
            return;
        }
        if let Err(error) = self.scenario.optics.validate() {
            let paths = tables.map(|table| format!("{table}.{}", error.field));
            let message = format!("`{}` is {}", error.field, error.value);
            self.wrong(&[&paths[0], &paths[1], &paths[2], "sensor"], message, format!("it must be {}", error.bound));
        }
    }

    /// No surface gives back more light than it gets.
    fn surfaces(&mut self) {
        let scenario = self.scenario;
        for surface in &scenario.surfaces {
            let path = format!("surface.{}", surface.name);
            let (albedo, specular) = (surface.look.albedo, surface.look.specular);
            // Decimal fractions that make up 1 may add up to a little more.
            if self.checked.is_sound(&[&path]) && albedo + specular > 1.0 + 1e-12 {
                let keys = ["specular", "albedo"].map(|key| format!("{path}.{key}"));
                self.wrong(
                    &[&keys[0], &keys[1], &path, "duct.surface"],
                    format!(
                        "surface \"{}\" scatters {albedo} of the light and mirrors {specular}: more than there is",
                        surface.name
                    ),
                    format!("`albedo` and `specular` together 1 or less, as in `specular = {:.3}`", (1.0 - albedo).max(0.0)),
                );
            }
        }
    }

    fn camera(&mut self) {
        let paths = ["width_px", "height_px", "centre_px", "focal_px", "distortion"].map(|key| format!("sensor.camera.{key}"));
        let [width, height, centre, _, distortion] = &paths;
        let camera = &self.scenario.rig.camera;
        if !paths.iter().all(|path| self.checked.is_sound(&[path])) || !self.checked.is_sound(&["sensor.camera"]) {
            return;
        }
        for (axis, size_path) in [(0, width), (1, height)] {
            let size = [camera.width_px, camera.height_px][axis] as f64;
            // Shifting a lens that far would take one whose image is three times as wide as the sensor.
            if !(-size..=2.0 * size).contains(&camera.centre_px[axis]) {
                let message = format!(
                    "the principal point {:?} lies more than an image's size outside the image of {} x {} pixels",
                    camera.centre_px, camera.width_px, camera.height_px
                );
                let help = format!(
                    "near its middle, [{:?}, {:?}]",
                    (camera.width_px as f64 - 1.0) / 2.0,
                    (camera.height_px as f64 - 1.0) / 2.0
                );
                return self.wrong(&[centre, size_path, "sensor.camera", "sensor"], message, help);
            }
        }
        if let Err(error) = Projection::new(camera, MARGIN_PX) {
            let help =
                "a barrel-shaped image of a short lens has k1 about -0.3 and k2 about 0.1; with zeros there is no distortion";
            self.wrong(&[distortion, "sensor.camera", "sensor"], error.to_string(), help.to_owned());
        }
    }

    /// The camera is in the duct and off its walls at the start.
    pub(super) fn start_view(&mut self, network: &Network) {
        let path = "sensor.camera.position_in_base_m";
        if !self.checked.is_sound(&[path, "start", "duct", "surface", "robot"]) {
            return;
        }
        let scenario = self.scenario;
        let looks: Vec<_> = scenario.surfaces.iter().map(|surface| surface.look).collect();
        // Looks that cannot be are told elsewhere.
        let Ok(scenery) = Scenery::new(network, &looks) else { return };
        // The mount's axes meet in the camera's centre: where they point makes no difference.
        let camera_in_base = scenario.rig.mount.position_in_base_m;
        let camera = scenario.world_from_start(network) * camera_in_base;
        let place = match clear_cell(&scenery, &camera, 0) {
            Ok(_) => return,
            Err(Obstacle::Metal) => format!("in the duct but nearer than {} mm to metal", CLEAR_M * 1e3),
            Err(Obstacle::Outside) => "outside the duct".to_owned(),
        };
        // As in a straight: across it a point of the base frame is at lateral + x sin + y cos.
        let (sin, cos) = (libm::sin(scenario.start.heading_rad), libm::cos(scenario.start.heading_rad));
        let half_m = scenario.duct.width_m / 2.0 - CLEAR_M;
        let across = |y_m: f64| (y_m - scenario.start.lateral_m - camera_in_base.x * sin) / cos;
        // Across the duct, y of the base frame says little.
        const LEAST_COS: f64 = 0.1;
        let help = [(2, "z", CLEAR_M, scenario.duct.height_m - CLEAR_M), (1, "y", across(-half_m), across(half_m))]
            .into_iter()
            .find(|(axis, _, low_m, high_m)| {
                let is_free = (low_m - ROUNDING_M..=high_m + ROUNDING_M).contains(&camera_in_base[*axis]);
                !is_free && (*axis == 2 || cos > LEAST_COS)
            })
            .map_or_else(
                || {
                    "here the duct ends, bends or has a body in it: another place on the robot, or another `start.distance_m`"
                        .to_owned()
                },
                |(_, name, low_m, high_m)| {
                    format!("at this start, in a straight, {name} may be {:.3} to {:.3}", up_mm(low_m), -up_mm(-high_m))
                },
            );
        self.wrong(
            &[path, "sensor.camera", "sensor", "duct.height_m"],
            format!("at the start the camera, {:?} in the base frame, is {place}", camera_in_base.coords.as_slice()),
            help,
        );
    }

    fn rig(&mut self) {
        if !self.checked.is_sound(&["sensor"]) {
            return;
        }
        let nominal = &self.scenario.rig;
        for laser in &nominal.lasers {
            // One by one: `validate` names the first error only.
            let alone = Rig { lasers: vec![laser.clone()], ..nominal.clone() };
            if let Err(error) = alone.validate() {
                self.rig_error(&error, &format!("sensor.laser.{}", laser.name));
            }
        }
        if nominal.lasers.len() > MAX_LASERS {
            let message = format!("the rig has {} lasers, more than can be rendered", nominal.lasers.len());
            self.wrong(&["sensor.laser", "sensor"], message, format!("at most {MAX_LASERS}"));
        }
        let turns = self.scenario.rig_error.laser_plane_rad.len();
        let lasers: Vec<_> = nominal.lasers.iter().map(|l| l.name.as_str()).collect();
        if turns != lasers.len() {
            self.wrong(
                &["sensor.error.laser_plane_deg", "sensor.error"],
                format!("`sensor.error.laser_plane_deg` takes {} angles, not {turns}", lasers.len()),
                format!("one for each of {}, in this order", lasers.join(", ")),
            );
        } else if self.checked.is_sound(&["sensor"])
            && let Err(error) = self.scenario.actual_rig().validate()
        {
            let path = "sensor.error.laser_plane_deg";
            self.wrong(&[path, "sensor.error"], format!("with this error, {error}"), "a smaller angle".to_owned());
        }
    }

    fn rig_error(&mut self, error: &RigError, laser: &str) {
        let field = |key: &str| format!("{laser}.{key}");
        let (offset, source) = (field("offset_m"), field("source_in_base_m"));
        match error {
            RigError::PlaneThroughCamera { .. } => self.wrong(
                &[&offset, laser],
                error.to_string(),
                "the plane's distance from the camera, 0.001 m or more either way".to_owned(),
            ),
            RigError::SourceOffPlane { .. } => self.wrong(
                &[&source, &field("source_in_camera_m"), &offset, &field("normal"), laser],
                error.to_string(),
                "a source is a point of its plane; `source_in_base_m` stays behind when the camera is moved, \
                 `source_in_camera_m` goes along"
                    .to_owned(),
            ),
            _ => self.wrong(&["sensor.camera", "sensor"], error.to_string(), "the camera cannot work so".to_owned()),
        }
    }
}
