#!/bin/bash
# Runs the tests of the Embree wrapper and of the callbacks on it under AddressSanitizer, the C shim and
# leaks included. A report ends it with an error.
#
#   ci/asan.sh              the wrapper and the curved geometry
#   ci/asan.sh --contract   also packets, filters, instances and all hits of whole bodies: much slower
#
# ASAN_TARGET   cargo's target directory   (default: target-asan in the checkout)
set -euo pipefail
cd "$(dirname "$0")/.."

host=$(rustc -vV | sed -n 's/^host: //p')
runtime=$(rustc --print sysroot)/lib/rustlib/$host/lib
if ! compgen -G "$runtime/librustc-*_rt.asan.a" >/dev/null; then
    echo "**********************************************************************" >&2
    echo "** SKIPPED: nothing was run under AddressSanitizer: this Rust has no runtime of it" >&2
    echo "**********************************************************************" >&2
    exit 0
fi

suppressions=$(mktemp)
trap 'rm -f "$suppressions"' EXIT
cat >"$suppressions" <<'END'
# Embree keeps some of its own for the process's life (its thread-local allocators, the tasking system's
# state), and so does TBB (its thread pool and per-thread data): not freed when the last device is.
leak:libembree
leak:libtbb
END

# The compiler's own switch is unstable; RUSTC_BOOTSTRAP admits it in a stable compiler. With --target,
# build scripts and macros stay as they are.
export RUSTC_BOOTSTRAP=1
flags="-Zsanitizer=address -Cforce-frame-pointers=yes"
# the kernel is safe code and the same for every instruction set: instrumented for one, it compiles in a
# fraction of the time
for level in sse4_2 avx2 avx512; do
    flags+=" --cfg disable_dispatch_$level"
done
export RUSTFLAGS="${RUSTFLAGS:-} $flags"
export "CFLAGS_${host//-/_}=-fsanitize=address -fno-omit-frame-pointer"
export CARGO_TARGET_DIR=${ASAN_TARGET:-$PWD/target-asan}
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_init_order=1${ASAN_OPTIONS:+:$ASAN_OPTIONS}
export LSAN_OPTIONS=suppressions=$suppressions:print_suppressions=0
unset CURVETRI_MESHES # the made bodies do

# what the tests' own profile leaves out
profile=(--config profile.test.debug-assertions=true --config 'profile.test.debug="line-tables-only"')
if [ "${1:-}" = --contract ]; then
    cargo test --locked --target "$host" "${profile[@]}" --lib --test contract
else
    ci/wrapper_tests.sh --target "$host" "${profile[@]}"
fi
