//! Instruction sets: detection at run time, and work compiled for each of them.

use std::fmt;

/// An instruction set for which work is compiled.
#[doc(alias = "SIMD")]
#[doc(alias = "AVX")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// The baseline that every processor of the target has. On x86-64: two doubles at a time, without fused
    /// multiply-add.
    Portable,
    /// Four doubles at a time, with fused multiply-add.
    Avx2,
    /// Eight doubles at a time, with fused multiply-add.
    Avx512,
}

impl InstructionSet {
    /// The widest instruction set of this processor.
    #[must_use]
    pub fn widest() -> Self {
        [Self::Avx512, Self::Avx2].into_iter().find(|set| set.is_present()).unwrap_or(Self::Portable)
    }

    /// Whether this processor has it.
    #[must_use]
    pub fn is_present(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_present()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Whether x·y + z is one instruction.
    #[must_use]
    pub fn fuses(self) -> bool {
        self != Self::Portable || cfg!(any(target_arch = "aarch64", target_feature = "fma"))
    }

    /// Does the work with these instructions, or with those that every processor has if this one does not have them.
    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Done {
        #[cfg(target_arch = "x86_64")]
        if self.is_present() {
            match self {
                #[allow(
                    unsafe_code,
                    reason = "the one place: the instructions are present, as was just asked"
                )]
                Self::Avx512 => return unsafe { with_avx512(work) },
                #[allow(unsafe_code, reason = "the same")]
                Self::Avx2 => return unsafe { with_avx2(work) },
                Self::Portable => {}
            }
        }
        work.run()
    }
}

/// A set of instructions in which x·y + z is one, and which this processor has. Work that is done by such sets alone is
/// not compiled for others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fusing(InstructionSet);

impl Fusing {
    /// This one, if it is such a set.
    pub(crate) fn of(set: InstructionSet) -> Option<Self> {
        Some(Self(set)).filter(|_| set.fuses() && set.is_present())
    }

    /// The widest instruction set of this processor.
    pub(crate) fn widest() -> Option<Self> {
        Self::of(InstructionSet::widest())
    }

    /// Does the work with these instructions.
    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Done {
        match self.0 {
            #[cfg(all(target_arch = "x86_64", not(target_feature = "avx512f")))]
            #[allow(unsafe_code, reason = "only sets that are present are made")]
            InstructionSet::Avx512 => unsafe { with_avx512(work) },
            _ => self.run_narrow(work),
        }
    }

    /// Does work on L lanes.
    #[inline]
    pub(crate) fn run_lanes<const L: usize, W: Work>(self, work: W) -> W::Done {
        if const { L == 1 } { self.run_narrow(work) } else { self.run(work) }
    }

    /// Does work that wide registers are no use for.
    #[inline]
    #[allow(clippy::unused_self, reason = "that there is such a set is what makes it safe")]
    pub(crate) fn run_narrow<W: Work>(self, work: W) -> W::Done {
        #[cfg(all(target_arch = "x86_64", not(target_feature = "fma")))]
        #[allow(unsafe_code, reason = "who has AVX-512 has it, and the portable set does not fuse here")]
        return unsafe { with_avx2(work) };
        #[cfg(not(all(target_arch = "x86_64", not(target_feature = "fma"))))]
        work.run()
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        })
    }
}

/// Work to be compiled for each instruction set. `run` and everything that it calls must be `#[inline(always)]`, since
/// only inlined code uses the instructions. What is long, and asked for at several places, is work of its own: inlined,
/// it is compiled at each place.
pub trait Work {
    /// The result.
    type Done;
    /// Does the work.
    fn run(self) -> Self::Done;
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
fn with_avx512<W: Work>(work: W) -> W::Done {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2<W: Work>(work: W) -> W::Done {
    work.run()
}

#[cfg(test)]
mod tests {
    use super::{Fusing, InstructionSet, Work};

    /// A sum of products, in a loop that a compiler vectorises.
    struct Sum<'a>(&'a [f64], &'a mut [f64]);

    impl Work for Sum<'_> {
        type Done = f64;
        #[inline(always)]
        fn run(self) -> f64 {
            for (x, y) in self.0.iter().zip(self.1.iter_mut()) {
                *y += x * x;
            }
            self.1.iter().sum()
        }
    }

    /// `tests/miri.sh` runs this under Miri, which reports a call of code for instructions that are not there.
    #[test]
    fn work_is_the_same_by_all_sets() {
        let x: Vec<f64> = (0..37).map(f64::from).collect();
        let set = |run: &dyn Fn(Sum<'_>) -> f64| {
            let mut y = vec![1.0; x.len()];
            run(Sum(&x, &mut y))
        };
        let expected = 37.0 + 36.0 * 37.0 * 73.0 / 6.0; // whole numbers: exact in any order
        for asked in [InstructionSet::Portable, InstructionSet::Avx2, InstructionSet::Avx512] {
            assert_eq!(set(&|work| asked.run(work)), expected, "{asked}");
            if let Some(fusing) = Fusing::of(asked) {
                assert_eq!(set(&|work| fusing.run(work)), expected, "{asked}, fusing");
                assert_eq!(set(&|work| fusing.run_narrow(work)), expected, "{asked}, narrow");
            }
            println!("{asked}: {}", if asked.is_present() { "present" } else { "not present" });
        }
    }
}
