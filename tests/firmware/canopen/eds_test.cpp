#include "firmware/canopen/eds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "firmware/canopen/object_dictionary.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/telemetry/recorder.hpp"

namespace plenum::canopen {
namespace {

const Identity kIdentity{.vendor_id = 0x11, .product_code = 0x22, .revision = 0x33, .serial = 0x44};

std::string text_of(float value) {
  TextLine line;
  line.real(value);
  return std::string(line.text());
}

TEST(TextLine, WritesAFloatWithTheFewestDigitsThatAreNearestToIt) {
  EXPECT_EQ(text_of(0.0F), "0");
  EXPECT_EQ(text_of(-0.0F), "-0");
  EXPECT_EQ(text_of(1.0F), "1");
  EXPECT_EQ(text_of(0.1F), "0.1");
  EXPECT_EQ(text_of(-12.5F), "-12.5");
  EXPECT_EQ(text_of(101.325F), "101.325");
  EXPECT_EQ(text_of(3'276'700.0F), "3276700");
  EXPECT_EQ(text_of(1.0e-10F), "1e-10");
  EXPECT_EQ(text_of(1.0e6F), "1000000");
  EXPECT_EQ(text_of(10.0F / 65535.0F), "0.00015259022");
  EXPECT_EQ(text_of(16'777'216.0F), "16777216");
  EXPECT_EQ(text_of(3.4028235e38F), "3.4028235e+38");
  EXPECT_EQ(text_of(1.4e-45F), "1e-45") << "the smallest of all";
}

TEST(TextLine, LosesNoBitOfAnyFloat) {
  std::mt19937 random(1);
  for (int i = 0; i < 200'000; ++i) {
    const float value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isfinite(value)) continue;
    const std::string text = text_of(value);
    ASSERT_EQ(std::strtof(text.c_str(), nullptr), value) << text;
    const std::string digits = text.substr(0, text.find('e'));
    ASSERT_LE(std::ranges::count_if(digits, [](char c) { return c >= '0' && c <= '9'; }), 9 + 4)
        << text << ": nine digits, and zeros before the first of them";
  }
}

TEST(TextLine, CutsWhatDoesNotFit) {
  TextLine line;
  line.put(std::string(TextLine::kCapacity - 1, 'x'));
  line.hexadecimal(0xABC, 4);
  EXPECT_EQ(line.text().size(), TextLine::kCapacity);
  EXPECT_TRUE(line.text().ends_with("x0"));
}

struct Sheet {
  config::ParameterSlots slots;
  telemetry::Recorder recorder;
  config::SettingsDesk installed;
  DataSheet text{kIdentity, installed, slots, recorder};
};

std::string read_all(DataSheet& sheet, std::size_t portion) {
  std::string text;
  std::vector<std::uint8_t> bytes(portion);
  while (const std::size_t count = sheet.read(static_cast<std::uint32_t>(text.size()), bytes)) {
    text.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return text;
}

const std::string& whole_text() {
  static const std::string text = [] {
    Sheet sheet;
    return read_all(sheet.text, DataSheet::kRepeat);
  }();
  return text;
}

TEST(DataSheet, ReadsTheSameInAnyPortions) {
  Sheet sheet;
  for (const std::size_t portion : {1U, 7U, 100U, 889U, 100'000U}) {
    EXPECT_TRUE(read_all(sheet.text, portion) == whole_text()) << portion;
  }
}

TEST(DataSheet, HoldsNothingThatReadersOfIniFilesTakeForAComment) {
  EXPECT_EQ(whole_text().find_first_of(";#"), std::string::npos);
}

TEST(DataSheet, KnowsItsSizeAndReadsOnAfterBeingAsked) {
  Sheet sheet;
  std::array<std::uint8_t, 7> bytes{};
  ASSERT_EQ(sheet.text.read(0, bytes), 7U);
  EXPECT_EQ(sheet.text.size(), whole_text().size());
  ASSERT_EQ(sheet.text.read(7, bytes), 7U);
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), whole_text().substr(7, 7));
}

TEST(DataSheet, RepeatsAnyBlockFromItsFirstByteAsOftenAsAsked) {
  Sheet sheet;
  std::mt19937 random(2);
  std::array<std::uint8_t, DataSheet::kRepeat> block{};
  std::uint32_t offset = 0;
  while (offset < whole_text().size()) {
    std::uint32_t size = 0;
    for (unsigned repeat = random() % 4; repeat < 4; ++repeat) {
      // by segments of seven, as a server sends them
      const std::uint32_t segments = 1 + static_cast<std::uint32_t>(random() % 127);
      size = 0;
      for (std::uint32_t i = 0; i < segments; ++i) {
        const std::size_t count = sheet.text.read(offset + size, std::span(block).subspan(size, 7));
        size += static_cast<std::uint32_t>(count);
        if (count < 7) break;
      }
      ASSERT_TRUE(std::equal(block.begin(), block.begin() + size,
                             whole_text().begin() + static_cast<std::ptrdiff_t>(offset)))
          << "at " << offset;
      ASSERT_NE(size, 0U) << "at " << offset;
    }
    offset += size;
  }
  EXPECT_EQ(sheet.text.read(offset, block), 0U);
}

TEST(DataSheet, BeginsAnewAtItsFirstByte) {
  Sheet sheet;
  read_all(sheet.text, 889);
  EXPECT_TRUE(read_all(sheet.text, 889) == whole_text());
}

TEST(DataSheet, EndsWhereItIsReadOutOfOrder) {
  Sheet sheet;
  std::array<std::uint8_t, 7> bytes{};
  EXPECT_EQ(sheet.text.read(50'000, bytes), 0U) << "far ahead: that would be unbounded work";
  read_all(sheet.text, 889);
  EXPECT_EQ(sheet.text.read(100, bytes), 0U) << "far behind";
  EXPECT_EQ(sheet.text.read(0, bytes), 7U);
}

// ---- what it says, in words of CiA 306 ----

bool says(const std::string& lines) {
  return whole_text().find("\n" + lines) != std::string::npos;
}

TEST(DataSheet, TellsAVariable) {
  EXPECT_TRUE(
      says("[6040]\nParameterName=Control word\nObjectType=0x7\nDataType=0x0006\nAccessType=rw\n"
           "PDOMapping=1\n\n"));
  EXPECT_TRUE(
      says("[1000]\nParameterName=Device type\nObjectType=0x7\nDataType=0x0007\nAccessType=const\n"
           "DefaultValue=0xFFFF0198\nPDOMapping=0\n\n"));
  EXPECT_TRUE(
      says("[1008]\nParameterName=Manufacturer device name\nObjectType=0x7\nDataType=0x0009\n"
           "AccessType=const\nDefaultValue=Plenum valve board\nPDOMapping=0\n\n"));
}

TEST(DataSheet, TellsARecordOfEachChamber) {
  EXPECT_TRUE(
      says("[9B80]\nParameterName=Set point, chamber 8\nObjectType=0x9\nSubNumber=4\n\n"
           "[9B80sub0]\nParameterName=Highest sub-index supported, chamber 8\nObjectType=0x7\n"
           "DataType=0x0005\nAccessType=const\nDefaultValue=0x03\nPDOMapping=0\n\n"
           "[9B80sub1]\nParameterName=Set point, chamber 8\nObjectType=0x7\nDataType=0x0003\n"
           "AccessType=rw\nLowLimit=0\nHighLimit=32767\nPDOMapping=1\n\n"));
  EXPECT_TRUE(
      says("[6380sub3]\nParameterName=Prefix, chamber 1\nObjectType=0x7\nDataType=0x0002\n"
           "AccessType=const\nDefaultValue=-3\nPDOMapping=0\n\n"));
}

TEST(DataSheet, TellsAnArrayAndADomain) {
  EXPECT_TRUE(says("[1010]\nParameterName=Store parameters\nObjectType=0x8\nSubNumber=4\n\n"));
  EXPECT_TRUE(says("[1003]\nParameterName=Pre-defined error field\nObjectType=0x8\nSubNumber=33\n\n"));
  EXPECT_TRUE(says("[1003sub20]\nParameterName=Error 32\nObjectType=0x7\nDataType=0x0007\nAccessType=ro\n"));
  EXPECT_TRUE(
      says("[2117]\nParameterName=Staged model image, chamber 8\nObjectType=0x2\nDataType=0x000F\n"
           "AccessType=wo\n\n"));
}

TEST(DataSheet, AddsTheNodeIdWhereAnIdentifierDependsOnIt) {
  const auto cob_id = [](const std::string& section, const std::string& value) {
    const std::size_t at = whole_text().find("\n[" + section + "]\n");
    const std::size_t end = whole_text().find("\n\n", at);
    return whole_text().substr(at, end - at).find("\nDefaultValue=" + value + "\n") != std::string::npos;
  };
  EXPECT_TRUE(cob_id("1014", "$NODEID+0x00000080"));
  EXPECT_TRUE(cob_id("1200sub1", "$NODEID+0x00000600"));
  EXPECT_TRUE(cob_id("1401sub1", "$NODEID+0x00000300"));
  EXPECT_TRUE(cob_id("1403sub1", "$NODEID+0x80000500")) << "switched off";
  EXPECT_TRUE(cob_id("1802sub1", "$NODEID+0x40000380")) << "no remote request";
  EXPECT_TRUE(cob_id("1804sub1", "0xC0000000")) << "has no identifier yet";
  EXPECT_TRUE(cob_id("1005", "0x00000080")) << "SYNC is everyone's";
  EXPECT_TRUE(cob_id("1600sub2", "0x6B800110")) << "set point of chamber 2, 16 bits";
}

TEST(DataSheet, GivesTheInstallersSettingsAsDefaults) {
  // 2402h:2 is the pressure's offset of the third chamber, 2418h:1 the gain of the supply's sensor
  config::SettingsDesk::Chambers chambers{};
  chambers[2].pressure_offset_kPa = -25.0F;
  config::BoardSettings board;
  board.supply_gain_kPa_per_V = 160.0F;
  Sheet plain;
  const auto sheet = std::make_unique<DataSheet>(kIdentity, config::SettingsDesk(board, chambers),
                                                 plain.slots, plain.recorder);
  const std::string text = read_all(*sheet, DataSheet::kRepeat);
  const auto default_of = [](const std::string& of, const std::string& section) {
    const std::string key = "\nDefaultValue=";
    const std::size_t at = of.find(key, of.find("\n[" + section + "]\n")) + key.size();
    return of.substr(at, of.find('\n', at) - at);
  };
  EXPECT_EQ(default_of(text, "2402sub2"), "-25");
  EXPECT_EQ(default_of(text, "2401sub2"), default_of(whole_text(), "2401sub2"));
  EXPECT_EQ(default_of(text, "2418sub1"), "160");
}

TEST(DataSheet, NamesTheDeviceThatCarriesIt) {
  EXPECT_TRUE(
      says("VendorNumber=0x00000011\nProductName=Plenum valve board\nProductNumber=0x00000022\n"
           "RevisionNumber=0x00000033\n"));
  EXPECT_TRUE(says("NrOfRXPDO=4\nNrOfTXPDO=12\n"));
}

// ---- against the table, through a reader of its own ----

using Section = std::map<std::string, std::string>;

/// Refuses what is not "[name]", "key=value" or an empty line, and what is said twice.
std::map<std::string, Section> parsed(const std::string& text) {
  std::map<std::string, Section> sections;
  std::string name;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) {
      ADD_FAILURE() << "the last line has no end: " << text.substr(at);
      break;
    }
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    EXPECT_LT(line.size() + 1, TextLine::kCapacity) << line;
    for (const char c : line) EXPECT_TRUE(c >= ' ' && c <= '~') << line;
    if (line.empty()) continue;
    if (line.front() == '[' && line.back() == ']') {
      name = line.substr(1, line.size() - 2);
      EXPECT_TRUE(sections.emplace(name, Section{}).second) << "twice: " << name;
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos || equals == 0 || name.empty()) {
      ADD_FAILURE() << "neither section nor key: " << line;
      continue;
    }
    EXPECT_TRUE(sections[name].emplace(line.substr(0, equals), line.substr(equals + 1)).second)
        << "twice: " << line;
  }
  return sections;
}

std::string hex(unsigned value, int digits) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%0*X", digits, value);
  return text.data();
}

