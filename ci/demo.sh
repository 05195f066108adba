#!/bin/bash
# Renders the demonstration's pictures into a directory: the paper's Figure 2, and every mesh of
# scenes/, flat and curved; and compares flat with curved where shadows end.
#
#   ci/demo.sh OUT      after cargo build --release --bin curvetri --bin figure_2
set -euo pipefail
cd "$(dirname "$0")/.."

out=${1:?a directory for the pictures}
program=${CARGO_TARGET_DIR:-target}/release/curvetri
mkdir -p "$out"

shopt -s nullglob
scenes=(scenes/*.obj)
[ ${#scenes[@]} -gt 0 ] || { echo "ci/demo.sh: no meshes in scenes/" >&2; exit 1; }
for mesh in "${scenes[@]}"; do
    name=$(basename "$mesh" .obj)
    for surface in flat smooth; do
        "$program" render "$mesh" -o "$out/$name-$surface.png" --surface "$surface" \
            --up-axis z --ground
    done
done
"$program" compare scenes/terminator.obj -o "$out/compare.png" --report "$out/compare.html" \
    --up-axis z --sun-direction 0.95,-0.2,0.24 --size 640x480 >/dev/null
"$(dirname "$program")/figure_2" "$out/figure_2.png" >/dev/null
echo "The pictures are in $out/:"
(cd "$out" && printf '  %s\n' *.png *.html)
