//! Opening what renders.

use ductloop::engine::{Engine, Threads};
use ductloop::output::manifest::AdapterInfo;

use super::args::{RendererArgs, RendererChoice};
use super::problem::Problem;
use super::streams::note;

/// What renders, opened.
pub(crate) struct Rendering {
    /// The engine.
    pub(crate) engine: Engine,
    /// Threads that the call was given.
    pub(crate) threads: Threads,
}

impl Rendering {
    /// Opens what was asked for. Unless `quiet`, `auto` says on standard error what it took.
    ///
    /// # Errors
    /// Exit code 2 for what this program was built without, 3 where wgpu was asked for and there is no adapter.
    pub(crate) fn open(args: RendererArgs, quiet: bool) -> Result<Self, Problem> {
        let threads = args.threads.map_or_else(Threads::here, |n| Threads { all: n.into() });
        let engine = match args.renderer {
            RendererChoice::Auto => Engine::auto(),
            RendererChoice::Cpu => Engine::Cpu,
            RendererChoice::Wgpu => wgpu()?,
        };
        let opened = Self { engine, threads };
        if args.renderer == RendererChoice::Auto && !quiet {
            note(&match opened.adapter() {
                Some(adapter) => format!("rendering with wgpu on {} ({})", adapter.name, adapter.backend),
                None => "rendering with cpu: there is no hardware graphics adapter".to_owned(),
            });
        }
        Ok(opened)
    }

    /// For runs of which `jobs` go on at once: unless a number of threads was asked for, they share the cores.
    pub(crate) fn for_jobs(self, args: RendererArgs, jobs: usize) -> Self {
        match args.threads {
            Some(_) => self,
            None => Self { threads: self.threads.shared_among(jobs), ..self },
        }
    }

    /// What the manifest says of it; `None` where the processor renders.
    pub(crate) fn adapter(&self) -> Option<AdapterInfo> {
        match &self.engine {
            Engine::Cpu => None,
            #[cfg(feature = "wgpu")]
            Engine::Wgpu(gpu) => Some(gpu.adapter().into()),
        }
    }
}

/// Any graphics adapter, of hardware or software.
#[cfg(feature = "wgpu")]
fn wgpu() -> Result<Engine, Problem> {
    Engine::wgpu().map_err(|error| Problem::new(Problem::CANNOT_GO_ON, error.to_string()))
}

#[cfg(not(feature = "wgpu"))]
fn wgpu() -> Result<Engine, Problem> {
    Err(Problem::new(Problem::WRONG_INPUT, "this program was built without wgpu")
        .about("--renderer wgpu")
        .help("`--renderer cpu` renders on the processor; a build with the feature `wgpu` has both"))
}
