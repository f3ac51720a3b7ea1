#!/usr/bin/env bash
# build/image/root.ext4: Debian 12 for arm64 with the packages of packages.txt, the plenumd package where there is one
# (build/aarch64/package/plenumd_*_arm64.deb), and the modules of the kernel. Needs no root, but an emulator for arm64 programs that
# the kernel of this machine knows of (binfmt_misc, package qemu-user-static).
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$top/board/image
work=$top/build/image
size=${PLENUM_ROOT_SIZE:-1G}
mkdir -p "$work"

packages=$(grep -v '^#' "$here/packages.txt" | paste -sd,)
mapfile -t ours < <(find "$top/build/aarch64/package" -name 'plenumd_*_arm64.deb' 2>/dev/null | sort -V | tail -n 1)

# The set-up by Debian's packages takes minutes, the rest seconds: it is kept as long as it would come out the same.
key=$( (printf '%s\n' "$packages"; [ ${#ours[@]} -eq 0 ] || sha256sum "${ours[@]}") | sha256sum)
if [ "$(cat "$work/root.key" 2>/dev/null)" != "$key" ]; then
  echo "== setting up the root file system (${packages//,/ } ${ours[*]##*/})"
  rm -f "$work/root.key"
  mmdebstrap --quiet --architectures=arm64 --variant=minbase --include="$packages" "${ours[@]/#/--include=}" \
    --aptopt='Acquire::Languages "none"' bookworm "$work/root.tar"
  printf '%s' "$key" >"$work/root.key"
fi

# Under fakeroot the files keep the owners that they have in the archive.
rm -rf "$work/root"
mkdir "$work/root"
fakeroot "$here/fill_root.sh" "$work/root" "$work/root.tar" "$work/kernel" "$work/root.ext4" "$size"
rm -rf "$work/root"
