#include "host-sim/trace/respiraworks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

using testing::HasSubstr;

const std::filesystem::path kData = std::filesystem::path(PLENUM_SOURCE_DIR) / "tests/data/respiraworks";

std::string refusal(const std::string& name, const std::string& rows,
                    const RespiraworksOptions& options = {}) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("plenum-respiraworks-test-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << "time(sec),pressure,cmd_exh_valve,cmd_psol,cmd_inh_valve\n" << rows;
  try {
    import_respiraworks(folder / name, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Respiraworks, TurnsARunIntoALogInSiUnits) {
  const Log log = import_respiraworks(kData / "ctl_OXY_1.csv");
  ASSERT_EQ(log.size(), 2340U);
  EXPECT_EQ(log.period_s, 0.01);
  EXPECT_EQ(log.pressure_average_s, 0.0);
  // First row of the file: pressure 0.503 kPa gauge, cmd_psol 0.184.
  EXPECT_DOUBLE_EQ(log.pressure_Pa[0], 101325.0 + 503.0);
  EXPECT_DOUBLE_EQ(log.command_V[0], 1.84);
  // 50 mL/cmH2O at one atmosphere: 50e-6/98.0665*101325 = 0.0516613..., and 1 L of gas.
  EXPECT_NEAR(log.volume_m3[0], 0.0516613 + 0.001, 1e-7) << "[m3]";
  EXPECT_EQ(log.volume_m3.front(), log.volume_m3.back());
}

TEST(Respiraworks, KnowsTheLungOfEachTest) {
  const auto volume_m3 = [](int test) {
    return import_respiraworks(kData / ("ctl_OXY_" + std::to_string(test) + ".csv")).volume_m3.front() -
           0.001;
  };
  EXPECT_NEAR(volume_m3(2) / volume_m3(3), 50.0 / 20.0, 1e-12);
  EXPECT_NEAR(volume_m3(4) / volume_m3(6), 1.0, 1e-12);
}

TEST(Respiraworks, TakesTheCommandOfTheInletValveThatMoves) {
  // First row of the file: cmd_inh_valve 0.582, cmd_psol 0 throughout.
  const Log log = import_respiraworks(kData / "pinch_new_1.csv");
  ASSERT_EQ(log.size(), 2340U);
  EXPECT_DOUBLE_EQ(log.command_V[0], 5.82);
}

TEST(Respiraworks, RefusesWhatItCannotTurnIntoOneCommand) {
  const std::string row = "0,1,0.5,0.2,0\n";
  EXPECT_THAT(refusal("x.csv", row + "0.01,1,0.5,0.2,0\n"), HasSubstr("test 0, expected 1 to 8"));
  EXPECT_THAT(refusal("x_9.csv", row + "0.01,1,0.5,0.2,0\n"), HasSubstr("test 9, expected 1 to 8"));
  EXPECT_THAT(refusal("x_1.csv", "0,1,0.5,0,0\n0.01,1,0.5,0,0\n"), HasSubstr("neither is above 0"));
  EXPECT_THAT(refusal("x_1.csv", row + "0.01,1,0.5,0.2,0.2\n"), HasSubstr("both are above 0"));
  EXPECT_THAT(refusal("x_1.csv", row + "0.01,1,0.5,1.2,0\n"),
              HasSubstr("row 2, column cmd_psol: 1.2, expected 0 to 1"));
  EXPECT_THAT(refusal("x_1.csv", row + "0.01,1,0.5,0.2,-0.1\n"),
              HasSubstr("row 2, column cmd_inh_valve: -0.1, expected 0 to 1"));
  EXPECT_THAT(refusal("x_1.csv", row + "0.01,1,0.3,0.2,0\n"), HasSubstr("row 2, column cmd_exh_valve"));
  EXPECT_THAT(refusal("x_1.csv", row + "0.01,x,0.5,0.2,0\n"), HasSubstr("row 2, column pressure"));
  EXPECT_EQ(refusal("x_1.csv", row + "0.01,1,0.5,0.2,0\n"), "accepted");
}

}  // namespace
}  // namespace plenum::host::trace
