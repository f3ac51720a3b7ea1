"""The rules of the house that a compiler does not check, each as a function from a tree or an archive to its violations.

A violation is one line: file:line: what was found, what is allowed. An empty list is a pass.
"""

import re
import subprocess
from pathlib import Path

# Who may include whom: a room's files may include its own room and these. "" is every room.
MAY_INCLUDE = {
    "firmware/control": ["firmware/numeric", "firmware/config"],
    "firmware/safety": ["firmware/numeric", "firmware/config"],
    "firmware/telemetry": ["firmware/numeric", "firmware/config"],
    "firmware": ["firmware"],
    "board": ["firmware", "board"],
    "host-sim/plant": [],
    "host-sim/effects": ["host-sim/plant"],
    "host-sim/wire": ["firmware/ports"],
    "host-sim/ports": ["firmware/ports", "host-sim/wire", "host-sim/plant", "host-sim/effects"],
    # What a board keeps in files the simulated one keeps in the same.
    "host-sim/rig": ["firmware", "host-sim/ports", "host-sim/plant", "host-sim/effects", "host-sim/trace", "board/drivers/slot_files.hpp"],
    "host-sim/trace": [],
    # The judge of diagnose shares no physics with what it judges.
    "host-sim/blind": ["host-sim/trace"],
    "host-sim/identify": ["host-sim/plant", "host-sim/effects", "host-sim/trace"],
    "host-sim/diagnose": ["host-sim/identify", "host-sim/effects", "host-sim/plant", "host-sim/trace"],
    # The socketcand and SocketCAN doors: the driver of the board is an exception. What a stranger wrote is shown in one way.
    "host-sim/client": ["firmware/canopen", "firmware/safety", "firmware/telemetry", "firmware/ports", "host-sim/wire", "board/drivers",
                        "host-sim/trace/legible.hpp"],
    "host-sim/dictionary": ["firmware"],
    "host-sim/rounding": ["firmware/control", "firmware/config", "firmware/numeric"],
    "host-sim/report": ["host-sim/trace"],
    "host-sim/reproduce": ["host-sim/plant", "host-sim/effects", "host-sim/trace", "host-sim/identify", "host-sim/report"],
    "host-sim/tools": ["host-sim"],
    "tests": [""],
}

# What a freestanding core may take from the standard library: types, bits and loops, nothing that allocates, throws,
# reads a clock, starts a thread or prints. What these headers offer beyond that is caught in the archive's symbols.
FIRMWARE_HEADERS = {
    "algorithm", "array", "bit", "cmath", "compare", "concepts", "cstddef", "cstdint", "cstring", "initializer_list",
    "iterator", "limits", "numbers", "numeric", "optional", "ratio", "span", "string_view", "tuple", "type_traits",
    "utility", "variant", "Eigen/Core", "Eigen/Dense", "Eigen/LU", "Eigen/Cholesky", "Eigen/QR",
}

# Libraries that only some rooms, or some files, may know; every other room's foreign headers are its own affair.
LIBRARY_OWNERS = [
    (re.compile(r"^ceres/"), ("host-sim/identify", "host-sim/diagnose", "tests")),
    # Each source that includes CLI11 compiles the whole of it anew.
    (re.compile(r"^CLI/"), ("host-sim/tools/command_line.cpp", "host-sim/tools/dictionary.cpp", "board/main.cpp")),
    (re.compile(r"^(gtest|gmock|rapidcheck|benchmark)\b"), ("tests",)),
]
# The plant is std and Eigen only.
FOREIGN = re.compile(r"^(ceres|CLI|toml\+\+|fmt|spdlog|nlohmann|gtest|gmock|rapidcheck|benchmark)\b")

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')
SOURCE_SUFFIXES = {".cpp", ".hpp", ".h", ".c"}


def files(root, *folders):
    """The files of the tree, without what is built or fetched, in a stable order."""
    left_out = {".git", "build", "node_modules", "__pycache__"}
    for top in folders or ("",):
        for path in sorted((root / top).rglob("*")):
            if path.is_file() and not left_out & set(path.relative_to(root).parts):
                yield path


def sources(root, *folders):
    return (path for path in files(root, *folders) if path.suffix in SOURCE_SUFFIXES)


def is_within(name, room):
    return room == "" or name == room or name.startswith(room + "/")


def room_of(name):
    """The longest entry of the table that holds `name`; a folder of firmware outside it is the room 'firmware/x'."""
    holders = [room for room in MAY_INCLUDE if is_within(name, room)]
    return max(holders, key=len) if holders else None


