"""The cost of the core: what the call graph refuses, and what the comparison with the table lets pass.

usage: cost_test.py [unittest arguments]
"""

import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import cost  # noqa: E402
from call_graph import BELOW, CallGraph, RefusedGraph  # noqa: E402

SOURCE = """
  model_->step(pressure);
  entry.handlers[2](device);
"""


def node(symbol, name, frame):
    return f'node: {{ title: "{symbol}" label: "{name}\\n/core/a.cpp:1:2\\n{frame}" }}'


def declared(symbol):
    return f'node: {{ title: "{symbol}" label: "{symbol}\\n/core/a.hpp:1:2" shape : ellipse }}'


def edge(caller, callee, place="a.cpp:1:1"):
    return f'edge: {{ sourcename: "{caller}" targetname: "{callee}" label: "{place}" }}'


def static(size):
    return f"{size} bytes (static)"


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "a.cpp").write_text(SOURCE)

    def write(self, *files):
        paths = [self.folder / f"{number}.ci" for number in range(len(files))]
        for path, lines in zip(paths, files):
            path.write_text("\n".join(['graph: { title: "x"', *lines, "}"]) + "\n")
        return paths

    def graph(self, *files, indirect=None):
        return CallGraph(self.write(*files), self.folder, indirect or {})


class StackByTheCallGraph(Folder):
    def test_the_need_is_that_of_the_deepest_path_across_files(self):
        graph = self.graph([node("a", "void a()", static(100)), declared("b"), edge("a", "b"), edge("a", "c"),
                            node("c", "void c()", static(40))],
                           [node("b", "void b()", "16 bytes (dynamic,bounded)"), edge("b", "d"), node("d", "void d()", static(30))])
        need = graph.need(r"void a\(\)")
        self.assertEqual(need.bytes, 146 + BELOW)
        self.assertEqual([frame.function for frame in need.path], ["void a()", "void b()", "void d()"])

    def test_an_inline_function_counts_with_its_largest_copy(self):
        graph = self.graph([node("a", "void a()", static(8))], [node("a", "void a()", static(24))], [node("a", "void a()", static(16))])
        self.assertEqual(graph.need(r"void a\(\)").bytes, 24 + BELOW)

    def test_a_constructor_of_a_whole_object_is_found_under_the_name_of_its_code(self):
        graph = self.graph([node("a", "void a()", static(8)), edge("a", "_ZN1XC1Ev"), node("_ZN1XC2Ev", "X::X()", static(32))])
        self.assertEqual(graph.need(r"void a\(\)").bytes, 40 + BELOW)

    def test_functions_of_the_library_lie_below_all_frames(self):
        graph = self.graph([node("a", "void a()", static(8)), edge("a", "memcpy"), edge("a", "__aeabi_fadd"), edge("a", "sqrtf")])
        self.assertEqual(graph.need(r"void a\(\)").bytes, 8 + BELOW)

    def test_an_indirect_call_reaches_the_deepest_that_may_answer(self):
        graph = self.graph([node("a", "void a()", static(8)), edge("a", "__indirect_call", "a.cpp:2:14"),
                            node("s", "virtual void Small::step(float)", static(16)),
                            node("l", "virtual void Large::step(float)", static(64)),
                            node("o", "virtual void Large::stop(float)", static(512))],
                           indirect={r"model\.(step|stop)": r"virtual void \w+::\1\(float\)"})
        self.assertEqual(graph.need(r"void a\(\)").bytes, 72 + BELOW)

    def test_the_place_of_a_call_may_be_where_its_name_begins(self):
        graph = self.graph([node("a", "void a()", static(8)), edge("a", "__indirect_call", "a.cpp:2:11"),
                            node("s", "void step()", static(16))], indirect={r"model\.step": r"void step\(\)"})
        self.assertEqual(graph.need(r"void a\(\)").bytes, 24 + BELOW)

    def test_a_call_of_a_driver_costs_the_core_nothing(self):
        graph = self.graph([node("a", "void a()", static(8)), edge("a", "__indirect_call", "a.cpp:2:14")],
                           indirect={r"model\.step": None})
        self.assertEqual(graph.need(r"void a\(\)").bytes, 8 + BELOW)

    def refused(self, expected, *lines, indirect=None):
        with self.assertRaisesRegex(RefusedGraph, expected):
            self.graph(list(lines), indirect=indirect).need(r"void a\(\)")

    def test_an_indirect_call_that_nobody_names_is_refused_with_its_place(self):
        self.refused(r"a\.cpp:2:14: an indirect call of model\.step: INDIRECT of call_graph\.py does not say where it goes",
                     node("a", "void a()", static(8)), edge("a", "__indirect_call", "a.cpp:2:14"))

    def test_an_indirect_call_that_is_no_plain_member_is_refused_with_its_line(self):
        self.refused(r"a\.cpp:3:20: an indirect call of entry\.handlers\[2\]", node("a", "void a()", static(8)),
                     edge("a", "__indirect_call", "a.cpp:3:20"))

    def test_a_name_that_leads_to_no_function_is_refused(self):
        self.refused(r"a\.cpp:2:14: an indirect call of model\.step, and no function is a void gone\\\(\\\)", node("a", "void a()", static(8)),
                     edge("a", "__indirect_call", "a.cpp:2:14"), indirect={r"model\.step": r"void gone\(\)"})

    def test_a_virtual_function_that_no_name_leads_to_is_refused(self):
        self.refused(r"virtual void New::halt\(\): no row of INDIRECT", node("a", "void a()", static(8)),
                     node("n", "virtual void New::halt()", static(8)), indirect={r"model\.step": r"virtual void \w+::step\(\)"})

    def test_recursion_is_refused_with_its_circle(self):
        self.refused(r"recursion: void b\(\) -> void c\(\) -> void b\(\)", node("a", "void a()", static(8)), edge("a", "b"),
                     node("b", "void b()", static(8)), edge("b", "c"), node("c", "void c()", static(8)), edge("c", "b"))

    def test_a_frame_of_unknown_size_is_refused(self):
        self.refused(r"void a\(\) \(/core/a\.cpp:1:2\): the size of its frame is found at run time",
                     node("a", "void a()", "48 bytes (dynamic)"))

    def test_a_function_of_which_nothing_is_known_is_refused(self):
        self.refused(r"void a\(\) calls qsort, of which nothing is known", node("a", "void a()", static(8)), edge("a", "qsort"))

    def test_a_root_that_is_missing_or_not_alone_is_refused(self):
        self.refused(r"one function named void a\\\(\\\) is expected, found: none", node("b", "void b()", static(8)))
        self.refused(r"found: void a\(\), void a\(\)", node("x:a", "void a()", static(8)), node("y:a", "void a()", static(8)))

    def test_a_line_of_another_form_is_refused_with_its_number(self):
        self.refused(r"0\.ci:2: expected what gcc's -fcallgraph-info=su writes, found: nonsense", "nonsense")


