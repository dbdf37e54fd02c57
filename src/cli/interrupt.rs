//! Ctrl-C: the first asks a run to stop at its next frame, the second ends the program at once. Either way what is being
//! written is staged aside, so that only whole files are seen.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Listens for it (and for SIGTERM and SIGHUP, where there are any).
pub(crate) fn listen() {
    // It fails only if somebody listens already, and nobody else does.
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(super::INTERRUPTED));
        }
    });
}

/// Whether it has come.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
