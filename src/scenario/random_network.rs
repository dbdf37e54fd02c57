//! Networks drawn from a seed: `[duct.random]` becomes a run, branches and a route through them, as if they had been typed.
//!
//! A straight, a fitting, a straight, and so on, along a way; at a junction the way takes one exit at random, and every other exit
//! becomes a dead end. Whatever would overlap is drawn again, and a network that cannot go on is begun again. Numbers come from
//! SplitMix64 (Steele, Lea and Flood 2014), a stream a network, so that the same seed gives the same network to the bit.

use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{AcrossAlign, Fitting, Hand, Shape, UprightAlign};
use ductloop_duct::network::{End, Network, Turn};
use ductloop_sim::walls::Walls;

use super::check::Checked;
use super::diagnostic::Finding;
use super::fittings;
use super::layout::kind;
use super::model::{Branch, Duct, Piece, Route};
use super::resolve::default_of;
use super::source::Span;
use super::tree::{Entry, Node, Table, Value};
use super::typed::Typed;

/// Drawn again so often where something overlaps, before the whole network is begun again; and that so often.
const TRIES: usize = 24;
const BEGINNINGS: u64 = 200;
/// Turns of elbows, in degrees.
const ELBOWS_DEG: [f64; 4] = [30.0, 45.0, 60.0, 90.0];
/// Length of dead ends over the shortest straight.
const DEAD_END: f64 = 0.75;

/// What may be drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
    pub(super) seed: u64,
    pub(super) section_m: [f64; 2],
    /// Fewest and most fittings, straights and dead ends counted.
    pub(super) fittings: [usize; 2],
    /// Shortest and longest straight, in metres.
    pub(super) straight_m: [f64; 2],
    /// Widths that transitions lead to.
    pub(super) widths_m: Vec<f64>,
    /// Words for what stands between straights.
    pub(super) kinds: Vec<String>,
}

impl Wanted {
    /// A width from which no transition leads on, if the way can come to it: the duct's own, or the one that its transitions lead to
    /// where nothing but transitions is drawn.
    fn last_width_m(&self) -> Option<f64> {
        let [begin_m, _] = self.section_m;
        let leads_on = |from_m: f64| self.widths_m.iter().any(|width_m| *width_m != from_m);
        let is_alone = self.kinds.iter().all(|word| word == "transition");
        let first_m = self.widths_m.first().copied().filter(|_| is_alone && self.fittings[1] > 4);
        std::iter::once(begin_m).chain(first_m).find(|width_m| !leads_on(*width_m))
    }
}

struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// A whole number below `count`.
    fn below(&mut self, count: usize) -> usize {
        // The bias of so few values out of 2^64 is far below what could be noticed.
        (self.next() % count.max(1) as u64) as usize
    }

    /// A number between two, in steps of 50 mm: as ducts are cut, and short to write.
    fn length_m(&mut self, [low, high]: [f64; 2]) -> f64 {
        let steps = ((high - low) / 0.05 + 1e-9).floor() as usize;
        ((low + 0.05 * self.below(steps + 1) as f64) * 1e3).round() / 1e3
    }

    fn pick<'a, T>(&mut self, of: &'a [T]) -> Option<&'a T> {
        of.get(self.below(of.len()))
    }
}

/// A network in the making: a duct whose last run goes on.
#[derive(Clone)]
struct Growth {
    duct: Duct,
    /// Width where the way goes on.
    width_m: f64,
    /// How many fittings there are.
    count: usize,
}

impl Growth {
    fn name(&self, shape: &Shape) -> String {
        let word = kind(shape);
        let runs = std::iter::once(&self.duct.run).chain(self.duct.branches.iter().map(|branch| &branch.run));
        let earlier = runs.flatten().filter(|piece| kind(&piece.shape) == word).count();
        format!("{word}-{}", earlier + 1)
    }

    /// Puts a fitting at the end of a branch, by its index, or of the duct's own run; gives its name.
    fn put(&mut self, shape: Shape, run: Option<usize>) -> String {
        let name = self.name(&shape);
        let piece = Piece { name: name.clone(), ..Piece::new(shape, SurfaceId(0)) };
        match run.and_then(|branch| self.duct.branches.get_mut(branch)) {
            Some(branch) => branch.run.push(piece),
            None => self.duct.run.push(piece),
        }
        self.count += 1;
        name
    }

