//! `ductloop bench`: what each part costs on this machine.
//!
//! Everything is measured on the built-in benchmark scenario: a straight duct, default noise, the `wide` rig, a camera that moves
//! on from frame to frame. Medians, because machines are noisy. "Every effect on" has walls with spangles and seams, which move in the
//! image: their frames are made of several parts of the exposure each.

use std::ops::ControlFlow;
use std::time::Instant;

use ductloop::closed_loop::{RunError, run_with};
use ductloop::engine::{Engine, Threads};
use ductloop::output::manifest::{AdapterInfo, Host};
use ductloop::scenario::Pipeline;
use ductloop::viewpoint::still;
use ductloop::{GreyImage, Pilot, Scenario, Sides};
use ductloop_duct::network::Network;
use ductloop_sensor::renderer::{Motion, View};
use ductloop_sim::ground::Ground;
use ductloop_sim::world::World;
use serde_json::json;

use super::args::BenchArgs;
use super::problem::Problem;
use super::streams::{self, print, print_json};

/// What is measured on.
const SCENARIO: &str = include_str!("bench.toml");
/// What is laid over it for the full model.
const FULL: &str = include_str!("bench_full.toml");
/// Physics steps to a measurement: long enough that the clock's resolution does not count.
const STEPS: u32 = 1200;
/// The first frames compile shaders and fill buffers.
const WARM_UP: u32 = 5;
/// How far the camera moves on between frames, in metres: 0.3 m/s at 30 frames a second.
const ADVANCE_M: f64 = 0.01;

/// Carries it out.
///
/// # Errors
/// Where a part fails; a part that is not there at all is null in the result.
pub(crate) fn command(args: &BenchArgs) -> Result<u8, Problem> {
    let failed = |error: &dyn std::fmt::Display| Problem::new(Problem::CANNOT_GO_ON, error.to_string());
    let scenario = Scenario::from_toml_str(SCENARIO).map_err(|wrong| Problem::in_files(vec![wrong]))?;
    let mut reflecting = scenario.clone();
    (reflecting.optics.ghosts, reflecting.optics.bounce) = (true, true);
    let full = Scenario::from_toml_str(&full_model()).map_err(|wrong| Problem::in_files(vec![wrong]))?;
    let threads = args.threads.map_or_else(Threads::here, |n| Threads { all: n.into() });
    let (wgpu, adapter) = adapter();
    let note = |text: &str| {
        if !args.json {
            streams::note(&format!("{text} …"));
        }
    };

    note("physics");
    let physics_steps_per_s = physics(&scenario).map_err(|error| failed(&error))?;
    note("rendering, cpu");
    let frames = |engine: &Engine, scenario, threads| frame_ms(engine, scenario, threads, args.frames).map_err(|e| failed(&e));
    let cpu = frames(&Engine::Cpu, &scenario, 1)?;
    let cpu_reflecting = frames(&Engine::Cpu, &reflecting, 1)?;
    let cpu_full = frames(&Engine::Cpu, &full, 1)?;
    let [cpu_threads, cpu_full_threads] =
        [frames(&Engine::Cpu, &scenario, threads.all)?, frames(&Engine::Cpu, &full, threads.all)?];
    note("perception");
    let perceive = |pipeline| perception(&scenario, pipeline, args.frames).map_err(|error| failed(&error));
    let [robust_ms, paper_ms] = [perceive(Pipeline::Robust)?, perceive(Pipeline::Paper)?];
    note("the whole loop, cpu");
    let real_time = |engine: &Engine| real_time_factor(engine, &scenario, threads).map_err(|e| failed(&e));
    let cpu_real_time = real_time(&Engine::Cpu)?;
    let (mut wgpu_ms, mut wgpu_reflecting, mut wgpu_full, mut wgpu_real_time) = (None, None, None, None);
    if let Some(wgpu) = &wgpu {
        note("the same, wgpu");
        wgpu_ms = Some(frames(wgpu, &scenario, 1)?);
        wgpu_reflecting = Some(frames(wgpu, &reflecting, 1)?);
        wgpu_full = Some(frames(wgpu, &full, 1)?);
        wgpu_real_time = Some(real_time(wgpu)?);
    }

    let camera = &scenario.rig.camera;
    if args.json {
        print_json(&json!({
            "frame_px": [camera.width_px, camera.height_px],
            "threads": threads.all,
            "render_ms": {"cpu": cpu, "wgpu": wgpu_ms},
            "perceive_ms": {"robust": robust_ms, "paper": paper_ms},
            "physics_steps_per_s": physics_steps_per_s,
            "real_time_factor": {"cpu": cpu_real_time, "wgpu": wgpu_real_time},
            "host": Host::this(),
            "adapter": adapter,
            "render_reflections_ms": {"cpu": cpu_reflecting, "wgpu": wgpu_reflecting},
            "render_full_ms": {"cpu": cpu_full, "wgpu": wgpu_full},
            "render_threads_ms": {"cpu": cpu_threads, "cpu_full": cpu_full_threads},
        }))?;
        return Ok(0);
    }
    let mut text = format!(
        "\
frame                  {} x {} pixels; {} threads
rendering, cpu         {cpu:.2} ms on one thread, {cpu_threads:.2} ms on {2}
  ghosts and bounce    {cpu_reflecting:.2} ms on one thread
  every effect on      {cpu_full:.2} ms on one thread, {cpu_full_threads:.2} ms on {2}
perception, robust     {robust_ms:.2} ms
perception, paper      {paper_ms:.2} ms
physics                {physics_steps_per_s:.0} steps/s
whole loop, cpu        {cpu_real_time:.1} times real time",
        camera.width_px, camera.height_px, threads.all
    );
    let timed = (wgpu_ms, wgpu_reflecting, wgpu_full, wgpu_real_time, adapter);
    if let (Some(ms), Some(reflecting), Some(full), Some(real_time), Some(AdapterInfo { name, .. })) = timed {
        text += &format!("\nrendering, wgpu        {ms:.2} ms ({name})\n  ghosts and bounce    {reflecting:.2} ms");
        text += &format!("\n  every effect on      {full:.2} ms");
        text += &format!("\nwhole loop, wgpu       {real_time:.1} times real time");
    } else {
        text += "\nrendering, wgpu        no graphics adapter";
    }
    print(&text)?;
    Ok(0)
}

