//! Parameters of the paper's perception chain, stage by stage.

use ductloop_nav::perception::paper::{LineFit, PlaneFit};

use super::field::Slot;
use super::{Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] =
    &[TableRow::new("perception.paper", "The paper's chain: threshold, opening and closing, thinning, Hough, lines, planes.")];

pub(super) const FIELDS: &[Field] = &[
    Field::number("perception.paper.threshold_dn", 0.1, 255.0, |s| &mut s.perception.paper.threshold_dn)
        .unit("DN")
        .default("6.0")
        .about("How far above its background a stripe's pixel must stand."),
    Field::number("perception.paper.nearest_wall_m", 0.05, 5.0, |s| &mut s.perception.paper.nearest_wall_m)
        .unit("m")
        .default("0.25")
        .about(
            "Depth of the nearest wall that stripes are sought on: the background is taken from beyond their thickness there.",
        ),
    Field::size("perception.paper.background_window_px", 1, 200, |s| &mut s.perception.paper.background_window_px)
        .unit("px")
        .default("6")
        .about("Pixels in each of these windows."),
    Field::new(
        "perception.paper.opening_px",
        Kind::Integers { len: 2, min: 1, max: 63 },
        Slot::Sizes(|s| &mut s.perception.paper.opening_px),
    )
    .unit("px")
    .default("[3, 3]")
    .about("Sides of the opening's element, along and across the stripe, odd."),
    Field::new(
        "perception.paper.closing_px",
        Kind::Integers { len: 2, min: 1, max: 63 },
        Slot::Sizes(|s| &mut s.perception.paper.closing_px),
    )
    .unit("px")
    .default("[3, 3]")
    .about("Sides of the closing's element, along and across the stripe, odd."),
    Field::numbers("perception.paper.thickness_ratio", 2, 0.01, 100.0, |s| &mut s.perception.paper.thickness_ratio)
        .default("[0.5, 2.0]")
        .about("Thinnest and thickest run of pixels taken for a stripe, as shares of the expected thickness."),
    Field::number("perception.paper.psf_sigma_px", 0.0, 10.0, |s| &mut s.perception.paper.psf_sigma_px)
        .unit("px")
        .default("0.6")
        .about("The lens' point spread as the navigator knows it, for the expected thickness."),
    Field::number("perception.paper.hough_r_px", 0.1, 20.0, |s| &mut s.perception.paper.hough_r_px)
        .unit("px")
        .default("1.0")
        .about("Width of a Hough bin in r."),
    Field::number("perception.paper.hough_theta_deg", 0.05, 10.0, |s| &mut s.perception.paper.hough_theta_rad)
        .degrees()
        .default("1.0")
        .about("Width of a Hough bin in theta."),
    Field::size("perception.paper.min_points", 2, 8192, |s| &mut s.perception.paper.min_points)
        .default("30")
        .about("Fewest points that make a line."),
    Field::number("perception.paper.inlier_px", 0.1, 20.0, |s| &mut s.perception.paper.inlier_px)
        .unit("px")
        .default("1.5")
        .about("Distance within which a point belongs to a refitted line."),
    Field::word(
        "perception.paper.line_fit",
        &["least-squares", "hough-peak"],
        |s| match s.perception.paper.line_fit {
            LineFit::LeastSquares => "least-squares",
            LineFit::HoughPeak => "hough-peak",
        },
        |s, word| {
            s.perception.paper.line_fit = if word == "hough-peak" { LineFit::HoughPeak } else { LineFit::LeastSquares };
        },
    )
    .default("\"least-squares\"")
    .about("What a line is made from: the sub-pixel centres that Hough selected, or, as in the paper, the Hough bin itself."),
    Field::word(
        "perception.paper.plane_fit",
        &["joint", "cross-product"],
        |s| match s.perception.paper.plane_fit {
            PlaneFit::Joint => "joint",
            PlaneFit::CrossProduct => "cross-product",
        },
        |s, word| {
            s.perception.paper.plane_fit = if word == "cross-product" { PlaneFit::CrossProduct } else { PlaneFit::Joint };
        },
    )
    .default("\"joint\"")
    .about("What a wall's plane is made from: the points of both stripes, or, as in the paper, the two lines' directions."),
    Field::number("perception.paper.max_heading_deg", 1.0, 89.0, |s| &mut s.perception.paper.max_heading_rad)
        .degrees()
        .default("35.0")
        .about("Largest heading against a wall that is taken for one."),
];
