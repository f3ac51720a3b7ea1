"""Reads what plenum_dictionary writes by readers that share no line with it.

usage: dictionary_test.py SOURCE_DIRECTORY PLENUM_DICTIONARY [CASE]
"""

import configparser
import re
import struct
import subprocess
import sys
import unittest
from pathlib import Path

SOURCE = TOOL = None

# CiA 306: object types and the data types of this board, with their sizes in bits
VAR, ARRAY, RECORD, DOMAIN = 0x7, 0x8, 0x9, 0x2
BITS = {0x02: 8, 0x03: 16, 0x04: 32, 0x05: 8, 0x06: 16, 0x07: 32, 0x08: 32}
SIGNED = {0x02, 0x03, 0x04}
REAL32, VISIBLE_STRING = 0x08, 0x09


def written(*arguments):
    return subprocess.run([TOOL, *arguments, "-"], check=True, capture_output=True, text=True).stdout


def parsed(text):
    file = configparser.ConfigParser(strict=True, interpolation=None, delimiters=("=",), comment_prefixes=(";",))
    file.optionxform = str
    file.read_string(text)
    return file


def number(text):
    return int(text, 0)


class DataSheet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.eds = parsed(written("--eds"))

    def listed(self, section):
        rows = dict(self.eds[section])
        count = number(rows.pop("SupportedObjects"))
        self.assertEqual(list(rows), [str(i + 1) for i in range(count)], section)
        return [number(index) for index in rows.values()]

    def members(self, index):
        prefix = f"{index:04X}sub"
        return {int(name[len(prefix):], 16): self.eds[name] for name in self.eds.sections() if name.startswith(prefix)}

    def values(self):
        """(name of the section, section) of everything that holds a value."""
        for name in self.eds.sections():
            if re.fullmatch(r"[0-9A-F]{4}(sub[0-9A-F]+)?", name) and "SubNumber" not in self.eds[name]:
                yield name, self.eds[name]

    def default(self, section):
        """The default for node 5 as the bits that the node holds; None where there is none."""
        text, kind = section.get("DefaultValue"), number(section["DataType"])
        if text is None or kind == VISIBLE_STRING:
            return None
        node = 0
        if text.startswith("$NODEID+"):
            text, node = text.removeprefix("$NODEID+"), 5
        if kind == REAL32:
            return struct.unpack("<f", struct.pack("<f", float(text)))[0]
        return number(text) + node

    def test_lists_each_object_once_in_the_list_of_its_area(self):
        mandatory, optional, manufacturer = map(self.listed, ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"))
        self.assertEqual(mandatory, [0x1000, 0x1001, 0x1018])
        self.assertTrue(all(0x2000 <= index < 0x6000 for index in manufacturer))
        self.assertTrue(all(0x1000 <= index < 0x2000 or 0x6000 <= index < 0xA000 for index in optional))
        everything = mandatory + optional + manufacturer
        self.assertEqual(len(everything), len(set(everything)))
        sections = {int(name, 16) for name in self.eds.sections() if re.fullmatch(r"[0-9A-F]{4}", name)}
        self.assertEqual(set(everything), sections)

    def test_has_no_section_that_is_neither_head_nor_object(self):
        head = {"FileInfo", "DeviceInfo", "DummyUsage", "Comments", "MandatoryObjects", "OptionalObjects", "ManufacturerObjects"}
        for name in self.eds.sections():
            self.assertTrue(name in head or re.fullmatch(r"[0-9A-F]{4}(sub[0-9A-F]{1,2})?", name), name)

    def test_counts_the_members_of_each_record(self):
        for name in self.eds.sections():
            if not re.fullmatch(r"[0-9A-F]{4}", name):
                continue
            kind, members = number(self.eds[name]["ObjectType"]), self.members(int(name, 16))
            if kind in (VAR, DOMAIN):
                self.assertEqual(members, {}, name)
                continue
            self.assertIn(kind, (ARRAY, RECORD), name)
            self.assertEqual(number(self.eds[name]["SubNumber"]), len(members), name)
            self.assertEqual(number(members[0]["DataType"]), 0x05, name)
            highest = self.default(members[0])
            if members[0]["AccessType"] == "const":
                self.assertEqual(highest, max(members), name)
            if kind == ARRAY:
                self.assertEqual(len({section["DataType"] for sub, section in members.items() if sub > 0}), 1, name)

    def test_gives_what_each_value_must_have(self):
        for name, section in self.values():
            with self.subTest(name):
                self.assertIn(section["AccessType"], ("ro", "wo", "rw", "rwr", "rww", "const"))
                self.assertLessEqual(len(section["ParameterName"]), 241)
                kind = number(section["DataType"])
                if number(section["ObjectType"]) == DOMAIN:
                    self.assertEqual(kind, 0x0F)
                    self.assertNotIn("PDOMapping", section)
                else:
                    self.assertEqual(number(section["ObjectType"]), VAR)
                    self.assertIn(section["PDOMapping"], ("0", "1"))
                self.assertEqual("LowLimit" in section, "HighLimit" in section)

    def test_keeps_defaults_within_type_and_limits(self):
        for name, section in self.values():
            value = self.default(section)
            if value is None:
                continue
            with self.subTest(name):
                kind = number(section["DataType"])
                if kind != REAL32:
                    low = -(1 << BITS[kind] - 1) if kind in SIGNED else 0
                    self.assertTrue(low <= value < low + (1 << BITS[kind]))
                if "LowLimit" in section:
                    self.assertLessEqual(float(section["LowLimit"]), value + 1e-6 * abs(value))
                    self.assertGreaterEqual(float(section["HighLimit"]), value - 1e-6 * abs(value))

    def test_maps_into_the_default_pdos_what_may_be_mapped_of_its_own_size(self):
        for first, last in ((0x1600, 0x1603), (0x1A00, 0x1A0B)):
            for index in range(first, last + 1):
                members = self.members(index)
                for sub in range(1, self.default(members[0]) + 1):
                    packed = self.default(members[sub])
                    object_index, object_sub, bits = packed >> 16, packed >> 8 & 0xFF, packed & 0xFF
                    name = f"{object_index:04X}"
                    if "SubNumber" in self.eds[name]:
                        name += f"sub{object_sub:X}"
                    with self.subTest(f"{index:04X}sub{sub} maps {name}"):
                        self.assertEqual(self.eds[name]["PDOMapping"], "1")
                        self.assertEqual(BITS[number(self.eds[name]["DataType"])], bits)
                        if first == 0x1600:
                            self.assertIn(self.eds[name]["AccessType"], ("rw", "rww", "wo"))

    def test_gives_the_predefined_connection_set(self):
        for index, cob_id in ((0x1400, 0x205), (0x1401, 0x305), (0x1402, 0x405), (0x1800, 0x40000185), (0x1801, 0x40000285)):
            self.assertEqual(self.default(self.members(index)[1]), cob_id, f"{index:04X}")
        self.assertEqual(self.default(self.eds["1014"]), 0x85)

    def test_counts_its_comments_and_pdos(self):
        self.assertEqual(number(self.eds["Comments"]["Lines"]), len(self.eds["Comments"]) - 1)
        indices = [int(name, 16) for name in self.eds.sections() if re.fullmatch(r"[0-9A-F]{4}", name)]
        info = self.eds["DeviceInfo"]
        self.assertEqual(number(info["NrOfRXPDO"]), sum(0x1400 <= index < 0x1600 for index in indices))
        self.assertEqual(number(info["NrOfTXPDO"]), sum(0x1800 <= index < 0x1A00 for index in indices))


class DeviceConfiguration(unittest.TestCase):
    """CiA 306-1: the data sheet for one node."""

    @classmethod
    def setUpClass(cls):
        cls.eds = parsed(written("--eds"))
        cls.text = written("--node", "5", "--dcf")
        cls.dcf = parsed(cls.text)

    def test_says_which_node_of_which_network_it_is(self):
        said = self.dcf["DeviceComissioning"]
        self.assertEqual((said["NodeID"], said["Baudrate"], said["CANopenManager"]), ("5", "1000", "0"))
        self.assertEqual(self.dcf["FileInfo"]["LastEDS"], "plenum.eds")
        self.assertEqual(self.dcf["FileInfo"]["FileName"], "plenum.dcf")
        for key in ("CreationDate", "ModificationDate"):
            self.assertRegex(self.dcf["FileInfo"][key], r"\A[01]\d-[0-3]\d-20\d\d\Z")
        for key in ("CreationTime", "ModificationTime"):
            self.assertRegex(self.dcf["FileInfo"][key], r"\A[01]\d:[0-5]\d[AP]M\Z")

    def test_resolves_each_node_id_and_leaves_every_other_line(self):
        self.assertNotIn("$NODEID", self.text)
        resolved = 0
        for name in self.eds.sections():
            if name == "FileInfo":
                continue
            for key, value in self.eds[name].items():
                with self.subTest(f"[{name}] {key}"):
                    if value.startswith("$NODEID+"):
                        resolved += 1
                        self.assertEqual(number(self.dcf[name][key]), number(value.removeprefix("$NODEID+")) + 5)
                    else:
                        self.assertEqual(self.dcf[name][key], value)
        self.assertEqual(resolved, 3 + 4 + 4, "emergency, both ways of SDO, RPDO1 to 4, TPDO1 to 4")
        self.assertEqual([name for name in self.dcf.sections() if name not in self.eds], ["DeviceComissioning"])


class Dbc(unittest.TestCase):
    MESSAGE = re.compile(r"BO_ (\d+) (\w+): (\d+) (\w+)")
    NUMBER = r"(-?[0-9.]+(?:e[+-]?\d+)?)"
    SIGNAL = re.compile(
        r" SG_ (\w+) : (\d+)\|(\d+)@1([+-]) \(" + NUMBER + "," + NUMBER + r"\) \[" + NUMBER + r"\|" + NUMBER + r"\] \"([^\"]*)\" (\w+)")

    @classmethod
    def setUpClass(cls):
        head, *blocks = written("--node", "5", "--dbc").split("\nBO_ ")
        cls.head = head
        cls.messages = {}
        for block in blocks:
            first, *rest = ("BO_ " + block).rstrip("\n").split("\n")
            identifier, name, length, sender = cls.MESSAGE.fullmatch(first).groups()
            signals = [cls.SIGNAL.fullmatch(line).groups() for line in rest]
            assert int(identifier) not in cls.messages, f"{identifier} twice"
            cls.messages[int(identifier)] = (name, int(length), sender, signals)

    def test_begins_as_the_format_asks(self):
        self.assertEqual(self.head, 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: Master Board5\n')

    def test_holds_the_pdos_that_are_switched_on(self):
        self.assertEqual(sorted(self.messages), [0x185, 0x205, 0x285, 0x305, 0x385, 0x405, 0x485])

    def test_lays_signals_side_by_side_within_the_frame(self):
        for name, length, _, signals in self.messages.values():
            end = 0
            for signal in signals:
                self.assertEqual(int(signal[1]), end, f"{name}.{signal[0]}")
                end += int(signal[2])
            self.assertEqual(end, 8 * length, name)

    def test_names_a_signal_once(self):
        for name, _, _, signals in self.messages.values():
            names = [signal[0] for signal in signals]
            self.assertEqual(len(names), len(set(names)), name)
            for one in names:
                self.assertRegex(one, r"\A[A-Za-z_]\w{0,127}\Z")

    def test_tells_set_points_and_actual_values_in_mbar(self):
        name, length, sender, signals = self.messages[0x305]
        self.assertEqual((name, length, sender), ("Board5_RPDO2", 8, "Master"))
        self.assertEqual(signals[3], ("Set_point_chamber_8", "48", "16", "-", "1", "0", "0", "32767", "mbar", "Board5"))
        name, length, sender, signals = self.messages[0x185]
        self.assertEqual((name, length, sender), ("Board5_TPDO1", 8, "Board5"))
        self.assertEqual(signals[0], ("Actual_value_chamber_1", "0", "16", "-", "1", "0", "-32768", "32767", "mbar", "Master"))

    def test_tells_the_words(self):
        self.assertEqual(self.messages[0x405][3], [("Control_word", "0", "16", "+", "1", "0", "0", "65535", "", "Board5")])
        self.assertEqual(self.messages[0x385][3], [("Status_word", "0", "16", "+", "1", "0", "0", "65535", "", "Master")])


class ObjectTable(unittest.TestCase):
    def test_stands_in_the_tree_as_the_tool_prints_it(self):
        file = Path(SOURCE) / "firmware/canopen/OBJECTS.md"
        self.assertEqual(file.read_text(encoding="utf-8"), written("--table"),
                         "the table has changed; run: build/host/bin/plenum_dictionary --table firmware/canopen/OBJECTS.md")


class BadUsage(unittest.TestCase):
    def refused(self, *arguments):
        result = subprocess.run([TOOL, *arguments], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2, arguments)
        self.assertNotEqual(result.stderr, "")

    def test_is_refused(self):
        self.refused()
        self.refused("--node", "128", "--dbc", "-")
        self.refused("--eds", "/nowhere/plenum.eds")
        self.refused("--dcf", "/nowhere/plenum.dcf")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    SOURCE, TOOL = sys.argv[1:3]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
