#!/bin/bash
# Runs a command (default: cargo test --locked) in this checkout against Debian 13's own Embree 4.3,
# in a chroot beside the host's system. The chroot is made once and kept outside the checkout.
#
#   ci/debian13.sh                   cargo test --locked
#   ci/debian13.sh CMD [ARG...]      CMD in the chroot, at the checkout's own path
#
# CURVETRI_DEBIAN13   where the chroot lives     (default: ~/.cache/curvetri/debian13)
# DEBIAN13_TARGET     cargo's target directory   (default: target-debian13 in the checkout; in one that the
#                     host has filled, only what knows of Embree is compiled again)
# DEBIAN_MIRROR       a Debian mirror            (default: the first one in the host's apt sources)
#
# The host's Rust toolchain (read-only) and cargo home are mounted into the chroot, in a mount
# namespace that ends with the command, so nothing is left mounted and nothing of the host can be
# deleted through it. Where the system does not permit that, it says so and ends with 0.
set -euo pipefail

checkout=$(cd "$(dirname "$0")/.." && pwd -P)
root=${CURVETRI_DEBIAN13:-${XDG_CACHE_HOME:-$HOME/.cache}/curvetri/debian13}
target=${DEBIAN13_TARGET:-$checkout/target-debian13}
packages="libembree-dev libclang-dev gcc g++ libc6-dev ca-certificates"
[ $# -gt 0 ] || set -- cargo test --locked

fail() { echo "ci/debian13.sh: $*" >&2; exit 1; }

skip() {
    echo "**********************************************************************" >&2
    echo "** SKIPPED: nothing was tested against Debian 13's Embree: $*" >&2
    echo "**********************************************************************" >&2
    exit 0
}

[ "$(id -u)" = 0 ] || skip "a chroot needs root"
unshare --mount true 2>/dev/null || skip "this system does not permit mount namespaces"
chroot / true 2>/dev/null || skip "this system does not permit chroot"
case $root in
    /?*) ;;
    *) fail "CURVETRI_DEBIAN13 must be an absolute path below /, not '$root'" ;;
esac

# From here on in a mount namespace of our own, with a lock against a second run's set-up.
if [ "${DEBIAN13_UNSHARED:-}" != yes ]; then
    export DEBIAN13_UNSHARED=yes
    exec unshare --mount --propagation private "$0" "$@"
fi
mkdir -p "$root" "$target"

mirror() {
    [ -z "${DEBIAN_MIRROR:-}" ] || { echo "$DEBIAN_MIRROR"; return; }
    apt-get indextargets --format '$(ORIGIN) $(LABEL) $(SITE)' 'Created-By: Packages' |
        sed -n 's/^Debian Debian //p' | head -n 1
}

inside() {
    chroot "$root" /usr/bin/env -i HOME=/root TERM="${TERM:-dumb}" DEBIAN_FRONTEND=noninteractive \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@"
}

# Names, certificates and the way to the packages follow the host's.
follow_host() {
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/" 2>/dev/null || true
    apt-config dump | grep -E '^Acquire::(http|https|Check-|Retries)' \
        >"$root/etc/apt/apt.conf.d/90host" || true
    [ ! -e /etc/ssl/certs/ca-certificates.crt ] || {
        mkdir -p "$root/etc/ssl/certs"
        cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    }
}

bootstrap() {
    local from
    from=$(mirror)
    [ -n "$from" ] || fail "no Debian mirror in the host's apt sources: name one in DEBIAN_MIRROR"
    command -v debootstrap >/dev/null || {
        echo "installing debootstrap" >&2
        apt-get -q update && apt-get -q -y install --no-install-recommends debootstrap
    }
    find "$root" -mindepth 1 -delete
    debootstrap --variant=minbase --components=main trixie "$root" "$from"
    # services must not start, and a chroot has no use for recommended packages
    printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"
    chmod +x "$root/usr/sbin/policy-rc.d"
    echo 'APT::Install-Recommends "false";' >"$root/etc/apt/apt.conf.d/91lean"
    touch "$root/.bootstrapped"
}

prepare() {
    [ -e "$root/.bootstrapped" ] || bootstrap
    mount -t proc proc "$root/proc"
    mount --rbind /sys "$root/sys"
    mount --rbind /dev "$root/dev"
    if [ "$(cat "$root/.packages" 2>/dev/null)" != "$packages" ]; then
        follow_host
        inside dpkg --configure -a # an interrupted earlier run
        inside apt-get -q update
        # shellcheck disable=SC2086 # a list of words
        inside apt-get -q -y install $packages
        inside apt-get -q clean
        echo "$packages" >"$root/.packages"
    fi
    follow_host # after ca-certificates wrote its own
}

exec 9>"$root.lock"
flock 9
prepare >&2
flock -u 9

sysroot=$(rustc --print sysroot)
cargo_home=${CARGO_HOME:-$HOME/.cargo}
share() {
    mkdir -p "$1" "$root$1"
    mount --rbind "$1" "$root$1"
}
share "$sysroot"
mount -o remount,bind,ro "$root$sysroot"
share "$cargo_home"
share "$checkout"
share "$target"
[ -z "${CURVETRI_MESHES:-}" ] || share "$(realpath "$CURVETRI_MESHES")"
# a git worktree keeps its history elsewhere
git_dir=$(git -C "$checkout" rev-parse --path-format=absolute --git-common-dir 2>/dev/null || true)
[ -z "$git_dir" ] || share "$git_dir"

# Settings that belong to the command, not to the host's system.
passed=()
while IFS= read -r -d '' setting; do
    case ${setting%%=*} in
        CARGO_HOME | CARGO_TARGET_DIR | CARGO_MANIFEST_* | CARGO_PKG_*) ;;
        CARGO_* | RUSTFLAGS | RUSTDOCFLAGS | RUST_* | CURVETRI_* | EMBREE_* | PROPTEST_* | \
            SSL_CERT_* | CURL_CA_BUNDLE | [Hh][Tt][Tt][Pp]*_[Pp][Rr][Oo][Xx][Yy] | [Nn][Oo]_[Pp][Rr][Oo][Xx][Yy])
            passed+=("$setting") ;;
    esac
done < <(env -0)

inside env "${passed[@]}" PATH="$sysroot/bin:/usr/local/bin:/usr/bin:/bin" CARGO_HOME="$cargo_home" \
    CARGO_TARGET_DIR="$target" sh -c 'cd "$0" && exec "$@"' "$checkout" "$@"