class Comparison(Folder):
    def setUp(self):
        super().setUp()
        self.table = {"x86_64, float": {"compiler": "GNU 12", cost.STACK: {"step": 1000, "receive": 500}}}

    def compare(self, name="x86_64, float", compiler="GNU 12", **rows):
        printed, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
            failed = cost.compare(self.table, {name: {"compiler": compiler, cost.STACK: rows}})
        return failed, printed.getvalue(), errors.getvalue()

    def test_up_to_ten_percent_more_passes(self):
        failed, printed, errors = self.compare(step=1100, receive=500)
        self.assertFalse(failed, errors)
        self.assertIn("2 rows, none above the table by more than 10 %", printed)

    def test_more_than_that_fails_and_says_which_how_much_and_how_to_accept_it(self):
        failed, _, errors = self.compare(step=1101, receive=500)
        self.assertTrue(failed)
        self.assertIn("x86_64, float: stack at most [bytes]: step: from 1000 to 1101, +10.1 %", errors)
        self.assertIn("toolchains/dev cost --write", errors)
        self.assertNotIn("receive", errors)

    def test_what_shrank_by_more_passes_and_asks_to_be_written(self):
        failed, printed, errors = self.compare(step=899, receive=450)
        self.assertFalse(failed, errors)
        self.assertIn("step: from 1000 to 899, -10.1 %: keep the gain by toolchains/dev cost --write", printed)
        self.assertNotIn("receive: from", printed)

    def test_another_compiler_is_named_and_not_compared(self):
        failed, printed, errors = self.compare(compiler="GNU 13", step=9999)
        self.assertFalse(failed, errors)
        self.assertIn("the table is of GNU 12, this is GNU 13: nothing compared", printed)

    def test_rows_and_sections_that_only_one_side_has_fail(self):
        self.assertIn("send: 7, not in the table yet", self.compare(step=1000, receive=500, send=7)[2])
        self.assertIn("receive: 500 in the table, but not measured any more", self.compare(step=1000)[2])
        failed, _, errors = self.compare(name="x86_64, fixed", step=1000, receive=500)
        self.assertTrue(failed)
        self.assertIn("x86_64, fixed: no such section in the table", errors)


