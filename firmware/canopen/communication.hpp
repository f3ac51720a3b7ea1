// The communication parameters of a node and what its PDOs are doing: the state behind objects 1003h..1A0Bh.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/elapsed.hpp"
#include "firmware/canopen/heartbeat_consumer.hpp"
#include "firmware/canopen/objects.hpp"
#include "firmware/canopen/process_image.hpp"
#include "firmware/config/lss_settings.hpp"
#include "firmware/config/model_desk.hpp"
#include "firmware/config/seal.hpp"
#include "firmware/config/settings_desk.hpp"
#include "firmware/telemetry/recorder.hpp"

namespace plenum::canopen {

struct Entry;
class DataSheet;

/// Who the board is. Strings are kept by reference: they must outlive the node.
struct Identity {
  std::uint32_t vendor_id = 0;
  std::uint32_t product_code = 0;
  std::uint32_t revision = 0;  ///< 0: that of the object dictionary, dictionary_revision()
  std::uint32_t serial = 0;
  const char* vendor_name = "Plenum";
  const char* device_name = "Plenum valve board";
  const char* model_url = "";  ///< of the installer's page about this model
  const char* hardware_version = "simulated";
  const char* software_version = "0.1.0";
};

struct Config {
  std::uint8_t node_id = 1;  ///< 1..127, or kUnconfiguredNodeId: LSS gives it one
  Identity identity{};
  std::uint32_t sdo_timeout_us = 1'000'000;  ///< silence after which a segmented transfer is aborted
  std::uint32_t store_timeout_us =
      5'000'000;                    ///< after which a write that waits for the parameter store is aborted
  std::uint16_t bit_rates = 0x1DF;  ///< that the CAN driver can run; bit n: row n of table 0 of CiA 305
};

/// An object as a PDO refers to it, looked up once when the mapping is activated.
struct MappedObject {
  const Entry* entry = nullptr;
  std::uint8_t instance = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 0;
};

struct Mapping {
  std::uint8_t count = 0;                         ///< sub-index 0; 0 while the mapping is being changed
  std::uint8_t bytes = 0;                         ///< length of the PDO
  std::array<std::uint32_t, kMappable> packed{};  ///< sub-indices 1..8: index << 16 | sub << 8 | bits
  std::array<MappedObject, kMappable> object{};   ///< the first `count` are valid
};

struct PdoParameters {
  std::uint32_t cob_id = 0x8000'0000U;
  std::uint8_t transmission_type = 254;
  std::uint16_t inhibit_100us = 0;   ///< TPDO only
  std::uint16_t event_timer_ms = 0;  ///< TPDO: longest pause; RPDO: deadline
  std::uint8_t sync_start = 0;       ///< TPDO: counter of the SYNC that counts as the first; 0: any
  Mapping mapping;
};

/// The PDO is on.
inline bool is_valid(const PdoParameters& parameters) noexcept {
  return (parameters.cob_id & cob::kInvalid) == 0;
}

struct Rpdo {
  bool latched = false;          ///< a checked frame waits for its SYNC ...
  std::uint32_t latched_us = 0;  ///< ... and has done so this long
  std::array<std::uint8_t, 8> data{};
  /// It has come since 6040h asks for ACTIVE, and must keep coming where it has a deadline.
  bool watched = false;
  bool feeds = false;  ///< what came carried a set point, whatever it is mapped to by now
  bool came = false;   ///< since ProcessImage::setpoint_count last went on
  Silence silence{};   ///< since it was applied

  const PdoParameters& parameters() const noexcept { return parameters_; }
  /// The one way to write the parameters.
  template <class Change>  // void(PdoParameters&)
  void change(Change&& change) noexcept {
    change(parameters_);
    seal_ = config::sum_of_object(parameters_);
  }
  bool intact() const noexcept { return seal_ == config::sum_of_object(parameters_); }

