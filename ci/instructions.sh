#!/bin/bash
# Counts the kernel's instructions under callgrind, case by case (crates/method/examples/instructions.rs),
# and compares them with ci/instructions.txt: each may be 3 % more or less. A kernel that has become faster
# fails as well, so that the counts that are committed are those of today.
#
#   ci/instructions.sh             compares
#   ci/instructions.sh --write     writes the counts of today; commit them with what changed them
#
# The counts are those of one compiler and of AVX2, the most that valgrind knows: with another compiler, or
# on another processor, differences are reported and are no failure. LIMIT=1 compares within 1 %.
set -euo pipefail
cd "$(dirname "$0")/.."

file=ci/instructions.txt
limit=${LIMIT:-3}
case ${1:-} in
    '' | --write) mode=${1:-} ;;
    *) echo "ci/instructions.sh: unknown argument $1; use --write, or nothing" >&2; exit 2 ;;
esac

ci/setup.sh valgrind
cargo build --quiet --release --locked --package curvetri-method --example instructions
program=${CARGO_TARGET_DIR:-target}/release/examples/instructions

# Only the calls are counted, not what prepares them.
callgrind() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='instructions::measured' \
        "$program" "$@"
}

list=$(callgrind 2>/dev/null)
# e.g. "rustc 1.95.0 (59807616e 2026-04-14), Avx2"
made_by="$(rustc --version), $(head -1 <<<"$list")"
log=$(mktemp)
trap 'rm -f "$log" "$log.now"' EXIT
{
    echo "# Instructions a call, by ci/instructions.sh --write"
    echo "# $made_by"
    for name in $(tail -n +2 <<<"$list"); do
        calls=$(callgrind "$name" 2>"$log")
        counted=$(sed -n 's/^==[0-9]*== Collected : \([0-9]*\)$/\1/p' "$log")
        if [ "${counted:-0}" -lt "$calls" ]; then
            echo "ci/instructions.sh: callgrind counted nothing in $name:" >&2
            cat "$log" >&2
            exit 1
        fi
        awk "BEGIN { printf \"%s %.1f\\n\", \"$name\", $counted / $calls }"
    done
} >"$log.now"

if [ "$mode" = --write ]; then
    cp "$log.now" "$file"
    cat "$file"
    exit 0
fi

# A case that only one of the files has is a failure.
if awk -v limit="$limit" '
    /^#/ { next }
    FNR == NR { before[$1] = $2; order[++count] = $1; next }
    { now[$1] = $2; if (!($1 in before)) order[++count] = $1 }
    END {
        for (n = 1; n <= count; n++) {
            name = order[n]
            if (!(name in before) || !(name in now)) { change = "one is missing"; bad = 1; off = 1 }
            else {
                percent = 100 * (now[name] - before[name]) / before[name]
                off = percent > limit || percent < -limit
                change = sprintf("%+.2f %%", percent)
            }
            if (off) bad = 1
            printf "%-30s %8s -> %8s  %s%s\n", name, before[name], now[name], change, off ? "  <--" : ""
        }
        exit bad || count == 0
    }' "$file" "$log.now"; then
    echo "Every case is within $limit % of $file."
    exit 0
fi
committed=$(sed -n '2s/^# //p' "$file")
if [ "$committed" != "$made_by" ]; then
    echo "More than $limit % off; but those of $file are by $committed, these by $made_by:" \
        "no failure. Write them anew with that compiler: ci/instructions.sh --write"
    exit 0
fi
echo "ci/instructions.sh: more than $limit % off. If that is meant, ci/instructions.sh --write, and commit it." >&2
exit 1
