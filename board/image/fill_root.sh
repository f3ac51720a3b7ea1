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
LABEL=plenum      /          ext4  defaults,noatime,x-systemd.growfs  0 1
LABEL=PLENUM-EFI  /boot/efi  vfat  ro,nofail,umask=022                0 2
FSTAB
mkdir -p "$root/boot/efi"
# At the start the last partition, and the file system in it, take what the medium has left: those of type "linux" in make_image.sh.
mkdir -p "$root/etc/repart.d"
printf '[Partition]\nType=linux-generic\n' >"$root/etc/repart.d/50-plenum.conf"
# It sets up a wired Ethernet where there is one. Nothing waits for that.
systemctl -q --root="$root" enable systemd-networkd
cat >"$root/etc/systemd/network/90-ethernet.network" <<'ETHERNET'
[Match]
Name=en* eth*

[Link]
RequiredForOnline=no

[Network]
DHCP=yes
ETHERNET
# mmdebstrap leaves that of this machine.
printf '# Nobody fills this in. "nameserver ADDRESS", for names of other machines.\n' >"$root/etc/resolv.conf"
chmod 644 "$root/etc/resolv.conf"
# The serial console is the way in, for who stands before the board; nothing listens on a network.
sed -i 's/^root:[^:]*:/root::/' "$root/etc/shadow"
find "$root/var/cache/apt" "$root/var/lib/apt/lists" -type f -delete
chown -R 0:0 "$root/lib/modules/$release" "$root/etc/hostname" "$root/etc/machine-id" "$root/etc/fstab" "$root/etc/repart.d" \
  "$root/etc/systemd/network" "$root/etc/resolv.conf" "$root/boot"

rm -f "$image"
mke2fs -qq -t ext4 -L plenum -d "$root" -E root_owner=0:0 "$image" "$size"
