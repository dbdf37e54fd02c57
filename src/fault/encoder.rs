//! Encoders that lose counts or are stuck.
//!
//! An encoder that loses counts misses each edge by chance: of the counts of a tick, a binomial number is lost, drawn count by count.
//! What is lost stays lost: the reading that the controllers get is the sum of what was seen.

use ductloop_nav::messages::{Counts, Tick};

use super::{ActiveFaults, side_of};
use crate::scenario::FaultKind;
use crate::stream::uniform;

/// What the encoders read, where they may be wrong.
#[derive(Clone, Debug)]
pub struct FaultyEncoders {
    seed: u64,
    /// What they truly counted when last looked at.
    before: [i64; 2],
    read: [i64; 2],
}

/// Streams of encoders: apart from all others that are drawn by the same function.
const STREAM: u64 = 0x656e_636f;

impl FaultyEncoders {
    /// At power-on.
    pub fn new(seed: u64) -> Self {
        Self { seed, before: [0; 2], read: [0; 2] }
    }

    /// Takes over what was truly counted up to `tick`.
    pub fn count(&mut self, counts: Counts, tick: Tick, active: &ActiveFaults<'_>) {
        let now = [counts.left, counts.right];
        let mut fresh = [now[0] - self.before[0], now[1] - self.before[1]];
        self.before = now;
        for fault in active.iter() {
            match fault.kind {
                FaultKind::EncoderStuck { side } => *side_of(&mut fresh, side) = 0,
                FaultKind::EncoderLoses { side, share } => {
                    let stream = STREAM + ((fault.index as u64) << 32);
                    let fresh = side_of(&mut fresh, side);
                    let lost = (0..fresh.unsigned_abs())
                        .filter(|i| uniform(self.seed, tick.wrapping_mul(1 << 20).wrapping_add(*i), stream) < share)
                        .count() as i64;
                    *fresh -= lost * fresh.signum();
                }
                _ => {}
            }
        }
        self.read = [self.read[0] + fresh[0], self.read[1] + fresh[1]];
    }

    /// What they read.
    pub fn read(&self) -> Counts {
        let [left, right] = self.read;
        Counts { left, right }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Faults;
    use super::*;
    use crate::scenario::{Fault, Side};

    fn run(kind: FaultKind) -> Counts {
        let faults = Faults(vec![Fault { at_s: 0.5, for_s: Some(1.0), kind }]);
        let mut encoders = FaultyEncoders::new(3);
        // 60 counts a tick ahead on the left, 60 back on the right, 2000 ticks of 1 ms.
        for tick in 1..=2000_u64 {
            let n = 60 * tick as i64;
            encoders.count(Counts { left: n, right: -n }, tick, &faults.at(tick as f64 / 1000.0));
        }
        encoders.read()
    }

    #[test]
    fn a_stuck_encoder_counts_nothing_meanwhile() {
        assert_eq!(run(FaultKind::EncoderStuck { side: Side::Right }), Counts { left: 120_000, right: -60_000 });
    }

    #[test]
    fn counts_are_lost_by_the_share_whichever_way_the_wheel_turns() {
        // 60 000 counts, a tenth of which is lost: 6000 with a deviation of sqrt(60 000 x 0.1 x 0.9) = 73; four of them allowed.
        for (side, sign) in [(Side::Left, 1), (Side::Right, -1)] {
            let counts = run(FaultKind::EncoderLoses { side, share: 0.1 });
            let read = sign * if side == Side::Left { counts.left } else { counts.right };
            assert!((read - 114_000).abs() < 300, "{counts:?}");
        }
    }
}