    /// Begins a branch.
    fn branch(&mut self, from: String, shape: Shape) {
        let name = self.name(&shape);
        let piece = Piece { name, ..Piece::new(shape, SurfaceId(0)) };
        self.duct.branches.push(Branch { from, run: vec![piece], to: None, end: End::Cap });
        self.count += 1;
    }

    fn is_possible(&self) -> bool {
        let Ok(layout) = self.duct.layout() else { return false };
        // Ducts may lie side by side, but with room between them for their sheets.
        Network::assemble(&layout.pieces, &layout.joins, &layout.ends).is_ok_and(|network| Walls::new(&network).is_ok())
    }
}

/// The network: run, branches and route; `None` if none was found.
pub(super) fn draw(wanted: &Wanted) -> Option<Duct> {
    (0..BEGINNINGS).find_map(|beginning| begin(wanted, &mut Draws(wanted.seed ^ beginning.wrapping_mul(0xd134_2543_de82_ef95))))
}

fn begin(wanted: &Wanted, draws: &mut Draws) -> Option<Duct> {
    let [least, most] = wanted.fittings;
    let aim = least + draws.below(most - least + 1);
    let duct = Duct {
        width_m: wanted.section_m[0],
        height_m: wanted.section_m[1],
        surface: SurfaceId(0),
        run: Vec::new(),
        branches: Vec::new(),
        route: Route::default(),
        entry: End::Cap,
        exit: End::Cap,
        bead_m: 0.0,
        bead_width_m: 0.0,
        objects: Vec::new(),
    };
    let mut growth = Growth { duct, width_m: wanted.section_m[0], count: 0 };
    // The branch that the way is in; none: the duct's own run.
    let mut run = None;
    growth.put(Shape::Straight { length_m: wanted.straight_m[1] }, run);
    while growth.count < aim {
        let mut grown = None;
        for _ in 0..TRIES {
            let mut next = growth.clone();
            let mut next_run = run;
            if step(&mut next, &mut next_run, wanted, draws, aim) && next.count <= aim && next.is_possible() {
                grown = Some((next, next_run));
                break;
            }
        }
        let (next, next_run) = grown?;
        (growth, run) = (next, next_run);
    }
    growth.duct.route.turns.push(Turn::Stop);
    growth.duct.network().ok().map(|_| growth.duct)
}

/// A fitting and a straight behind it; at a junction a straight behind each exit. False if that would be too many.
fn step(growth: &mut Growth, run: &mut Option<usize>, wanted: &Wanted, draws: &mut Draws, aim: usize) -> bool {
    let left = aim - growth.count;
    let straight = Shape::Straight { length_m: draws.length_m(wanted.straight_m) };
    if left == 1 {
        growth.put(straight, *run);
        return true;
    }
    let Some(shape) = draws.pick(&wanted.kinds).and_then(|word| shape(word, growth, wanted, draws)) else { return false };
    let fitting = Fitting { shape, width_m: growth.width_m, height_m: wanted.section_m[1], surface: SurfaceId(0) };
    let exits: Vec<PortName> = fitting.ports().iter().map(|port| port.name).filter(|name| *name != PortName::In).collect();
    if 1 + exits.len() > left {
        return false;
    }
    let name = growth.put(shape, *run);
    let Some(&way) = draws.pick(&exits) else { return false };
    if exits.len() > 1 {
        growth.duct.route.turns.push(match way {
            PortName::Left => Turn::Left,
            PortName::Right => Turn::Right,
            _ => Turn::Straight,
        });
    }
    let here = *run;
    for exit in exits {
        let length_m = if exit == way { None } else { Some(DEAD_END * wanted.straight_m[0]) };
        let behind = length_m.map_or(straight, |length_m| Shape::Straight { length_m });
        if exit == PortName::Out {
            growth.put(behind, here);
        } else {
            growth.branch(format!("{name}.{exit}"), behind);
            if exit == way {
                *run = Some(growth.duct.branches.len() - 1);
            }
        }
        if exit == way {
            growth.width_m = fitting.port(exit).map_or(growth.width_m, |port| port.width_m);
        }
    }
    true
}