/// The benchmark scenario with every effect on.
fn full_model() -> String {
    // The duct of the second file stands in for that of the first.
    let head = SCENARIO.split("[duct]").next().unwrap_or(SCENARIO);
    format!("{head}{FULL}")
}

/// Whatever graphics adapter there is.
#[cfg(feature = "wgpu")]
fn adapter() -> (Option<Engine>, Option<AdapterInfo>) {
    match Engine::wgpu() {
        Ok(Engine::Wgpu(gpu)) => (Some(Engine::Wgpu(gpu.clone())), Some(gpu.adapter().into())),
        _ => (None, None),
    }
}

#[cfg(not(feature = "wgpu"))]
fn adapter() -> (Option<Engine>, Option<AdapterInfo>) {
    (None, None)
}

/// Physics steps a second.
fn physics(scenario: &Scenario) -> Result<f64, RunError> {
    let network = scenario.duct.network()?;
    let ground = Ground::new(scenario.surfaces.iter().map(|s| s.friction).collect());
    let start = scenario.world_from_start(&network);
    let rest = scenario.rig.mount.rest;
    let mut world = World::new(&network, &scenario.robot, &ground, &start, rest, scenario.rates.physics_hz)?;
    let mut rates = Vec::new();
    for _ in 0..7 {
        let started = Instant::now();
        for _ in 0..STEPS {
            world.step(Sides { left: 0.2, right: 0.21 })?;
        }
        rates.push(f64::from(STEPS) / started.elapsed().as_secs_f64());
    }
    Ok(median(&mut rates))
}

/// What the camera sees on its way along the duct, frame by frame.
fn view(scenario: &Scenario, network: &Network, frame: u32) -> View {
    // To and fro over three metres in the middle of the duct.
    let along_m = f64::from(frame) * ADVANCE_M % 3.0;
    let base = network.centreline.pose_at(scenario.start.distance_m + along_m);
    let speed_m_s = ADVANCE_M * f64::from(scenario.rates.camera_hz);
    View {
        motion: Motion { linear_m_s: base.rotation * nalgebra::Vector3::new(speed_m_s, 0.0, 0.0), ..Motion::default() },
        frame: u64::from(frame),
        laser_power: scenario.laser_powers(1.0),
        ..still(base * scenario.rig.mount.base_from_camera(scenario.rig.mount.rest), scenario.first_exposure_s())
    }
}

/// Milliseconds a frame.
fn frame_ms(engine: &Engine, scenario: &Scenario, threads: usize, frames: u32) -> Result<f64, RunError> {
    let network = scenario.duct.network()?;
    let mut renderer = engine.renderer(scenario, threads)?;
    let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
    let mut times = Vec::new();
    for frame in 0..frames + WARM_UP {
        let view = view(scenario, &network, frame);
        let started = Instant::now();
        renderer.render(&view, image.room())?;
        times.push(started.elapsed().as_secs_f64() * 1e3);
    }
    Ok(median(&mut times[WARM_UP as usize..]))
}

/// Milliseconds to read a frame.
fn perception(scenario: &Scenario, pipeline: Pipeline, frames: u32) -> Result<f64, RunError> {
    let network = scenario.duct.network()?;
    let mut renderer = Engine::Cpu.renderer(scenario, 1)?;
    let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
    let mut read_by = scenario.clone();
    read_by.perception.pipeline = pipeline;
    let mut perception = ductloop::pilot::perception(&read_by);
    let mut times = Vec::new();
    for frame in 0..frames + WARM_UP {
        renderer.render(&view(scenario, &network, frame), image.room())?;
        let started = Instant::now();
        perception.perceive(&image.frame(), scenario.rig.mount.rest);
        times.push(started.elapsed().as_secs_f64() * 1e3);
    }
    Ok(median(&mut times[WARM_UP as usize..]))
}

/// Simulated seconds a second of the whole loop.
fn real_time_factor(engine: &Engine, scenario: &Scenario, threads: Threads) -> Result<f64, Box<dyn std::error::Error>> {
    let mut renderer = engine.renderer(scenario, threads.rendering())?;
    let started = Instant::now();
    let run = run_with(scenario, Pilot::of(scenario), renderer.as_mut(), threads.pace(), |_, _| ControlFlow::Continue(()))?;
    Ok(run.sim_time_s / started.elapsed().as_secs_f64())
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
