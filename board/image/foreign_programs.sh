#!/usr/bin/env bash
# Sees to it that the kernel of this machine runs programs of arm64, by qemu-user, as the set-up of the root file system needs.
# In a container the kernel's table of interpreters may not be mounted yet, which takes root.
set -euo pipefail

table=/proc/sys/fs/binfmt_misc
if arch-test arm64 >/dev/null 2>&1; then exit 0; fi
[ "$(id -u)" -eq 0 ] || { echo "foreign_programs: programs of arm64 do not run here; as root: mount -t binfmt_misc none $table; update-binfmts --enable qemu-aarch64" >&2; exit 1; }
[ -e $table/status ] || mount -t binfmt_misc none $table
update-binfmts --enable qemu-aarch64
arch-test arm64
