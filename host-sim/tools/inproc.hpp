// The rig that a command simulates inside itself, as its arguments describe it, and what is recorded of it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::rig {
struct RigConfig;
}

namespace plenum::host::tools {

class Arguments;

/// --plant, --rig, --effect, --chambers, --seed, --volume-swing, --spool.
struct RigChoice {
  std::string plant = "mpye";
  std::string rig_file;
  std::string rig_text;              ///< what it holds, where the store of the board knows; else empty
  std::vector<std::string> effects;  ///< ID=VALUE, or ID=PARAMETER:VALUE,...
  unsigned boards = 1;
  unsigned chambers = 8;
  std::uint64_t seed = 1;
  double volume_swing = 0.2;
  bool spool = true;

  /// `title`: in the help, of what only a simulated rig has.
  void add_to(Arguments& arguments, const std::string& title = "Options");
  /// What its user knows of the rig: the file's, or the standard rig's, without the effects of --effect: those are
  /// what its user would have to find. Throws InputError, also for a rate or an averaging time that a board does
  /// not have.
  trace::RigDescription description() const;
  /// The rig as it is, with all effects. `store`: the folder that keeps the board's models. Throws
  /// std::invalid_argument for effects that are not the catalogue's, or on measured valves.
  rig::RigConfig config(const std::optional<std::filesystem::path>& store = std::nullopt) const;
};

/// Of a log: fewer tell no rate.
inline constexpr std::size_t kLeastLogRows = 2;

/// Writes chamber-1.csv .. and rig.toml. Throws InputError.
void write_recording(const std::filesystem::path& folder, const std::vector<client::CapturedRow>& rows,
                     unsigned chambers, bool with_reference, const trace::RigDescription& description);

/// What was recorded before an exception that ends a recording is written all the same, as far as it makes logs. `description` and
/// `output` must outlive it.
class RecordedSoFar {
 public:
  RecordedSoFar(std::filesystem::path folder, unsigned chambers, bool with_reference,
                const trace::RigDescription& description, const Output& output);
  ~RecordedSoFar();
  RecordedSoFar(const RecordedSoFar&) = delete;
  RecordedSoFar& operator=(const RecordedSoFar&) = delete;
  std::vector<client::CapturedRow>* rows() { return &rows_; }

 private:
  std::filesystem::path folder_;
  unsigned chambers_;
  bool with_reference_;
  const trace::RigDescription& description_;
  const Output& output_;
  std::vector<client::CapturedRow> rows_;
};

/// Set points that leave a twentieth of the span free at both ends: what random references stay within.
struct SetpointRange {
  double low_Pa;
  double high_Pa;
};
SetpointRange setpoint_range(const trace::RigDescription& description);

}  // namespace plenum::host::tools
