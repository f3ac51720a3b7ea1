"""Kernels of different instruction sets share no function: the linker keeps one of those that objects share, whichever
processor it is for. Called with: nm, then the kernels' objects."""

import subprocess
import sys

NM, *OBJECTS = sys.argv[1:]
found = []
for path in OBJECTS:
    listing = subprocess.run([NM, "-C", "--defined-only", path], capture_output=True, text=True, check=True).stdout
    # weak functions; data of a header is the same for every processor
    shared = [line.split(" ", 2)[2] for line in listing.splitlines() if line.split(" ", 2)[1] in "Ww"]
    own = [name for name in shared if "Lanes<" in name]
    if not own:
        found.append(f"{path}: no function of Lanes, expected the kernel's")
    # ASan's and UBSan's own, of builds that have them
    found += [f"{path}: {name}, expected functions of Lanes alone"
              for name in shared if name not in own and not name.startswith(("__asan", "__ubsan", "__odr_asan", "DW.ref"))]
print("\n".join(found) or f"{len(OBJECTS)} kernels share no function")
sys.exit(bool(found))
