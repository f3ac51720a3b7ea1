#!/usr/bin/env bash
# build/virtual-board/guest.cpio.gz: what the test adds to the initramfs of the image, for one boot and in memory only. The
# front end and the bus-off (kernel modules), plantd, can_door, the agent, the units that start them.
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$top/tests/virtual-board
work=$top/build/virtual-board
tree=$top/build/image/kernel/tree
release=$(cat "$top/build/image/kernel/release")
cross=aarch64-linux-gnu-
mkdir -p "$work"

module_folder=$work/frontend
mkdir -p "$module_folder"
cp -u "$here/frontend/Kbuild" "$module_folder/"
make -s -C "$tree/usr/src/linux-headers-$release" ARCH=arm64 CROSS_COMPILE=$cross M="$module_folder" src="$here/frontend" modules

[ -f "$work/guest/build.ninja" ] || cmake -S "$here/guest" -B "$work/guest" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_CXX_COMPILER=${cross}g++ >/dev/null
cmake --build "$work/guest"

staged=$work/staged
rm -rf "$staged"
mkdir -p "$staged/run-extra/virtual-board" "$staged/run-extra/systemd/system/multi-user.target.wants"
cp "$here/guest/main" "$staged/"
cp "$here/guest/agent" "$here/guest/board.toml" "$work/guest/plantd" "$work/guest/can_door" "$staged/run-extra/virtual-board/"
for module in plenum_frontend plenum_bus_off; do
  ${cross}strip --strip-debug -o "$staged/run-extra/virtual-board/$module.ko" "$module_folder/$module.ko"
done

for unit in "$here"/guest/units/*.service; do
  cp "$unit" "$staged/run-extra/systemd/system/"
  ln -s "../${unit##*/}" "$staged/run-extra/systemd/system/multi-user.target.wants/"
done

# An emulated processor on a busy machine is slow: what its devices take is no reason to give them up.
mkdir "$staged/run-extra/systemd/system.conf.d"
printf '[Manager]\nDefaultDeviceTimeoutSec=infinity\nDefaultTimeoutStartSec=infinity\n' >"$staged/run-extra/systemd/system.conf.d/virtual-board.conf"

# Where there is no root file system, the modules come along, with those of the initramfs: depmod's index is one.
cp -r "$top/build/image/initramfs/lib" "$staged/"
for module in virtio_console industrialio-triggered-buffer kvaser_pci can_raw; do
  modprobe -d "$tree" -S "$release" --show-depends "$module" | sed -n 's|^insmod ||p'
done | sort -u | while read -r file; do
  install -D -m 644 "$file" "$staged/${file#"$tree"/}"
done
depmod -b "$staged" "$release"
(cd "$staged" && find . -print0 | LC_ALL=C sort -z | cpio --null -o -H newc -R 0:0 --reproducible --quiet | gzip -1n) >"$work/guest.cpio.gz"
cat "$top/build/image/initramfs.cpio.gz" "$work/guest.cpio.gz" >"$work/initramfs.cpio.gz"
