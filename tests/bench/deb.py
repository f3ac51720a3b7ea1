"""What plenumd takes on the disk of a board: usage deb.py PLENUMD.deb

The installed size of the package and of all that it depends on (without recommendations), less what a minimal Debian has:
every package of priority required or important, and what those depend on. apt resolves both, from nothing installed.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def apt(status, *command):
    run = subprocess.run([*command[:1], "-o", f"Dir::State::status={status}", "-o", "APT::Install-Recommends=false",
                          *command[1:]], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"deb.py: {' '.join(command[:3])} ... failed: {run.stderr.strip()}")
    return run.stdout


def available(status):
    """Of each package and version that apt knows: priority, and installed size [KiB]."""
    found = {}
    for stanza in apt(status, "apt-cache", "dumpavail").split("\n\n"):
        fields = dict(re.findall(r"(?m)^(Package|Version|Priority|Installed-Size): (.+)$", stanza))
        if "Package" in fields:
            found[fields["Package"]] = (fields.get("Priority", ""), int(fields.get("Installed-Size", 0)))
    return found


def installed(status, packages):
    """The names of all that apt would install for these."""
    return set(re.findall(r"(?m)^Inst (\S+)", apt(status, "apt-get", "install", "--simulate", *packages)))


def main(deb):
    with tempfile.TemporaryDirectory() as folder:
        status = Path(folder) / "status"
        status.touch()
        known = available(status)
        minimal = [name for name, (priority, _) in known.items() if priority in ("required", "important")]
        there = installed(status, minimal)
        added = installed(status, [*minimal, str(Path(deb).resolve())]) - there
    added.discard("plenumd")
    own = int(subprocess.run(["dpkg-deb", "--field", deb, "Installed-Size"], capture_output=True, text=True, check=True).stdout)
    sizes = {"plenumd": own, **{name: known[name][1] for name in added}}
    for name, kib in sorted(sizes.items(), key=lambda item: -item[1]):
        print(f"{kib / 1024:8.2f} MiB  {name}", file=sys.stderr)
    print(json.dumps({"name": "board.deb_mib", "value": round(sum(sizes.values()) / 1024, 2), "unit": "MiB", "better": "lower",
                      "target": 8}))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
