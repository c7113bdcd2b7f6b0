//! Calls of the scheduler's methods in the build for an instruction set.

/// Defines a function that calls a method of `CellState` in the build for the chosen instruction
/// set.
macro_rules! dispatched {
    ($name:ident ( $($argument:ident : $type:ty),* )) => {
        #[inline]
        pub(in crate::cells) fn $name<F: $crate::cells::frame::CellFrame, D: carom_detection::Detection>(
            state: &mut $crate::cells::state::CellState<F>,
            world: &$crate::World,
            detection: &D
            $(, $argument: $type)*
        ) {
            struct Call<'a, F: $crate::cells::frame::CellFrame, D> {
                state: &'a mut $crate::cells::state::CellState<F>,
                world: &'a $crate::World,
                detection: &'a D,
                $($argument: $type,)*
            }
            impl<F: $crate::cells::frame::CellFrame, D: carom_detection::Detection> $crate::cells::simd::KernelWork
                for Call<'_, F, D>
            {
                type Output = ();

                #[inline(always)]
                fn with<K: $crate::cells::simd::Kernel>(self, kernel: K) {
                    self.state.$name(kernel, self.world, self.detection $(, self.$argument)*);
                }
            }
            $crate::cells::simd::dispatch(state.instructions, Call { state, world, detection $(, $argument)* });
        }
    };
}

pub(super) use dispatched;
