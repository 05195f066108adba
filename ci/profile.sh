#!/bin/bash
# Where the time of curved rays goes: samples of `curvetri bench` by the kernel's stages, as Markdown.
#
#   ci/profile.sh > docs/profile.md
#
# Needs perf (Debian: linux-perf) and addr2line (binutils). What is inlined counts for the first stage in the
# list below that its chain of functions names; Embree's own time, which flat triangles take as well, is left
# out, as the samples do not tell whose it is.
set -euo pipefail
cd "$(dirname "$0")/.."

for tool in perf addr2line; do
    command -v "$tool" >/dev/null || { echo "ci/profile.sh: $tool is missing" >&2; exit 1; }
done
cargo build --release --locked --quiet --bin curvetri
program=${CARGO_TARGET_DIR:-target}/release/curvetri
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Where the kernel puts a position-independent program whose addresses are not random.
base=$((16#555555554000))

# A function or file in a chain of inlined functions and its stage: the first that matches counts; of making a
# mesh and its patches, nothing does.
stages='tessellate=
prepare=
clusters=
Cluster>::new=
Cluster>::of=
normal_at=the normal at a hit
search=rays that may cross several times
clearance=F of equation (44)
crossing=steps to the root
verify=verifying a root
stretch=what the paraboloid tells
unclipped=the segment over a patch
localize=the segment over a patch
of_patches=numbers of a pair out of columns
gather=numbers of a pair out of columns
surface/single.rs=planes of a single ray, and its clip
surface/hull.rs=clip to sides and slab
curved/mod.rs=reading of triangles
surface<=layout of a patch
packet_met=boxes of a cluster
curved/entries.rs=boxes of a cluster
lay_columns=layout of a patch
PatchBlock=layout of a patch
::lay=layout of a patch
trace<fearless=pairs, the rest
trace_wide=pairs, the rest
report=reports to Embree
intersect_at=a single ray, the rest
curved::geometry=callback, the rest
curvetri_embree::user=callback, the rest
curvetri_rtc_intersect=the shim
curvetri_rtc_occluded=the shim'

# Of one kind of rays in one way: profile KIND WAY TRIANGLES
profile() {
    local data=$folder/data how=(--triangles "$3" --forms smooth --kinds "$1" --ways "$2")
    setarch -R perf record --quiet --event cpu-clock --freq 4000 --output "$data" -- \
        "$program" bench "${how[@]}" --threads 1 --rays 262144 --rounds 20 >"$folder/bench" 2>/dev/null
    perf script --input "$data" --fields ip,dso 2>/dev/null |
        awk -v program="/curvetri)" 'index($2, program) { count[$1]++ }
            END { for (ip in count) print ip, count[ip] }' >"$folder/counts"
    while read -r ip count; do
        printf '0x%x %d\n' $((16#$ip - base)) "$count"
    done <"$folder/counts" >"$folder/addresses"
    cut -d' ' -f1 "$folder/addresses" |
        addr2line --addresses --inlines --functions --demangle --exe "$program" >"$folder/chains"
    printf '\n## %s rays, %s: a bumpy torus of %s triangles\n\n' "$1" \
        "$([ "$2" = 1 ] && echo one by one || echo "packets $2")" "$3"
    awk '/Mray\/s on/ { told = 1 } told && ($1 == "flat" || $1 == "smooth") && NF == 3 {
            printf "%s: %.0f ns a ray  \n", $1, 1000 / $2 }
        /every way/ { exit }' "$folder/bench"
    printf '\n| stage | share of the time outside Embree |\n| --- | ---: |\n'
    shares
}

shares() {
    awk -v stages="$stages" '
        BEGIN {
            lines = split(stages, line, "\n")
            for (n = 1; n <= lines; n++) {
                at = index(line[n], "=")
                key[n] = substr(line[n], 1, at - 1)
                name[n] = substr(line[n], at + 1)
            }
        }
        FILENAME ~ /addresses$/ { count[++addresses] = $2; next }
        /^0x[0-9a-f]+$/ { close_chain(); seen++; chain = ""; next }
        { chain = chain "\n" $0 }
        function close_chain(    n) {
            if (!seen) return
            for (n = 1; n <= lines; n++)
                if (index(chain, key[n])) {
                    if (name[n] == "") return
                    share[name[n]] += count[seen]
                    all += count[seen]
                    return
                }
        }
        END {
            close_chain()
            if (!all) exit 1 # the addresses are not where they were taken to be
            for (stage in share)
                printf "| %s | %.1f %% |\n", stage, 100 * share[stage] / all
        }' "$folder/addresses" "$folder/chains" | sort -t'|' -k3 -rn
}

cat <<EOF
# Where the time goes

Written by \`ci/profile.sh\`: samples of \`curvetri bench\` on one thread of
$(sed -n '/^model name/{s/.*: //p;q}' /proc/cpuinfo). What limits the speed is in experiments.md.
EOF
profile primary 16c 10000
profile primary 16c 1000000
profile diffuse 1 10000
