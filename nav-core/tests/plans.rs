//! The robot in ducts that are drawn as plans: what it takes a fitting for, and where it goes.

#[path = "plans/ahead.rs"]
mod ahead;
#[path = "plans/course.rs"]
mod course;
#[path = "plans/plan.rs"]
mod plan;
#[path = "plans/wheels.rs"]
mod wheels;
