//! All frames of a study, on several threads. Each is a function of its cell and number alone, so the result is the same to the bit
//! however many threads there are.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

use super::figures::Figures;
use super::trial::{Trial, TrialError, trial};
use crate::scenario::Pipeline;
use crate::scenario::accuracy_file::AccuracyFile;

/// The frames, cell by cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Trials {
    /// Every frame, in the order of (cell, number).
    pub list: Vec<Trial>,
}

impl Trials {
    /// Figures of a pipeline, in a cell of the grid or over all.
    pub fn figures(&self, cell: Option<usize>, pipeline: Pipeline) -> Figures {
        Figures::of(self.list.iter().filter(|trial| cell.is_none_or(|cell| trial.cell == cell)), pipeline)
    }
}

/// Carries out a study on `threads` threads. `watch` is told how many frames are done, and may break it off; then there is no
/// result.
///
/// # Errors
/// The first frame, in order, that could not be made.
pub fn carry_out(
    file: &AccuracyFile,
    threads: usize,
    mut watch: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Option<Trials>, Box<TrialError>> {
    let per_cell = file.poses.count as usize;
    let count = per_cell * file.cells.len();
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut done: Vec<Option<Result<Trial, Box<TrialError>>>> = Vec::new();
    done.resize_with(count, || None);
    let mut made = 0;
    std::thread::scope(|scope| {
        let (sender, results) = mpsc::channel();
        for _ in 0..threads.clamp(1, count.max(1)) {
            let sender = sender.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= count {
                        break;
                    }
                    let (cell, index) = (place / per_cell, (place % per_cell) as u64);
                    let result = trial(&file.cells[cell].scenario, cell, &file.poses, index, &file.pipelines);
                    if sender.send((place, result)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (place, result) in results {
            // No frame after one that failed is needed; those before it may be on their way.
            let failed = result.is_err();
            done[place] = Some(result);
            made += 1;
            if failed || watch(made).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    let mut list = Vec::with_capacity(count);
    for result in done {
        match result {
            Some(result) => list.push(result?),
            None => return Ok(None),
        }
    }
    Ok(Some(Trials { list }))
}
