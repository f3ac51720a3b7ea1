"""The tree keeps the rules of rules.py, and each rule catches what it is there for.

usage: rules_test.py SOURCE_DIR ARCHIVE CXX [unittest arguments]
"""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rules

SOURCE_DIR = ARCHIVE = CXX = None


def listed(violations):
    return f"{len(violations)} violations:\n" + "\n".join(violations)


class PlantedTree:
    """A small tree in which something wrong is planted."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory()
        self.root = Path(self._folder.name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._folder.cleanup()

    def plant(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


class Includes(unittest.TestCase):
    def test_every_room_includes_only_what_the_table_allows(self):
        violations = rules.include_violations(SOURCE_DIR)
        self.assertEqual(violations, [], listed(violations))

    def assert_caught(self, name, line, expected):
        with PlantedTree() as tree:
            for header in ("firmware/ports/clock.hpp", "firmware/config/limits.hpp", "host-sim/plant/gas.hpp",
                           "host-sim/identify/fit.hpp"):
                tree.plant(header, "#pragma once\n")
            tree.plant(name, f"// planted\n{line}\n")
            violations = rules.include_violations(tree.root)
            self.assertEqual(len(violations), 1, listed(violations))
            self.assertTrue(violations[0].startswith(f"{name}:2: "), violations[0])
            self.assertIn(expected, violations[0])

    def test_control_that_includes_ports_is_caught(self):
        self.assert_caught("firmware/control/x.cpp", '#include "firmware/ports/clock.hpp"', "firmware/control may not")

    def test_firmware_that_includes_the_host_is_caught(self):
        self.assert_caught("firmware/canopen/x.cpp", '#include "host-sim/plant/gas.hpp"', "firmware may not")

    def test_the_plant_that_includes_firmware_is_caught(self):
        self.assert_caught("host-sim/plant/x.cpp", '  #  include "firmware/config/limits.hpp"', "host-sim/plant may not")

    def test_the_plant_that_includes_a_library_is_caught(self):
        self.assert_caught("host-sim/plant/x.cpp", "#include <fmt/format.h>", "standard library and Eigen")

    def test_the_report_that_includes_identify_is_caught(self):
        self.assert_caught("host-sim/report/x.cpp", '#include "host-sim/identify/fit.hpp"', "host-sim/report may not")

    def test_a_hosted_header_in_firmware_is_caught(self):
        self.assert_caught("firmware/config/x.hpp", "#include <vector>", "freestanding")

    def test_ceres_outside_identification_is_caught(self):
        self.assert_caught("host-sim/rig/x.cpp", "#include <ceres/ceres.h>", "host-sim/identify")

    def test_a_command_that_includes_the_parser_is_caught(self):
        self.assert_caught("host-sim/tools/x.cpp", "#include <CLI/CLI.hpp>", "host-sim/tools/command_line.cpp")

    def test_an_include_not_rooted_at_the_repository_is_caught(self):
        self.assert_caught("host-sim/plant/x.cpp", '#include "gas.hpp"', "rooted")

    def test_a_folder_outside_the_table_is_caught(self):
        with PlantedTree() as tree:
            tree.plant("host-sim/common/x.cpp", "\n")
            self.assertIn("no room", rules.include_violations(tree.root)[0])


class Words(unittest.TestCase):
    def test_firmware_holds_no_banned_word(self):
        violations = rules.banned_word_violations(SOURCE_DIR)
        self.assertEqual(violations, [], listed(violations))

    def test_each_banned_word_is_caught_at_its_line(self):
        for line in ("double x = 0;", "auto* p = new int;", "delete p;", "std::vector<int> v;", "std::string s;",
                     "std::function<void()> f;", "throw 1;", "int r = rand();", "void* p = std::malloc(4);",
                     "auto t = std::chrono::seconds(1);", "dynamic_cast<A*>(b);", "std::printf(\"x\");", "time(nullptr);"):
            with self.subTest(line=line), PlantedTree() as tree:
                tree.plant("firmware/config/x.cpp", f"// a comment\n\n{line}\n")
                violations = rules.banned_word_violations(tree.root)
                self.assertEqual(len(violations), 1, listed(violations))
                self.assertTrue(violations[0].startswith("firmware/config/x.cpp:3: "), violations[0])

    def test_float_is_caught_in_control_only(self):
        with PlantedTree() as tree:
            tree.plant("firmware/control/x.cpp", "float x;\n")
            tree.plant("firmware/config/x.cpp", "float x;\n")
            violations = rules.banned_word_violations(tree.root)
            self.assertEqual(len(violations), 1, listed(violations))
            self.assertIn("firmware/control/x.cpp:1:", violations[0])

    def test_comments_literals_and_longer_names_are_no_words_of_the_code(self):
        with PlantedTree() as tree:
            tree.plant("firmware/config/x.cpp",
                       "// throw a double\n/* new\n delete */ const char* text = \"rand() new\";\n"
                       "X(const X&) = delete;\nstd::string_view name;\nint new_value = renewed + 1'000;\n"
                       "auto t = clock.time(); bus.free(); std::uint32_t time = 3;\n")
            violations = rules.banned_word_violations(tree.root)
            self.assertEqual(violations, [], listed(violations))


class MachineNames(unittest.TestCase):
    def test_the_tree_names_no_machine_path_and_no_registry(self):
        violations = rules.machine_name_violations(SOURCE_DIR)
        self.assertEqual(violations, [], listed(violations))

    def test_each_such_name_is_caught_at_its_line(self):
        for text in ("/" + "work/main/x", "/" + "root/x", "/" + "home/ann/x", "registry.npm" + "js.org", "deb.deb" + "ian.org"):
            with self.subTest(text=text), PlantedTree() as tree:
                tree.plant("toolchains/x.txt", f"\nsee {text}\n")
                violations = rules.machine_name_violations(tree.root)
                self.assertEqual(len(violations), 1, listed(violations))
                self.assertTrue(violations[0].startswith("toolchains/x.txt:2: "), violations[0])


class Rooms(unittest.TestCase):
    def test_each_room_is_found_from_a_readme_above(self):
        violations = rules.unlisted_rooms(SOURCE_DIR)
        self.assertEqual(violations, [], listed(violations))

    def test_a_room_that_no_readme_names_is_caught(self):
        with PlantedTree() as tree:
            tree.plant("README.md", "[plant](host-sim/plant/README.md)")
            tree.plant("host-sim/plant/README.md", "[valve](valve/README.md), [gas](../gas/README.md)")
            for room in ("plant/valve", "gas"):
                tree.plant(f"host-sim/{room}/README.md", "")
            self.assertEqual(rules.unlisted_rooms(tree.root), ["host-sim/gas/README.md:1: no README of a folder above links to it"])


class Symbols(unittest.TestCase):
    def test_the_firmware_archive_needs_no_heap_throw_thread_clock_or_libm(self):
        violations = rules.symbol_violations(ARCHIVE)
        self.assertEqual(violations, [], listed(violations))

    def archive_of(self, folder, code):
        source, object_, archive = (folder / name for name in ("planted.cpp", "planted.o", "libplanted.a"))
        source.write_text(code, encoding="utf-8")
        subprocess.run([CXX, "-std=c++20", "-O1", "-c", source, "-o", object_], check=True)
        subprocess.run(["ar", "rcs", archive, object_], check=True)
        return archive

    def assert_needs(self, code, why):
        with tempfile.TemporaryDirectory() as folder:
            violations = rules.symbol_violations(self.archive_of(Path(folder), code))
            self.assertTrue(any(violation.endswith(": " + why) for violation in violations), listed(violations))
            self.assertTrue(all("planted.o" in violation for violation in violations), listed(violations))

    def test_heap_is_caught(self):
        self.assert_needs("int* f() { return new int[7]; }", "heap")

    def test_malloc_is_caught(self):
        self.assert_needs("#include <cstdlib>\nvoid* f() { return std::malloc(7); }", "heap")

    def test_double_without_a_floating_point_unit_is_caught(self):
        self.assert_needs('extern "C" double __aeabi_dmul(double, double);\n'
                          "double f(double x) { return __aeabi_dmul(x, x); }", "double")

    def test_a_throw_is_caught(self):
        self.assert_needs("void f() { throw 1; }", "exceptions")

    def test_a_hidden_static_is_caught(self):
        self.assert_needs("struct A { A(); ~A(); };\nA& f() { static A a; return a; }", "hidden statics")

    def test_a_thread_is_caught(self):
        self.assert_needs("#include <thread>\nvoid f() { std::thread([] {}).detach(); }", "threads")

    def test_a_clock_is_caught(self):
        self.assert_needs("#include <chrono>\nlong f() { return std::chrono::steady_clock::now().time_since_epoch().count(); }",
                          "clock")

    def test_printing_is_caught(self):
        self.assert_needs("#include <iostream>\nvoid f(int x) { std::cout << x; }", "input and output")

    def test_libm_is_caught(self):
        self.assert_needs("#include <cmath>\ndouble f(double x) { return std::sin(x); }\n"
                          "float g(float x) { return std::exp(x); }", "libm, whose bits differ from machine to machine")

    def test_block_moves_and_exact_roots_are_allowed(self):
        with tempfile.TemporaryDirectory() as folder:
            archive = self.archive_of(Path(folder), "#include <cmath>\n#include <cstring>\n"
                                      "float f(float x) { return std::sqrt(x); }\n"
                                      "void g(char* a, const char* b, unsigned long n) { std::memmove(a, b, n); }")
            violations = rules.symbol_violations(archive)
            self.assertEqual(violations, [], listed(violations))


if __name__ == "__main__":
    SOURCE_DIR, ARCHIVE, CXX = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    unittest.main(argv=[sys.argv[0]] + sys.argv[4:])
