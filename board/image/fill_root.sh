#!/usr/bin/env bash
# fill_root.sh FOLDER ARCHIVE KERNEL IMAGE SIZE: unpacks the archive into the empty folder, adds what no package brings, and makes
# the folder a file system. make_root.sh runs it under fakeroot.
set -euo pipefail

root=$1 archive=$2 kernel=$3 image=$4 size=$5

tar -C "$root" --numeric-owner --exclude='./dev/*' -xf "$archive"
release=$(cat "$kernel/release")
mkdir -p "$root/lib/modules"
cp -a "$kernel/tree/lib/modules/$release" "$root/lib/modules/"

printf 'plenum\n' >"$root/etc/hostname"
: >"$root/etc/machine-id" # systemd gives each board its own at the first boot
cat >"$root/etc/fstab" <<'FSTAB'
LABEL=plenum      /          ext4  defaults,noatime     0 1
LABEL=PLENUM-EFI  /boot/efi  vfat  ro,nofail,umask=022  0 2
FSTAB
mkdir -p "$root/boot/efi"
# It sets up can0, as the package of plenumd says.
systemctl -q --root="$root" enable systemd-networkd
# The serial console is the way in, for who stands before the board; nothing listens on a network.
sed -i 's/^root:[^:]*:/root::/' "$root/etc/shadow"
find "$root/var/cache/apt" "$root/var/lib/apt/lists" -type f -delete
chown -R 0:0 "$root/lib/modules/$release" "$root/etc/hostname" "$root/etc/machine-id" "$root/etc/fstab" "$root/boot"

rm -f "$image"
mke2fs -qq -t ext4 -L plenum -d "$root" -E root_owner=0:0 "$image" "$size"
