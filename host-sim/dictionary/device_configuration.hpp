// A device configuration file (DCF, CiA 306-1): the electronic data sheet, for one node of one network.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "host-sim/dictionary/object_values.hpp"

namespace plenum::host::dictionary {

struct Commissioning {
  std::uint8_t node_id = 1;                  ///< 1..127
  std::uint32_t bit_rate_per_s = 1'000'000;  ///< whole kbit/s
  std::string node_name;
  std::uint32_t serial = 0;               ///< by which an LSS master finds the node
  std::string data_sheet = "plenum.eds";  ///< the file that `eds` is found in
  std::string file_name = "plenum.dcf";   ///< the file that this becomes
  std::chrono::sys_seconds created{};
};

/// `eds` for that node: each $NODEID is resolved, [DeviceComissioning] (so spelt by CiA 306) says who and how fast it is,
/// and `values` stand as ParameterValue. Throws std::invalid_argument for an `eds` in which a value is none.
std::string device_configuration(std::string_view eds, const Commissioning& commissioning,
                                 const ObjectValues& values = {});

}  // namespace plenum::host::dictionary
