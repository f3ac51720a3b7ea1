// board.toml: what the example says arrives, and each mistake is named with its line and its key.
#include "board/config/board_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace plenum::board::config {
namespace {

using plenum::config::SafeOutput;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kLeast = R"(
[can]
interface = "can0"
[analog_input]
rate_Hz = 1000
[[chamber]]
pressure = { device = "adc", channel = "voltage0" }
position = { device = "adc", channel = "voltage1" }
command = { device = "dac", channel = "voltage0" }
[store]
folder = "/var/lib/plenum"
)";

/// kLeast with one line (its first is 1, and empty) put in another's place.
std::string with(const std::string& line, const std::string& changed) {
  std::string text = kLeast;
  const std::size_t at = text.find(line + "\n");
  EXPECT_NE(at, std::string::npos) << line;
  return text.replace(at, line.size(), changed);
}

std::string refusal(const std::string& text) {
  try {
    parse_board(text, "board.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(BoardFile, TheExampleIsReadWhole) {
  const BoardFile board = read_board(PLENUM_SOURCE_DIR "/board/service/board.toml");
  EXPECT_EQ(board.interface, "can0");
  EXPECT_EQ(board.settings.node.node_id, 5);
  EXPECT_EQ(board.settings.node.identity.serial, 1U);
  EXPECT_EQ(board.model_url, "");
  EXPECT_EQ(board.bit_rate_kbit, std::nullopt);
  EXPECT_EQ(board.settings.node.bit_rates, 0x1DFU) << "LSS offers what CiA 305 has";
  EXPECT_EQ(board.analog_in.rate_Hz, 0U);
  EXPECT_EQ(board.analog_in.trigger, "");
  ASSERT_EQ(board.analog_in.channels.size(), 17U);
  EXPECT_EQ(board.analog_in.channels[1].device, "ad7606-0");
  EXPECT_EQ(board.analog_in.channels[1].channel, "voltage1");
  EXPECT_EQ(board.analog_in.channels[8].device, "ad7606-1");
  EXPECT_EQ(board.analog_in.channels[16].device, "ad7606-2");
  ASSERT_EQ(board.analog_out.channels.size(), 8U);
  EXPECT_EQ(board.analog_out.channels[3].channel, "voltage3");
  EXPECT_EQ(board.gpio.valve_power.line, "0");
  EXPECT_TRUE(board.gpio.vent.active_low);
  EXPECT_EQ(board.store, "/var/lib/plenum");
  EXPECT_EQ(board.settings.board.supply_low_kPa, 400.0F);
  EXPECT_EQ(board.settings.chamber[0].over_pressure_kPa, 900.0F);
  EXPECT_EQ(board.settings.chamber[3].safe_output, SafeOutput::vent);
  EXPECT_EQ(board.real_time.pacing, Pacing::timer);
  EXPECT_EQ(board.real_time.priority, 80);
  EXPECT_FALSE(board.real_time.cpu.has_value());
  EXPECT_TRUE(board.watchdog.empty());
}

TEST(BoardFile, OfABitRateThatIsStatedLssOffersNoOther) {
  const BoardFile board =
      parse_board(with("interface = \"can0\"", "interface = \"can0\"\nbit_rate_kbit = 250"), "board.toml");
  EXPECT_EQ(board.bit_rate_kbit, 250);
  EXPECT_EQ(board.settings.node.bit_rates, 1U << 3) << "row 3 of table 0 of CiA 305";
}

TEST(BoardFile, SaysWhereThePageAboutItsModelIs) {
  const auto of = [](const std::string& page) {
    return with("interface = \"can0\"", "interface = \"can0\"\nmodel_url = \"" + page + "\"");
  };
  EXPECT_EQ(parse_board(of("https://example.org/valve-board"), "board.toml").model_url,
            "https://example.org/valve-board");
  EXPECT_EQ(refusal(of(std::string(256, 'u'))),
            "board.toml: line 4: can.model_url has 256 characters, expected at most 255");
}

TEST(BoardFile, SaysHowAReferenceRampsAndWhatIsWatched) {
  const std::string command = "command = { device = \"dac\", channel = \"voltage0\" }";
  const auto settings = [&](const std::string& lines) {
    return parse_board(with(command, command + lines), "").settings.chamber[0];
  };
  using plenum::config::RampType;
  EXPECT_EQ(settings("").ramp_type, RampType::one_rate);
  EXPECT_FALSE(settings("").deviation_watched);
  const auto ramped = settings("\nramp_type = \"two_rates\"\nreference_fall_kPa_per_s = 40.0");
  EXPECT_EQ(ramped.ramp_type, RampType::two_rates);
  EXPECT_EQ(ramped.reference_fall_kPa_per_s, 40.0F);
  const auto watched =
      settings("\ndeviation_watched = true\ndeviation_delay_ms = 250\ntarget_watched = true");
  EXPECT_TRUE(watched.deviation_watched);
  EXPECT_EQ(watched.deviation_delay_ms, 250);
  EXPECT_TRUE(watched.target_watched);
}

TEST(BoardFile, AChamberThatIsNotListedOrNotInUseHasNoChannelAndIsNotWatched) {
  const BoardFile board = read_board(PLENUM_SOURCE_DIR "/board/service/board.toml");
  for (const std::size_t c : {2U, 4U, 5U, 6U, 7U}) {
    EXPECT_FALSE(board.settings.chamber[c].in_use) << c;
    EXPECT_EQ(board.analog_in.channels[c].device, "") << c;
    EXPECT_EQ(board.analog_in.channels[8 + c].device, "") << c;
    EXPECT_EQ(board.analog_out.channels[c].device, "") << c;
  }
}

TEST(BoardFile, TheSafeVoltageIsTheRestingCommandUnlessStated) {
  const std::string command = "command = { device = \"dac\", channel = \"voltage0\" }";
  EXPECT_EQ(parse_board(kLeast, "").analog_out.safe_V[0], 5.0F);
  EXPECT_EQ(parse_board(with(command, command + "\nsafe_output = \"vent\""), "").analog_out.safe_V[0], 3.0F);
  EXPECT_EQ(parse_board(with(command, command + "\nsafe_V = 4.5"), "").analog_out.safe_V[0], 4.5F);
  // no float is 5.02
  EXPECT_EQ(parse_board(with(command, command + "\nnull_V = 5.02\nsafe_V = 5.02"), "").analog_out.safe_V[0],
            5.02F);
}

TEST(BoardFile, TheConverterPacesTheTicksUnlessItRunsFreely) {
  EXPECT_EQ(parse_board(kLeast, "").real_time.pacing, Pacing::adc);
  const std::string freely = with("rate_Hz = 1000", "rate_Hz = 0");
  EXPECT_EQ(parse_board(freely, "").real_time.pacing, Pacing::timer);
  EXPECT_EQ(refusal(freely + "[real_time]\npacing = \"adc\"\n"),
            "board.toml: line 13: real_time.pacing = 'adc', expected timer, as analog_input.rate_Hz is 0");
}

TEST(BoardFile, OversamplingIsLeftToTheConverterUnlessItIsStated) {
  EXPECT_EQ(parse_board(kLeast, "").analog_in.oversampling, std::nullopt);
  EXPECT_EQ(
      parse_board(with("rate_Hz = 1000", "rate_Hz = 1000\noversampling = 16"), "").analog_in.oversampling,
      16U);
  EXPECT_EQ(refusal(with("rate_Hz = 1000", "rate_Hz = 1000\noversampling = 0")),
            "board.toml: line 6: analog_input.oversampling = 0, expected a whole number from 1 to 65536");
}

TEST(BoardFile, WithoutANodeIdItWaitsForLss) {
  EXPECT_EQ(parse_board(kLeast, "").settings.node.node_id, canopen::kUnconfiguredNodeId);
}

TEST(BoardFile, EverythingThatMayBeLeftOutIsLeftOut) {
  const BoardFile board = parse_board(kLeast, "");
  EXPECT_TRUE(board.gpio.valve_power.chip.empty());
  EXPECT_TRUE(board.gpio.emergency_stop.chip.empty());
  EXPECT_TRUE(board.analog_in.channels[16].device.empty());
  EXPECT_EQ(board.real_time.overrun, Overrun::fault);
}

struct Mistake {
  const char* line;
  const char* changed;
  const char* said;
};

class NamedMistake : public testing::TestWithParam<Mistake> {};

TEST_P(NamedMistake, IsToldWithLineKeyAndExpectation) {
  EXPECT_EQ(refusal(with(GetParam().line, GetParam().changed)), GetParam().said);
}

constexpr const char* kFolder = "folder = \"/var/lib/plenum\"";
constexpr const char* kCommand = "command = { device = \"dac\", channel = \"voltage0\" }";
constexpr const char* kPosition = "position = { device = \"adc\", channel = \"voltage1\" }";

INSTANTIATE_TEST_SUITE_P(
    Board, NamedMistake,
    testing::Values(
        Mistake{"interface = \"can0\"", "interfaces = \"can0\"",
                "board.toml: line 2: can.interface is missing, expected a CAN interface, as can0"},
        Mistake{"interface = \"can0\"", "interface = 0",
                "board.toml: line 3: can.interface is a whole number, expected a string"},
        Mistake{"interface = \"can0\"", "interface = \"\"",
                "board.toml: line 3: can.interface is empty, expected a string of at least one character"},
        Mistake{"interface = \"can0\"", "interface = \"can0\"\nnode_id = 128",
                "board.toml: line 4: can.node_id = 128, expected a whole number from 1 to 127"},
        Mistake{
            "interface = \"can0\"", "interface = \"can0\"\nbit_rate_kbit = 300",
            "board.toml: line 4: can.bit_rate_kbit = 300, expected 1000, 800, 500, 250, 125, 50, 20 or 10"},
        Mistake{"interface = \"can0\"", "interface = \"can0\"\nspeed = 1",
                "board.toml: line 4: can.speed is no key of this file, expected interface, node_id, "
                "bit_rate_kbit, "
                "vendor_id, product_code, revision, serial, model_url"},
        Mistake{"rate_Hz = 1000", "rate_Hz = 1001",
                "board.toml: line 5: analog_input.rate_Hz = 1001, expected a multiple of 100"},
        Mistake{"rate_Hz = 1000", "rate_Hz = 1000.0",
                "board.toml: line 5: analog_input.rate_Hz is a number, expected a whole number from 0 to "
                "100000"},
        Mistake{
            kPosition, "",
            "board.toml: line 6: chamber[1].position is missing, expected { device = ..., channel = ... }"},
        Mistake{kPosition, "position = { device = \"adc\" }",
                "board.toml: line 8: chamber[1].position.channel is missing, expected a channel of it, as "
                "voltage0"},
        Mistake{kPosition, "position = \"adc\"",
                "board.toml: line 8: chamber[1].position is a string, expected a table"},
        Mistake{kPosition, "position = { device = \"adc\", channel = \"voltage0\" }",
                "board.toml: line 8: chamber[1].position = adc/voltage0 is named twice, expected a place of "
                "its own"},
        Mistake{
            kPosition, "position = { device = \"adc\", channel = \"voltage1\", gain = 2 }",
            "board.toml: line 8: chamber[1].position.gain is no key of this file, expected device, channel"},
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nnull_V = nan",
                "board.toml: line 10: chamber[1].null_V = nan, expected a number from 0 to 10"},
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nnull_V = 2.0",
                "board.toml: line 10: chamber[1].null_V = 2, expected 3.01 to 6.99"},
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nsafe_output = \"open\"",
                "board.toml: line 10: chamber[1].safe_output = 'open', expected null, vent"},
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nramp_type = \"steep\"",
                "board.toml: line 10: chamber[1].ramp_type = 'steep', expected none, one_rate, two_rates"},
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nin_use = 1",
                "board.toml: line 10: chamber[1].in_use is a whole number, expected true or false"},
        // 5 V is the null: above it the valve fills
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nsafe_V = 5.1",
                "board.toml: line 10: chamber[1].safe_V = 5.1, expected 0 to null_V = 5"},
        Mistake{kCommand, "command = { device = \"dac\", channel = \"voltage0\" }\nsafe_V = 12",
                "board.toml: line 10: chamber[1].safe_V = 12, expected a number from 0 to 10"},
        Mistake{kFolder, "folder = \"plenum\"",
                "board.toml: line 11: store.folder = 'plenum', expected a path that begins with /"},
        Mistake{kFolder, "",
                "board.toml: line 10: store.folder is missing, expected a folder, as /var/lib/plenum"},
        Mistake{kFolder, "folder = \"/var/lib/plenum\"\n[real_time]\nprirority = 5",
                "board.toml: line 13: real_time.prirority is no key of this file, expected pacing, priority, "
                "cpu, "
                "overrun, guard_ticks, watchdog"},
        Mistake{kFolder, "folder = \"/var/lib/plenum\"\n[real_time]\noverrun = \"ignore\"",
                "board.toml: line 13: real_time.overrun = 'ignore', expected skip, count, fault"},
        Mistake{kFolder, "folder = \"/var/lib/plenum\"\n[board]\nsupply_low_kPa = 300",
                "board.toml: line 13: board.supply_low_kPa = 300, expected 0, or a channel board.supply"},
        Mistake{
            kFolder,
            "folder = \"/var/lib/plenum\"\n[board]\nsupply = { device = \"adc\", channel = \"voltage1\" }",
            "board.toml: line 8: chamber[1].position = adc/voltage1 is named twice, expected a place of its "
            "own"},
        Mistake{kFolder,
                "folder = \"/var/lib/plenum\"\n[gpio]\nvalve_power = { chip = \"c\", line = \"1\" }\nvent = "
                "{ chip = \"c\", "
                "line = \"1\" }",
                "board.toml: line 14: gpio.vent = c/1 is named twice, expected a place of its own"},
        Mistake{kFolder, "folder = \"/var/lib/plenum\"\n[gpio]\nvalve_power = { chip = \"c\", line = 1 }",
                "board.toml: line 13: gpio.valve_power.line is a whole number, expected a string"},
        Mistake{kFolder, "folder = \"/var/lib/plenum\"\n[service]",
                "board.toml: line 12: service is no key of this file, expected can, analog_input, board, "
                "chamber, gpio, "
                "store, real_time"},
        Mistake{kFolder, "folder = \"\xC2\xB5\"",
                "board.toml: line 11: a character beyond ASCII, expected those in comments only"},
        Mistake{kFolder, "folder = \"\"\"# \\\n\xC2\xA7\"\"\"",
                "board.toml: line 12: a character beyond ASCII, expected none in a file with strings of "
                "several lines"},
        Mistake{kFolder, "folder = \"#\"\xC2\xA7",
                "board.toml: line 11: a character beyond ASCII, expected those in comments only"}));

