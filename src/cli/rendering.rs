//! Opening what renders.

use ductloop::closed_loop::Pace;
use ductloop::output::manifest::AdapterInfo;
use ductloop_sensor::gpu::Gpu;
use ductloop_sensor::renderer::RenderError;

use super::args::{RendererArgs, RendererChoice};
use super::problem::Problem;
use super::streams::note;

/// What renders, opened.
pub(crate) struct Rendering {
    /// The device.
    pub(crate) gpu: Gpu,
    /// How runs are carried out.
    pub(crate) pace: Pace,
    /// Threads that the call was given.
    pub(crate) threads: usize,
}

impl Rendering {
    /// The word for it in summaries.
    pub(crate) const WORD: &'static str = "wgpu";

    /// Opens what was asked for. Unless `quiet`, `auto` says on standard error what it took.
    ///
    /// # Errors
    /// Exit code 2 for what this version does not have, 3 where there is no adapter.
    pub(crate) fn open(args: RendererArgs, quiet: bool) -> Result<Self, Problem> {
        if args.renderer == RendererChoice::Cpu {
            return Err(Problem::new(Problem::WRONG_INPUT, "this version has no CPU renderer")
                .about("--renderer cpu")
                .help("`--renderer wgpu` runs on the processor too, with Mesa's lavapipe: apt-get install mesa-vulkan-drivers"));
        }
        let gpu = Gpu::open().map_err(|error| problem(&error))?;
        if args.renderer == RendererChoice::Auto && !quiet {
            let adapter = gpu.adapter();
            let kind = if adapter.software { ", in software" } else { "" };
            note(&format!("rendering with wgpu on {} ({}{kind})", adapter.name, adapter.backend));
        }
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = args.threads.map_or(cores, usize::from);
        Ok(Self { gpu, pace: if threads > 1 { Pace::Overlapped } else { Pace::Alone }, threads })
    }

    /// What the manifest says of it.
    pub(crate) fn adapter(&self) -> AdapterInfo {
        self.gpu.adapter().into()
    }
}

/// A renderer's failure.
pub(crate) fn problem(error: &RenderError) -> Problem {
    Problem::new(Problem::CANNOT_GO_ON, error.to_string())
}
