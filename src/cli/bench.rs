//! `ductloop bench`: what each part costs on this machine.
//!
//! Everything is measured on the built-in benchmark scenario: a straight duct, default noise, the `wide` rig. Medians, because
//! machines are noisy.

use std::ops::ControlFlow;
use std::time::Instant;

use ductloop::closed_loop::run_with;
use ductloop::output::manifest::Host;
use ductloop::{Frame, Pilot, Pixels, Scenario, Sides};
use ductloop_nav::perception::Perception as _;
use ductloop_nav::perception::paper::PaperPerception;
use ductloop_sensor::renderer::{MAX_LASERS, Renderer as _, View};
use ductloop_sim::ground::Ground;
use ductloop_sim::world::World;
use serde_json::json;

use super::args::{BenchArgs, RendererArgs, RendererChoice};
use super::problem::Problem;
use super::rendering::Rendering;
use super::streams::{self, print, print_json};

/// What is measured on.
const SCENARIO: &str = include_str!("bench.toml");
/// Physics steps to a measurement: long enough that the clock's resolution does not count.
const STEPS: u32 = 1200;

/// Carries it out.
///
/// # Errors
/// Where a part fails; a part that is not there at all is null in the result.
pub(crate) fn command(args: &BenchArgs) -> Result<u8, Problem> {
    let failed = |error: &dyn std::fmt::Display| Problem::new(Problem::CANNOT_GO_ON, error.to_string());
    let scenario = Scenario::from_toml_str(SCENARIO).map_err(|wrong| Problem::in_files(vec![wrong]))?;
    let rendering = Rendering::open(RendererArgs { renderer: RendererChoice::Auto, threads: None }, args.json)?;
    let network = scenario.duct.network().map_err(|e| failed(&e))?;
    let start = scenario.world_from_start(&network);
    let rest = scenario.rig.mount.rest;
    let note = |text: &str| {
        if !args.json {
            streams::note(&format!("{text} …"));
        }
    };

    note("physics");
    let ground = Ground::new(scenario.surfaces.iter().map(|s| s.friction).collect());
    let mut world =
        World::new(&network, &scenario.robot, &ground, &start, rest, scenario.rates.physics_hz).map_err(|e| failed(&e))?;
    let mut rates = Vec::new();
    for _ in 0..7 {
        let started = Instant::now();
        for _ in 0..STEPS {
            world.step(Sides { left: 0.2, right: 0.21 }).map_err(|e| failed(&e))?;
        }
        rates.push(f64::from(STEPS) / started.elapsed().as_secs_f64());
    }
    let physics_steps_per_s = median(&mut rates);

    note("rendering and perception");
    let mut renderer = ductloop::renderer(&rendering.gpu, &scenario).map_err(|e| failed(&e))?;
    let camera = &scenario.rig.camera;
    let mut image = vec![0; camera.width_px * camera.height_px];
    let mut perception = PaperPerception::new(scenario.rig.clone(), ductloop::pilot::paper_params(&scenario));
    let (mut render_ms, mut perceive_ms) = (Vec::new(), Vec::new());
    // The first frames compile shaders and fill buffers.
    const WARM_UP: u32 = 5;
    for frame in 0..args.frames + WARM_UP {
        let view = View {
            world_from_camera: start * scenario.rig.mount.base_from_camera(rest),
            frame: u64::from(frame),
            exposure_s: scenario.exposure_s,
            laser_power: [1.0; MAX_LASERS],
            headlamp_power: 1.0,
        };
        let started = Instant::now();
        renderer.render(&view, &mut image).map_err(|e| failed(&e))?;
        let rendered = Instant::now();
        let seen = Frame { width_px: camera.width_px, height_px: camera.height_px, pixels: Pixels::Grey8(&image) };
        let measured = perception.perceive(&seen, rest);
        if measured.lateral_m.is_none() {
            return Err(failed(&"the benchmark's frame shows no wall"));
        }
        if frame >= WARM_UP {
            render_ms.push((rendered - started).as_secs_f64() * 1e3);
            perceive_ms.push(rendered.elapsed().as_secs_f64() * 1e3);
        }
    }
    let (render_ms, perceive_ms) = (median(&mut render_ms), median(&mut perceive_ms));

    note("the whole loop");
    let started = Instant::now();
    let run = run_with(&scenario, Pilot::of(&scenario), &mut renderer, rendering.pace, |_, _| ControlFlow::Continue(()))
        .map_err(|failure| failed(&failure))?;
    let real_time_factor = run.sim_time_s / started.elapsed().as_secs_f64();

    if args.json {
        print_json(&json!({
            "frame_px": [camera.width_px, camera.height_px],
            "threads": rendering.threads,
            "render_ms": {"cpu": null, "wgpu": render_ms},
            "perceive_ms": {"robust": null, "paper": perceive_ms},
            "physics_steps_per_s": physics_steps_per_s,
            "real_time_factor": {"cpu": null, "wgpu": real_time_factor},
            "host": Host::this(),
            "adapter": rendering.adapter(),
        }))?;
    } else {
        print(&format!(
            "\
frame             {} x {} pixels, {} threads
rendering, wgpu   {render_ms:.2} ms ({})
perception, paper {perceive_ms:.2} ms
physics           {physics_steps_per_s:.0} steps/s
whole loop        {real_time_factor:.1} times real time",
            camera.width_px,
            camera.height_px,
            rendering.threads,
            rendering.adapter().name
        ))?;
    }
    Ok(0)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
