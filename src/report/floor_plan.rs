//! What plans of ducts have in common: from metres to pixels, and outlines of what is drawn.

use std::fmt::Write;

use ductloop_duct::cell::Face;
use ductloop_duct::network::Network;
use nalgebra::{Point2, Point3};

use super::ticks::step;

/// A scale bar is at least so long, in pixels.
const BAR: f64 = 60.0;

/// The room that a drawing has, in pixels.
pub(super) struct Room {
    /// Its least and its greatest width.
    pub(super) width: [f64; 2],
    /// Its greatest height.
    pub(super) height_max: f64,
    /// Space around the network.
    pub(super) margin: f64,
    /// More space below it.
    pub(super) below: f64,
    /// The most pixels a metre.
    pub(super) per_m_max: f64,
}

/// From metres in the world to pixels.
pub(super) struct Scale {
    pub(super) per_m: f64,
    left_m: f64,
    top_m: f64,
    margin: f64,
    /// Size of the drawing, in pixels.
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Scale {
    /// As large as there is room for; in the middle where the height decides.
    pub(super) fn of(network: &Network, room: &Room) -> Self {
        let corners = || network.cells.iter().flat_map(|cell| cell.faces.iter().flat_map(|face| &face.outline));
        let least = |coordinate: fn(&Point3<f64>) -> f64| corners().map(coordinate).fold(f64::INFINITY, f64::min);
        let (left, right) = (least(|p| p.x), -least(|p| -p.x));
        let (bottom, top) = (least(|p| p.y), -least(|p| -p.y));
        let [width_min, width_max] = room.width;
        let margins = 2.0 * room.margin;
        let across = (width_max - margins) / (right - left);
        let per_m = across.min((room.height_max - margins) / (top - bottom)).min(room.per_m_max);
        let width = ((right - left) * per_m + margins).max(width_min);
        let spare_m = (width - margins) / per_m - (right - left);
        let height = (top - bottom) * per_m + margins + room.below;
        Self { per_m, left_m: left - spare_m / 2.0, top_m: top, margin: room.margin, width, height }
    }

    pub(super) fn at(&self, p: &Point2<f64>) -> [f64; 2] {
        [self.margin + (p.x - self.left_m) * self.per_m, self.margin + (self.top_m - p.y) * self.per_m]
    }

    pub(super) fn path(&self, points: impl IntoIterator<Item = Point2<f64>>, closed: bool) -> String {
        let mut path = String::new();
        for (i, point) in points.into_iter().enumerate() {
            let [u, v] = self.at(&point);
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{u:.1} {v:.1}", if i == 0 { 'M' } else { 'L' });
        }
        if closed { path + "Z" } else { path }
    }

    /// A round length for a scale bar, in metres.
    pub(super) fn bar_m(&self) -> f64 {
        step(BAR / self.per_m)
    }
}

/// The convex outline of points from above, anticlockwise (Andrew's monotone chain).
pub(super) fn hull(points: &[Point3<f64>]) -> Vec<Point2<f64>> {
    let mut sorted: Vec<Point2<f64>> = points.iter().map(Point3::xy).collect();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(point - a)) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        // The last point is the first of the other chain.
        chain.pop();
        chain
    };
    let mut outline = chain(&mut sorted.iter().copied());
    outline.extend(chain(&mut sorted.iter().rev().copied()));
    outline
}

