"""What a test preset leaves out it names: each name in CMakePresets.json is that of a test.

presets_test.py SOURCE BUILD CTEST, of a build that has all tests. A test that is renamed would else run again where it takes minutes.
"""

import json
import re
import subprocess
import sys
from pathlib import Path


def alternatives(pattern):
    """Of a regular expression "a|b(c|d)" the three "a", "bc", "bd"; groups are not nested."""
    for part in re.split(r"\|(?![^()]*\))", pattern):
        group = re.fullmatch(r"(.*)\((.*)\)(.*)", part)
        yield from [group[1] + middle + group[3] for middle in group[2].split("|")] if group else [part]


def names_no_test(presets, tests):
    for preset in presets["testPresets"]:
        for pattern in alternatives(preset.get("filter", {}).get("exclude", {}).get("name", "")):
            if not any(re.search(pattern, test) for test in tests):
                yield f"CMakePresets.json, {preset['name']}: {pattern}: names no test"


source, build, ctest = sys.argv[1:]
listed = subprocess.run([ctest, "--test-dir", build, "-N"], check=True, capture_output=True, text=True).stdout
if "_NOT_BUILT" in listed:
    print("not asked: some of the tests are not built, and have no names")
    sys.exit()
tests = re.findall(r"^ *Test +#\d+: (\S+)", listed, re.MULTILINE)
assert list(alternatives("a|b(c|d)|e")) == ["a", "bc", "bd", "e"]
planted = {"testPresets": [{"name": "p", "filter": {"exclude": {"name": f"{re.escape(tests[0])}|Gone\\."}}}]}
assert len(list(names_no_test(planted, tests))) == 1, "a name of no test is not seen"
found = list(names_no_test(json.loads((Path(source) / "CMakePresets.json").read_text()), tests))
sys.exit("\n".join(found) or 0)
