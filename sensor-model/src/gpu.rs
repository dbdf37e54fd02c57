//! The graphics device: one instance and one device, shared by all renderers of a process.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::renderer::RenderError;

/// Longest that a frame may take before the device counts as hung. The first one compiles shaders: 0.3 s on lavapipe.
pub(crate) const FRAME_TIMEOUT: Duration = Duration::from_secs(20);

/// Longest that opening a device may take: drivers start services and fill caches the first time.
const OPEN_TIMEOUT: Duration = Duration::from_secs(60);

/// What renders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Its name, as its driver gives it.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// Whether it computes on the processor (lavapipe, WARP).
    pub software: bool,
}

/// A graphics device. Clones are the same device; it may be used from several threads.
#[derive(Clone, Debug)]
pub struct Gpu {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    adapter: Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// The first thing that went wrong on the device; it stays.
    fault: Arc<Mutex<Option<RenderError>>>,
}

impl Gpu {
    /// Opens the fastest adapter there is. The environment variables of wgpu (`WGPU_BACKEND`) and of the Vulkan loader
    /// (`VK_DRIVER_FILES`) choose among several.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] where there is none, [`RenderError::Device`] where it gives no device, [`RenderError::Hung`] where the
    /// driver does not answer within a minute.
    pub fn open() -> Result<Self, RenderError> {
        // Drivers are asked without a limit of time: they are waited for elsewhere.
        let (tell, told) = std::sync::mpsc::sync_channel(1);
        std::thread::spawn(move || {
            // Nobody listens any more only if the wait below has given up.
            let _ = tell.send(Self::open_unlimited());
        });
        told.recv_timeout(OPEN_TIMEOUT).unwrap_or(Err(RenderError::Hung(OPEN_TIMEOUT.as_secs_f64())))
    }

    fn open_unlimited() -> Result<Self, RenderError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter =
            pollster::block_on(instance.request_adapter(&options)).map_err(|error| RenderError::NoAdapter(error.to_string()))?;
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("ductloop"),
            // The default limits, but for the size of images, where the adapter's own holds.
            required_limits: wgpu::Limits::default().using_resolution(adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| RenderError::Device(error.to_string()))?;

        let fault: Arc<Mutex<Option<RenderError>>> = Arc::default();
        let lost = Arc::clone(&fault);
        // A device that is dropped reports its loss too; there is nobody left to tell.
        device.set_device_lost_callback(move |reason, message| {
            let message = if message.is_empty() { format!("{reason:?}") } else { message };
            record(&lost, RenderError::Lost(message));
        });
        let refused = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            record(&refused, RenderError::Device(error.to_string()));
        }));

        let adapter = Adapter {
            name: info.name,
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            backend: info.backend.to_str().to_owned(),
            software: info.device_type == wgpu::DeviceType::Cpu,
        };
        Ok(Self { shared: Arc::new(Shared { adapter, device, queue, fault }) })
    }

    /// What renders.
    pub fn adapter(&self) -> &Adapter {
        &self.shared.adapter
    }

    /// Gives the device back, for all its clones: every frame that is asked for after that fails with [`RenderError::Lost`].
    pub fn close(&self) {
        self.shared.device.destroy();
        // The loss is reported by the next poll; what it says is `check`'s to tell.
        let _ = self.shared.device.poll(wgpu::PollType::Poll);
    }

    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.shared.device
    }

    pub(crate) fn queue(&self) -> &wgpu::Queue {
        &self.shared.queue
    }

    /// The first thing that went wrong on the device, if anything did. After that no frame of it is to be trusted.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let fault = self.shared.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault.clone().map_or(Ok(()), Err)
    }

    /// The first thing that went wrong on the device, or else this.
    pub(crate) fn fault_or(&self, message: String) -> RenderError {
        self.check().err().unwrap_or(RenderError::Device(message))
    }

    /// Waits for a submission, and for the mappings asked for after it.
    pub(crate) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(FRAME_TIMEOUT) };
        match self.shared.device.poll(wait) {
            Ok(_) => self.check(),
            Err(wgpu::PollError::Timeout) => {
                record(&self.shared.fault, RenderError::Hung(FRAME_TIMEOUT.as_secs_f64()));
                self.check()
            }
            Err(error) => Err(self.fault_or(error.to_string())),
        }
    }
}

fn record(fault: &Mutex<Option<RenderError>>, error: RenderError) {
    fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
}
