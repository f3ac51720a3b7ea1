// What a rig's user knows of it, as a TOML file: README.md of this room holds the format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::trace {

/// Every table of the file but [sampling] may be left out; these initial values are then its defaults.
struct RigDescription {
  struct Sampling {
    double rate_Hz = 100.0;
    double pressure_average_s = 0.01;  ///< default: one tick, 1/rate_Hz; at most that
  } sampling;
  struct Gas {
    double temperature_K = 293.15;
  } gas;
  struct Supply {
    double pressure_Pa = 700000.0;  ///< absolute, above ambient
  } supply;
  struct Ambient {
    double pressure_Pa = 101325.0;
  } ambient;
  struct Valve {
    double open_above_V = 5.08;     ///< U_c: the supply port opens above
    double exhaust_below_V = 4.92;  ///< U_r: the exhaust port opens below
    double inlet_area_per_V_m2 = 1.5e-6;
    double exhaust_area_per_V_m2 = 1.6e-6;
    double inlet_leak_m2 = 3.0e-8;    ///< L_c
    double exhaust_leak_m2 = 3.0e-8;  ///< L_r
    double transition_m2 = 5.0e-8;    ///< w of a(u) = L + w smax((B (u - U) - L)/w)
    double discharge_coefficient = 0.72;
  } valve;
  struct Sensor {
    double pressure_noise_Pa = 100.0;  ///< standard deviation of one row's pressure
  } sensor;
  /// What the rig has beyond the nominal model: figures by the effect's id and their name, which carries the
  /// unit ("spool_lag": {"natural_frequency_Hz": 9.8}). Which ids and figures there are, and what they may
  /// be, is for the catalogue of effects to say; here a name has only its form.
  std::map<std::string, std::map<std::string, double>> effects;
  /// What is built into a chamber, by its number from 1: serial numbers, 0 where they are not stated.
  struct Chamber {
    std::uint32_t valve_serial = 0;
    std::uint32_t sensor_serial = 0;
  };
  std::map<unsigned, Chamber> chamber;
};

/// Reads a rig. Throws InputError naming file, line, table and key, the value found and the allowed range,
/// for: a syntax error, an unknown table or key, a value that is not a finite number or is out of range, a
/// missing sampling.rate_Hz, an averaging time longer than a tick, a supply that is not above ambient; in
/// [effects.ID] for a name that is not made of letters, digits and _, and for anything but finite numbers; in [chamber.N] for
/// an N that is not 1 to 8, and for anything but the whole numbers valve_serial and sensor_serial, 0 to 4294967295.
/// `assumed`, when given, gets "table.key = value" of each key that the file does not state.
RigDescription read_rig(const std::filesystem::path& path, std::vector<std::string>* assumed = nullptr);

/// As read_rig, from memory; `file` is the name used in errors.
RigDescription parse_rig(std::string_view text, std::string_view file,
                         std::vector<std::string>* assumed = nullptr);

/// The effective values, every table and key with its unit in the name: what a reader sees is what is used.
/// It is itself a rig file that reads back to the same values.
std::string format_rig(const RigDescription& rig);

/// Throws InputError when `rig` would not read back (out of range), or the file cannot be written.
void write_rig(const std::filesystem::path& path, const RigDescription& rig);

}  // namespace plenum::host::trace
