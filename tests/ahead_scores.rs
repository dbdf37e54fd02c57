//! Scores of what the robot says lies ahead: the truth along drawn ducts, scores of made-up frames, and whole runs.

#[path = "ahead_scores/driven.rs"]
mod driven;
#[path = "ahead_scores/made_up.rs"]
mod made_up;
#[path = "ahead_scores/truth.rs"]
mod truth;
