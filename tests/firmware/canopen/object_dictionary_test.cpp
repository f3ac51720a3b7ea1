#include "firmware/canopen/object_dictionary.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <type_traits>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

std::string label(unsigned index, unsigned sub) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04Xh:%u", index, sub);
  return text.data();
}

/// Calls `visit(entry, index, sub)` for every object of the table.
template <class Visit>
void for_each_object(Visit visit) {
  for (const Entry& entry : object_dictionary()) {
    for (unsigned instance = 0; instance < entry.instances; ++instance) {
      for (unsigned sub = entry.sub; sub <= entry.last_sub; ++sub) {
        visit(entry, entry.index + instance * entry.stride, sub);
      }
    }
  }
}

TEST(ObjectDictionary, NamesEveryObjectOnce) {
  std::set<std::pair<unsigned, unsigned>> seen;
  for_each_object([&](const Entry&, unsigned index, unsigned sub) {
    EXPECT_LE(index, 0xFFFFU);
    EXPECT_TRUE(seen.insert({index, sub}).second) << label(index, sub);
  });
  EXPECT_GT(seen.size(), 400U);
}

TEST(ObjectDictionary, FindsEveryObjectItNames) {
  for_each_object([](const Entry& entry, unsigned index, unsigned sub) {
    const Found found = find(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub));
    ASSERT_EQ(found.entry, &entry) << label(index, sub);
    EXPECT_EQ(found.entry->index + found.place.instance * found.entry->stride, static_cast<int>(index));
    EXPECT_EQ(found.place.sub, sub);
  });
}

TEST(ObjectDictionary, FindsNothingElse) {
  std::map<unsigned, std::set<unsigned>> named;
  for_each_object([&](const Entry&, unsigned index, unsigned sub) { named[index].insert(sub); });
  for (unsigned index = 0; index <= 0xFFFF; ++index) {
    const auto object = named.find(index);
    for (const unsigned sub : {0U, 1U, 2U, 9U, 255U}) {
      const Abort expected = object == named.end()          ? Abort::no_object
                             : object->second.contains(sub) ? Abort::none
                                                            : Abort::no_subindex;
      ASSERT_EQ(find(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub)).abort, expected)
          << label(index, sub);
    }
  }
}

TEST(ObjectDictionary, TellsTheHighestSubIndexOfEachRecord) {
  std::map<unsigned, unsigned> highest;
  for_each_object(
      [&](const Entry&, unsigned index, unsigned sub) { highest[index] = std::max(highest[index], sub); });
  Bench bench;
  for (const auto& [index, sub] : highest) {
    // the counts of 1003h, 1600h.. and 1A00h.. are values, not limits
    if (sub == 0 || index == 0x1003 || (index & 0xFFF0U) == 0x1600 || (index & 0xFFF0U) == 0x1A00) continue;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "605 40 %02X %02X 00 0 0 0 0", index & 0xFFU, index >> 8);
    const std::string answer = bench.answer(text.data());
    std::snprintf(text.data(), text.size(), "585 4F %02X %02X 00 %02X 00 00 00", index & 0xFFU, index >> 8,
                  sub);
    EXPECT_EQ(answer, text.data());
  }
}

TEST(ObjectDictionary, GivesEachAccessWhatItNeeds) {
  for_each_object([](const Entry& entry, unsigned index, unsigned sub) {
    const bool readable = entry.access != Access::write_only;
    const bool writable = entry.access == Access::read_write || entry.access == Access::write_only;
    EXPECT_EQ(readable,
              entry.read_value != nullptr || entry.read_bytes != nullptr || entry.read_stream != nullptr)
        << label(index, sub);
    EXPECT_EQ(writable, entry.write_value != nullptr || entry.write_bytes != nullptr) << label(index, sub);
    const bool without_size =
        entry.read_bytes != nullptr || entry.write_bytes != nullptr || entry.read_stream != nullptr;
    EXPECT_EQ(size_of(entry.type) == 0, without_size) << label(index, sub);
    EXPECT_EQ(entry.read_stream != nullptr, entry.stream_size != nullptr) << label(index, sub);
    const bool waits = index == 0x1010 || index == 0x1011 || (index & 0xFFF8U) == 0x2110;
    EXPECT_EQ(waits && writable, entry.outcome != nullptr) << label(index, sub);
    if (entry.mappable != Mappable::no) {
      EXPECT_NE(entry.read_value, nullptr) << label(index, sub);
    }
    if (entry.mappable == Mappable::receive_and_transmit) {
      EXPECT_NE(entry.write_value, nullptr) << label(index, sub);
    }
  });
}

