// The electronic data sheet as the board makes it, on the host.
#pragma once

#include <string>

#include "firmware/canopen/eds.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/telemetry/recorder.hpp"

namespace plenum::host::dictionary {

/// A data sheet and what it leans on.
struct DataSheet {
  config::ParameterSlots slots;
  telemetry::Recorder recorder;
  canopen::DataSheet sheet;

  explicit DataSheet(const canopen::Identity& identity) : sheet(identity, {}, slots, recorder) {}
};

/// The whole text, as object 1021h carries it.
std::string electronic_data_sheet(const canopen::Identity& identity);

}  // namespace plenum::host::dictionary
