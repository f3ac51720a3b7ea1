// The vessels that `plenum orifice` is given: logs of a chamber, or leak-down recordings of a sealed vessel.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host-sim/identify/orifice/vessel.hpp"
#include "host-sim/tools/log_input.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

class Arguments;

/// What is to be fitted of one file.
struct VesselLog {
  std::string name;
  identify::orifice::VesselRecord record;
  double period_s = 0.0;
  std::optional<double> command_V{};   ///< none: a sealed vessel has no valve
  std::optional<double> volume_m3{};   ///< none: neither the file nor --volume tells it
  std::vector<std::string> notices{};  ///< what may be wrong with it; to be told once it is fitted
};

class VesselInput {
 public:
  /// Declares LOG, --from, --to, --volume, and what LogInput does.
  void add_to(Arguments& arguments);

  trace::RigDescription rig() const { return logs_.rig(); }
  void print_assumed(const Output& output) const { logs_.print_assumed(output); }
  /// Tells its notices on standard error.
  void tell(const VesselLog& log) const { logs_.tell(log.notices); }

  /// Each file from --from to --to, logs of chambers before sealed vessels. Which kind it is, its header says: `t_s` and `p_bar`
  /// (gauge) are a sealed vessel's, whose far side is the ambient pressure. Of a log, the first row is left out where its pressure
  /// is still of the command before. Throws trace::InputError, and CannotIdentify where command or volume change.
  std::vector<VesselLog> read(const trace::RigDescription& rig) const;

 private:
  VesselLog of_chamber(const trace::NamedLog& of, const trace::RigDescription& rig) const;
  VesselLog of_sealed(const std::string& file, const trace::RigDescription& rig) const;

  LogInput logs_;
  std::vector<std::string> files_;
  double from_s_ = 0.0;
  std::optional<double> to_s_;
  std::optional<double> volume_mL_;
};

}  // namespace plenum::host::tools
