#!/usr/bin/env bash
# build/image/root.ext4: Debian 12 for arm64 with the packages of packages.txt, that of plenumd (build/aarch64/package, made by
# `toolchains/dev package aarch64`), and the modules of the kernel. Needs no root, but an emulator for arm64 programs that
# the kernel of this machine knows of (binfmt_misc, package qemu-user-static).
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$top/board/image
work=$top/build/image
size=${PLENUM_ROOT_SIZE:-1G}
mkdir -p "$work"

packages=$(grep -v '^#' "$here/packages.txt" | paste -sd,)
ours=$(find "$top/build/aarch64/package" -name 'plenumd_*_arm64.deb' 2>/dev/null)
[ -f "$ours" ] || { echo "make_root: build/aarch64/package holds '$ours', expected one plenumd_*_arm64.deb: run toolchains/dev package aarch64" >&2; exit 1; }

# The set-up by Debian's packages takes minutes, the rest seconds: it is kept as long as it would come out the same.
key=$( (printf '%s\n' "$packages"; sha256sum "$ours") | sha256sum)
if [ "$(cat "$work/root.key" 2>/dev/null)" != "$key" ]; then
  echo "== setting up the root file system (${packages//,/ } ${ours##*/})"
  rm -f "$work/root.key"
  mmdebstrap --quiet --architectures=arm64 --variant=minbase --include="$packages" --aptopt='Acquire::Languages "none"' \
    --customize-hook="copy-in $ours /var/cache" \
    --customize-hook='chroot "$1" sh -c "apt-get -qq -y --no-install-recommends install /var/cache/plenumd_*.deb && rm /var/cache/plenumd_*.deb"' \
    bookworm "$work/root.tar"
  printf '%s' "$key" >"$work/root.key"
fi

# Under fakeroot the files keep the owners that they have in the archive.
rm -rf "$work/root"
mkdir "$work/root"
fakeroot "$here/fill_root.sh" "$work/root" "$work/root.tar" "$work/kernel" "$work/root.ext4" "$size"
rm -rf "$work/root"
