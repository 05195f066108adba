#!/bin/bash
# Runs the tests of the parts without foreign functions under Miri: maths, meshes, cameras; or those
# that the arguments name.
#
# Needs the component miri of a nightly toolchain; where it is missing it says so and ends with 0.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! cargo +nightly miri --version >/dev/null 2>&1; then
    echo "**********************************************************************" >&2
    echo "** SKIPPED: nothing was run under Miri: rustup toolchain install nightly --component miri" >&2
    echo "**********************************************************************" >&2
    exit 0
fi

# With DOCS_RS set nothing of Embree is compiled or linked, so only tests that never call it can run.
export DOCS_RS=1
export CARGO_TARGET_DIR=${MIRI_TARGET:-$PWD/target-miri}
export MIRIFLAGS="-Zmiri-disable-isolation ${MIRIFLAGS:-}"
export PROPTEST_CASES=${PROPTEST_CASES:-4}
[ $# -gt 0 ] || set -- --package curvetri-method --package curvetri-mesh --package curvetri-bodies
cargo +nightly miri test --locked --lib "$@"