/// The nearest value of a type beyond `limit`, upwards or downwards, as bits; none where the type ends there.
std::optional<std::uint32_t> beyond(DataType type, float limit, bool upwards) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  if (type == DataType::real32)
    return std::bit_cast<std::uint32_t>(std::nextafter(limit, upwards ? kInfinity : -kInfinity));
  const bool is_signed = type == DataType::integer8 || type == DataType::integer16;
  const int bits = static_cast<int>(8 * size_of(type));
  const long number = std::lround(limit) + (upwards ? 1 : -1);
  const long least = is_signed ? -(1L << (bits - 1)) : 0, most = (1L << (is_signed ? bits - 1 : bits)) - 1;
  if (number < least || number > most) return std::nullopt;
  return static_cast<std::uint32_t>(number) & static_cast<std::uint32_t>((1UL << bits) - 1);
}

std::string write_of(unsigned index, unsigned sub, DataType type, std::uint32_t bits) {
  const auto size = static_cast<unsigned>(size_of(type));
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "605 %02X %02X %02X %02X %02X %02X %02X %02X",
                0x23U | (4 - size) << 2, index & 0xFFU, index >> 8, sub, bits & 0xFFU, bits >> 8 & 0xFFU,
                bits >> 16 & 0xFFU, bits >> 24);
  return text.data();
}

TEST(ObjectDictionary, TellsOnWhichSideOfItsRangeAValueLies) {
  Bench bench;
  int above = 0, below = 0;
  for_each_object([&](const Entry& entry, unsigned index, unsigned sub) {
    if (!entry.range.limited || entry.access == Access::read_only) return;
    const auto expect = [&](bool upwards, const char* code, int& count) {
      const auto bits = beyond(entry.type, upwards ? entry.range.high : entry.range.low, upwards);
      if (!bits) return;
      const std::string answer = bench.answer(write_of(index, sub, entry.type, *bits));
      EXPECT_TRUE(answer.starts_with("585 80") && answer.ends_with(code))
          << label(index, sub) << ": " << answer;
      ++count;
    };
    expect(true, "31 00 09 06", above);
    expect(false, "32 00 09 06", below);
  });
  EXPECT_GT(above, 200) << "settings of eight chambers alone are 24 x 8";
  EXPECT_GT(below, 150);
}

TEST(ObjectDictionary, NamesEachRecordAtItsSubIndex0) {
  const std::span<const Entry> rows = object_dictionary();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool opens_record = rows[i].sub == 0 && i + 1 < rows.size() && rows[i + 1].index == rows[i].index;
    EXPECT_EQ(opens_record, rows[i].object_name != nullptr) << label(rows[i].index, rows[i].sub);
  }
}

TEST(ObjectDictionary, KeepsOnlyWhatCanBeReadAndWrittenAgain) {
  for_each_object([](const Entry& entry, unsigned index, unsigned sub) {
    if (entry.kept == Kept::no) return;
    EXPECT_EQ(entry.kept, index < 0x2000 ? Kept::communication : Kept::application) << label(index, sub);
    EXPECT_EQ(entry.access, Access::read_write) << label(index, sub);
    EXPECT_TRUE(entry.read_value != nullptr && entry.write_value != nullptr) << label(index, sub);
  });
}

