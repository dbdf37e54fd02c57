//! The route: which way to take at each junction, in order.

/// A way to take at a junction or an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Into the branch on the left.
    Left,
    /// On.
    Straight,
    /// Into the branch on the right.
    Right,
    /// Back the way that it came.
    TurnBack,
    /// No farther.
    Stop,
}

impl Turn {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Left, Self::Straight, Self::Right, Self::TurnBack, Self::Stop];

    /// The words for them in a scenario, in the same order.
    pub const WORDS: [&'static str; 5] = ["left", "straight", "right", "turn-back", "stop"];

    /// The word for it in a scenario.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// The turn of that word.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|turn| turn.word() == word)
    }
}
