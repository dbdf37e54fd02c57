//! The engine in plain Rust: the reference, and the default where there is no hardware adapter.
//!
//! Its images are the same to the bit for any number of threads, any optimisation level, any x86-64 processor and whatever vector
//! instructions it picks at run time: pixels are computed in single precision by operations that IEEE 754 rounds the same
//! everywhere, in an order that the source alone decides. Nothing is fused, reordered or left to a library of the system.
//!
//! A frame comes about in this order:
//!
//! - [`crate::exposure_parts`]: the parts of the exposure, one where nothing moves; of each a [`picture`]: geometry, [`raster`] (which
//!   region each pixel sees), [`surfaces`], [`ridges`] (the strips) and their [`intervals`],
//!   and the pixels that edges cross ([`crate::soft_edges`]);
//! - bands of rows, on any thread ([`band`]): [`smooth`] light, its point [`spread`], the strips' light with their [`edges`],
//!   [`transmission`] through seams and spangle, and mean electrons;
//! - [`blooming`], where a pixel is full;
//! - [`ccd`]: noise and grey values.
//!
//! Of the model in double precision ([`crate::strip`], `docs/sensor-model.md`) it is within 0.05 DN.

mod band;
mod blooming;
mod ccd;
mod edges;
mod intervals;
mod picture;
pub(crate) mod raster;
mod ridges;
mod smooth;
mod spread;
mod surfaces;
pub(crate) mod tables;
mod transmission;
mod vectors;

use std::sync::Mutex;

use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;
use rayon::prelude::*;

use self::band::{BAND_ROWS, Model, Workspace};
use self::blooming::{Spilt, bloom};
use self::ccd::{Exposure, Grey, Shot};
use self::picture::Picture;
use self::ridges::LensBlur;
use self::spread::Spread;
use self::tables::{PixelTable, RayTable};
use self::vectors::vectorised;
use crate::exposure_parts;
use crate::frame_geometry::FrameGeometry;
use crate::optics::Optics;
use crate::renderer::{ImageMut, RenderError, Renderer, View, check_parameters};
use crate::scenery::Scenery;
use crate::surface::Look;

/// Renders on the processor.
#[derive(Debug)]
pub struct CpuRenderer {
    scenery: Scenery,
    rig: Rig,
    optics: Optics,
    seed: u64,
    model: Model,
    /// The parts of the exposure; more are made when a frame first needs them.
    pictures: Vec<Picture>,
    /// One a thread.
    workspaces: Vec<Mutex<Workspace>>,
    /// Mean electrons of the whole image, where charge may spill.
    mean_e: Vec<f32>,
    spilt: Spilt,
    /// None for a single thread.
    pool: Option<rayon::ThreadPool>,
}

impl CpuRenderer {
    /// A renderer of what `rig` sees of `network`, whose surfaces look as `looks` says (indexed by surface), on `threads` threads
    /// (at least one). `seed` chooses all its random numbers.
    ///
    /// # Errors
    /// Whatever is wrong with rig, optics and looks; [`RenderError::Device`] when the threads cannot be started.
    pub fn new(
        network: &Network,
        rig: &Rig,
        optics: &Optics,
        looks: &[Look],
        seed: u64,
        threads: usize,
    ) -> Result<Self, RenderError> {
        check_parameters(rig, optics)?;
        let scenery = Scenery::new(network, looks)?;
        let geometry = FrameGeometry::new(rig, optics)?;
        let (width, height) = (rig.camera.width_px, rig.camera.height_px);
        let spread = Spread::new(&optics.lens, geometry.blur());
        let model = Model {
            arch: pulp::Arch::new(),
            rays: RayTable::new(geometry.projection(), spread.radius),
            pixels: PixelTable::new(optics, seed, width, height),
            lens: LensBlur::new(geometry.blur()),
            exposure: Exposure::new(optics, width, height),
            vignetting: optics.lens.vignetting,
            spread,
        };
        let threads = threads.max(1);
        let pool = (threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build())
            .transpose()
            .map_err(|error| RenderError::Device(format!("{threads} threads could not be started: {error}")))?;
        let blooms = optics.ccd.blooming > 0.0;
        Ok(Self {
            workspaces: (0..threads).map(|_| Mutex::new(Workspace::new(&model))).collect(),
            mean_e: vec![0.0; if blooms { model.pixels.stride * height } else { 0 }],
            pictures: vec![Picture::new(geometry)],
            scenery,
            rig: rig.clone(),
            optics: optics.clone(),
            seed,
            model,
            spilt: Spilt::default(),
            pool,
        })
    }