TEST(BoardFile, ATableThatIsMissingOrTextThatIsNoTomlIsNamed) {
  EXPECT_EQ(refusal(""),
            "board.toml: can is missing, expected a table [can]\n"
            "board.toml: analog_input is missing, expected a table [analog_input]\n"
            "board.toml: chamber is missing, expected 1 to 8 tables [[chamber]]\n"
            "board.toml: store is missing, expected a table [store]");
  EXPECT_THAT(refusal("[can\n"), AllOf(StartsWith("board.toml: line 1: "), HasSubstr("expected TOML")));
}

TEST(BoardFile, WhatIsWrongInEachTableIsToldAtOnce) {
  EXPECT_EQ(
      refusal(R"([can]
interface = "can0"
speed = 1
rate = 2
[analog_input]
rate_Hz = "fast"
[[chamber]]
in_use = false
null_V = 11
over_pressure_kPa = "much"
[[chamber]]
in_use = 1
[store]
folder = "here"
[real_time]
pacing = "adc"
priority = 99
[reel_time]
)"),
      "board.toml: line 4: can.rate is no key of this file, expected interface, node_id, bit_rate_kbit, "
      "vendor_id, product_code, revision, serial, model_url\n"
      "board.toml: line 3: can.speed is no key of this file, expected interface, node_id, bit_rate_kbit, "
      "vendor_id, product_code, revision, serial, model_url\n"
      "board.toml: line 6: analog_input.rate_Hz is a string, expected a whole number from 0 to 100000\n"
      "board.toml: line 10: chamber[1].over_pressure_kPa is a string, expected a number from 0 to 2000\n"
      "board.toml: line 9: chamber[1].null_V = 11, expected a number from 0 to 10\n"
      "board.toml: line 12: chamber[2].in_use is a whole number, expected true or false\n"
      "board.toml: line 14: store.folder = 'here', expected a path that begins with /\n"
      "board.toml: line 17: real_time.priority = 99, expected a whole number from 0 to 98\n"
      "board.toml: line 18: reel_time is no key of this file, expected can, analog_input, board, chamber, "
      "gpio, store, real_time");
}

