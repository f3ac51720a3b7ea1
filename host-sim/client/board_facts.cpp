#include "host-sim/client/board_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

#include "firmware/telemetry/latency_histogram.hpp"

namespace plenum::host::client {
namespace {

using plenum::config::ModelKind;
using plenum::config::SetPhase;
namespace object = canopen::object;
namespace word = canopen::word;

constexpr unsigned kScalarFormats = 2;  ///< both carry models as REAL32

}  // namespace

Identity read_identity(Session& session) {
  const auto optional = [&](std::uint8_t sub) -> std::uint32_t {
    try {
      return session.read<std::uint32_t>(object::kIdentity, sub);
    } catch (const SdoAbort& abort) {
      if (abort.code == static_cast<std::uint32_t>(canopen::Abort::no_subindex)) return 0;
      throw;
    }
  };
  return {.vendor_id = session.read<std::uint32_t>(object::kIdentity, 1),
          .product_code = optional(2),
          .revision = optional(3),
          .serial = optional(4)};
}

Versions read_versions(Session& session) {
  return {.device = session.read_text(object::kDeviceName),
          .hardware = session.read_text(object::kHardwareVersion),
          .software = session.read_text(object::kSoftwareVersion),
          .schema_hash = session.read<std::uint32_t>(object::kSchema, 1),
          .parameter_count = session.read<std::uint16_t>(object::kSchema, 2),
          .scalar_format = session.read<std::uint8_t>(object::kSchema, 3)};
}

Serials read_serials(Session& session, std::uint8_t chamber) {
  const std::uint16_t index = object::nth(object::kSerials, chamber);
  try {
    return {session.read<std::uint32_t>(index, 1), session.read<std::uint32_t>(index, 2)};
  } catch (const SdoAbort& abort) {
    if (abort.code != static_cast<std::uint32_t>(canopen::Abort::no_object)) throw;
    return {};
  }
}

std::uint32_t own_schema_hash() {
  return plenum::config::schema_hash(ModelKind::tassa9);
}

unsigned own_parameter_count() {
  return static_cast<unsigned>(plenum::config::required_count(ModelKind::tassa9));
}

void require_compatible(Session& session) {
  const auto type = session.read<std::uint32_t>(object::kDeviceTypeIndex, 0);
  if (type != canopen::kDeviceType) {
    throw Refused(
        fmt::format("node {}: device type {:08X}h in 1000h, expected {:08X}h, that of a Plenum board",
                    session.node_id(), type, canopen::kDeviceType));
  }
  const Identity identity = read_identity(session);
  const Versions versions = read_versions(session);
  const bool fits = versions.schema_hash == own_schema_hash() &&
                    versions.parameter_count == own_parameter_count() && versions.scalar_format >= 1 &&
                    versions.scalar_format <= kScalarFormats;
  if (fits) return;
  throw Refused(fmt::format(
      "node {}: firmware {} (product {:X}h, revision {:X}h) has models of schema {:08X}h with {} parameters "
      "in scalar "
      "format {}, expected {:08X}h with {} in format 1 or 2: firmware and program are of different releases",
      session.node_id(), versions.software, identity.product_code, identity.revision, versions.schema_hash,
      versions.parameter_count, versions.scalar_format, own_schema_hash(), own_parameter_count()));
}

const char* state_name(std::uint16_t status_word, std::uint16_t error_code) {
  switch (status_word & (word::kStateMask | word::kReady)) {
    case 0x8:
      return "INIT";
    case 0x9:
      return "DISABLED";
    case 0xB:
      return "HOLD";
    case 0xF:
      return "ACTIVE";
    case 0x7:
      return "FAULT_REACTION";
    case 0x3:
      return "FAULT_HOLD";
    case 0x1:
      return "FAULT_DISABLED";
    case 0x0:
      return error_code != 0 ? "FAULT_INIT" : "NOT_READY";
    default:
      return "unknown";
  }
}

bool is_regulating(std::uint16_t status_word) {
  return (status_word & word::kHold & ~word::kDisabled) != 0;
}

void require_at_rest(Session& session, const char* why) {
  const std::uint16_t status = session.status_word();
  if (!is_regulating(status)) return;
  const auto fault = read_fault(session);
  throw Refused(fmt::format("node {}: is in {}, expected a board at rest: {}", session.node_id(),
                            state_name(status, fault ? fault->code : std::uint16_t{0}), why));
}

const char* nmt_name(canopen::NmtState state) {
  switch (state) {
    case canopen::NmtState::initialising:
      return "initialising";
    case canopen::NmtState::stopped:
      return "stopped";
    case canopen::NmtState::operational:
      return "operational";
    case canopen::NmtState::pre_operational:
      return "pre-operational";
  }
  return "unknown";
}

const char* phase_name(SetPhase phase) {
  switch (phase) {
    case SetPhase::empty:
      return "empty";
    case SetPhase::active:
      return "active";
    case SetPhase::staged:
      return "staged";
    case SetPhase::committed:
      return "committed";
    case SetPhase::refused:
      return "refused";
    case SetPhase::checking:
      return "checking";
    case SetPhase::doubted:
      return "doubted";
  }
  return "unknown";
}

std::vector<const plenum::safety::FaultSpec*> fault_specs(const FaultEntry& fault) {
  using plenum::safety::Scope;
  const Scope scope = fault.chamber == 0 ? Scope::board : Scope::chamber;
  std::vector<const plenum::safety::FaultSpec*> specs;
  for (const auto& row : plenum::safety::fault_table()) {
    if (row.code == fault.code && (row.scope == scope || !fault.placed)) specs.push_back(&row);
  }
  return specs;
}

bool reacts(const FaultEntry& fault) {
  const auto specs = fault_specs(fault);
  return std::any_of(specs.begin(), specs.end(),
                     [](const auto* spec) { return spec->reaction != plenum::safety::Reaction::none; });
}

std::string fault_name(const FaultEntry& fault) {
  std::string name;
  for (const auto* spec : fault_specs(fault)) name += (name.empty() ? "" : " or ") + std::string(spec->name);
  return name.empty() ? "a fault that this program does not know" : name;
}

std::string fault_text(const FaultEntry& fault) {
  const std::string where = fault.chamber == 0 ? "" : fmt::format(", chamber {}", fault.chamber);
  return fmt::format("{:04X}h {}{}", fault.code, fault_name(fault), where);
}

std::optional<FaultEntry> read_fault(Session& session) {
  const auto code = session.read<std::uint16_t>(object::kErrorCode, 0);
  if (code == 0) return std::nullopt;
  const auto of_code = [code](const std::vector<FaultEntry>& faults) -> std::optional<FaultEntry> {
    const auto same =
        std::find_if(faults.begin(), faults.end(), [code](const auto& one) { return one.code == code; });
    return same == faults.end() ? std::nullopt : std::optional(*same);
  };
  if (const auto standing = of_code(read_standing_faults(session))) return standing;
  // of a board that has been asked between two ticks, or knows no 2831h, the newest line that is about this fault
  return of_code(read_fault_history(session)).value_or(FaultEntry{code, 0, false});
}

std::vector<FaultEntry> read_standing_faults(Session& session) try {
  std::array<std::uint32_t, kChambers + 1> standing{};  // the board's first
  std::uint32_t anywhere = 0;
  for (unsigned place = 0; place <= kChambers; ++place) {
    const auto sub = static_cast<std::uint8_t>(place == 0 ? kChambers + 1 : place);
    standing[place] = session.read<std::uint32_t>(object::kStandingFaults, sub);
    anywhere |= standing[place];
  }
  std::vector<FaultEntry> faults;
  for (; anywhere != 0; anywhere &= anywhere - 1) {
    const auto fault = static_cast<unsigned>(std::countr_zero(anywhere));
    const auto row =
        session.read<std::uint32_t>(object::kFaultReactions, static_cast<std::uint8_t>(fault + 1));
    for (unsigned place = 0; place <= kChambers; ++place) {
      if ((standing[place] >> fault & 1U) != 0)
        faults.push_back({static_cast<std::uint16_t>(row & 0xFFFFU), place});
    }
  }
  return faults;
} catch (const SdoAbort& abort) {
  if (abort.code != static_cast<std::uint32_t>(canopen::Abort::no_object)) throw;
  return {};
}

std::vector<FaultEntry> read_fault_history(Session& session) {
  std::vector<FaultEntry> history;
  const auto count = session.read<std::uint8_t>(object::kErrorHistoryIndex, 0);
  for (unsigned sub = 1; sub <= count; ++sub) {
    const auto bits = session.read<std::uint32_t>(object::kErrorHistoryIndex, static_cast<std::uint8_t>(sub));
    history.push_back({static_cast<std::uint16_t>(bits & 0xFFFFU), bits >> 16U & 0xFFU});
  }
  return history;
}

std::vector<LatencyBin> read_latency(Session& session) {
  using Histogram = plenum::telemetry::LatencyHistogram;
  std::vector<LatencyBin> bins;
  for (std::size_t bin = 0; bin < Histogram::kBins; ++bin) {
    bins.push_back(
        {.lowest_us = Histogram::lowest_us(bin),
         .ticks = session.read<std::uint32_t>(object::kLatency, static_cast<std::uint8_t>(bin + 1))});
  }
  return bins;
}

double read_drift_Pa(Session& session, std::uint8_t chamber) {
  return static_cast<double>(session.read<float>(object::nth(object::kRegulator, chamber), 5));
}

ModelSet read_model_set(Session& session, std::uint8_t chamber) {
  const std::uint16_t state = object::nth(object::kSetState, chamber);
  return {.phase = static_cast<SetPhase>(session.read<std::uint8_t>(state, 1)),
          .crc = session.read<std::uint32_t>(state, 3),
          .generation = session.read<std::uint32_t>(state, 4),
          .image = session.download_model(chamber)};
}

bool is_in_use(Session& session, std::size_t chamber) {
  return session.read<std::uint8_t>(object::nth(object::kChamberChoices, chamber), 1) != 0;
}

bool watches_supply(Session& session) {
  constexpr std::uint8_t kSupplyLow_kPa = 3;  // of kBoardSettings
  return session.read<float>(object::kBoardSettings, kSupplyLow_kPa) > 0.0F;
}

}  // namespace plenum::host::client
