#!/bin/bash
# Generates the bindings of the installed Embree anew (feature `bindgen`, needs libclang) and compares
# them with the committed ones. With --write it replaces the committed ones instead.
set -euo pipefail
cd "$(dirname "$0")/.."

messages=$(cargo check --locked --package curvetri-embree --features bindgen --message-format=json)
out=$(grep '"reason":"build-script-executed"' <<<"$messages" | grep '[/#]curvetri-embree[@#]\|wrapper/embree#' |
    sed -n 's/.*"out_dir":"\([^"]*\)".*/\1/p')
new=$out/bindings.rs
[ -s "$new" ] || { echo "ci/bindings.sh: no bindings were generated" >&2; exit 1; }
major=$(sed -n 's/.*RTC_VERSION_MAJOR: u32 = \([0-9]*\).*/\1/p' "$new")
committed=wrapper/embree/src/bindings_$major.rs

if [ "${1:-}" = --write ]; then
    cp "$new" "$committed"
    echo "$committed is written"
elif diff -u "$committed" "$new"; then
    echo "$committed is what bindgen makes of the installed headers"
else
    echo "ci/bindings.sh: $committed differs from what bindgen makes (ci/bindings.sh --write)" >&2
    exit 1
fi