TEST(BoardFile, AKeyOfMorePartsThanAnyOfThisFileIsRefusedHoweverManyTheyAre) {
  const auto dotted = [](const std::string& part, std::size_t parts) {
    std::string key = part;
    for (std::size_t more = 1; more < parts; ++more) key += "." + part;
    return key;
  };
  for (const std::size_t parts : {9U, 5'000U, 200'000U}) {
    const std::string expected = fmt::format("a key of {} parts, expected 8 at most", parts);
    for (const std::string part : {"a", "'='", "\"]\\\"\""}) {
      EXPECT_EQ(refusal("\n" + dotted(part, parts) + " = 1\n"), "board.toml: line 2: " + expected) << part;
      EXPECT_EQ(refusal("[" + dotted(part, parts) + "]"), "board.toml: line 1: " + expected) << part;
      EXPECT_EQ(refusal("a.a = [ 1.5, {" + dotted(part, parts) + " = 1 } ]"),
                "board.toml: line 1: " + expected);
    }
    EXPECT_THAT(refusal("a = [\"\"\"\n'\"\"\", {" + dotted("a", parts) + " = 1 }]"),
                StartsWith("board.toml: line 2: a key of"));
  }
  EXPECT_THAT(refusal(dotted("a", 8) + " = 1"), HasSubstr("can is missing"));
  EXPECT_THAT(refusal("a = [1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5]  # 1.2.3.4.5.6.7.8.9"),
              HasSubstr("can is missing"));
  EXPECT_THAT(refusal("a = '1.2.3.4.5.6.7.8.9'"), HasSubstr("can is missing"));
}

TEST(BoardFile, ANinthChamberIsOneTooMany) {
  std::string text = kLeast;
  for (int c = 0; c < 8; ++c) text += "[[chamber]]\nin_use = false\n";
  EXPECT_EQ(refusal(text), "board.toml: line 6: chamber has 9, expected up to 8 tables [[chamber]]");
}

TEST(BoardFile, AFileThatCannotBeReadIsNamed) {
  const auto read = [](const char* path) {
    try {
      read_board(path);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_EQ(read("/nowhere/board.toml"),
            "/nowhere/board.toml: No such file or directory, expected a board.toml");
  EXPECT_EQ(read("/proc"), "/proc: Is a directory, expected a board.toml");
  EXPECT_EQ(read("/dev/null"), "/dev/null: is a pipe or a device, expected a board.toml");
}

}  // namespace
}  // namespace plenum::board::config
