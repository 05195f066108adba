#!/bin/bash
# Installs what building curvetri needs and is not there: a C and a C++ compiler, make and Embree with
# its headers, through apt-get as root or with sudo. Does nothing where all is there, or where
# EMBREE_DIR names an Embree.
#
#   ci/setup.sh [PACKAGE...]      further Debian packages to have
set -euo pipefail

fail() { echo "ci/setup.sh: $*" >&2; exit 1; }

command -v "${CARGO:-cargo}" >/dev/null ||
    fail "cargo is missing: install Rust 1.89 or later from https://rustup.rs"

has_embree() {
    [ -z "${EMBREE_DIR:-}" ] || return 0 # build.rs looks there, and says what it misses
    printf '#include <embree4/rtcore.h>\n' | cc -E - >/dev/null 2>&1 ||
        printf '#include <embree3/rtcore.h>\n' | cc -E - >/dev/null 2>&1
}

missing=()
command -v make >/dev/null || missing+=(make)
# A compiler without the C library's headers compiles nothing.
printf '#include <stdio.h>\n' | cc -E - >/dev/null 2>&1 || missing+=(gcc libc6-dev)
printf '#include <vector>\n' | c++ -x c++ -E - >/dev/null 2>&1 || missing+=(g++)
has_embree || missing+=(libembree-dev)
for package; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
        missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

command -v apt-get >/dev/null ||
    fail "this system has no apt-get: install C and C++ compilers, make and Embree 3.13 or 4.3 and later" \
        "with its headers (on Debian and Ubuntu: gcc g++ libc6-dev make libembree-dev), or set EMBREE_DIR" \
        "to a prefix that has include/ and lib/"

if [ "$(id -u)" = 0 ]; then
    as_root=()
elif command -v sudo >/dev/null; then
    as_root=(sudo)
else
    fail "neither root nor sudo: have someone install ${missing[*]}"
fi
echo "installing ${missing[*]}" >&2
"${as_root[@]}" apt-get -q update >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -q -y install --no-install-recommends "${missing[@]}" >&2
