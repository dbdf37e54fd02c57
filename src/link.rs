//! The link from the command controller to wheel and mount controller: what is said arrives late, in another order, twice or never.
//!
//! A packet carries a sequence number of 32 bits that wraps. The receiver takes a packet only if its number is ahead of the last
//! one taken, by less than half the range (serial numbers of RFC 1982): what is older, or the same again, is dropped. So a command
//! never undoes a later one.
//!
//! Each packet draws its own fate, by counter, from the scenario's seed: whether it is lost, whether it comes a second time, and how
//! late each of the two is, latency + uniform(0, jitter), in whole physics ticks, rounded up.
//!
//! What it does not do: packets are not corrupted, losses do not come in bursts, and the way back (encoder counts and mount angles,
//! which come with the frame) is ideal.

use ductloop_nav::messages::Tick;

use crate::scenario::LinkParams;
use crate::stream::uniform;

/// Which link: each has random streams of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// To the wheel controller.
    Wheels,
    /// To the mount controller.
    Mount,
}

/// What became of packets so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Lost on the way.
    pub lost: u64,
    /// Dropped by the receiver: older than one taken, or the same again.
    pub dropped: u64,
}

/// What the link carries: a payload and its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packet<T> {
    /// One more than that of the packet before; wraps.
    pub sequence: u32,
    /// What is said.
    pub payload: T,
}

/// The receiver's memory of what it has taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Receiver {
    taken: Option<u32>,
    dropped: u64,
}

/// A link with its receiver.
#[derive(Clone, Debug)]
pub struct Link<T> {
    params: LinkParams,
    ticks_per_s: f64,
    seed: u64,
    channel: Channel,
    /// Packets sent so far.
    sent: u64,
    lost: u64,
    /// Packets on the way and the tick at which each arrives, in the order of sending.
    on_the_way: Vec<(Tick, Packet<T>)>,
    receiver: Receiver,
}

/// The draws of a packet.
#[derive(Clone, Copy)]
enum Draw {
    Lost,
    Delay,
    Repeat,
    RepeatDelay,
}

impl Receiver {
    /// The payload, if it is newer than all taken before.
    pub fn take<T>(&mut self, packet: Packet<T>) -> Option<T> {
        let is_newer = self.taken.is_none_or(|taken| (packet.sequence.wrapping_sub(taken) as i32) > 0);
        if is_newer {
            self.taken = Some(packet.sequence);
            Some(packet.payload)
        } else {
            self.dropped += 1;
            None
        }
    }
}

impl<T: Copy> Link<T> {
    /// A link on which nothing has been said yet.
    pub fn new(params: LinkParams, channel: Channel, seed: u64, ticks_per_s: f64) -> Self {
        Self { params, ticks_per_s, seed, channel, sent: 0, lost: 0, on_the_way: Vec::new(), receiver: Receiver::default() }
    }

    /// Says something at `tick`. With the link down it is lost.
    pub fn send(&mut self, tick: Tick, payload: T, is_up: bool) {
        let index = self.sent;
        self.sent += 1;
        let LinkParams { loss, repeat, .. } = self.params;
        if !is_up || self.draw(index, Draw::Lost) < loss {
            self.lost += 1;
            return;
        }
        // Numbers wrap.
        let packet = Packet { sequence: index as u32, payload };
        self.on_the_way.push((tick + self.delay(index, Draw::Delay), packet));
        if self.draw(index, Draw::Repeat) < repeat {
            self.on_the_way.push((tick + self.delay(index, Draw::RepeatDelay), packet));
        }
    }

    /// What the receiver takes by `tick`: the newest of what has arrived, if there is any; called at every tick.
    pub fn receive(&mut self, tick: Tick) -> Option<T> {
        let receiver = &mut self.receiver;
        let mut taken = None;
        self.on_the_way.retain(|(due, packet)| {
            let on_the_way = *due > tick;
            if !on_the_way {
                taken = receiver.take(*packet).or(taken);
            }
            on_the_way
        });
        taken
    }

    /// What became of packets so far.
    pub fn counts(&self) -> LinkCounts {
        LinkCounts { lost: self.lost, dropped: self.receiver.dropped }
    }

    fn delay(&self, index: u64, draw: Draw) -> Tick {
        let LinkParams { latency_s, jitter_s, .. } = self.params;
        let delay_s = latency_s + jitter_s * self.draw(index, draw);
        // Less a billionth, lest what is a whole number of ticks be rounded up to one more.
        libm::ceil(delay_s * self.ticks_per_s - 1e-9).max(0.0) as Tick
    }

