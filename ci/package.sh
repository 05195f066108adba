#!/bin/bash
# Packs everything that is published, as `cargo publish` would: the manifests are complete, and each package
# has its licences.
#
#   ci/package.sh            packs
#   ci/package.sh --verify   also compiles each package from its own archive: takes minutes
set -euo pipefail
cd "$(dirname "$0")/.."

verify=--no-verify
[ "${1:-}" != --verify ] || verify=

published=() options=()
for manifest in Cargo.toml crates/*/Cargo.toml wrapper/*/Cargo.toml; do
    name=$(sed -n 's/^name = "\(.*\)"/\1/p' "$manifest" | head -n 1)
    if grep -q '^publish = false' "$manifest"; then
        options+=(--exclude "$name")
    else
        published+=("$name")
    fi
done
# what is not committed yet is packed as well, so that this can run before a commit
cargo package --quiet --locked --allow-dirty --workspace "${options[@]}" $verify

version=$(sed -n '/^\[workspace.package\]/,/^$/s/^version = "\(.*\)"/\1/p' Cargo.toml)
for name in "${published[@]}"; do
    archive=${CARGO_TARGET_DIR:-target}/package/$name-$version.crate
    files=$(tar -tf "$archive")
    for file in LICENSE-APACHE LICENSE-MIT; do
        grep -qx "$name-$version/$file" <<<"$files" ||
            { echo "ci/package.sh: $name is packed without $file" >&2; exit 1; }
    done
    echo "$name $version: $(wc -l <<<"$files") files, $(stat -c %s "$archive") bytes"
done