TEST(DataSheet, HoldsEveryObjectOfTheTableAndNothingElse) {
  std::map<std::string, Section> sections = parsed(whole_text());
  std::set<unsigned> objects;
  for (const Entry& entry : object_dictionary()) {
    for (unsigned instance = 0; instance < entry.instances; ++instance) {
      const unsigned index = entry.index + instance * entry.stride;
      objects.insert(index);
      Section& whole = sections[hex(index, 4)];
      for (unsigned sub = entry.sub; sub <= entry.last_sub; ++sub) {
        const bool is_member = whole.contains("SubNumber");
        const std::string name = is_member ? hex(index, 4) + "sub" + hex(sub, 1) : hex(index, 4);
        SCOPED_TRACE(name);
        ASSERT_TRUE(sections.contains(name));
        Section& object = sections[name];
        EXPECT_TRUE(object["ParameterName"].starts_with(entry.name));
        EXPECT_EQ(std::stoul(object["DataType"], nullptr, 16), static_cast<unsigned>(entry.type));
        const std::map<Access, std::string> access = {{Access::constant, "const"},
                                                      {Access::read_only, "ro"},
                                                      {Access::read_write, "rw"},
                                                      {Access::write_only, "wo"}};
        EXPECT_EQ(object["AccessType"], access.at(entry.access));
        EXPECT_EQ(object["ObjectType"], entry.type == DataType::domain ? "0x2" : "0x7");
        if (entry.type != DataType::domain) {
          EXPECT_EQ(object["PDOMapping"], entry.mappable == Mappable::no ? "0" : "1");
        }
        ASSERT_EQ(object.contains("LowLimit"), entry.range.limited);
        if (entry.range.limited) {
          EXPECT_EQ(std::strtof(object["LowLimit"].c_str(), nullptr), entry.range.low);
          EXPECT_EQ(std::strtof(object["HighLimit"].c_str(), nullptr), entry.range.high);
        }
        if (is_member) sections.erase(name);
      }
    }
  }
  for (const unsigned index : objects) sections.erase(hex(index, 4));

  std::set<unsigned> listed;
  for (const char* list : {"MandatoryObjects", "OptionalObjects", "ManufacturerObjects"}) {
    const Section& names = sections[list];
    EXPECT_EQ(std::stoul(names.at("SupportedObjects")), names.size() - 1) << list;
    for (std::size_t i = 1; i < names.size(); ++i)
      listed.insert(static_cast<unsigned>(std::stoul(names.at(std::to_string(i)), nullptr, 16)));
    sections.erase(list);
  }
  EXPECT_EQ(listed, objects);

  const Section& comments = sections["Comments"];
  EXPECT_EQ(std::stoul(comments.at("Lines")), comments.size() - 1);
  std::string said;
  for (const auto& [key, line] : comments) said += key == "Lines" ? "" : line + " ";
  for (const Entry& entry : object_dictionary()) {
    const unsigned index = entry.index;
    const bool told_together = (index >= 0x1400 && index < 0x1C00) || (index >= 0x2400 && index < 0x2500);
    if (entry.kept == Kept::no || told_together) continue;
    EXPECT_NE(said.find(hex(index, 4) + "h"), std::string::npos) << "kept: " << hex(index, 4);
  }
  for (const char* head : {"FileInfo", "DeviceInfo", "DummyUsage", "Comments"}) {
    EXPECT_FALSE(sections[head].empty()) << head;
    sections.erase(head);
  }
  for (const auto& [name, section] : sections) ADD_FAILURE() << "no object of the table: " << name;
}

}  // namespace
}  // namespace plenum::canopen
