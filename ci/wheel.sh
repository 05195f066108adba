#!/bin/bash
# Runs a command (default: cargo test --locked --package curvetri-embree-linked --test embree) in this checkout against the Embree 4.4
# that comes in the Python wheel embreex, as EMBREE_DIR. The wheel has no headers: those of Debian 13's
# chroot (ci/debian13.sh) fit.
#
# CURVETRI_WHEEL   where the prefix is kept   (default: ~/.cache/curvetri/embree-wheel)
# WHEEL_TARGET     cargo's target directory   (default: target-wheel in the checkout)
#
# Where pip or the headers are missing, it says so and ends with 0.
set -euo pipefail

checkout=$(cd "$(dirname "$0")/.." && pwd -P)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/curvetri
prefix=${CURVETRI_WHEEL:-$cache/embree-wheel}
headers=${CURVETRI_DEBIAN13:-$cache/debian13}/usr/include/embree4
[ $# -gt 0 ] || set -- cargo test --locked --package curvetri-embree-linked --test embree

skip() {
    echo "**********************************************************************" >&2
    echo "** SKIPPED: nothing was tested against the wheel's Embree 4.4: $*" >&2
    echo "**********************************************************************" >&2
    exit 0
}

prepare() {
    command -v pip3 >/dev/null || skip "there is no pip"
    "$checkout/ci/debian13.sh" true
    [ -d "$headers" ] || skip "there are no headers from ci/debian13.sh"
    local work libs
    work=$(mktemp -d)
    # shellcheck disable=SC2064 # the directory of now
    trap "rm -rf '$work'" EXIT
    pip3 download --quiet --no-deps --only-binary=:all: --python-version 3.11 \
        --dest "$work" embreex==4.4.0.post1
    python3 -m zipfile -e "$work"/embreex-*.whl "$work/wheel"
    libs=$work/wheel/embreex.libs
    # the library's own name has a hash in it; the linker looks for the plain one
    ln -s "$(cd "$libs" && ls libembree4-*.so.4)" "$libs/libembree4.so"
    mkdir -p "$work/prefix/include"
    cp -r "$headers" "$work/prefix/include/"
    mv "$libs" "$work/prefix/lib"
    rm -rf "$prefix"
    mkdir -p "$(dirname "$prefix")"
    mv "$work/prefix" "$prefix"
}

[ -e "$prefix/lib/libembree4.so" ] || prepare >&2
cd "$checkout"
EMBREE_DIR=$prefix CARGO_TARGET_DIR=${WHEEL_TARGET:-$checkout/target-wheel} "$@"
