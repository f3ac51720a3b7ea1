// What a board says of itself, and the words for it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/safety/faults.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {

/// Object 1018h.
struct Identity {
  std::uint32_t vendor_id = 0;
  std::uint32_t product_code = 0;
  std::uint32_t revision = 0;
  std::uint32_t serial = 0;
};

/// Objects 1008h..100Ah and 2100h.
struct Versions {
  std::string device;
  std::string hardware;
  std::string software;
  std::uint32_t schema_hash = 0;
  unsigned parameter_count = 0;
  unsigned scalar_format = 0;  ///< 1: IEEE 754 binary32, 2: fixed point
  bool in_float() const { return scalar_format == 1; }
};

/// Each throws as Session does.
Identity read_identity(Session& session);
Versions read_versions(Session& session);

/// The model schema that this program writes.
std::uint32_t own_schema_hash();
unsigned own_parameter_count();

/// What is built into a chamber: 2148h+c; 0: not stated, or not by this firmware.
struct Serials {
  std::uint32_t valve = 0;
  std::uint32_t sensor = 0;
};
Serials read_serials(Session& session, std::uint8_t chamber);

/// To be asked before a board is changed: throws Refused when its firmware and this program do not fit each other, or it
/// is no board of this project.
void require_compatible(Session& session);

/// "DISABLED", "ACTIVE", "FAULT_HOLD" ... by 6041h and 604Eh.
const char* state_name(std::uint16_t status_word, std::uint16_t error_code);
/// The state is one in which outputs are regulated: HOLD, ACTIVE, FAULT_REACTION or FAULT_HOLD.
bool is_regulating(std::uint16_t status_word);
/// Throws Refused for a board that is in such a state, with `why` it should not be.
void require_at_rest(Session& session, const char* why);
const char* nmt_name(canopen::NmtState state);
const char* phase_name(plenum::config::SetPhase phase);

/// A fault as 604Eh, 1003h and the emergency message have it.
struct FaultEntry {
  std::uint16_t code = 0;
  unsigned chamber = 0;  ///< from 1; 0: the whole board
  bool placed = true;    ///< the board said which: the history that does may have been cleared
};
/// The rows of the fault table that this may be: of the chamber's faults or of the board's those with its code; empty for a
/// code that is not in the table.
std::vector<const plenum::safety::FaultSpec*> fault_specs(const FaultEntry& fault);
/// One of these rows asks the outputs for more than a report.
bool reacts(const FaultEntry& fault);
/// "set-point timeout", "stored set damaged or stored set cannot be written", or that the code is unknown here.
std::string fault_name(const FaultEntry& fault);
/// "6300h no valid model, chamber 2".
std::string fault_text(const FaultEntry& fault);

/// The most urgent of the standing faults; empty when there is none.
std::optional<FaultEntry> read_fault(Session& session);
/// All of them by urgency, of a fault first the board's: objects 2831h and 2830h. Empty for a board that has none of these.
std::vector<FaultEntry> read_standing_faults(Session& session);
/// Object 1003h, the newest first.
std::vector<FaultEntry> read_fault_history(Session& session);

/// A bin of object 2201h.
struct LatencyBin {
  std::uint32_t lowest_us = 0;  ///< the next bin's ends it
  std::uint32_t ticks = 0;      ///< that began so late, since the start of the board
};
/// Every bin, the earliest first.
std::vector<LatencyBin> read_latency(Session& session);

/// A chamber's parameter set: 2128h+c and 2118h+c.
struct ModelSet {
  plenum::config::SetPhase phase = plenum::config::SetPhase::empty;
  std::uint32_t crc = 0;
  std::uint32_t generation = 0;
  std::vector<std::uint8_t> image;  ///< empty when no model is in force
};
ModelSet read_model_set(Session& session, std::uint8_t chamber);

/// Of the last seconds in which its valve was driven: the mean of what the chamber's model, with nothing learned since, misses of
/// a tick's pressure [Pa].
double read_drift_Pa(Session& session, std::uint8_t chamber);

/// The board watches the chamber, from 0, and drives it with the others (2410h + c:1).
bool is_in_use(Session& session, std::size_t chamber);
/// What a board says of a supply that it has no sensor for is no measurement.
bool watches_supply(Session& session);

}  // namespace plenum::host::client
