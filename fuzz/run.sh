#!/bin/bash
# Runs the fuzzers one after the other, each from the corpus that the program writes and what earlier
# runs have added to it. Ends with an error where one of them finds a crash, a hang or too much memory;
# the input is then in fuzz/artifacts.
#
#   fuzz/run.sh [SECONDS] [TARGET...]     default: 600 seconds of each
#
# Needs cargo-fuzz (cargo install cargo-fuzz). FUZZ_ARGS is handed to libFuzzer behind the rest.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v cargo-fuzz >/dev/null ||
    { echo "fuzz/run.sh: cargo-fuzz is missing: cargo install cargo-fuzz" >&2; exit 1; }
seconds=600
if [[ "${1:-}" =~ ^[0-9]+$ ]]; then
    seconds=$1
    shift
fi
targets=("$@")
[ $# -gt 0 ] || targets=(obj ply stl off gltf gz rays)

# The sanitizer is an unstable switch; RUSTC_BOOTSTRAP admits it in a stable compiler.
export RUSTC_BOOTSTRAP=1
# Embree and TBB keep some memory for the process's life.
export ASAN_OPTIONS=detect_leaks=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}

cargo run --quiet --locked -p curvetri-fuzz-seeds fuzz/corpus
failed=()
for target in "${targets[@]}"; do
    mkdir -p "fuzz/corpus/$target"
    echo "== $target"
    # Files stay small, so that their number a second is large; the targets themselves hold the
    # memory to ten times a file's length, and the limit here is for what does not go through Rust.
    # shellcheck disable=SC2086
    cargo fuzz run "$target" "fuzz/corpus/$target" -- -max_total_time="$seconds" -timeout=10 \
        -rss_limit_mb=2048 -malloc_limit_mb=512 -max_len=16384 -print_final_stats=1 \
        ${FUZZ_ARGS:-} || failed+=("$target")
done
[ ${#failed[@]} -eq 0 ] || { echo "fuzz/run.sh: failed: ${failed[*]}" >&2; exit 1; }
