#!/bin/bash
# Checks that what the documentation names exists: every path in backquotes in ARCHITECTURE.md, and the
# target of every relative link in every page.
set -euo pipefail
cd "$(dirname "$0")/.."

failed=0
missing() {
    echo "ci/docs.sh: $1 names $2, which does not exist" >&2
    failed=1
}

# what has a slash or the ending of a file
paths=$(grep -o '`[^` ]*`' ARCHITECTURE.md | tr -d '`' | grep -E '/|\.(rs|sh|md|toml)$' | sort -u)
for path in $paths; do
    [ -e "$path" ] || missing ARCHITECTURE.md "$path"
done

links=0
while IFS= read -r page; do
    while IFS= read -r target; do
        links=$((links + 1))
        [ -e "$(dirname "$page")/$target" ] || missing "$page" "$target"
    done < <(grep -o ']([^)#]*' "$page" | cut -c3- | grep -v '^[a-z]*:')
done < <(git ls-files '*.md')

# the patterns above may stop to fit what is written
if [ "$(wc -w <<<"$paths")" -lt 20 ] || [ "$links" -lt 50 ]; then
    echo "ci/docs.sh: found only $(wc -w <<<"$paths") paths and $links links" >&2
    failed=1
fi
exit "$failed"
