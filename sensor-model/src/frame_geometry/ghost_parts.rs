//! Which part of a ghost needs every pixel, and for which the glow's nodes are enough.
//!
//! A ghost of a rough wall is narrow only where it starts, at the corner where the two walls meet, and widens from there. Where linear
//! interpolation between nodes is right to [`SMOOTH_DN`] it goes to them: cut in two by an edge across it which the roughness
//! softens like its other edges, so that the two parts add up. A ghost that widens faster than it gets longer cannot be cut so, and
//! is narrow for some pixels only: all of it goes to the nodes, blurred as far as they need.

use nalgebra::{Vector2, Vector3};

use super::{FrameGeometry, GLOW_SPACING_PX};
use crate::band::Middle;
use crate::coverage::Edge;
use crate::strip::{MirroredWay, PixelRay, SQRT_TAU, Strip};

/// Ghosts that nowhere reach this grey value are left out.
const FAINT_DN: f64 = 0.02;

/// The same for light on nodes, of which there is more: it is spread wide, and hardly any eye or algorithm finds an edge in it.
const FAINT_SMOOTH_DN: f64 = 0.04;

/// What interpolation between nodes may be wrong by, in grey values.
const SMOOTH_DN: f64 = 0.1;

/// A Gaussian of height 1 and standard deviation q pixels, interpolated linearly between nodes, is wrong by at most this over q^2: an
/// eighth of the spacing's square times the second derivative.
const INTERPOLATION_PX2: f64 = (GLOW_SPACING_PX * GLOW_SPACING_PX) as f64 / 8.0;

/// A ghost under construction: the strip without edges, holes and band; the piece of sheet is in `FrameGeometry::points`, the edges in
/// `Ghosts`.
pub(super) struct Draft {
    pub(super) strip: Strip,
    /// Normal of the laser's plane, mirrored like it.
    pub(super) laser: Vector3<f64>,
    /// The region in which it is seen.
    pub(super) region: usize,
    /// Strength times power, in DN m^2.
    pub(super) strength: f64,
}

/// A ghost divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    /// What nodes are enough for; none where that is too faint.
    pub(super) smooth: [Option<SmoothPart>; 2],
    /// What needs every pixel, as shares of the middle's length.
    pub(super) sharp: Option<[f64; 2]>,
}

/// The part of a ghost on one side of a cut: the share of the middle's length where it is, and 1 where the part is toward the end, -1
/// toward the beginning. All of the ghost without a cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothPart {
    pub(super) cut: Option<(f64, f64)>,
    /// Whether some of it is narrower than nodes can show.
    pub(super) coarse: bool,
}

/// How bright and how wide a ghost is at a place.
#[derive(Clone, Copy, Debug)]
struct Level {
    peak_dn: f64,
    smooth: bool,
    /// Softness of its edges.
    soft_px: f64,
}

