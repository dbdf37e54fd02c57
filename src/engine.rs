//! What renders: a graphics adapter or the processor.

use ductloop_sensor::CpuRenderer;
#[cfg(feature = "wgpu")]
use ductloop_sensor::WgpuRenderer;
#[cfg(feature = "wgpu")]
use ductloop_sensor::gpu::Gpu;
#[cfg(feature = "wgpu")]
use ductloop_sensor::renderer::RenderError;
use ductloop_sensor::renderer::Renderer;

use crate::closed_loop::{Pace, RunError};
use crate::scenario::Scenario;

/// An engine that renders, opened.
#[derive(Clone, Debug)]
pub enum Engine {
    /// The processor: the same images to the bit on every x86-64 machine.
    Cpu,
    /// A graphics adapter.
    #[cfg(feature = "wgpu")]
    Wgpu(Gpu),
}

impl Engine {
    /// A graphics adapter of hardware if there is one, else the processor: an adapter that computes on the processor itself would
    /// be the slower way to the same.
    pub fn auto() -> Self {
        #[cfg(feature = "wgpu")]
        if let Some(gpu) = Gpu::open().ok().filter(|gpu| !gpu.adapter().software) {
            return Self::Wgpu(gpu);
        }
        Self::Cpu
    }

    /// Whatever graphics adapter there is, of hardware or software.
    ///
    /// # Errors
    /// Where there is none, or it gives no device.
    #[cfg(feature = "wgpu")]
    pub fn wgpu() -> Result<Self, RenderError> {
        Gpu::open().map(Self::Wgpu)
    }

    /// The word for it in files: `cpu` or `wgpu`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            #[cfg(feature = "wgpu")]
            Self::Wgpu(_) => "wgpu",
        }
    }

    /// A renderer of a scenario's duct, seen by its true rig. On the processor it uses `threads` threads, with the same images
    /// whatever their number.
    ///
    /// # Errors
    /// Where the duct, the rig or the optics cannot be rendered, or the device fails.
    pub fn renderer(&self, scenario: &Scenario, threads: usize) -> Result<Box<dyn Renderer>, RunError> {
        let network = scenario.duct.network()?;
        let looks: Vec<_> = scenario.surfaces.iter().map(|surface| surface.look).collect();
        let (rig, optics, seed) = (scenario.actual_rig(), &scenario.optics, scenario.seed);
        Ok(match self {
            Self::Cpu => Box::new(CpuRenderer::new(&network, &rig, optics, &looks, seed, threads)?),
            #[cfg(feature = "wgpu")]
            Self::Wgpu(gpu) => Box::new(WgpuRenderer::new(gpu, &network, &rig, optics, &looks, seed)?),
        })
    }
}

/// How the threads of a call are used: physics runs on while a frame is rendered and read, if there are two; what is left
/// renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads {
    /// All of them.
    pub all: usize,
}

impl Threads {
    /// As many as run at once here.
    pub fn here() -> Self {
        Self { all: std::thread::available_parallelism().map_or(1, usize::from) }
    }

    /// Those of one run where `jobs` go on at once: at least one.
    pub fn shared_among(self, jobs: usize) -> Self {
        Self { all: (self.all / jobs.max(1)).max(1) }
    }

    /// How a run is carried out.
    pub fn pace(self) -> Pace {
        if self.all > 1 { Pace::Overlapped } else { Pace::Alone }
    }

    /// Those that render.
    pub fn rendering(self) -> usize {
        self.all.saturating_sub(1).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thread_does_everything_and_of_more_one_is_left_to_the_physics() {
        let used = |all: usize| (Threads { all }.pace(), Threads { all }.rendering());
        assert_eq!(used(1), (Pace::Alone, 1));
        assert_eq!(used(2), (Pace::Overlapped, 1));
        assert_eq!(used(5), (Pace::Overlapped, 4));
    }

    #[test]
    fn runs_that_go_on_at_once_share_the_threads_and_each_has_one() {
        let each = |all: usize, jobs: usize| Threads { all }.shared_among(jobs).all;
        assert_eq!([each(8, 1), each(8, 2), each(8, 3), each(8, 8), each(2, 5), each(4, 0)], [8, 4, 2, 1, 1, 4]);
    }
}
