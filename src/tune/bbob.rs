//! Our evolution strategy beside published ones: evaluations on functions of the BBOB testbed in ten dimensions, to 1e-8 above the least.
//!
//! Functions: N. Hansen, S. Finck, R. Ros and A. Auger, *Real-Parameter Black-Box Optimization Benchmarking 2009: Noiseless Functions
//! Definitions*, INRIA RR-6829. Published: the data of R. Ros and N. Hansen's entries of 2010, IPOP-CMA-ES and, with negative weights as ours,
//! IPOP-ACTCMA-ES, 15 runs each, as the package cocopp 2.9.1 of the COCO platform holds them (`pprldistrever_1e-8.pickle.gz`); expected
//! running times are evaluations over successes, computed from these. Ours begin as BBOB's entries of CMA-ES are commonly begun, anywhere in
//! [-4, 4]^10 with a step size of 2; how those were is not in the data.

use super::restarts::{Rest, Restarts};
use crate::stream::{normal, uniform};

const DIMENSIONS: usize = 10;
const TARGET: f64 = 1e-8;
/// Evaluations after which a run is given up.
const MOST: u64 = 600_000;
/// First step size.
const SIGMA: f64 = 2.0;
/// A box that is none: half its width.
const WIDE: f64 = 20.0;
/// Streams of random numbers: where the least lies, beginnings, rotations.
const LEAST: u64 = 1 << 20;
const BEGINNING: u64 = 2 << 20;
const ROTATION: u64 = 3 << 20;

/// Anywhere in [-4, 4]^10.
fn anywhere(seed: u64, stream: u64) -> Vec<f64> {
    (0..DIMENSIONS as u64).map(|i| 8.0 * uniform(seed, i, stream) - 4.0).collect()
}

/// A rotation: normal columns, made orthogonal one after the other (Gram and Schmidt).
fn rotation(seed: u64) -> Vec<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for row in 0..DIMENSIONS as u64 {
        let mut new: Vec<f64> = (0..DIMENSIONS as u64).map(|i| normal(seed, row * 100 + i, ROTATION)).collect();
        for other in &rows {
            let share = dot(&new, other);
            new.iter_mut().zip(other).for_each(|(new, other)| *new -= share * other);
        }
        let length = dot(&new, &new).sqrt();
        rows.push(new.iter().map(|new| new / length).collect());
    }
    rows
}

fn rotated(rows: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    rows.iter().map(|row| row.iter().zip(x).map(|(row, x)| row * x).sum()).collect()
}

/// T_osz of the definitions: a smooth curve becomes a wavy one.
fn wavy(x: f64) -> f64 {
    if x == 0.0 {
        return 0.0;
    }
    let log = libm::log(x.abs());
    let (c1, c2) = if x > 0.0 { (10.0, 7.9) } else { (5.5, 3.1) };
    libm::exp(log + 0.049 * (libm::sin(c1 * log) + libm::sin(c2 * log))).copysign(x)
}

/// Place of a coordinate, 0 to 1.
fn share(i: usize) -> f64 {
    i as f64 / (DIMENSIONS - 1) as f64
}

/// f1, the sphere; with the least at zero, as all of these.
fn sphere(z: &[f64]) -> f64 {
    z.iter().map(|z| z * z).sum()
}

/// f2, the separable ellipsoid; f10 is the same rotated.
fn ellipsoid(z: &[f64]) -> f64 {
    z.iter().enumerate().map(|(i, z)| libm::pow(1e6, share(i)) * wavy(*z) * wavy(*z)).sum()
}

/// f8, Rosenbrock's function.
fn rosenbrock(z: &[f64]) -> f64 {
    let pairs = z.windows(2).map(|pair| (pair[0] + 1.0, pair[1] + 1.0));
    pairs.map(|(a, b)| 100.0 * (a * a - b) * (a * a - b) + (a - 1.0) * (a - 1.0)).sum()
}

