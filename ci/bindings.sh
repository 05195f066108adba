#!/bin/bash
# Generates the bindings of the installed Embree's types and of curvetri's table anew (feature `bindgen`,
# needs libclang) and compares them with the committed ones. With --write it replaces the committed ones instead.
set -euo pipefail
cd "$(dirname "$0")/.."

# The committed bindings may be what does not compile.
messages=$(cargo check --locked --package curvetri-embree-linked --features bindgen --keep-going \
    --message-format=json || true)
out=$(grep '"reason":"build-script-executed"' <<<"$messages" |
    grep '[/#]curvetri-embree-linked[@#]\|wrapper/linked#' | sed -n 's/.*"out_dir":"\([^"]*\)".*/\1/p')
compgen -G "$out/embree_?.rs" >/dev/null || { echo "ci/bindings.sh: no bindings were generated" >&2; exit 1; }

committed=wrapper/embree/src/bindings
differ=0
for new in "$out"/embree_?.rs "$out/table.rs"; do
    name=$(basename "$new")
    if [ "${1:-}" = --write ]; then
        cp "$new" "$committed/$name"
        echo "$committed/$name is written"
    elif diff -u "$committed/$name" "$new"; then
        echo "$committed/$name is what bindgen makes of the headers"
    else
        differ=1
    fi
done
if [ $differ = 1 ]; then
    echo "ci/bindings.sh: the committed bindings differ from what bindgen makes (ci/bindings.sh --write)" >&2
    exit 1
fi
