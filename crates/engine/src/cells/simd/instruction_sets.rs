//! Instruction sets as zero-sized values: a value of such a type proves that this processor has the
//! instructions.
//!
//! A call of a function with `#[target_feature]` is undefined behaviour on a processor without
//! these instructions. Each set here is one type, with one private field and one constructor,
//! `detect`, which detects every feature of the set. So safe code holds a value only where the
//! instructions exist, and a function that takes the value may use them. The value has size 0: no
//! register holds it, and no instruction passes it on.
//!
//! Detection and `#[target_feature]` are generated from one list of features, so they cannot
//! differ.

use std::arch::is_x86_feature_detected;

/// A computation that is compiled with the instructions of a set `S`.
pub(in crate::cells) trait CompiledWith<S> {
    type Output;

    /// Runs the computation; `set` proves that this processor has the instructions. Inlined, so
    /// that it is compiled with them.
    fn with(self, set: S) -> Self::Output;
}

/// A proof that this processor has the instructions of a set.
pub(in crate::cells) trait InstructionSet: Copy {
    /// Runs a computation in a function that is compiled with the instructions of the set.
    fn run<W: CompiledWith<Self>>(self, work: W) -> W::Output;

    /// As [`Self::run`], in a function that is never inlined.
    fn run_apart<W: CompiledWith<Self>>(self, work: W) -> W::Output;
}

/// Defines an instruction set: its type, its detection, and the function compiled for it.
macro_rules! instruction_set {
    ($(#[$attribute:meta])* $set:ident: $($feature:tt),+) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(in crate::cells) struct $set(());

        impl $set {
            /// The proof, if this processor and its operating system support every feature of the
            /// set.
            pub fn detect() -> Option<Self> {
                ($(is_x86_feature_detected!($feature))&&+).then_some(Self(()))
            }
        }

        impl InstructionSet for $set {
            #[inline]
            fn run<W: CompiledWith<Self>>(self, work: W) -> W::Output {
                #[target_feature($(enable = $feature),+)]
                fn compiled<W: CompiledWith<$set>>(set: $set, work: W) -> W::Output {
                    work.with(set)
                }
                // SAFETY: `compiled` needs the features of this set. `self` exists, and only
                // `detect` makes it, after it has found each of them on this processor.
                unsafe { compiled(self, work) }
            }

            #[inline(always)]
            fn run_apart<W: CompiledWith<Self>>(self, work: W) -> W::Output {
                #[target_feature($(enable = $feature),+)]
                #[inline(never)]
                fn compiled<W: CompiledWith<$set>>(set: $set, work: W) -> W::Output {
                    work.with(set)
                }
                // SAFETY: as in `run`.
                unsafe { compiled(self, work) }
            }
        }
    };
}

instruction_set! {
    /// AVX2, and the instructions on bits of integers that every processor with AVX2 has.
    Avx2: "avx2", "bmi1", "bmi2", "lzcnt", "popcnt"
}

instruction_set! {
    /// AVX-512 (F, VL, DQ, BW) and [`Avx2`]. The compiler takes FMA and F16C to be part of
    /// AVX-512F, so they are detected, although no kernel fuses operations.
    Avx512:
        "avx2", "bmi1", "bmi2", "lzcnt", "popcnt",
        "fma", "f16c", "avx512f", "avx512vl", "avx512dq", "avx512bw"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proof_has_no_size() {
        assert_eq!(size_of::<Avx2>(), 0);
        assert_eq!(size_of::<Avx512>(), 0);
    }

    /// An independent source: the flags that the operating system reports for this processor.
    #[test]
    #[cfg(target_os = "linux")]
    fn detection_agrees_with_the_operating_system() {
        let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap();
        let flags: Vec<&str> = cpuinfo
            .lines()
            .find_map(|line| line.strip_prefix("flags"))
            .unwrap()
            .split_whitespace()
            .collect();
        let has = |names: &[&str]| names.iter().all(|name| flags.contains(name));
        // Linux calls LZCNT "abm".
        let avx2 = has(&["avx2", "bmi1", "bmi2", "abm", "popcnt"]);
        let avx512 = has(&["fma", "f16c", "avx512f", "avx512vl", "avx512dq", "avx512bw"]);
        // Emulators of a processor report its features, which may be fewer.
        assert!(Avx2::detect().is_none() || avx2);
        assert!(Avx512::detect().is_none() || avx2 && avx512);
    }
}
