// The board that a command works with, as its arguments name it: on a bus, or simulated inside the program.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/client/bus_address.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/inproc.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::rig {
class Rig;
struct RigConfig;
}  // namespace plenum::host::rig

namespace plenum::host::tools {

/// --bus, --node, --patience, --store, and the options of the simulated rig, which are refused on any other bus. What they leave
/// out of the rig is as the store keeps it.
struct BoardChoice {
  std::string bus = "inproc";
  unsigned node = 1;
  double patience = 1.0;  ///< of a board on a bus: how many times as long it is waited for
  std::string store;
  RigChoice rig;  ///< of a board on a bus: how many chambers it has, and what is known of its rig

  void add_to(Arguments& arguments);
  bool simulated() const { return bus == "inproc"; }
  /// The board, for a message: the folder of its models, or the bus and its node id.
  std::string name() const;
  /// Of a session with the board: on a bus there may be other masters.
  client::SessionConfig session_config() const;
  /// Throws std::invalid_argument when a simulated board has no --store: it would keep nothing.
  void require_store() const;
  /// Throws as require_store(), and InputError when there is no such folder: a simulated board without models is no use
  /// to who names one.
  void require_stored() const;
  /// What a simulated board has stored is of its rig, which the store keeps beside it. Throws InputError.
  void keep_rig() const;

 private:
  friend class BoardAccess;
  std::optional<Arguments> arguments_;
};

/// The way to the board, open, and a session with it.
class BoardAccess {
 public:
  /// Throws std::invalid_argument for arguments that do not go together, std::runtime_error for a bus that is not
  /// reached.
  explicit BoardAccess(const BoardChoice& choice);
  /// A rig of this program's own, and a session with its first board.
  explicit BoardAccess(const rig::RigConfig& config);
  ~BoardAccess();

  client::Session& session() { return *session_; }
  client::Link& link() { return *link_; }
  /// The rig, when it is simulated in this program; otherwise none.
  rig::Rig* rig() { return rig_.get(); }
  /// Share of the time that the bus was busy; known of a simulated one.
  std::optional<double> bus_load();

 private:
  std::unique_ptr<rig::Rig> rig_;
  std::unique_ptr<client::Link> link_;
  std::optional<client::Session> session_;
};

/// Says on a terminal which object of the board is being read or written, of which chamber, and how many of its bytes are there.
class ShownTransfers {
 public:
  ShownTransfers(client::Session& session, std::string doing);
  ~ShownTransfers() { session_.watch_transfers({}); }
  ShownTransfers(const ShownTransfers&) = delete;
  ShownTransfers& operator=(const ShownTransfers&) = delete;

 private:
  client::Session& session_;
  Progress progress_;
};

/// The images of the models of the board's chambers. Throws std::runtime_error naming the first chamber that has none.
std::vector<std::vector<std::uint8_t>> require_models(client::Session& session, const BoardChoice& choice);

}  // namespace plenum::host::tools
