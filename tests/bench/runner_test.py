"""The runner of the benchmarks keeps its format, its summary and its exit codes.

usage: runner_test.py BENCH_PY [unittest arguments]
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

RUNNER = None


def row(name, value, **fields):
    return {"name": name, "value": value, "unit": "s", "better": "lower", "target": 4} | fields


class Runner(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.list = Path(self._folder.name, "list.json")
        self.summary = Path(self._folder.name, "summary.json")

    def register(self, **benches):
        """Each bench is a list of rows, or the text that it prints."""
        def command(output):
            text = output if isinstance(output, str) else "\n".join(json.dumps(one) for one in output)
            return [sys.executable, "-c", f"print({text!r})"]
        self.list.write_text(json.dumps([{"name": n, "command": command(output)} for n, output in benches.items()]))

    def run_bench(self, *prefixes):
        return subprocess.run([sys.executable, "-B", RUNNER, self.list, self.summary, *prefixes],
                              capture_output=True, text=True)

    def summary_values(self):
        return {one["name"]: one["value"] for one in json.loads(self.summary.read_text())}

    def test_rows_reach_the_summary_with_every_field_and_the_table_with_a_verdict(self):
        self.register(a=[row("a.low", 3.5), row("a.high", 3.5, better="higher", peer="scipy", peer_value=7),
                         row("a.reported", 9, target=None)])
        done = self.run_bench()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"a\.low .* <= 4 +met\n")
        self.assertRegex(done.stdout, r"a\.high .* >= 4 +MISSED +scipy: 7\n")
        self.assertRegex(done.stdout, r"a\.reported .* reported\n")
        for one in json.loads(self.summary.read_text()):
            self.assertEqual(list(one), ["name", "value", "unit", "better", "target", "peer", "peer_value"])

    def test_a_subset_leaves_the_rows_of_the_others(self):
        self.register(a=[row("a.x", 1)], b=[row("b_y", 2)])
        self.run_bench()
        self.register(a=[row("a.x", 10)], b=[row("b_y", 20)])
        self.assertEqual(self.run_bench("b").returncode, 0)
        self.assertEqual(self.summary_values(), {"a.x": 1, "b_y": 20})

    def test_what_breaks_the_format_is_named_and_drops_the_earlier_rows(self):
        self.register(a=[row("a.x", 1)], b=[row("b.y", 2)])
        self.run_bench()
        broken = {"no JSON": "hello", "value": [row("a.x", "fast")], "better": [row("a.x", 1, better="smaller")],
                  "name": [row("c.x", 1)], "unknown field": [row("a.x", 1, goal=3)], "no row": ""}
        for what, output in broken.items():
            with self.subTest(what=what):
                self.register(a=output, b=[row("b.y", 2)])
                done = self.run_bench()
                self.assertEqual(done.returncode, 1)
                self.assertIn("bench: a: ", done.stderr)
                self.assertIn("expected" if what != "no row" else what, done.stderr)
                self.assertEqual(self.summary_values(), {"b.y": 2})

    def test_an_unknown_prefix_names_what_there_is(self):
        self.register(a=[row("a.x", 1)])
        done = self.run_bench("zz")
        self.assertEqual(done.returncode, 2)
        self.assertIn("expected one of: a", done.stderr)


if __name__ == "__main__":
    RUNNER = Path(sys.argv[1])
    unittest.main(argv=[sys.argv[0]] + sys.argv[2:])