def include_violations(root):
    found = []
    for path in sources(root, "firmware", "board", "host-sim", "tests"):
        name = path.relative_to(root).as_posix()
        room = room_of(name)
        if room is None:
            found.append(f"{name}:1: this folder is no room of the table in tests/architecture/rules.py")
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            if match:
                reason = include_fault(root, name, room, *match.groups())
                if reason:
                    found.append(f"{name}:{number}: {reason}")
    return found


def include_fault(root, name, room, ours, foreign):
    if ours is not None:
        if not (root / ours).is_file():
            return f'"{ours}" is no file of the repository; includes are rooted there'
        allowed = [room] + MAY_INCLUDE[room]
        if not any(is_within(ours, one) for one in allowed):
            return f'{room} may not include "{ours}"; it may include {", ".join(allowed)}'
        return None
    if is_within(room, "firmware") and foreign not in FIRMWARE_HEADERS:
        return f"firmware may not include <{foreign}>: it is not among the freestanding headers"
    if room in ("host-sim/plant", "host-sim/effects") and FOREIGN.match(foreign):
        return f"{room} may not include <{foreign}>; it knows the standard library and Eigen"
    for pattern, owners in LIBRARY_OWNERS:
        if pattern.match(foreign) and not any(is_within(name, owner) for owner in owners):
            return f"{room} may not include <{foreign}>; that is for {', '.join(owners)}"
    return None


# ---- rooms that a reader finds

def unlisted_rooms(root):
    """Each folder that has a README is linked from a README above it."""
    found = []
    for path in files(root, "firmware", "board", "host-sim", "tests"):
        if path.name == "README.md":
            above = (folder / "README.md" for folder in path.parent.parents if folder == root or root in folder.parents)
            if not any(f"({path.relative_to(one.parent).as_posix()})" in one.read_text(encoding="utf-8") for one in above if one.is_file()):
                found.append(f"{path.relative_to(root).as_posix()}:1: no README of a folder above links to it")
    return found


# ---- words that the core's sources may not hold

BANNED_WORDS = [
    (r"double", "the core computes in its scalar"),
    (r"long\s+double", "the core computes in its scalar"),
    (r"new", "no heap"),
    (r"delete", "no heap"),
    (r"malloc|calloc|realloc|free|alloca", "no heap"),
    (r"std::(vector|string|deque|list|forward_list|map|set|multimap|multiset|unordered_\w+)", "no heap"),
    (r"std::(unique_ptr|shared_ptr|make_unique|make_shared|function|any)", "no heap"),
    (r"throw|try|catch", "no exceptions"),
    (r"dynamic_cast|typeid", "no run-time types"),
    (r"std::(chrono|thread|mutex|atomic|condition_variable|async|future)", "no clock, no threads"),
    (r"rand|srand|time|clock|gettimeofday|clock_gettime|sleep|usleep", "no clock, no hidden state"),
    (r"printf|sprintf|snprintf|puts|std::c(out|err|in)", "no input or output"),
    (r"goto|setjmp|longjmp", "no jumps"),
]
# A call or a type, not part of a longer name, a member or a qualified name of ours (safety::clear, state.time).
BANNED_CALLS = {"rand|srand|time|clock|gettimeofday|clock_gettime|sleep|usleep", "malloc|calloc|realloc|free|alloca",
                "printf|sprintf|snprintf|puts|std::c(out|err|in)"}
BANNED = [
    (re.compile(r"(?<![\w.:>])(?:std::)?(?:" + words + r")\s*\(" if words in BANNED_CALLS else r"(?<![\w:])(?:" + words + r")(?!\w)"), why)
    for words, why in BANNED_WORDS
]
BANNED_IN_CONTROL = (re.compile(r"(?<![\w:])float(?!\w)"), "control computes in Scalar and names no other real type")
DELETED_FUNCTION = re.compile(r"=\s*delete\b")

COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)


def code_only(text):
    """The text with comments and literals blanked, line numbers kept. Digit separators (1'000) are no literals."""
    text = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "", text)
    text = COMMENT_OR_TEXT.sub(lambda match: '""' + "\n" * match.group().count("\n"), text)
    return DELETED_FUNCTION.sub("", text)


def banned_word_violations(root):
    found = []
    for path in sources(root, "firmware"):
        name = path.relative_to(root).as_posix()
        rules = BANNED + ([BANNED_IN_CONTROL] if is_within(name, "firmware/control") else [])
        for number, line in enumerate(code_only(path.read_text(encoding="utf-8")).splitlines(), 1):
            if line.lstrip().startswith("#include"):
                continue
            for pattern, why in rules:
                match = pattern.search(line)
                if match:
                    found.append(f"{name}:{number}: '{match.group().strip()}' may not stand in firmware: {why}")
    return found


# ---- names of one machine or of a registry

