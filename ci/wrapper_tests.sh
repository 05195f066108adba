#!/bin/bash
# Runs the tests of the Embree wrapper and of the callbacks on it, for where they run once more: under
# AddressSanitizer (ci/asan.sh) and with another Embree (.ci/run). Arguments go to `cargo test`.
set -euo pipefail
cd "$(dirname "$0")/.."

# Little of it is arithmetic, so that compiling costs more than running. Nothing being inlined, each operation
# on lanes has a frame with room around it: more than a test's thread has by default.
export CARGO_PROFILE_TEST_OPT_LEVEL=0 RUST_MIN_STACK=$((256 << 20))
# What is skipped traces hundreds of thousands of rays, in no other way than the others do.
cargo test --locked "$@" --package curvetri-embree --package curvetri-embree-linked --package curvetri \
    --lib --test embree -- --skip closed_meshes_stay_closed --skip glass_tests