/// f15, Rastrigin's function, rotated, wavy and asymmetric: R Λ^10 Q T_asy^0.2 T_osz R, whose last rotation matters since the cosine is taken of
/// each coordinate.
fn rastrigin(r: &[Vec<f64>], q: &[Vec<f64>], x: &[f64]) -> f64 {
    let asymmetric = |(i, z): (usize, f64)| if z > 0.0 { libm::pow(z, 1.0 + 0.2 * share(i) * z.sqrt()) } else { z };
    let y: Vec<f64> = rotated(r, x).into_iter().map(wavy).enumerate().map(asymmetric).collect();
    let y: Vec<f64> = rotated(q, &y).into_iter().enumerate().map(|(i, y)| libm::pow(10.0, 0.5 * share(i)) * y).collect();
    let cosine = |z: &f64| libm::cos(2.0 * std::f64::consts::PI * z);
    rotated(r, &y).iter().map(|z| 10.0 * (1.0 - cosine(z)) + z * z).sum()
}

/// Evaluations over successes of `runs` runs, each of which gives its evaluations and whether it came to the target.
fn expected_running_time(runs: u64, run: impl Fn(u64) -> (u64, bool)) -> f64 {
    let all: Vec<(u64, bool)> = (0..runs).map(run).collect();
    let successes = all.iter().filter(|(_, hit)| *hit).count();
    all.iter().map(|(evaluations, _)| *evaluations as f64).sum::<f64>() / successes as f64
}

/// Searches, beginning again where it rests, for the least at `least` of a function, in the box [-half, half]^10.
fn run(half: f64, least: &[f64], cost: impl Fn(&[f64]) -> f64, seed: u64) -> (u64, bool) {
    let start = anywhere(seed, BEGINNING).iter().map(|x| 0.5 + 0.5 * x / half).collect();
    let mut search = Restarts::new(start, 0.5 * SIGMA / half, Rest { step: 1e-12, cost: 1e-12 }, seed);
    let mut evaluations = 0;
    while evaluations < MOST {
        let mut costs = Vec::new();
        for point in search.ask() {
            evaluations += 1;
            let z: Vec<f64> = point.iter().zip(least).map(|(share, least)| half * (2.0 * share - 1.0) - least).collect();
            costs.push(cost(&z));
            if costs.last().is_some_and(|cost| *cost <= TARGET) {
                return (evaluations, true);
            }
        }
        search.tell(&costs);
    }
    (evaluations, false)
}

/// At most 1.3 times what either published entry took, on functions of one minimum (Rosenbrock's has a second, from which one run in a few
/// begins again); in a box that is wide, as these were not held in one.
#[test]
fn it_takes_no_more_evaluations_than_were_published() {
    let of = |cost: fn(&[f64]) -> f64, share: f64| {
        let least = move |seed| anywhere(seed, LEAST).iter().map(|x| share * x).collect::<Vec<_>>();
        expected_running_time(25, move |seed| run(WIDE, &least(seed), cost, seed))
    };
    let turned = expected_running_time(25, |seed| {
        let rows = rotation(seed);
        run(WIDE, &anywhere(seed, LEAST), move |z| ellipsoid(&rotated(&rows, z)), seed)
    });
    for (name, published, active, ours) in [
        ("f1 sphere", 1436.0, 1478.0, of(sphere, 1.0)),
        ("f2 ellipsoid", 5961.0, 4565.0, of(ellipsoid, 1.0)),
        ("f10 ellipsoid, rotated", 5997.0, 4499.0, turned),
        ("f8 Rosenbrock", 6004.0, 6287.0, of(rosenbrock, 0.75)),
    ] {
        println!("{name}: {ours:.0}, published {published} and {active}");
        assert!(ours <= 1.3 * f64::min(published, active), "{name}: {ours:.0} against {published} and {active}");
    }
}

/// Rastrigin's function takes restarts: published 68 761 and 69 801, from 14 884 to 155 383 a run. Here it is held in the testbed's domain
/// [-5, 5]^10, near whose sides the least may lie.
#[test]
fn restarts_take_no_more_evaluations_than_were_published() {
    let ours = expected_running_time(30, |seed| {
        let (r, q) = (rotation(seed), rotation(seed + 1000));
        run(5.0, &anywhere(seed, LEAST), move |z| rastrigin(&r, &q, z), seed)
    });
    println!("f15 Rastrigin: {ours:.0}");
    assert!(ours <= 1.3 * 68_761.0, "{ours:.0}");
}
