#!/usr/bin/env bash
# Debian's stock arm64 kernel, its headers and a static busybox, unpacked under build/image/kernel, without the machine's
# own apt or dpkg being touched. Prints nothing when the newest is there already. Exit code 77: the package sources do not give it.
#   build/image/kernel/release   e.g. 6.1.0-40-arm64
#   build/image/kernel/tree      boot/vmlinuz-RELEASE, lib/modules/RELEASE, usr/src/linux-headers-RELEASE, bin/busybox,
#                                systemd-boot
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$top/build/image
apt=$work/apt

# apt as an arm64 machine without any package sees the package sources of this one.
mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial" "$work/debs"
: >"$apt/status"
options=(-o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State="$apt/state" -o Dir::State::status="$apt/status"
  -o Dir::Cache="$apt/cache" -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none)
unreachable() { echo "fetch_kernel: $1: is there a network, and a Debian 12 package source?" >&2; exit 77; }

apt-get "${options[@]}" -qq update || unreachable "apt-get update failed (above)"

release=$(apt-cache "${options[@]}" depends linux-image-arm64 | sed -n 's/^ *Depends: linux-image-\(.*\)$/\1/p') || true
[ -n "$release" ] || unreachable "linux-image-arm64 names no kernel"
version=$(apt-cache "${options[@]}" show "linux-image-$release" | sed -n 's/^Version: //p' | head -n 1)
if [ "$(cat "$work/kernel/version" 2>/dev/null)" = "$release $version" ]; then exit 0; fi

echo "== fetching Linux $release ($version)"
cd "$work/debs"
rm -f ./*.deb
apt-get "${options[@]}" -qq download "linux-image-$release" "linux-headers-$release" "linux-headers-${release%-arm64}-common" busybox-static systemd-boot-efi ||
  unreachable "apt-get download failed (above)"
# What the headers need to build a module runs here, not there.
apt-get -o APT::Sandbox::User="$(id -un)" -qq download "linux-kbuild-6.1=$version" || unreachable "apt-get download failed (above)"

rm -rf "$work/kernel"
tree=$work/kernel/tree
mkdir -p "$tree"
for package in ./*.deb; do dpkg-deb -x "$package" "$tree"; done
# The package expects its files under /usr/src.
printf 'include %s\n' "$tree/usr/src/linux-headers-${release%-arm64}-common/Makefile" >"$tree/usr/src/linux-headers-$release/Makefile"
depmod -b "$tree" "$release"
printf '%s\n' "$release" >"$work/kernel/release"
printf '%s\n' "$release $version" >"$work/kernel/version"
