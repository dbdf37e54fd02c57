//! What a perception made of a picture, as a document and in words.

use std::path::Path;

use ductloop::Scenario;
use ductloop::output::words::number;
use ductloop::photograph::{Channel, Photograph};
use ductloop_nav::perception::ridge::{Ridge, RidgeCentre};
use ductloop_nav::perception::{Measurement, SeenPlane, Stages, StripeCentre, StripeLine, Wall};
use serde_json::{Value, json};

/// The stages' results of one picture.
pub(crate) struct Perceived {
    /// Stripe centres.
    pub(crate) centres: Vec<StripeCentre>,
    /// Lines.
    pub(crate) lines: Vec<StripeLine>,
    /// What the extractor without a rig tells beyond that of each centre.
    ridge: Vec<RidgeCentre>,
    planes: Vec<SeenPlane>,
    measured: Measurement,
    /// Whether a lateral error is wanting for nothing but the duct's width.
    wants_width: bool,
    perceive_ms: Option<f64>,
}

impl Perceived {
    /// Of a pipeline.
    pub(crate) fn of_stages(stages: Stages<'_>, measured: Measurement, perceive_ms: Option<f64>) -> Self {
        let Stages { centres, lines, planes, .. } = stages;
        Self {
            centres: centres.into(),
            lines: lines.into(),
            ridge: Vec::new(),
            planes: planes.into(),
            measured,
            wants_width: false,
            perceive_ms,
        }
    }

    /// With the duct's width, in metres, as far as somebody has said it. The pipelines take the middle between one wall and where the other
    /// must be; of a width that nobody said, that is no measurement.
    pub(crate) fn with_width(mut self, width_m: Option<f64>) -> Self {
        let Measurement { left, right, lateral_m, deviation, .. } = &mut self.measured;
        if width_m.is_none() && (left.is_none() || right.is_none()) && lateral_m.is_some() {
            (*lateral_m, deviation.lateral_m) = (None, None);
            self.wants_width = true;
        }
        self
    }

    /// Of the extractor without a rig.
    pub(crate) fn of_ridge(ridge: &Ridge, perceive_ms: Option<f64>) -> Self {
        let ridge_centres = ridge.centres().into();
        Self { ridge: ridge_centres, ..Self::of_stages(ridge.stages(), Measurement::default(), perceive_ms) }
    }
}

/// The document of a picture. What was not measured is null.
pub(crate) fn document(
    file: &Path,
    overlay: &Path,
    photograph: &Photograph,
    channel: Channel,
    scenario: Option<&Scenario>,
    perceived: &Perceived,
) -> Value {
    let laser = |assigned: Option<(usize, Wall)>| {
        assigned
            .map(|(laser, _)| scenario.and_then(|s| s.rig.lasers.get(laser)).map_or(String::new(), |laser| laser.name.clone()))
    };
    let wall = |assigned: Option<(usize, Wall)>| assigned.map(|(_, wall)| wall.word());
    let centre = |(i, centre): (usize, &StripeCentre)| {
        let mut row = json!({
            "u_px": centre.u_px, "v_px": centre.v_px, "sigma_px": centre.sigma_px,
            "laser": laser(centre.assigned), "wall": wall(centre.assigned),
        });
        if let (Some(row), Some(ridge)) = (row.as_object_mut(), perceived.ridge.get(i)) {
            row.insert("line".into(), ridge.line.into());
            row.insert("fwhm_px".into(), ridge.fwhm_px.into());
            row.insert("height_dn".into(), ridge.height_dn.into());
        }
        row
    };
    let line = |line: &StripeLine| {
        json!({
            "ends_px": line.ends_px, "points": line.points, "residual_px": line.residual_px,
            "laser": laser(line.assigned), "wall": wall(line.assigned),
        })
    };
    let plane = |plane: &SeenPlane| {
        json!({
            "wall": plane.wall.word(),
            "normal_in_camera": plane.plane.normal.as_slice(),
            "distance_m": plane.plane.distance_m,
            "sigma_m": plane.distance_sigma_m(),
            "points": plane.points,
        })
    };
    let measured = &perceived.measured;
    json!({
        "file": file.display().to_string(),
        "size_px": photograph.size_px(),
        "max_dn": photograph.max_dn(),
        "channel": channel.word(),
        "pipeline": scenario.map(|scenario| scenario.perception.pipeline.word()),
        "centres": perceived.centres.iter().enumerate().map(centre).collect::<Vec<_>>(),
        "lines": perceived.lines.iter().map(line).collect::<Vec<_>>(),
        "planes": perceived.planes.iter().map(plane).collect::<Vec<_>>(),
        "lateral_m": measured.lateral_m,
        "heading_rad": measured.heading_rad,
        "width_m": measured.width_m,
        "height_m": measured.height_m,
        "sigma": {
            "lateral_m": measured.deviation.lateral_m,
            "heading_rad": measured.deviation.heading_rad,
            "width_m": measured.deviation.width_m,
            "height_m": measured.deviation.height_m,
        },
        "perceive_ms": perceived.perceive_ms,
        "overlay": overlay.display().to_string(),
    })
}

/// The same in a few words.
pub(crate) fn words(file: &Path, overlay: &Path, perceived: &Perceived) -> String {
    let Perceived { centres, lines, planes, measured, wants_width, perceive_ms, .. } = perceived;
    let mut text = format!("{}: {} centres, {} lines", file.display(), centres.len(), lines.len());
    for plane in planes {
        let sigma = plane.distance_sigma_m().map_or(String::new(), |sigma| format!(" ± {}", number(sigma * 1e3, 2)));
        text += &format!("\n  {}: {}{sigma} mm from the camera", plane.wall.word(), number(plane.plane.distance_m * 1e3, 4));
    }
    let deviation = |sigma: Option<f64>, per_si: f64| sigma.map_or(String::new(), |s| format!(" ± {}", number(s * per_si, 2)));
    if let Some(lateral_m) = measured.lateral_m {
        text += &format!("\n  lateral {}{} mm", number(lateral_m * 1e3, 4), deviation(measured.deviation.lateral_m, 1e3));
    }
    if *wants_width {
        text +=
            "\n  lateral not known: one wall alone is seen, and the rig does not say how wide the duct is ([navigation] width_m)";
    }
    if let Some(heading_rad) = measured.heading_rad {
        let degrees = 180.0 / std::f64::consts::PI;
        text +=
            &format!("\n  heading {}{}°", number(heading_rad * degrees, 3), deviation(measured.deviation.heading_rad, degrees));
    }
    for (name, value, sigma) in
        [("width", measured.width_m, measured.deviation.width_m), ("height", measured.height_m, measured.deviation.height_m)]
    {
        if let Some(value) = value {
            text += &format!("\n  {name} {}{} mm", number(value * 1e3, 4), deviation(sigma, 1e3));
        }
    }
    if let Some(ms) = perceive_ms {
        text += &format!("\n  read in {} ms", number(*ms, 3));
    }
    text + &format!("\n  {}", overlay.display())
}