    fn draw(&self, index: u64, draw: Draw) -> f64 {
        // "link", so that no other part of a run shares these streams.
        let stream = 0x6c69_6e6b_0000_0000 | (self.channel as u64) << 8 | draw as u64;
        uniform(self.seed, index, stream)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDEAL: LinkParams = LinkParams { latency_s: 0.0, jitter_s: 0.0, loss: 0.0, repeat: 0.0 };

    /// Sends the numbers 0.. every 40 ticks at 1200 Hz; what is taken, with its tick.
    fn run(params: LinkParams, seed: u64, packets: u64) -> (Vec<(Tick, u64)>, LinkCounts) {
        let mut link = Link::new(params, Channel::Wheels, seed, 1200.0);
        let mut taken = Vec::new();
        for tick in 0..40 * packets + 1200 {
            if tick % 40 == 0 && tick / 40 < packets {
                link.send(tick, tick / 40, true);
            }
            taken.extend(link.receive(tick).map(|number| (tick, number)));
        }
        (taken, link.counts())
    }

    #[test]
    fn an_ideal_link_delivers_everything_at_once() {
        let (taken, counts) = run(IDEAL, 1, 50);
        assert_eq!(taken, (0..50).map(|i| (40 * i, i)).collect::<Vec<_>>());
        assert_eq!(counts, LinkCounts::default());
    }

    #[test]
    fn latency_is_whole_ticks_rounded_up() {
        for (latency_s, ticks) in [(0.005, 6), (0.0051, 7), (0.1, 120)] {
            let (taken, _) = run(LinkParams { latency_s, ..IDEAL }, 1, 5);
            assert_eq!(taken[0], (ticks, 0), "{latency_s}");
        }
    }

    /// Jitter of three frames' time brings packets into another order: what is taken still only goes up, and what was overtaken
    /// was dropped.
    #[test]
    fn what_was_overtaken_is_dropped() {
        let (taken, counts) = run(LinkParams { jitter_s: 0.1, ..IDEAL }, 3, 300);
        assert!(taken.windows(2).all(|two| two[0].1 < two[1].1), "{taken:?}");
        // Two that arrive at one tick count once, as the newer: nearly all others are taken or dropped.
        assert!(counts.dropped > 50 && counts.lost == 0, "{counts:?}");
        assert!(taken.len() as u64 + counts.dropped <= 300 && taken.len() > 100, "{}", taken.len());
    }

    /// The standard deviation of 2000 draws at 0.2 is 18: five of them.
    #[test]
    fn losses_and_repetitions_are_as_frequent_as_stated_and_the_seeds_own() {
        let (taken, counts) = run(LinkParams { loss: 0.2, ..IDEAL }, 1, 2000);
        assert!((310..=490).contains(&counts.lost) && taken.len() as u64 + counts.lost == 2000, "{counts:?}");
        assert_eq!(run(LinkParams { loss: 0.2, ..IDEAL }, 1, 2000).0, taken);
        assert_ne!(run(LinkParams { loss: 0.2, ..IDEAL }, 2, 2000).0, taken);
        let (taken, counts) = run(LinkParams { repeat: 0.2, ..IDEAL }, 1, 2000);
        assert!((310..=490).contains(&counts.dropped), "{counts:?}");
        assert_eq!(taken.len(), 2000);
        let never = run(LinkParams { loss: 1.0, ..IDEAL }, 1, 20);
        assert_eq!((never.0.len(), never.1.lost), (0, 20));
    }

    #[test]
    fn numbers_wrap_and_a_stale_or_repeated_one_is_dropped() {
        let mut receiver = Receiver::default();
        let mut take = |sequence| receiver.take(Packet { sequence, payload: () }).is_some();
        let numbers = [u32::MAX - 1, u32::MAX, u32::MAX, 0, u32::MAX, 1, 0, 3, 2];
        let taken = [true, true, false, true, false, true, false, true, false];
        assert_eq!(numbers.map(&mut take), taken);
        assert_eq!(receiver.dropped, 4);
    }

    #[test]
    fn a_link_that_is_down_loses_what_is_said_and_no_more() {
        let mut link = Link::new(LinkParams { latency_s: 0.01, ..IDEAL }, Channel::Mount, 1, 1200.0);
        link.send(0, 'a', true);
        link.send(1, 'b', false);
        assert_eq!((0..20).filter_map(|tick| link.receive(tick)).collect::<String>(), "a");
        assert_eq!(link.counts().lost, 1);
        link.send(20, 'c', true);
        assert_eq!(link.receive(40), Some('c'));
    }
}
