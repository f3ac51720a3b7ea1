#!/usr/bin/env bash
# build/image/plenum-arm64.img: a disk for a board that starts by UEFI. A partition for it (systemd-boot, kernel, initramfs) and
# one for the root file system.
set -euo pipefail

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$top/build/image
release=$(cat "$work/kernel/release")
image=$work/plenum-arm64.img
mib=1048576
efi_mib=96

efi=$work/efi.vfat
rm -f "$efi"
truncate -s ${efi_mib}M "$efi"
mkfs.vfat -n PLENUM-EFI "$efi" >/dev/null
mmd -i "$efi" ::EFI ::EFI/BOOT ::loader ::loader/entries ::plenum
mcopy -i "$efi" "$work/kernel/tree/usr/lib/systemd/boot/efi/systemd-bootaa64.efi" ::EFI/BOOT/BOOTAA64.EFI
mcopy -i "$efi" "$work/kernel/tree/boot/vmlinuz-$release" ::plenum/linux
mcopy -i "$efi" "$work/initramfs.cpio.gz" ::plenum/initramfs
printf 'timeout 0\n' | mcopy -i "$efi" - ::loader/loader.conf
printf 'title Plenum\nlinux /plenum/linux\ninitrd /plenum/initramfs\noptions root=LABEL=plenum panic=10\n' | mcopy -i "$efi" - ::loader/entries/plenum.conf

root_mib=$(($(stat -c %s "$work/root.ext4") / mib))
rm -f "$image"
truncate -s $((1 + efi_mib + root_mib + 1))M "$image"
sfdisk -q "$image" <<TABLE
label: gpt
start=1MiB, size=${efi_mib}MiB, type=uefi, name=efi
start=$((1 + efi_mib))MiB, size=${root_mib}MiB, type=linux, name=plenum
TABLE
dd if="$efi" of="$image" bs=$mib seek=1 conv=notrunc,sparse status=none
dd if="$work/root.ext4" of="$image" bs=$mib seek=$((1 + efi_mib)) conv=notrunc,sparse status=none
rm -f "$efi" "$work/root.ext4"
echo "== $image: $(du -h --apparent-size "$image" | cut -f1), $(du -h "$image" | cut -f1) of them in use; Linux $release"
