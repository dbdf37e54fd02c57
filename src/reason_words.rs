//! Words for why a navigator is no surer, and for why it stopped: in tables, summaries, reports and scenarios.

use ductloop_nav::navigator::{Reason, State};

use crate::record::{EndState, FrameRecord};

/// The words for what a navigator stops for; a scenario may ask for one (`pass.stop_reason`).
pub const STOPS: [&str; 10] = [
    "route-ends",
    "dead-end",
    "obstacle",
    "drop",
    "no-way-known",
    "no-such-way",
    "no-room",
    "coasted-too-long",
    "frozen-camera",
    "wheels-swapped",
];

/// The word for why a navigator is no surer, in tables.
pub fn reason_word(reason: Reason) -> &'static str {
    match reason {
        Reason::NothingSeenYet => "nothing-seen-yet",
        Reason::WallLost => "wall-lost",
        Reason::Uncertain => "uncertain",
        Reason::Refused => "refused",
        Reason::NoWall => "no-wall",
        Reason::FrozenCamera => "frozen-camera",
        Reason::CoastedTooLong => "coasted-too-long",
        Reason::RouteEnds => "route-ends",
        Reason::DeadEnd => "dead-end",
        Reason::Obstacle => "obstacle",
        Reason::Drop => "drop",
        Reason::NoWayKnown => "no-way-known",
        Reason::NoSuchWay => "no-such-way",
        Reason::NoRoom => "no-room",
        Reason::WheelsSwapped => "wheels-swapped",
    }
}

/// Why a navigator is no surer, in a phrase.
pub fn reason_about(reason: Reason) -> &'static str {
    match reason {
        Reason::NothingSeenYet => "no wall was seen yet",
        Reason::WallLost => "a wall that was seen before is not seen",
        Reason::Uncertain => "the estimate's deviation is large",
        Reason::Refused => "the walls appear where they cannot be",
        Reason::NoWall => "no wall is seen",
        Reason::FrozenCamera => "the camera gives the same frame again and again",
        Reason::CoastedTooLong => "nothing was seen for too long",
        Reason::RouteEnds => "the route ends here",
        Reason::DeadEnd => "the duct ends, and the route does not say to turn back",
        Reason::Obstacle => "something stands in the way",
        Reason::Drop => "the floor ends",
        Reason::NoWayKnown => "how the duct goes on cannot be told",
        Reason::NoSuchWay => "the way that the route names is not there",
        Reason::NoRoom => "there is no room to turn back, as far as it came",
        Reason::WheelsSwapped => "the wheels turn the other way than they are told",
    }
}

/// Why the navigator had stopped where that ended the run. A robot whose wheel controller had stopped it, for want of commands, has no
/// such reason.
pub fn stop_reason(end: EndState, last: Option<&FrameRecord>) -> Option<&'static str> {
    let stopped = last.filter(|frame| end == EndState::Stopped && frame.state == State::Stopped)?;
    stopped.reason.map(reason_word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_navigator_stops_for_can_be_asked_for() {
        use Reason::{
            CoastedTooLong, DeadEnd, Drop, FrozenCamera, NoRoom, NoSuchWay, NoWayKnown, Obstacle, RouteEnds, WheelsSwapped,
        };
        let told =
            [RouteEnds, DeadEnd, Obstacle, Drop, NoWayKnown, NoSuchWay, NoRoom, CoastedTooLong, FrozenCamera, WheelsSwapped];
        assert_eq!(told.map(reason_word), STOPS);
    }
}
