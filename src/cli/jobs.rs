//! Several things at once, with results in order.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Does `one` for 0 to `count - 1`, begun in this order, `jobs` at a time. Once one breaks off, no other is begun.
///
/// Results stand by their index, whichever came first: `None` for what broke off or was not begun.
pub(crate) fn carry_out<T: Send>(count: usize, jobs: usize, one: impl Fn(usize) -> ControlFlow<(), T> + Sync) -> Vec<Option<T>> {
    let next = AtomicUsize::new(0);
    let broken_off = AtomicBool::new(false);
    let results = Mutex::new((0..count).map(|_| None).collect::<Vec<Option<T>>>());
    let work = || {
        while !broken_off.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return;
            }
            match one(index) {
                ControlFlow::Continue(result) => results.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(result),
                ControlFlow::Break(()) => broken_off.store(true, Ordering::Relaxed),
            }
        }
    };
    thread::scope(|scope| {
        // This thread is one of them, and does everything where the system gives no other.
        for _ in 1..jobs.min(count) {
            let _ = thread::Builder::new().name("run".into()).spawn_scoped(scope, work);
        }
        work();
    });
    results.into_inner().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::time::Duration;

    use super::*;

    #[test]
    fn results_are_in_order_however_many_go_on_at_once() {
        for jobs in [0, 1, 2, 3, 20] {
            // Later ones are done sooner.
            let squares = carry_out(9, jobs, |index| {
                thread::sleep(Duration::from_millis(9 - index as u64));
                ControlFlow::Continue(index * index)
            });
            assert_eq!(squares, [0, 1, 4, 9, 16, 25, 36, 49, 64].map(Some), "{jobs} jobs");
        }
        assert_eq!(carry_out(0, 4, |_| ControlFlow::Continue(())), []);
    }

    #[test]
    fn as_many_go_on_at_once_as_were_asked_for_and_no_more() {
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        // Three wait for each other: fewer at a time would hang here.
        let all_here = Barrier::new(3);
        carry_out(9, 3, |_| {
            most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            all_here.wait();
            now.fetch_sub(1, Ordering::SeqCst);
            ControlFlow::Continue(())
        });
        assert_eq!(most.into_inner(), 3);
    }

    #[test]
    fn once_one_breaks_off_no_other_is_begun_and_what_is_done_is_kept() {
        let begun = AtomicUsize::new(0);
        let results = carry_out(100, 1, |index| {
            begun.fetch_add(1, Ordering::SeqCst);
            if index == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(index) }
        });
        assert_eq!((begun.into_inner(), results.len()), (3, 100));
        assert_eq!(results.into_iter().flatten().collect::<Vec<_>>(), [0, 1]);
        // Of two the other goes on to its end.
        let both = Barrier::new(2);
        let results = carry_out(100, 2, |index| {
            if index < 2 {
                both.wait();
            }
            if index == 0 {
                return ControlFlow::Break(());
            }
            thread::sleep(Duration::from_millis(50));
            ControlFlow::Continue(index)
        });
        assert_eq!((results[0], results[1]), (None, Some(1)));
        assert!(results[3..].iter().all(Option::is_none), "{results:?}");
    }
}