TEST(ObjectDictionary, ActivatesEveryDefaultMapping) {
  const Communication communication = delivered_communication();
  for (const Rpdo& rpdo : communication.rpdo) {
    EXPECT_NE(rpdo.parameters().mapping.count, 0);
    EXPECT_NE(rpdo.parameters().mapping.bytes, 0);
  }
  for (std::size_t n = 0; n < kRpdos; ++n)
    EXPECT_EQ(is_valid(communication.rpdo[n].parameters()), n < 3) << "RPDO" << n + 1;
  for (std::size_t n = 0; n < kTpdos; ++n) {
    EXPECT_NE(communication.tpdo[n].parameters.mapping.count, 0) << "TPDO" << n + 1;
    EXPECT_EQ((communication.tpdo[n].parameters.cob_id & cob::kInvalid) != 0, n >= 4) << "TPDO" << n + 1;
  }
  for (std::size_t n = 4; n < kTpdos; ++n) EXPECT_EQ(communication.tpdo[n].parameters.mapping.bytes, 8);
}

struct Pressure {
  float value_Pa;
  const char* answer;
};

TEST(ObjectDictionary, ShowsPressuresInMillibarSaturatingAndNaNSafe) {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // A fixed-point core takes not-a-number for 0, and sees that the float 500.05 [kPa] is a little less.
  constexpr bool kInFloat = std::is_same_v<numeric::Scalar, float>;
  for (const Pressure& pressure :
       {Pressure{101325.0F, "585 4B 81 63 01 F5 03 00 00"},  // 1013.25 -> 1013
        Pressure{500050.0F,
                 kInFloat ? "585 4B 81 63 01 89 13 00 00" : "585 4B 81 63 01 88 13 00 00"},  // 5000.5 -> 5001
        Pressure{500250.0F, "585 4B 81 63 01 8B 13 00 00"},                                  // 5002.5 -> 5003
        Pressure{0.0F, "585 4B 81 63 01 00 00 00 00"}, Pressure{1.0e9F, "585 4B 81 63 01 FF 7F 00 00"},
        Pressure{inf, "585 4B 81 63 01 FF 7F 00 00"}, Pressure{-inf, "585 4B 81 63 01 01 80 00 00"},
        Pressure{nan, kInFloat ? "585 4B 81 63 01 00 80 00 00" : "585 4B 81 63 01 00 00 00 00"}}) {
    Bench bench;
    bench.image.chamber[0].actual_Pa = pressure.value_Pa;
    EXPECT_EQ(bench.answer("605 40 81 63 01 00 00 00 00"), pressure.answer) << pressure.value_Pa << " Pa";
  }
}

TEST(ObjectDictionary, RoundsEverySetPointOfHalfAMillibarAwayFromZero) {
  Bench bench;
  for (int half = 1; half <= 2 * 32'766; ++half) {
    bench.image.chamber[0].setpoint_Pa = numeric::Scalar(50 * half);
    const unsigned code = static_cast<unsigned>(half + 1) / 2;
    std::array<char, 32> answer{};
    std::snprintf(answer.data(), answer.size(), "585 4B 80 63 01 %02X %02X 00 00", code & 0xFFU, code >> 8U);
    ASSERT_EQ(bench.answer("605 40 80 63 01 00 00 00 00"), answer.data()) << 50 * half << " Pa";
  }
}

TEST(ObjectDictionary, CodesCommandAndVolumeForTheStream) {
  Bench bench;
  bench.image.chamber[7].command_V = 10.0F;
  bench.image.chamber[7].volume_m3 = 6.5e-3F;
  EXPECT_EQ(bench.answer("605 40 27 22 01 00 00 00 00"), "585 4B 27 22 01 FF FF 00 00");
  EXPECT_EQ(bench.answer("605 40 27 22 02 00 00 00 00"), "585 4B 27 22 02 E8 FD 00 00") << "65000 x 1e-7 m3";
  bench.image.chamber[7].command_V = std::numeric_limits<float>::quiet_NaN();
  bench.image.chamber[7].volume_m3 = 1.0F;
  EXPECT_EQ(bench.answer("605 40 27 22 01 00 00 00 00"), "585 4B 27 22 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 27 22 02 00 00 00 00"), "585 4B 27 22 02 FF FF 00 00") << "saturates";
}

