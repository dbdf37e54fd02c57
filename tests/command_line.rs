//! The command as its users meet it: the built program, in a folder of its own, with real files and signals.
#![cfg(feature = "cli")]

#[path = "command_line/accuracy.rs"]
mod accuracy;
#[path = "command_line/bad_input.rs"]
mod bad_input;
#[path = "command_line/calibrate.rs"]
mod calibrate;
#[path = "command_line/folders.rs"]
mod folders;
#[path = "command_line/inputs.rs"]
mod inputs;
#[path = "command_line/interrupts.rs"]
mod interrupts;
#[path = "command_line/jobs.rs"]
mod jobs;
#[path = "command_line/library.rs"]
mod library;
#[path = "command_line/other_commands.rs"]
mod other_commands;
#[path = "command_line/own_navigator.rs"]
mod own_navigator;
#[path = "command_line/perceive.rs"]
mod perceive;
#[path = "command_line/render.rs"]
mod render;
#[path = "command_line/renderers.rs"]
mod renderers;
#[path = "command_line/same_seed.rs"]
mod same_seed;
#[path = "command_line/seeds.rs"]
mod seeds;
#[path = "command_line/sweep.rs"]
mod sweep;
#[path = "command_line/sweep_engines.rs"]
mod sweep_engines;
#[path = "command_line/verdicts.rs"]
mod verdicts;
#[path = "command_line/workshop.rs"]
mod workshop;
