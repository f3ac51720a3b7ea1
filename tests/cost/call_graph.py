"""How much stack a function may need at most: the deepest path through the call graph that gcc writes beside each object.

A .ci file of -fcallgraph-info=su holds each function with its frame in bytes, and each call with its place. Where an indirect call
goes it cannot tell; INDIRECT does, by the words that stand at the call. CallGraph refuses, by a RefusedGraph that says where, what
would make its answer a guess: an indirect call that INDIRECT does not name, a virtual function that no row of it leads to, a
function of which nothing is known, recursion, and a frame whose size is found at run time.
"""

import re
from collections import namedtuple
from pathlib import Path

# What may lie below the deepest frame [bytes]. A leaf of x86-64 uses up to 128 without counting them in its frame (the red zone
# of its ABI); what the core calls of the C and the compiler's library takes less (__aeabi_ldivmod of libgcc 60, memcpy of glibc 32,
# both of armel, by their disassembly).
BELOW = 128

DEVICE, PLACE, VALUE = r"(?:plenum::canopen::)?Device&", r"(?:plenum::canopen::)?Place", r"(?:uint32_t|Bits)"
WITH = r"(?: \[with .*\])?"

# Where indirect calls go: "object.member" as it is written at the call, less a trailing underscore, and the functions that may
# answer, as gcc prints them: all of that type, or all that override. None: a driver, which is no part of the core.
INDIRECT = {
    r"model\.(opening|moving|step|inverse|draw)": r"virtual .* plenum::control::\w+::\1\(.*\) const",
    r"desk\.(\w+)": r"virtual .* plenum::config::ParameterSlots::\1\(.*\)(?: const)?",
    r"trial\.begin": r"virtual bool plenum::\w+::begin\(uint8_t\)",
    r"proof\.begin": r"virtual void plenum::\w+::begin\(uint8_t\)",
    r"known\.validate": r"plenum::config::ImageVerdict .*validate_\w+\(const plenum::config::ModelParameters&\)",
    r"line\.value": rf"void .*\(plenum::canopen::TextLine&, const plenum::canopen::Identity&\){WITH}",
    # the columns of the object dictionary
    r"entry\.read_value": rf"plenum::canopen::Abort .*\(const {DEVICE}, {PLACE}, {VALUE}&\){WITH}",
    r"entry\.write_value": rf"plenum::canopen::Abort .*\({DEVICE}, {PLACE}, {VALUE}\){WITH}",
    r"entry\.read_bytes": rf"std::span<const unsigned char> .*\(const {DEVICE}, {PLACE}\){WITH}",
    r"entry\.write_bytes": rf"plenum::canopen::Abort .*\({DEVICE}, {PLACE}, std::span<const unsigned char>\){WITH}",
    r"entry\.read_stream": rf"std::size_t .*\({DEVICE}, {PLACE}, uint32_t, std::span<unsigned char>\){WITH}",
    r"entry\.outcome": rf"plenum::canopen::Abort .*\(const {DEVICE}, {PLACE}\){WITH}",
    r"entry\.stream_size": rf"uint32_t .*\(const {DEVICE}, {PLACE}\){WITH}",
    r"(can|analog_in|analog_out|digital|medium)\.\w+": None,
}

# Of the C and the compiler's library; tests/architecture holds the archive to fewer. None of them calls back.
OUTSIDE = re.compile(r"mem(cpy|move|set|cmp)|strlen|[a-z]+f|__aeabi_\w+|__c[lt]zdi2|__u?(div|mod)[dt]i3")

NODE = re.compile(r'node: \{ title: "([^"]*)" label: "(.*)"(?: shape : ellipse)? \}')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"(?: label: "([^"]*)")? \}')
FRAME = re.compile(r"(\d+) bytes \(([a-z,]+)\)")
INDIRECT_CALL = "__indirect_call"

Frame = namedtuple("Frame", "function bytes")
Need = namedtuple("Need", "bytes path")  # path: the Frames from the root to the deepest


class RefusedGraph(Exception):
    pass


