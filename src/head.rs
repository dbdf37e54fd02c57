//! The robot's head: the camera, what becomes of its frames, and the navigator behind it.

use ductloop_nav::messages::{Command, Counts, Tick};
use ductloop_nav::navigator::{Navigator, Report};
use ductloop_nav::rig::MountAngles;
use ductloop_sensor::renderer::{Renderer, View};

use crate::closed_loop::RunError;
use crate::command_check;
use crate::fault::ActiveFaults;
use crate::fault::camera::{Delivery, Exposed, UnderWay, delivery, spoil};
use crate::grey_image::GreyImage;
use crate::navigator_process::FailureSlot;
use crate::pilot::{Pilot, TruthFeed};
use crate::scenario::Scenario;

/// What belongs to an exposure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure<'v> {
    pub(crate) view: &'v View,
    /// The true errors and the duct's width there, for a navigator that steers by the truth.
    pub(crate) truth: [f64; 3],
    /// As they are read.
    pub(crate) counts: Counts,
    /// As it is read.
    pub(crate) mount: MountAngles,
    pub(crate) tick: Tick,
}

/// Camera and navigator.
pub(crate) struct Head<'a> {
    renderer: &'a mut dyn Renderer,
    navigator: Box<dyn Navigator>,
    truth: Option<TruthFeed>,
    /// Where a navigator that is a program of its own says that it has failed.
    failure: Option<FailureSlot>,
    image: GreyImage,
    under_way: UnderWay,
    delivery: Delivery,
    seed: u64,
    black_dn: f64,
}

impl<'a> Head<'a> {
    pub(crate) fn new(scenario: &Scenario, pilot: Pilot, renderer: &'a mut dyn Renderer) -> Self {
        let image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        let Pilot { navigator, truth, failure } = pilot;
        Self {
            renderer,
            navigator,
            truth,
            failure,
            image,
            under_way: UnderWay::default(),
            delivery: Delivery::Fresh,
            seed: scenario.seed,
            black_dn: scenario.optics.ccd.black_level_dn,
        }
    }

    /// Exposes a frame and has the navigator decide on what arrives of it; `None` where nothing does.
    pub(crate) fn look(&mut self, exposure: &Exposure<'_>, active: &ActiveFaults<'_>) -> Result<Option<Command>, RunError> {
        let Exposure { view, truth, counts, mount, tick } = *exposure;
        self.delivery = delivery(active, self.seed, view.frame);
        if !matches!(self.delivery, Delivery::Late(_)) {
            self.under_way.clear();
        }
        match self.delivery {
            Delivery::Dropped => return Ok(None),
            // The image is still there.
            Delivery::Repeated if view.frame > 0 => {}
            Delivery::Fresh | Delivery::Repeated => self.expose(view, active)?,
            Delivery::Late(frames) => {
                self.expose(view, active)?;
                let exposed = Exposed { image: self.image.clone(), truth, counts, mount, tick };
                let Some(late) = self.under_way.pass(exposed, frames) else { return Ok(None) };
                self.image = late.image;
                return self.decide(late.truth, late.counts, late.mount, late.tick);
            }
        }
        self.decide(truth, counts, mount, tick)
    }

    fn decide(&mut self, truth: [f64; 3], counts: Counts, mount: MountAngles, tick: Tick) -> Result<Option<Command>, RunError> {
        if let Some(feed) = &self.truth {
            let [lateral_m, heading_rad, width_m] = truth;
            feed.set(lateral_m, heading_rad, width_m);
        }
        let command = self.navigator.on_frame(&self.image.frame(), counts, mount, tick);
        match self.failure.as_ref().and_then(FailureSlot::get) {
            Some(error) => Err(error.into()),
            None => match command_check::check(&command) {
                Ok(()) => Ok(Some(command)),
                Err(what) => Err(RunError::Command { what, tick }),
            },
        }
    }

    fn expose(&mut self, view: &View, active: &ActiveFaults<'_>) -> Result<(), RunError> {
        self.renderer.render(view, self.image.room())?;
        spoil(&mut self.image, active, self.seed, self.black_dn);
        Ok(())
    }

    /// The image that arrived last; where none did, the one that was exposed last.
    pub(crate) fn image(&self) -> &GreyImage {
        &self.image
    }

    /// Whether what arrived last was this exposure's frame.
    pub(crate) fn is_fresh(&self) -> bool {
        self.delivery == Delivery::Fresh
    }

    /// What the navigator made of the last frame; of a frame that did not arrive, only its state.
    pub(crate) fn report(&self, arrived: bool) -> Report<'_> {
        let report = self.navigator.report();
        if arrived { report } else { Report { state: report.state, ..Report::default() } }
    }
}
