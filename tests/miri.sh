#!/bin/sh
# The one place with `unsafe`, rattle-core/src/number/instructions.rs, under Miri: as a processor without wide instructions, as one
# with AVX2 and as one with AVX-512 would go through it. Wants a nightly toolchain with Miri:
#
#     rustup toolchain install nightly --profile minimal --component miri,rust-src
#
# `is_x86_feature_detected!` says under Miri what the program was compiled for, so that each branch is taken once. Miri stops where code
# is called that was compiled for instructions that are not there, which is what is unsafe about these calls; there are no pointers. That
# a processor has what `cpuid` says, and that machine code of wide instructions is right, Miri cannot see: `vectorised/tests/vectorised.rs`
# and the laws of the program `lanes` (`tests/programs/lanes.rs`), which compare sets with each other, look at that.
set -e
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/miri"
for features in "" "+avx2,+fma" "+avx2,+fma,+avx512f,+avx512dq,+avx512vl,+avx512bw"; do
    echo "target features: ${features:-those of every processor}"
    RUSTFLAGS="${features:+-C target-feature=$features}" \
        cargo +nightly miri test -p rattle-core --lib number::instructions -- --nocapture
done