fn shape(word: &str, growth: &Growth, wanted: &Wanted, draws: &mut Draws) -> Option<Shape> {
    let width_m = growth.width_m;
    let side = if draws.below(2) == 0 { 1.0 } else { -1.0 };
    let hand = if side > 0.0 { Hand::Left } else { Hand::Right };
    let angle_rad = side * draws.pick(&ELBOWS_DEG)?.to_radians();
    Some(match word {
        "elbow" => Shape::RadiusElbow { angle_rad, throat_radius_m: fittings::THROAT_RATIO * width_m },
        "mitre" => Shape::MitredElbow { angle_rad },
        "offset" => Shape::Offset { aside_m: side * 0.5 * width_m, length_m: 2.0 * width_m },
        "transition" => {
            let others: Vec<f64> = wanted.widths_m.iter().copied().filter(|other| *other != width_m).collect();
            let to_width_m = *draws.pick(&others)?;
            // 20 degrees a side, rounded up to 50 mm: what contractions in ducts have at most.
            let drawn_in_m = (width_m - to_width_m).abs() / 2.0;
            let length_m = ((drawn_in_m / libm::tan(20_f64.to_radians()) / 0.05).ceil() * 50.0).max(50.0) / 1e3;
            Shape::Transition {
                length_m,
                to_width_m,
                to_height_m: wanted.section_m[1],
                across: AcrossAlign::Concentric,
                upright: UprightAlign::FlatBottom,
            }
        }
        "slope" => Shape::Slope { length_m: 1.0, angle_rad: side * 5_f64.to_radians() },
        "tee" => Shape::Tee { hand, branch_width_m: width_m },
        "bullhead" => Shape::BullheadTee { branch_width_m: width_m },
        "side-branch" => Shape::SideBranch { hand, branch_width_m: width_m, shoe_m: 0.25 * width_m },
        "wye" => Shape::Wye { half_angle_rad: 45_f64.to_radians(), branch_width_m: width_m },
        _ => Shape::Cross { branch_width_m: width_m },
    })
}

/// Puts run, branches and route in the place of `[duct.random]`.
pub(super) fn lay(layered: &mut Table, typed: &Typed, checked: &mut Checked) {
    const TABLE: &str = "duct.random";
    let Some(random) = layered.at(TABLE).and_then(Node::as_table).cloned() else { return };
    let beside: Vec<&str> =
        ["duct.run", "duct.branch", "route.turns"].into_iter().filter(|path| layered.at(path).is_some()).collect();
    for path in &beside {
        let finding = Finding::new(typed.span(path), format!("`{path}` beside `[{TABLE}]`, which draws it"))
            .help(format!("take one of the two out; resolved, `[{TABLE}]` is a run with branches and a route"))
            .also(typed.span(TABLE), format!("`[{TABLE}]` is here"));
        checked.wrong(path, finding);
    }
    if !beside.is_empty() {
        // Nothing is drawn, and no run is missed.
        checked.wrong.insert("duct.run".to_owned());
        return;
    }
    if !checked.is_sound(&[TABLE, "duct.width_m", "duct.height_m", "seed"]) {
        // Something for what rests on a run; the error has been told.
        checked.wrong.insert("duct.run".to_owned());
        return;
    }
    let node = |key: &str| random.get(key).cloned().or_else(|| default_of(&format!("{TABLE}.{key}")));
    let numbers = |key: &str| -> Vec<f64> {
        let node = node(key);
        node.as_ref().and_then(Node::as_list).unwrap_or_default().iter().filter_map(Node::as_number).collect()
    };
    let pair = |key: &str| match numbers(key)[..] {
        [low, high] => [low, high],
        _ => [0.0; 2],
    };
    let number = |path: &str| layered.at(path).and_then(Node::as_number);
    let own_seed = random.get("seed").and_then(Node::as_integer);
    let seed = own_seed.or_else(|| layered.at("seed").and_then(Node::as_integer)).or_else(|| default_of("seed")?.as_integer());
    let (Some(width_m), Some(height_m)) = (number("duct.width_m"), number("duct.height_m")) else {
        checked.wrong.insert("duct.run".to_owned());
        return;
    };
    let [least, most] = pair("fittings");
    let wanted = Wanted {
        seed: seed.unwrap_or_default().unsigned_abs(),
        section_m: [width_m, height_m],
        fittings: [least as usize, most as usize],
        straight_m: pair("straight_m"),
        widths_m: numbers("widths_m"),
        kinds: node("kinds")
            .as_ref()
            .and_then(Node::as_list)
            .unwrap_or_default()
            .iter()
            .filter_map(|word| word.as_text().map(str::to_owned))
            .collect(),
    };
    let span = |key: &str| typed.span(&format!("{TABLE}.{key}"));
    for (key, [low, high]) in [("fittings", [least, most]), ("straight_m", wanted.straight_m)] {
        if low > high {
            let finding = Finding::new(span(key), format!("`{TABLE}.{key}` goes from {low} to {high}"));
            checked.wrong("duct.run", finding.help("the smaller one comes first"));
            return;
        }
    }
    if wanted.kinds.is_empty() {
        let finding = Finding::new(span("kinds"), format!("`{TABLE}.kinds` is empty: nothing would stand between the straights"));
        checked
            .wrong("duct.run", finding.help("one word or more, as in `kinds = [\"elbow\", \"tee\"]`; or leave it out for a mix"));
        return;
    }
    if random.get("kinds").is_some()
        && let Some(at) = wanted.kinds.iter().position(|word| word == "transition")
        && let Some(width_m) = wanted.last_width_m()
    {
        let message = format!(
            "`{TABLE}.kinds` has \"transition\", but where the duct is {width_m} m wide there is no other width to go to"
        );
        let kind = typed.span(&format!("{TABLE}.kinds[{at}]"));
        let finding = Finding::new(kind, message).help(format!("another width in `{TABLE}.widths_m`, or `kinds` without it"));
        let widths = random.get("widths_m").map(|node| (node.span, "these are the widths"));
        let finding = widths.into_iter().fold(finding, |finding, (span, what)| finding.also(span, what));
        checked.wrong("duct.run", finding.also(typed.span("duct.width_m"), "here the duct begins"));
        return;
    }
    let Some(duct) = draw(&wanted) else {
        let count = if least == most { format!("{most}") } else { format!("{least} to {most}") };
        let seed = wanted.seed;
        let message = format!("`[{TABLE}]` with seed {seed}: no network of {count} fittings was found in which nothing overlaps");
        let help = "fewer fittings, longer straights, or more `kinds`";
        checked.wrong("duct.run", Finding::new(typed.span(TABLE), message).help(help));
        return;
    };
    put(layered, &duct, typed.span(TABLE));
}