TEST(ObjectDictionary, PutsTheChambersAtTheirStrides) {
  Bench bench;
  bench.answer("605 2B 80 9B 01 E8 03 00 00");  // 6380h + 7 x 800h
  EXPECT_EQ(bench.image.chamber[7].setpoint_Pa.value(), 100000.0F);
  bench.answer("605 2B 94 73 01 D0 07 00 00");  // 6394h + 2 x 800h
  EXPECT_EQ(bench.image.chamber[2].hold_setpoint_Pa.value(), 200000.0F);
  bench.image.chamber[1].demand_Pa = 300000.0F;
  bench.image.chamber[1].deviation_Pa = 50000.0F;
  EXPECT_EQ(bench.answer("605 40 90 6B 01 00 00 00 00"), "585 4B 90 6B 01 B8 0B 00 00");
  EXPECT_EQ(bench.answer("605 40 D0 6B 01 00 00 00 00"), "585 4B D0 6B 01 F4 01 00 00");
  EXPECT_EQ(bench.answer("605 40 D0 6B 02 00 00 00 00"), "585 4F D0 6B 02 4E 00 00 00");
  EXPECT_EQ(bench.answer("605 40 D0 6B 03 00 00 00 00"), "585 4F D0 6B 03 FD 00 00 00");
  EXPECT_EQ(bench.answer("605 40 FF 67 00 00 00 00 00"), "585 43 FF 67 00 98 01 00 00") << "a module's type";
  EXPECT_EQ(bench.answer("605 40 FF 9F 00 00 00 00 00"), "585 43 FF 9F 00 98 01 00 00");
}

// The codes and reactions as the documents of the board have them, priority by priority.
TEST(FaultReactions, AreThoseOfTheSupervisor) {
  Bench bench;
  const auto read = [&](const char* sub) {
    return bench.answer("605 40 30 28 " + std::string(sub) + " 00 00 00 00").substr(16);
  };
  EXPECT_EQ(bench.answer("605 40 30 28 00 00 00 00 00"), "585 4F 30 28 00 1C 00 00 00") << "28 faults";
  EXPECT_EQ(read("01"), "00 90 02 00") << "emergency stop 9000h: safe, of the board";
  EXPECT_EQ(read("03"), "02 83 03 01") << "over-pressure 8302h: vent, of a chamber";
  EXPECT_EQ(read("04"), "09 FF 02 00") << "memory upset FF09h: safe, of the board";
  EXPECT_EQ(read("05"), "20 63 02 00") << "configuration refused 6320h: safe, of the board";
  EXPECT_EQ(read("12"), "50 82 02 00") << "set-point timeout 8250h: safe, of the board";
  EXPECT_EQ(read("13"), "12 34 01 00") << "supply low 3412h: hold, of the board";
  EXPECT_EQ(read("14"), "02 FF 01 01") << "model residual FF02h: hold, of a chamber";
  EXPECT_EQ(read("17"), "20 81 00 02") << "error passive 8120h: none, clears by itself";
  EXPECT_EQ(read("18"), "0B FF 00 03") << "model drift FF0Bh: none, of a chamber, clears by itself";
  EXPECT_EQ(read("19"), "0C FF 00 03") << "control deviation FF0Ch: none, of a chamber, clears by itself";
  EXPECT_EQ(read("1A"), "10 82 00 02") << "PDO too short 8210h: none, clears by itself";
  EXPECT_EQ(read("1B"), "40 82 00 02") << "SYNC that 1019h does not allow 8240h: none, clears by itself";
  EXPECT_EQ(read("1C"), "20 82 00 02") << "PDO longer than mapped 8220h: none, clears by itself";
  EXPECT_EQ(bench.answer("605 40 30 28 1D 00 00 00 00"), "585 80 30 28 1D 11 00 09 06");
  EXPECT_EQ(bench.answer("605 23 30 28 01 00 90 00 00"), "585 80 30 28 01 02 00 01 06") << "read only";
}

TEST(DeviceIdentity, IsToldByCia408AsByCia301) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 57 60 00 00 00 00 00"), "585 41 57 60 00 06 00 00 00");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 03 50 6C 65 6E 75 6D 00") << "Plenum";
  EXPECT_EQ(bench.answer("605 40 54 60 00 00 00 00 00").substr(16),
            bench.answer("605 40 08 10 00 00 00 00 00").substr(16));
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 00 50 6C 65 6E 75 6D 20")
      << "Plenum valve board";
}

}  // namespace
}  // namespace plenum::canopen