impl FrameGeometry {
    /// Looks along a ghost for where it is bright and narrow. `window` is what it is seen through.
    pub(super) fn parts(&self, draft: &Draft, middle: &Middle, window: &[Edge]) -> Parts {
        /// Places looked at where every pixel may be needed, and on each side of that; halvings of the distance between two where narrow
        /// turns wide.
        const PLACES: usize = 8;
        const BESIDE: usize = 2;
        const HALVINGS: usize = 3;
        /// Length of a narrow part, in its cuts' softness, from which on cutting it off is of use.
        const LONG_SOFTNESSES: f64 = 2.0;
        /// Between three places a ghost is nowhere so many times brighter than at the brightest of them.
        const HOPELESS: f64 = 4.0;
        let level = |share: f64| self.level(draft, middle, share);
        // Most ghosts are far too faint: three places tell.
        if [0.0, 0.5, 1.0].into_iter().all(|share| level(share).peak_dn < FAINT_DN / HOPELESS) {
            return Parts { smooth: [None; 2], sharp: None };
        }
        let view = draft.strip.mirror.is_some_and(|mirror| mirror.way == MirroredWay::View);
        let [low, high] = if view { self.within(middle, window) } else { [0.0, 1.0] };
        let beside = |from: f64, to: f64| {
            let places = (0..=BESIDE).map(|i| from + (to - from) * i as f64 / BESIDE as f64);
            if from < to { places.map(|share| level(share).peak_dn).fold(0.0, f64::max) } else { 0.0 }
        };
        let (before_dn, after_dn) = (beside(0.0, low.min(1.0)), beside(high.max(0.0), 1.0));
        let all = |peak_dn: f64| [(peak_dn >= FAINT_SMOOTH_DN).then_some(SmoothPart { cut: None, coarse: false }), None];
        if low >= high {
            return Parts { smooth: all(before_dn.max(after_dn)), sharp: None };
        }
        let share = |i: usize| low + (high - low) * i as f64 / PLACES as f64;
        let levels: [Level; PLACES + 1] = std::array::from_fn(|i| level(share(i)));
        let peak = |levels: &[Level]| levels.iter().map(|level| level.peak_dn).fold(0.0, f64::max);
        let Some(first) = levels.iter().position(|level| !level.smooth) else {
            return Parts { smooth: all(peak(&levels).max(before_dn).max(after_dn)), sharp: None };
        };
        if middle.length_px(&self.projection) < 1.0 {
            // Seen end on, it has no direction to be cut across.
            return Parts { smooth: [None; 2], sharp: Some([0.0, 1.0]) };
        }
        let last = levels.iter().rposition(|level| !level.smooth).unwrap_or(first);
        let turn = |mut smooth: f64, mut narrow: f64| {
            for _ in 0..HALVINGS {
                let between = (smooth + narrow) / 2.0;
                *(if level(between).smooth { &mut smooth } else { &mut narrow }) = between;
            }
            smooth
        };
        let from = if first > 0 { turn(share(first - 1), share(first)) } else { low };
        let to = if last < PLACES { turn(share(last + 1), share(last)) } else { high };
        // The roughness softens the cuts. Where that reaches farther than the narrow part is long, they would cut nothing off.
        let soft_px = |is_cut: bool, share: f64| if is_cut { level(share).soft_px } else { 0.0 };
        let softest_px = soft_px(from > 0.0, from).max(soft_px(to < 1.0, to));
        if middle.length_px(&self.projection) * (to - from) < LONG_SOFTNESSES * softest_px {
            let parts = all(peak(&levels).max(before_dn).max(after_dn));
            return Parts { smooth: parts.map(|part| part.map(|part| SmoothPart { coarse: true, ..part })), sharp: None };
        }
        // Beyond the window, a part that would be narrow is seen by no node.
        let part = |share: f64, side: f64, peak_dn: f64| {
            (share > 0.0 && share < 1.0 && peak_dn >= FAINT_SMOOTH_DN)
                .then_some(SmoothPart { cut: Some((share, side)), coarse: false })
        };
        let before = part(from, -1.0, peak(&levels[..first]).max(before_dn));
        let after = part(to, 1.0, peak(&levels[last + 1..]).max(after_dn));
        Parts { smooth: [before, after], sharp: Some([from, to]) }
    }

    /// The part of a ghost's middle, as shares of its length, that is in a window or near it.
    fn within(&self, middle: &Middle, window: &[Edge]) -> [f64; 2] {
        /// Distance from the window, in pixels, at which what is narrow (else nodes are enough) is not seen through it.
        const NEAR_PX: f64 = 32.0;
        let mut within = [0.0_f64, 1.0_f64];
        for edge in window {
            let near = edge.xy().norm() * NEAR_PX / self.blur.focal_px;
            let [from, to] = [middle.first, middle.last].map(|xy| edge.xy().dot(&xy) + edge.z + near);
            match (from < 0.0, to < 0.0) {
                (true, true) => return [1.0, 0.0],
                (true, false) => within[0] = within[0].max(from / (from - to)),
                (false, true) => within[1] = within[1].min(from / (from - to)),
                (false, false) => {}
            }
        }
        within
    }

    fn level(&self, draft: &Draft, middle: &Middle, share: f64) -> Level {
        let at = draft.strip.at(&PixelRay::of(&self.projection, middle.at(share)), &self.blur);
        let soft_px = at.ridge.blur_px.max(at.window.blur_px);
        // A piece shorter than its ends are soft is nowhere as bright as its middle would be in a longer one.
        let kept = (middle.length_px(&self.projection) / (SQRT_TAU * soft_px)).min(1.0);
        let peak_dn = kept * draft.strength * at.peak * at.sigma_px / at.spread_px;
        let error_dn = peak_dn * INTERPOLATION_PX2 / (at.spread_px * at.spread_px);
        Level { peak_dn, smooth: error_dn <= SMOOTH_DN || peak_dn < FAINT_DN, soft_px }
    }
}

/// The line across a ghost's middle at a share of its length, inside toward its end.
pub(super) fn cut(middle: &Middle, share: f64) -> Edge {
    let (place, along): (Vector2<f64>, Vector2<f64>) = (middle.at(share), middle.last - middle.first);
    Vector3::new(along.x, along.y, -along.dot(&place)).normalize()
}
