#!/usr/bin/env bash
# build/image/initramfs.cpio.gz: busybox, init, and the modules of initramfs/modules with what they need.
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$top/board/image
tree=$top/build/image/kernel/tree
release=$(cat "$top/build/image/kernel/release")
staged=$top/build/image/initramfs

rm -rf "$staged"
mkdir -p "$staged"/{bin,dev,proc,sys,run,system}
cp "$tree/bin/busybox" "$staged/bin/"
ln -s busybox "$staged/bin/sh"
ln -s bin "$staged/sbin" # where the kernel looks for modprobe
cp "$here/initramfs/init" "$here/initramfs/modules" "$staged/"

# A module that is built in, or another that it needs, is no file; one that the kernel does not have ends this with an error.
while read -r module; do
  modprobe -d "$tree" -S "$release" --show-depends "$module" | sed -n "s|^insmod ||p"
done <"$here/initramfs/modules" | sort -u | while read -r file; do
  mkdir -p "$staged/$(dirname "${file#"$tree"/}")"
  cp "$file" "$staged/${file#"$tree"/}"
done
cp "$tree/lib/modules/$release"/modules.{order,builtin,builtin.modinfo} "$staged/lib/modules/$release/"
depmod -b "$staged" "$release"
(cd "$staged" && find . -print0 | LC_ALL=C sort -z | cpio --null -o -H newc -R 0:0 --reproducible --quiet | gzip -9n) >"$top/build/image/initramfs.cpio.gz"
