"""What tests of the commands that identify a component have in common. Called as command.py says."""

import json
import subprocess
import sys

from command import CommandTest

BENCH_LOGS = sys.argv[4]


class Component(CommandTest):
    def bench(self, component, name, seed, *how):
        subprocess.run([BENCH_LOGS, component, self.folder / name, str(seed), *map(str, how)], check=True, timeout=300)
        return name

    def answer(self, *arguments):
        return json.loads(self.done(*arguments, "--json", "-"))

    def table(self, name, header, rows):
        return self.write(name, header + "\n" + "".join(",".join(f"{cell:.9g}" for cell in row) + "\n" for row in rows))
