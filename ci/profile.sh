#!/bin/bash
# Where the time of curved rays goes: samples of `curvetri bench` by stages of the kernel, as Markdown.
#
#   ci/profile.sh > docs/profile.md
#
# Needs perf (Debian: linux-perf) and addr2line (binutils). A sample in inlined code counts for the first stage in
# the list below that its chain of functions names. Embree's own time is left out: flat triangles take it as well,
# and the samples do not say whose it is.
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

# A function or file in a chain of inlined functions, and its stage. The first that matches counts. What makes a
# mesh ready has no stage and does not count.
stages='curved/tessellate.rs=
curved/build/=
cluster/build.rs=
cluster/grouping.rs=
method/src/build/=
normal_at=normal at a hit
lane_search.rs=search for one of several roots
bracketing.rs=search for one of several roots
clearance=F of equation (44)
secant.rs=secant steps to the root
verify=verifying a root
paraboloid.rs=paraboloid
segment.rs=segment of a ray over a patch
localize=segment of a ray over a patch
of_patches=fetching the numbers of a pair
gather=fetching the numbers of a pair
intersect/single.rs=clip of a single ray
intersect/clip.rs=clip to planes and slab
curved/triangle.rs=reading triangles
method/src/store/=unpacking patches
ray_test.rs=boxes of a cluster
intersect/pairs.rs=pairs, the rest
report=reports to Embree
method/src/intersect/=a single ray, the rest
curved/query/=callback, the rest
wrapper/embree=callback, the rest
curvetri_rtc_intersect=C shim
curvetri_rtc_occluded=C shim'

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
            printf "%s: %.0f ns per ray  \n", $1, 1000 / $2 }
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