 private:
  PdoParameters parameters_;
  std::uint64_t seal_ = 0;  ///< of the parameters: one that listens elsewhere makes a board that obeys nobody
};

struct Tpdo {
  PdoParameters parameters;
  bool due = false;           ///< a SYNC called for it
  bool ever_sent = false;     ///< since the node became operational
  bool sync_started = false;  ///< the SYNC of sync_start has come
  std::uint8_t sync_count = 0;
  std::uint32_t since_sent_us = 0;
  alignas(4) std::array<std::uint8_t, 8> last{};
};

/// What 2200h shows beside the controller's own counts. All of them wrap.
struct Counters {
  std::uint32_t received = 0;  ///< frames taken: well formed and meant for this node
  std::uint32_t rejected = 0;  ///< frames meant for this node that were malformed, or carried a refused value
  std::uint32_t sync = 0;
  std::uint32_t queue_overflow = 0;   ///< emergency, heartbeat or SDO frames that found their queue full
  std::uint32_t pdo_overwritten = 0;  ///< TPDOs replaced by newer values before the bus took them
  std::uint32_t sdo_aborts = 0;       ///< aborts sent
};

/// An error as 604Eh, 1001h, 1003h and the emergency message show it.
struct ErrorState {
  std::uint16_t code = 0;
  std::uint8_t error_register = 0;
  std::uint8_t chamber = 0;
};

struct ErrorHistory {
  std::uint8_t count = 0;
  std::array<std::uint32_t, kErrorHistory> newest_first{};  ///< error code | chamber << 16

  void push(const ErrorState& error) noexcept {
    for (std::size_t i = kErrorHistory - 1; i > 0; --i) newest_first[i] = newest_first[i - 1];
    newest_first[0] = error.code | std::uint32_t{error.chamber} << 16;
    if (count < kErrorHistory) ++count;
  }
};

/// 1029h, what an error makes of the state OPERATIONAL: sub-index 1 of the communication (bus-off, a consumed heartbeat lost), 2 any
/// fault that has taken the board out of what 6040h asks for.
enum class ErrorBehaviour : std::uint8_t { pre_operational = 0, no_change = 1, stopped = 2 };

/// Reset by "reset communication".
struct Communication {
  std::uint32_t sync_cob_id = 0x80;
  std::uint32_t cycle_period_us = 0;  ///< 1006h, as the master tells it
  std::uint8_t sync_overflow = 0;     ///< 1019h; 0: SYNCs are not counted
  std::uint32_t emergency_cob_id = 0;
  std::uint16_t heartbeat_ms = 1000;
  HeartbeatConsumer heartbeats;
  ErrorBehaviour on_communication_error = ErrorBehaviour::pre_operational;
  ErrorBehaviour on_device_error = ErrorBehaviour::no_change;
  std::array<Rpdo, kRpdos> rpdo{};
  std::array<Tpdo, kTpdos> tpdo{};
  std::uint8_t commit_mask = 0;
  std::uint32_t commit_crc = 0;
};

/// The defaults of the predefined connection set (README.md of this room lists them), as of node id 0: identifiers are bases. It
/// looks up every mapped object, and is made once (DataSheet).
Communication delivered_communication() noexcept;
/// Gives it the object dictionary's revision where it states none.
void state_revision(Identity& identity) noexcept;

/// Adds the node id to the identifiers that belong to a node, and seals its RPDOs.
void give_node_id(Communication& delivered, std::uint8_t node_id) noexcept;

/// Work on the parameter store that no tick can wait for. One order stands at a time.
///
/// The bus orders (1010h, 1011h, LSS): it finds `what` at none, sets it and its details, and returns Abort::pending. The owner
/// of the store sees the order between two ticks, does it at his leisure, and sets `result`, then `done`. Whoever ordered
/// answers, and takes the order away. An order is carried out even when the client that gave it has gone.
struct StoreOrder {
  enum class What : std::uint8_t { none, store, restore, lss };

  What what = What::none;
  std::uint8_t sub = 0;  ///< of 1010h or 1011h: 1 all, 2 communication, 3 application parameters
  /// Of `lss`: what takes the place of the stored ones. 0 leaves the stored one, kUnconfiguredNodeId forgets the node id.
  config::LssSettings lss{};
  bool done = false;
  Abort result = Abort::none;  ///< valid when done: none, or hardware_error (the store failed)
};

/// All that the objects of the dictionary are bound to.
struct Device {
  const Config& config;
  ProcessImage& image;
  config::ModelDesk& desk;
  config::SettingsDesk& settings;
  telemetry::Recorder& recorder;
  DataSheet& sheet;
  Communication communication;
  Counters counters;
  ErrorHistory history;
  StoreOrder order;
};

/// The controller's error. The node has none of its own: what it sees first (setpoint_lost) it tells the
/// controller, so that status word, outputs and emergency speak of it in one and the same tick.
ErrorState error_state(const ProcessImage& image) noexcept;

}  // namespace plenum::canopen