class CallGraph:
    """`files`: .ci files of all objects. `root`: the folder that the places in them are relative to."""

    def __init__(self, files, root, indirect=INDIRECT):
        self._root = Path(root)
        self._indirect = {re.compile(key): answer for key, answer in indirect.items()}
        self._name, self._frame, self._calls = {}, {}, {}
        self._sources, self._answers, self._needs = {}, {}, {}
        for path in files:
            self._read(Path(path))
        self._refuse_unanswered()

    def need(self, pattern):
        """The stack [bytes] that a call of the one function whose name `pattern` matches may need, and on which path."""
        roots = sorted({symbol for symbol, name in self._name.items() if re.fullmatch(pattern, name)})
        if len(roots) != 1:
            found = ", ".join(self._name[symbol] for symbol in roots) or "none"
            raise RefusedGraph(f"one function named {pattern} is expected, found: {found}")
        need = self._need(roots[0], [])
        return Need(need.bytes + BELOW, need.path)

    def _read(self, path):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            node, edge = NODE.fullmatch(line), EDGE.fullmatch(line)
            if edge:
                self._calls.setdefault(edge[1], set()).add((edge[2], edge[3]))
            elif node:
                self._take_node(node[1], node[2].split(r"\n"))
            elif not re.match(r"graph: \{|\}", line):
                raise RefusedGraph(f"{path}:{number}: expected what gcc's -fcallgraph-info=su writes, found: {line[:100]}")

    def _take_node(self, symbol, label):
        frame = FRAME.fullmatch(label[-1])
        if frame is None:
            return  # called in this file, defined in another
        if frame[2] == "dynamic":
            raise RefusedGraph(f"{label[0]} ({label[1]}): the size of its frame is found at run time")
        self._name[symbol] = label[0]
        # an inline function stands in several objects, and the linker picks one
        self._frame[symbol] = max(self._frame.get(symbol, 0), int(frame[1]))

    def _refuse_unanswered(self):
        wanted = [re.compile(answer.replace(r"\1", r"\w+")) for answer in self._indirect.values() if answer is not None]
        for name in self._name.values():
            if name.startswith("virtual ") and not any(one.fullmatch(name) for one in wanted):
                raise RefusedGraph(f"{name}: no row of INDIRECT leads to this virtual function")

    def _need(self, symbol, callers):
        if symbol not in self._frame:
            symbol = re.sub(r"([CD])1(?=E)", r"\g<1>2", symbol)  # constructor and destructor of a whole object: one code, two names
        if symbol in callers:
            cycle = " -> ".join(self._name[one] for one in callers[callers.index(symbol):] + [symbol])
            raise RefusedGraph(f"recursion: {cycle}")
        if symbol not in self._needs:
            self._needs[symbol] = self._need_afresh(symbol, callers)
        return self._needs[symbol]

    def _need_afresh(self, symbol, callers):
        if symbol not in self._frame:
            if OUTSIDE.fullmatch(symbol):
                return Need(0, [])  # BELOW covers it
            raise RefusedGraph(f"{self._name[callers[-1]]} calls {symbol}, of which nothing is known")
        deepest = Need(0, [])
        for target, place in sorted(self._calls.get(symbol, ())):
            for callee in self._answers_at(place) if target == INDIRECT_CALL else [target]:
                deepest = max(deepest, self._need(callee, callers + [symbol]), key=lambda need: need.bytes)
        own = Frame(self._name[symbol], self._frame[symbol])
        return Need(own.bytes + deepest.bytes, [own] + deepest.path)

    def _answers_at(self, place):
        site = self._site(place)
        if site not in self._answers:
            self._answers[site] = self._answers_to(site, place)
        return self._answers[site]

    def _answers_to(self, site, place):
        for key, answer in self._indirect.items():
            call = key.fullmatch(site)
            if call is None:
                continue
            if answer is None:
                return []
            wanted = re.compile(answer.replace(r"\1", call[1]) if key.groups else answer)
            found = [symbol for symbol, name in self._name.items() if wanted.fullmatch(name)]
            if found:
                return found
            raise RefusedGraph(f"{place}: an indirect call of {site}, and no function is a {wanted.pattern}")
        raise RefusedGraph(f"{place}: an indirect call of {site}: INDIRECT of {Path(__file__).name} does not say where it goes")

    def _site(self, place):
        """What is called at file:line:column, as "object.member"; the column is that of the member's begin, or of what follows it."""
        name, line, column = place.rsplit(":", 2)
        path = self._root / name
        if path not in self._sources:
            self._sources[path] = path.read_text(encoding="utf-8").splitlines()
        text = self._sources[path][int(line) - 1]
        end = re.compile(r"\w*").match(text, int(column) - 1).end()
        words = re.search(r"(?:(\w+?)_?(?:\.|->))?(\w+)$", text[:end])
        return ".".join(word for word in words.groups() if word) if words else text.strip()
