// Importer of the RespiraWorks ventilator control tests: proportional valves, a breathing circuit and a test
// lung.
//
//   V = V_gas + C p_gauge          the test lung is a spring-loaded bellows: compliance C
//   command_V = 10 V cmd           0..1 becomes the range of a 0..10 V valve; cmd is cmd_psol in oxygen runs,
//                                  cmd_inh_valve in air runs: the one that moves
//   pressure_Pa = p_ambient + 1000 p_gauge[kPa]
//
// Symbols: C compliance [m3/Pa] (1 mL/cmH2O = 1e-6/98.0665 m3/Pa), V_gas gas in lung and circuit at 0 gauge
// [m3].
//
// What the volume column is, and why. Mass balance of the compliant load with isothermal gas (slow breaths,
// large wetted surface): d(p V)/dt = R T m', V = V_gas + C p_gauge, so p' = R T m' / (V + C p_abs): the load
// answers a flow as a RIGID chamber of volume V + C p_abs would, with no v' term left. 50 mL/cmH2O
// at one atmosphere act like 52 L; the gauge pressures of the runs (below 3.6 kPa) change that by 4 % at
// most. The volume column therefore holds this equivalent volume, constant over a run. Feeding the bellows'
// moving volume to a model that has a v' term instead would be wrong twice: v = C p makes v' a copy of p',
// the very quantity to be predicted.
//
// The two valves. The controller drives one signal: in an OXY run cmd_exh_valve falls from 0.6 to 0 as
// cmd_psol rises from 0.05 to 1, in an AIR run from 0.6 to 0.05 as cmd_inh_valve does; at equal inlet command it
// differs by 0.03 at most in the published runs. So ONE
// command is what acted, inlet opening and exhaust opening being both functions of it, as the two ports of a
// 5/3 spool are. A run in which that does not hold (spread above `exhaust_spread`) is refused.
//
// What a fit on these data can and cannot identify: README.md of host-sim/identify.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>

#include "host-sim/trace/log.hpp"

namespace plenum::host::trace {

/// One test of the published series: the settings of its test lung.
struct TestLung {
  double compliance_mL_per_cmH2O;
  double resistance_cmH2O_s_per_L;
};

/// Tests 1 to 8 of the series, as published with the data.
inline constexpr std::array<TestLung, 8> kTestLungs{
    {{50, 5}, {50, 20}, {20, 5}, {20, 20}, {20, 20}, {20, 50}, {10, 50}, {10, 20}}};

struct RespiraworksOptions {
  unsigned test = 0;  ///< 1 to 8; 0: the number at the end of the file's name, as in ctl_OXY_3.csv
  double ambient_Pa = 101325.0;
  double gas_volume_m3 =
      1.0e-3;  ///< V_gas: lung at rest, hoses; not published, a guess of 1 L (2 % of the whole)
  double exhaust_spread = 0.05;  ///< largest spread of cmd_exh_valve at one cmd_psol
};

/// Reads one run as a log. The pressure sensor's averaging is not published: instant samples are assumed.
/// Throws InputError as the log reader does, and for an unknown test number, a command outside
/// 0..1, a run in which neither or both inlet valves open, and inlet and exhaust that do not move together.
Log import_respiraworks(const std::filesystem::path& path, const RespiraworksOptions& options = {});

}  // namespace plenum::host::trace