/// What of a wall's plan is sheet metal: its length without its portals.
pub(super) fn wall_pieces(face: &Face) -> Vec<[Point2<f64>; 2]> {
    let along = nalgebra::Vector2::new(-face.plane.normal.y, face.plane.normal.x);
    let span = |outline: &[Point3<f64>]| {
        let places = || outline.iter().map(|p| p.xy().coords.dot(&along));
        [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
    };
    let Some(first) = face.outline.first() else { return Vec::new() };
    let at = |place: f64| first.xy() + along * (place - first.xy().coords.dot(&along));
    let mut portals: Vec<[f64; 2]> = face.portals.iter().map(|portal| span(&portal.outline)).collect();
    portals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [mut from, to] = span(&face.outline);
    let mut pieces = Vec::new();
    for [opens, closes] in portals.into_iter().chain([[to, to]]) {
        if opens > from + 1e-6 {
            pieces.push([at(from), at(opens)]);
        }
        from = f64::max(from, closes);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use ductloop_duct::cell::{Beyond, Cell, Portal, Side, SurfaceId};

    /// A duct of 10 m by 0.5 m in a drawing of 1000 pixels with a margin of 50, and in one that gives 20 pixels a metre at most.
    #[test]
    fn a_network_fills_the_room_that_it_has() {
        let text =
            "format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 10.0 }]";
        let network = Scenario::from_toml_str(text).ok().and_then(|scenario| scenario.duct.network().ok()).expect("a duct");
        let wide = Room { width: [1000.0; 2], height_max: 560.0, margin: 50.0, below: 16.0, per_m_max: f64::INFINITY };
        let scale = Scale::of(&network, &wide);
        assert!((scale.per_m - 90.0).abs() < 1e-9 && (scale.width - 1000.0).abs() < 1e-9);
        assert!((scale.height - (0.5 * 90.0 + 100.0 + 16.0)).abs() < 1e-9 && scale.bar_m() == 1.0);
        let [u, v] = scale.at(&Point2::new(10.0, -0.25));
        assert!((u - 950.0).abs() < 1e-9 && (v - 95.0).abs() < 1e-9, "{u} {v}");
        // 200 pixels long, in the middle of the least width.
        let small = Scale::of(&network, &Room { width: [460.0, 1200.0], per_m_max: 20.0, ..wide });
        let [from, to] = [0.0, 10.0].map(|x| small.at(&Point2::new(x, 0.0))[0]);
        assert!((small.width - 460.0).abs() < 1e-9 && (from - 130.0).abs() < 1e-9 && (to - 330.0).abs() < 1e-9, "{from} {to}");
    }

    #[test]
    fn the_outline_of_a_box_from_above_has_its_four_corners() {
        // Turned, so that the lower and the upper corners differ by rounding only.
        let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), 0.3);
        let corners = (0..8).map(|i| turn * Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let outline = hull(&corners.collect::<Vec<_>>());
        let area = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| a.coords.perp(&b.coords)).sum::<f64>() / 2.0;
        assert!((area - 1.0).abs() < 1e-12, "{area}");
        assert!((4..=8).contains(&outline.len()), "{outline:?}");
    }

    #[test]
    fn a_wall_is_drawn_without_its_openings() {
        let plan = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point2::new(x, y));
        let outside = Side::Portal(Beyond::Outside);
        let mut cell = Cell::prism(&plan, 0.3, &[Side::Wall, outside, Side::Wall, outside], SurfaceId(0), 0);
        assert_eq!(wall_pieces(&cell.faces[2]), [[plan[0], plan[1]]]);
        assert!(wall_pieces(&cell.faces[3]).is_empty());
        let opening = [[0.5, 0.0], [0.8, 0.0], [0.8, 0.3], [0.5, 0.3]].map(|[x, z]| Point3::new(x, 0.0, z));
        let plane = cell.faces[2].plane;
        cell.faces[2].portals.push(Portal::new(&plane, opening.to_vec(), Beyond::Outside));
        let pieces: Vec<_> = wall_pieces(&cell.faces[2]).iter().map(|[a, b]| [a.x, b.x]).collect();
        for (piece, expected) in pieces.iter().zip([[0.0, 0.5], [0.8, 2.0]]) {
            assert!((piece[0] - expected[0]).abs() < 1e-12 && (piece[1] - expected[1]).abs() < 1e-12, "{pieces:?}");
        }
        assert_eq!(pieces.len(), 2);
    }
}
