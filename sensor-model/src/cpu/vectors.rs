//! Runs loops with the vector instructions that the processor has.

use pulp::{Arch, Simd, WithSimd};

/// Runs `body` as compiled for the processor at hand. Only what is inlined into it is: mark it, and all that it calls,
/// `#[inline(always)]`.
#[inline(always)]
pub(super) fn vectorised(arch: Arch, body: impl FnMut()) {
    /// A closure handed to pulp as such would be called through a shim, which is not inlined.
    struct Body<F>(F);

    impl<F: FnMut()> WithSimd for Body<F> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(mut self, _: S) {
            (self.0)();
        }
    }

    arch.dispatch(Body(body));
}
