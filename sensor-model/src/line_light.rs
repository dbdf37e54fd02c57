//! What a line that shines evenly in all directions gives the points of a plane: an integral in closed form, many points at a time.
//!
//! In single precision, the same bits whatever vectors a processor has: no fused multiplication, no sum but in the order that is written.

use nalgebra::Vector3;

use crate::bounce::{Knot, Line};

/// Points that are lit at a time.
pub(crate) const LANES: usize = 16;

/// A value of each point.
pub(crate) type Lanes = [f32; LANES];

/// A stripe as the points of one plane meet it, in single precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lighting {
    /// First end of the line.
    start: [f32; 3],
    along: [f32; 3],
    normal: [f32; 3],
    width_m2: f32,
    /// m . (start - x), the same for all x of the plane, and m . t.
    rise: f32,
    climb: f32,
    /// The part of the line before the plane, as ways from its first end.
    pub(crate) before: [f32; 2],
}

impl Lighting {
    /// For points on the plane `away . x = offset_m`, seen from the side that `away` points away from. None where all of the line is
    /// behind it, or where line and points are in one plane.
    pub(crate) fn new(line: &Line, away: &Vector3<f64>, offset_m: f64) -> Option<Self> {
        /// Lines nearer to the plane than this throughout are in it, in metres.
        const IN_PLANE_M: f64 = 1e-6;
        let length_m = (line.ends[1] - line.ends[0]).norm();
        let rise = offset_m - away.dot(&line.ends[0].coords);
        let climb = -away.dot(&line.along);
        let (first, last) = (rise, rise + climb * length_m);
        if first.max(last) < IN_PLANE_M {
            return None;
        }
        let crossing = -rise / climb;
        let before = [if first < 0.0 { crossing } else { 0.0 }, if last < 0.0 { crossing } else { length_m }];
        Some(Self {
            start: line.ends[0].coords.map(|c| c as f32).into(),
            along: line.along.map(|c| c as f32).into(),
            normal: line.normal.map(|c| c as f32).into(),
            width_m2: line.width_m2 as f32,
            rise: rise as f32,
            climb: climb as f32,
            before: before.map(|c| c as f32),
        })
    }
}

/// Adds the light of a line to points at (x, y, z), in metres; those whose distance from the line has a smaller square than `near_m2` are
/// lit as from that distance. With HIDDEN, only the part of the line from `part[0]` to `part[1]` is seen from each point.
///
/// For light that is linear between knots, light' being its slope, K = (a + b s) / (d^2 + s^2)^2, G its integral and H that of G:
///
/// ```text
/// integral of light K = [light G] - integral of light' G = [light G] - sum over knots of bend H
/// G = (a s / d^2 - b) / (2 (d^2 + s^2)) + a atan(s / d) / (2 d^3),    H = atan(s / d) (a s / d^2 - b) / (2 d)
/// ```
#[inline(always)]
pub(crate) fn shine<const HIDDEN: bool>(
    lighting: &Lighting,
    knots: &[Knot],
    [x, y, z, near_m2]: [&Lanes; 4],
    part: [&Lanes; 2],
    light: &mut Lanes,
) {
    let Lighting { start, along, normal, width_m2, rise, climb, .. } = *lighting;
    let [mut foot, mut height, mut inverse, mut share, mut sum] = [[0.0_f32; LANES]; 5];
    for i in 0..LANES {
        let way = [x[i] - start[0], y[i] - start[1], z[i] - start[2]];
        foot[i] = way[0] * along[0] + way[1] * along[1] + way[2] * along[2];
        let off = [0, 1, 2].map(|k| way[k] - foot[i] * along[k]);
        height[i] = way[0] * normal[0] + way[1] * normal[1] + way[2] * normal[2];
        let d2 = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        let d2 = larger(d2, near_m2[i]) + width_m2;
        inverse[i] = 1.0 / d2.sqrt();
        // a / d^2
        share[i] = (rise + climb * foot[i]) * (inverse[i] * inverse[i]);
    }
    let within = |at: f32, i: usize| if HIDDEN { smaller(larger(at, part[0][i]), part[1][i]) } else { at };
    for knot in knots {
        for i in 0..LANES {
            let s = within(knot.at_m, i) - foot[i];
            let angle = arctangent(s * inverse[i]) * inverse[i];
            sum[i] -= knot.bend * (angle * (share[i] * s - climb));
        }
    }
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    let mut lights = [[first.light; LANES], [last.light; LANES]];
    if HIDDEN {
        lights = [[first.light; LANES]; 2];
        for knot in &knots[..knots.len() - 1] {
            for (light, part) in lights.iter_mut().zip(part) {
                for i in 0..LANES {
                    light[i] -= knot.bend * larger(part[i] - knot.at_m, 0.0);
                }
            }
        }
    }
    for (end, sign) in [(0, -1.0_f32), (1, 1.0)] {
        let at_m = [first.at_m, last.at_m][end];
        for i in 0..LANES {
            let s = within(at_m, i) - foot[i];
            let cosine = s * inverse[i];
            let slanted = (share[i] * s - climb) * (inverse[i] * inverse[i]) / (1.0 + cosine * cosine);
            sum[i] += sign * lights[end][i] * (slanted + share[i] * (arctangent(cosine) * inverse[i]));
        }
    }
    for i in 0..LANES {
        // Half, from G and H; a point behind the line's sheet gets nothing.
        let lit = larger(0.5 * sum[i] * larger(height[i], 0.0), 0.0);
        light[i] += if HIDDEN && part[0][i] >= part[1][i] { 0.0 } else { lit };
    }
}