    /// Makes the pictures of an exposure and returns how many they are.
    fn look(&mut self, view: &View) -> Result<usize, RenderError> {
        let lens = &self.optics.lens;
        let whole = exposure_parts::whole(view, lens);
        self.pictures[0].geometry.build(&self.scenery, &whole, &view.laser_power)?;
        let parts = exposure_parts::parts(view, lens, &self.pictures[0].geometry);
        let count = parts.len();
        if count > 1 {
            for (index, sweep) in parts.enumerate() {
                if index == self.pictures.len() {
                    self.pictures.push(Picture::new(FrameGeometry::new(&self.rig, &self.optics)?));
                }
                self.pictures[index].geometry.build(&self.scenery, &sweep, &view.laser_power)?;
            }
        }
        for picture in &mut self.pictures[..count] {
            picture.prepare(&self.scenery, &self.optics, view, &self.model.rays);
        }
        Ok(count)
    }

    /// Exposes and reads out all bands.
    fn develop<T: Grey>(&mut self, shot: &Shot, pictures: usize, image: &mut [T]) {
        let Self { model, pictures: all, workspaces, mean_e, spilt, pool, optics, .. } = self;
        let (model, pictures) = (&*model, &all[..pictures]);
        let (width, height, stride) = (model.rays.width, model.rays.height, model.pixels.stride);
        let rows_of = |band: usize| band * BAND_ROWS..((band + 1) * BAND_ROWS).min(height);
        let workspace = || {
            let thread = rayon::current_thread_index().filter(|_| workspaces.len() > 1).unwrap_or(0);
            // A thread that panicked left its workspace as it is: each band writes what it reads.
            workspaces[thread].lock().unwrap_or_else(std::sync::PoisonError::into_inner)
        };
        if optics.ccd.blooming == 0.0 {
            let make = |(band, image): (usize, &mut [T])| {
                let work = &mut *workspace();
                let mut mean_e = std::mem::take(&mut work.mean_e);
                work.expose(model, pictures, shot, rows_of(band), &mut mean_e);
                read_out(model, shot, rows_of(band), &mean_e, work, image);
                work.mean_e = mean_e;
            };
            match pool {
                None => image.chunks_mut(BAND_ROWS * width).enumerate().for_each(make),
                Some(pool) => pool.install(|| image.par_chunks_mut(BAND_ROWS * width).enumerate().for_each(make)),
            }
            return;
        }
        let expose = |(band, mean_e): (usize, &mut [f32])| workspace().expose(model, pictures, shot, rows_of(band), mean_e);
        match pool {
            None => mean_e.chunks_mut(BAND_ROWS * stride).enumerate().for_each(expose),
            Some(pool) => pool.install(|| mean_e.par_chunks_mut(BAND_ROWS * stride).enumerate().for_each(expose)),
        }
        let well_e = optics.ccd.full_well_e as f32;
        if mean_e.iter().any(|charge| *charge > well_e) {
            bloom(mean_e, stride, well_e, optics.ccd.blooming as f32, spilt);
        }
        let mean_e = &*mean_e;
        let read = |(band, image): (usize, &mut [T])| {
            let mean_e = &mean_e[band * BAND_ROWS * stride..];
            read_out(model, shot, rows_of(band), mean_e, &mut workspace(), image);
        };
        match pool {
            None => image.chunks_mut(BAND_ROWS * width).enumerate().for_each(read),
            Some(pool) => pool.install(|| image.par_chunks_mut(BAND_ROWS * width).enumerate().for_each(read)),
        }
    }
}

/// Grey values of a band.
fn read_out<T: Grey>(
    model: &Model,
    shot: &Shot,
    rows: std::ops::Range<usize>,
    mean_e: &[f32],
    work: &mut Workspace,
    image: &mut [T],
) {
    let (width, stride) = (model.rays.width, model.pixels.stride);
    for (r, row) in rows.enumerate() {
        let mean_e = &mean_e[r * stride..(r + 1) * stride];
        let dark_e = model.pixels.dark_e.get(row * stride..(row + 1) * stride);
        let out = &mut image[r * width..(r + 1) * width];
        let numbers = &mut work.numbers;
        vectorised(
            model.arch,
            #[inline(always)]
            || model.exposure.read_out(shot, row, mean_e, dark_e, numbers, out),
        );
    }
}

impl Renderer for CpuRenderer {
    fn render(&mut self, view: &View, image: ImageMut<'_>) -> Result<(), RenderError> {
        image.check(self.model.rays.width * self.model.rays.height, self.optics.ccd.bits)?;
        view.validate()?;
        let pictures = self.look(view)?;
        let shot = self.model.exposure.shot(self.seed, view.frame, view.exposure_s);
        match image {
            ImageMut::Grey8(image) => self.develop(&shot, pictures, image),
            ImageMut::Grey16(image) => self.develop(&shot, pictures, image),
        }
        Ok(())
    }
}