fn put(layered: &mut Table, duct: &Duct, span: Span) {
    let node = |value| Node { value, span };
    let table = |entries: Vec<(&str, Value)>| {
        let entries = entries.into_iter().map(|(key, value)| Entry { key: key.to_owned(), key_span: span, node: node(value) });
        node(Value::Table(Table { entries: entries.collect() }))
    };
    let run = |pieces: &[Piece]| {
        let piece = |piece: &Piece| {
            let name = ("name", Value::Text(piece.name.clone()));
            table(std::iter::once(name).chain(fittings::write(&piece.shape)).collect())
        };
        Value::List(pieces.iter().map(piece).collect())
    };
    let branch = |branch: &Branch| {
        let end = Value::Text("cap".to_owned());
        table(vec![("from", Value::Text(branch.from.clone())), ("end", end), ("run", run(&branch.run))])
    };
    let turns = duct.route.turns.iter().map(|turn| node(Value::Text(turn.as_str().to_owned()))).collect();
    layered.put("duct.run", run(&duct.run));
    layered.put("duct.branch", Value::List(duct.branches.iter().map(branch).collect()));
    // What explores takes no turns.
    if layered.at("route.explore").is_none_or(|node| node.value != Value::Flag(true)) {
        layered.put("route.turns", Value::List(turns));
    }
    if layered.at("duct.exit").is_none() {
        layered.put("duct.exit", Value::Text("cap".to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(seed: u64) -> Wanted {
        let kinds = ["elbow", "mitre", "tee", "side-branch", "cross", "wye", "bullhead", "transition", "offset", "slope"];
        Wanted {
            seed,
            section_m: [0.5, 0.3],
            fittings: [10, 20],
            straight_m: [1.0, 2.5],
            widths_m: vec![0.4, 0.5, 0.6],
            kinds: kinds.map(str::to_owned).into(),
        }
    }

    #[test]
    fn each_seed_gives_a_network_of_its_own_that_fits_and_is_the_same_each_time() {
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..200 {
            let duct = draw(&wanted(seed)).unwrap_or_else(|| panic!("seed {seed} gave none"));
            let network = duct.network().unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            assert!((10..=20).contains(&network.fittings.len()), "seed {seed}: {}", network.fittings.len());
            assert!(Walls::new(&network).is_ok(), "seed {seed}: sheets reach into other ducts");
            assert_eq!(duct.route.turns.last(), Some(&Turn::Stop));
            let again = draw(&wanted(seed)).map(|duct| duct.network());
            assert_eq!(again, Some(Ok(network.clone())), "seed {seed}");
            seen.insert(format!("{:?}", network.centreline));
        }
        assert!(seen.len() > 195, "{} different ones", seen.len());
    }
}