# Written in brackets so that this file does not name them itself.
MACHINE_NAMES = re.compile(
    r"(?<![\w.])/(?:[w]ork|[f]arm|[r]oot|[t]mp|[h]ome/\w+|[U]sers/\w+)/"
    r"|deb[i]an[.]org|npm[j]s[.]|py[p]i[.]|pythonh[o]sted|registry[.]y[a]rn|cr[a]tes[.]io")


def machine_name_violations(root):
    found = []
    for path in files(root):
        name = path.relative_to(root).as_posix()
        if is_within(name, "tests/data"):
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            match = MACHINE_NAMES.search(line)
            if match:
                found.append(f"{name}:{number}: '{match.group()}' names one machine or a package registry")
    return found


# ---- what the archive of the core needs from outside

# All that may be undefined: block moves and comparisons, which a compiler emits by itself, the floating-point functions
# that IEEE 754 rounds exactly, so that they give the same bits everywhere, and the trap of a pure virtual call.
ALLOWED_SYMBOLS = re.compile(
    r"^(mem(cpy|move|set|cmp)|bcmp|strlen"
    r"|(sqrt|floor|ceil|trunc|round|nearbyint|rint|lround|lrint|fabs|fmin|fmax|copysign|fma)f"
    r"|__cxa_pure_virtual|__stack_chk_fail|_GLOBAL_OFFSET_TABLE_"
    # What 32-bit Arm leaves to the compiler's library: float without a floating-point unit, and 64-bit integers.
    r"|__aeabi_(f(add|sub|rsub|mul|div|cmp(eq|lt|le|ge|gt|un)|2(u?iz|u?lz))|(u?i|u?l)2f|u?[il]div(mod)?|l(mul|asr|lsl|lsr|cmp))|__c[lt]zdi2"
    # A thread's own count of the results that its fixed-point numbers cut off.
    r"|__tls_get_addr|__aeabi_read_tp"
    r"|__(asan|ubsan|sanitizer)_\w+)$")

WHY_FORBIDDEN = [
    (re.compile(r"^__aeabi_(d\w+|f2d|u?[il]2d)$"), "double"),
    (re.compile(r"^operator (new|delete)|^(malloc|calloc|realloc|free|posix_memalign|aligned_alloc)$"), "heap"),
    (re.compile(r"^__cxa_(throw|begin_catch|end_catch|rethrow|allocate_exception)|^_Unwind|^__gxx_personality"
                r"|^std::__throw|^std::terminate|^__cxa_call"), "exceptions"),
    (re.compile(r"^__cxa_(guard|atexit)|^__dso_handle"), "hidden statics"),
    (re.compile(r"typeinfo|^__dynamic_cast"), "run-time types"),
    (re.compile(r"^pthread|^std::thread|^std::(mutex|condition_variable)|^__gthread"), "threads"),
    (re.compile(r"chrono|^clock|^time$|^gettimeofday|^nanosleep|^(u|)sleep"), "clock"),
    (re.compile(r"ostream|istream|ios_base|^(f|s|sn|)printf$|^__printf_chk|^puts$|^putchar$|^(f|)write$"), "input and output"),
    (re.compile(r"^__aeabi_d|^__\w+df[23]?$|^__extendsfdf2|^__truncdfsf2|^__float\w+df$|^__fix\w*df\w+$"),
     "double precision in software"),
    (re.compile(r"^(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|sinh|cosh|tanh|cbrt|hypot|fmod)f?$"),
     "libm, whose bits differ from machine to machine"),
    (re.compile(r"^(abort|exit|_exit|__assert_fail)$"), "ends the program"),
]


def symbol_violations(archive, nm="nm"):
    """Undefined symbols of the archive that no member of it defines and ALLOWED_SYMBOLS does not hold."""
    listing = subprocess.run([nm, "-C", str(archive)], check=True, capture_output=True, text=True).stdout
    defined, needed, member = set(), [], "?"
    for line in listing.splitlines():
        if line.endswith(":") and " " not in line:
            member = line[:-1]
            continue
        match = re.match(r"^[0-9a-fA-F]*\s+([A-Za-z])\s(.+)$", line)
        if not match:
            continue
        kind, symbol = match.groups()
        if kind in "UwvW" and not re.match(r"^[0-9a-fA-F]+\s", line):
            needed.append((member, symbol))
        else:
            defined.add(symbol)
    found = []
    for member, symbol in needed:
        bare = symbol.split("@")[0]
        if symbol in defined or ALLOWED_SYMBOLS.match(bare):
            continue
        why = next((why for pattern, why in WHY_FORBIDDEN if pattern.search(bare)), "not among the allowed symbols")
        found.append(f"{Path(archive).name}({member}): needs {symbol}: {why}")
    return found
