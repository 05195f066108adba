#!/bin/bash
# All that has to hold before an issue is closed: .ci/run, and what takes longer than a change should wait.
# With names it runs those steps only.
#
# - asan_contract: whole bodies under AddressSanitizer. .ci/run has the wrapper's and the callbacks' own tests.
# - package: each package compiled from its own archive, the kernel among them. .ci/run packs them.
# - debian13: every test with Embree 4.3. .ci/run has those that depend on what Embree answers.
# - fuzzers: two minutes each. .ci/run reads their seeds, damaged in many ways.
set -euo pipefail
cd "$(dirname "$0")/.."

asan_contract() { ci/asan.sh --contract; }
package() { ci/package.sh --verify; }
debian13() { ci/debian13.sh cargo test --locked --workspace; }
fuzzers() {
    command -v cargo-fuzz >/dev/null || cargo install --locked --quiet cargo-fuzz
    fuzz/run.sh 120
}

if [ $# -eq 0 ]; then
    .ci/run
    set -- asan_contract package debian13 fuzzers
fi
for step; do
    echo "== $step"
    SECONDS=0
    "$step"
    echo "== $step took $SECONDS s"
done