class Command(Folder):
    """The whole command, on a build of one function and a program that claims to have used some stack."""

    def setUp(self):
        super().setUp()
        lines = [node(f"f{i}", name, static(100)) for i, name in enumerate((
            "plenum::Outputs plenum::Controller::step(const plenum::Inputs&)",
            "void plenum::canopen::Node::receive(const CanFrame&)", "bool plenum::canopen::Node::next_frame(CanFrame&)",
            "uint32_t plenum::canopen::DataSheet::size()",
            "plenum::config::ImageVerdict plenum::Controller::restore(uint8_t)",
            "plenum::Controller::Controller(const plenum::Settings&)", "void plenum::Board::start()",
            "void plenum::Board::handle_frames()", "void plenum::Board::tick(const plenum::TickTiming&)",
            "void plenum::Board::store_changed()"))]
        self.write(lines)
        self.table = self.folder / "cost.json"

    def program(self, name, lines):
        program = self.folder / name
        program.write_text("#!/bin/sh\n" + lines)
        program.chmod(0o755)
        return program

    def run_cost(self, *words, used=200, counter=""):
        program = self.program("stack", f'echo \'{{"row": "Controller::step", "bytes": {used}}}\'\n')
        build = self.folder / "build.json"
        build.write_text(json.dumps({"section": "toy, float", "compiler": "GNU 12", "root": str(self.folder), "emulator": [""],
                                     "stack": str(program), "instructions": str(counter), "objects": [str(self.folder / "0.o")]}))
        printed, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
            code = cost.main([*words, "--table", str(self.table), str(build)])
        return code, printed.getvalue(), errors.getvalue()

    def test_what_was_written_is_met_and_another_section_stays(self):
        self.table.write_text(json.dumps({"other, float": {"compiler": "GNU 12", cost.STACK: {"step": 1}}}))
        code, _, errors = self.run_cost("--write")
        self.assertEqual(code, 0, errors)
        table = json.loads(self.table.read_text())
        self.assertEqual(sorted(table), ["other, float", "toy, float"])
        self.assertEqual(table["toy, float"][cost.STACK]["Board::tick"], 100 + BELOW)
        self.assertEqual(table["toy, float"][cost.USED], {"Controller::step": 200})
        code, printed, errors = self.run_cost()
        self.assertEqual(code, 0, errors)
        self.assertIn("toy, float: 11 rows", printed)

    def test_stack_used_beyond_the_bound_or_far_below_it_fails_and_is_not_written(self):
        for used in (100 + BELOW + 1, (100 + BELOW) // 2 - 1):
            code, _, errors = self.run_cost("--write", used=used)
            self.assertEqual(code, 1)
            self.assertIn(f"Controller::step used {used} bytes of stack", errors)
            self.assertFalse(self.table.exists())

    def counter(self, dearest_known):
        """A program that counts one row: a case takes as many instructions as its number says, a search finds `dearest_known` + 1."""
        return self.program("counter", f"""
if [ "$1" = --list ]; then echo 'Toy::step'; exit; fi
most=0; while read -r row number; do [ "$row" = Toy::step ] && [ "$number" -gt $most ] && most=$number; done
found=$((most < {dearest_known} ? most + 1 : most)); [ $most -gt 0 ] || found=100
echo "{{\\"row\\": \\"Toy::step\\", \\"instructions\\": $found, \\"kept\\": $most, \\"case\\": \\"$found\\"}}"
""")

    def test_a_search_begins_with_the_cases_kept_and_one_that_is_written_goes_further(self):
        counter = self.counter(1000)
        code, _, errors = self.run_cost("--write", counter=counter)
        self.assertEqual(code, 0, errors)
        cases = self.folder / "cases.json"
        most = 100 + cost.ROUNDS_OF_WRITE - 1
        self.assertEqual(json.loads(cases.read_text()), {"toy, float": {"Toy::step": str(most)}})
        self.assertEqual(json.loads(self.table.read_text())["toy, float"][cost.INSTRUCTIONS], {"Toy::step": most})
        cases.write_text(json.dumps({"toy, float": {"Toy::step": "116"}, "toy, fixed": {"Toy::step": "300"}}))
        code, _, errors = self.run_cost(counter=counter)
        self.assertEqual(code, 1)
        self.assertIn(f"Toy::step: from {most} to 117", errors)
        self.assertIn("116", cases.read_text())  # nothing is written where nothing was asked to be
        self.run_cost("--write", counter=counter)
        self.assertEqual(json.loads(cases.read_text())["toy, float"]["Toy::step"], str(300 + cost.ROUNDS_OF_WRITE))

    def test_a_graph_that_is_refused_fails_with_its_reason(self):
        self.write([node("a", "void a()", "8 bytes (dynamic)")])
        code, _, errors = self.run_cost()
        self.assertEqual(code, 1)
        self.assertIn("toy, float: void a() (/core/a.cpp:1:2): the size of its frame is found at run time", errors)


if __name__ == "__main__":
    unittest.main()
