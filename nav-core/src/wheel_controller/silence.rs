//! A controller that hears nothing: how long it goes on, and what it says of it.
//!
//! After `limit` ticks without a command it brings its set-points down, step by step, and says so; a command that is heard ends
//! this at once. A controller that has never heard one counts from its start.

/// What a wheel controller does about its commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hearing {
    /// It holds what it was commanded.
    #[default]
    Commanded,
    /// It has heard nothing for too long, and is slowing down.
    RampingDown,
    /// It has heard nothing for too long, and holds standstill.
    Down,
    /// A wheel has not followed its set-point for too long ([`super::following`]): the motors are cut off, and stay so.
    CutOff,
}

/// Counts the ticks of silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Silence {
    limit: u32,
    ticks: u32,
}

impl Silence {
    /// Silence is too long after `limit` ticks.
    pub fn new(limit: u32) -> Self {
        Self { limit, ticks: 0 }
    }

    /// A command has come.
    pub fn heard(&mut self) {
        self.ticks = 0;
    }

    /// A tick passes; says whether there has been silence for more than the limit.
    pub fn tick(&mut self) -> bool {
        let too_long = self.ticks >= self.limit;
        self.ticks = self.ticks.saturating_add(1);
        too_long
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_counts_from_the_last_command() {
        let mut silence = Silence::new(3);
        let mut said: Vec<bool> = (0..5).map(|_| silence.tick()).collect();
        silence.heard();
        said.extend((0..4).map(|_| silence.tick()));
        assert_eq!(said, [false, false, false, true, true, false, false, false, true]);
    }
}