/// What `f32::max` is where nothing is NaN, in one instruction.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// What `f32::min` is where nothing is NaN, in one instruction.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// atan, within 4e-7: on [0, 1] an odd polynomial fitted for the smallest error (2.5e-7), beyond by atan(x) = pi/2 - atan(1/x).
#[inline(always)]
fn arctangent(x: f32) -> f32 {
    const C: [f32; 7] = [0.999_996_1, -0.333_173_7, 0.198_078_16, -0.132_333_42, 0.079_623_67, -0.033_604_22, 0.006_811_793];
    let size = x.abs();
    let steep = size > 1.0;
    let y = smaller(size, 1.0) / larger(size, 1.0);
    let y2 = y * y;
    let odd = y * (C[0] + y2 * (C[1] + y2 * (C[2] + y2 * (C[3] + y2 * (C[4] + y2 * (C[5] + y2 * C[6]))))));
    let angle = if steep { std::f32::consts::FRAC_PI_2 - odd } else { odd };
    angle.copysign(x)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn the_arctangent_is_as_good_as_it_says() {
        for i in -400_000..=400_000 {
            let x = f64::from(i) / 10_000.0;
            let worst = (f64::from(arctangent(x as f32)) - libm::atan(f64::from(x as f32))).abs();
            // Beyond 1, rounding of pi/2 - y adds 1.2e-7.
            assert!(worst < 4e-7, "{x}: {worst}");
        }
        assert!((f64::from(arctangent(1e30)) - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
    }

    /// A line of two pieces, hidden in part, against the sum over short pieces in double precision.
    #[test]
    fn the_integral_is_that_of_many_short_pieces() {
        let knots = [(0.0, 2.0), (0.3, 0.5), (1.1, 0.1)];
        // Slopes of -5 and -0.5.
        let bends = [5.0, -4.5, -0.5];
        let knots: Vec<Knot> =
            knots.iter().zip(bends).map(|(k, bend)| Knot { at_m: k.0 as f32, light: k.1 as f32, bend: bend as f32 }).collect();
        let start = Point3::new(0.2, -0.1, 0.4);
        let along = Vector3::new(0.3, 0.9, 0.2).normalize();
        let normal = along.cross(&Vector3::new(0.1, 0.2, 1.0)).normalize();
        // So thick that it matters to points 0.3 m away.
        const WIDTH_M2: f64 = 4e-3;
        let line =
            Line { ends: [start, start + along * 1.1], along, normal, cell: 0, width_m2: WIDTH_M2, power: 1.0, knots: 0..3 };
        // A wall 0.3 m or so from the line, facing it aslant.
        let away = (normal + along * 0.2).normalize();
        let offset_m = away.dot(&(start + normal * 0.3 + along * 0.2).coords);
        let (u, v) = (away.cross(&along).normalize(), away.cross(&away.cross(&along)).normalize());
        let lighting = Lighting::new(&line, &away, offset_m).expect("the line is before the wall");
        assert_eq!(lighting.before, [0.0, 1.1], "all of it is");
        let light_at = |s: f64| if s < 0.3 { 2.0 - 5.0 * s } else { 0.5 - 0.5 * (s - 0.3) };
        for part in [[0.0, 1.1], [0.1, 0.9], [0.35, 0.6], [0.7, 0.7]] {
            let base = Point3::from(away * offset_m);
            let points: Vec<_> =
                (0..LANES).map(|i| base + u * (0.1 * i as f64 - 0.5) + v * (0.07 * (i * 5 % 16) as f64 - 0.5)).collect();
            let lanes = |k: usize| -> Lanes { std::array::from_fn(|i| points[i][k] as f32) };
            let mut light = [0.0; LANES];
            let part_lanes = part.map(|p| [p as f32; LANES]);
            let place = [&lanes(0), &lanes(1), &lanes(2), &[0.0; LANES]];
            shine::<true>(&lighting, &knots, place, [&part_lanes[0], &part_lanes[1]], &mut light);
            if part == [0.0, 1.1] {
                let mut whole = [0.0; LANES];
                shine::<false>(&lighting, &knots, place, [&part_lanes[0], &part_lanes[1]], &mut whole);
                assert!(light.iter().zip(whole).all(|(a, b)| (a - b).abs() <= 1e-5 * b), "{light:?} {whole:?}");
            }
            for (point, light) in points.iter().zip(light) {
                const PIECES: usize = 20_000;
                let step = (part[1] - part[0]) / PIECES as f64;
                let sum: f64 = (0..PIECES)
                    .map(|i| {
                        let s = part[0] + (i as f64 + 0.5) * step;
                        let way = point - (start + along * s);
                        let (out, into) = (normal.dot(&way), away.dot(&way));
                        let r2 = way.norm_squared() + WIDTH_M2;
                        light_at(s) * out.max(0.0) * into / (r2 * r2) * step
                    })
                    .sum();
                // Single precision where large terms cancel: 1e-4 of what such a line gives a point straight before it.
                assert!((f64::from(light) - sum).abs() < 1e-3 * sum + 1e-4, "{part:?}: {light} against {sum}");
            }
        }
    }

    /// A wall lit by an endless line on the wall square to it: with both as far from their corner as `a` and `b`,
    /// `E = light a b / (a^2 + b^2)^(3/2) pi / 2`.
    #[test]
    fn an_endless_line_lights_the_wall_square_to_its_own() {
        const HALF_M: f64 = 400.0;
        for a in [0.002, 0.05, 0.25] {
            let start = Point3::new(a, 0.0, -HALF_M);
            let line = Line {
                ends: [start, start + Vector3::z() * (2.0 * HALF_M)],
                along: Vector3::z(),
                normal: Vector3::y(),
                cell: 0,
                width_m2: 0.0,
                power: 1.0,
                knots: 0..2,
            };
            let ends = [(0.0, 0.0), (2.0 * HALF_M as f32, 0.0)];
            let knots = ends.map(|(at_m, bend)| Knot { at_m, light: 1.5, bend });
            let lighting = Lighting::new(&line, &-Vector3::x(), 0.0).expect("the line is before the wall");
            let far: Lanes = std::array::from_fn(|i| 0.002 * (i as f32 + 1.0) * (i as f32 + 1.0));
            let (zero, mut light) = ([0.0; LANES], [0.0; LANES]);
            shine::<false>(&lighting, &knots, [&zero, &far, &zero, &zero], [&zero, &zero], &mut light);
            for (b, light) in far.iter().zip(light) {
                let b = f64::from(*b);
                let expected = 1.5 * a * b / libm::pow(a * a + b * b, 1.5) * std::f64::consts::FRAC_PI_2;
                // Single precision: some ten roundings.
                assert!((f64::from(light) / expected - 1.0).abs() < 2e-6, "{a}, {b}: {light} against {expected}");
            }
        }
    }
}
