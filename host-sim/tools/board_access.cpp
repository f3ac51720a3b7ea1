#include "host-sim/tools/board_access.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "host-sim/client/patient_link.hpp"
#include "host-sim/client/transfer_text.hpp"
#include "host-sim/rig/rig.hpp"
#include "host-sim/tools/kept_rig.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

constexpr unsigned kLastNode = 127;
/// What only a simulated rig has.
constexpr std::array kSimulatedOnly{"--store", "--plant", "--effect", "--volume-swing", "--spool"};

}  // namespace

void BoardChoice::add_to(Arguments& arguments) {
  constexpr const char* kTitle = "Simulated board only";
  arguments_ = arguments;
  arguments
      .option("--bus", bus,
              fmt::format("Where the board is: inproc, a rig simulated inside this program, or {}",
                          client::kOutsideForms))
      .type_name("BUS")
      .show_default();
  arguments.option("--node", node, "Node id of the board; a simulated one has this")
      .within(1U, kLastNode)
      .show_default();
  arguments
      .option("--patience", patience,
              "How many times as long to wait for a board on a bus, whatever for: one in an emulator, say, "
              "whose second is longer than this PC's")
      .within(1.0, 1000.0)
      .show_default();
  arguments.option("--store", store, "Folder that keeps the models of the simulated board")
      .type_name("DIR")
      .group(kTitle);
  rig.add_to(arguments, kTitle);
  arguments.when_read([this] {
    if (simulated() && !store.empty()) take_rig(rig, *arguments_, store);
  });
}

std::string BoardChoice::name() const {
  return simulated() ? store.empty() ? "--store is not given" : store : fmt::format("{} node {}", bus, node);
}

client::SessionConfig BoardChoice::session_config() const {
  constexpr double kListen_s = 0.05;    // several ticks, in each of which a transfer under way shows itself
  constexpr double kHeartbeat_s = 2.5;  // one comes each second by default
  if (simulated()) return {};
  return {.sdo = {.listen_first_s = kListen_s, .heartbeat_wait_s = kHeartbeat_s}};
}

void BoardChoice::require_store() const {
  if (!simulated() || !store.empty()) return;
  throw std::invalid_argument(
      "--store is missing, expected the folder that keeps the models of the simulated board");
}

void BoardChoice::require_stored() const {
  require_store();
  if (!simulated() || std::filesystem::is_directory(store)) return;
  throw trace::InputError(
      fmt::format("{}: there is no such folder, expected the models of a simulated board", store));
}

void BoardChoice::keep_rig() const {
  if (simulated() && !store.empty()) tools::keep_rig(rig, store);
}

ShownTransfers::ShownTransfers(client::Session& session, std::string doing)
    : session_(session), progress_(std::move(doing)) {
  session_.watch_transfers(
      [this](const client::Transfer& transfer) { progress_(client::text_of(transfer)); });
}

BoardAccess::BoardAccess(const BoardChoice& choice) {
  const client::BusAddress address = client::parse_bus(choice.bus);
  if (choice.simulated()) {
    if (choice.patience != 1.0) {
      throw std::invalid_argument(
          "--patience with --bus inproc: a simulated rig makes nobody wait, expected a board on a bus");
    }
    rig::RigConfig config =
        choice.rig.config(choice.store.empty() ? std::nullopt : std::optional(choice.store));
    config.board.front().settings.node.node_id = static_cast<std::uint8_t>(choice.node);
    rig_ = std::make_unique<rig::Rig>(config);
    link_ = std::make_unique<RigLink>(*rig_);
  } else {
    for (const char* option : kSimulatedOnly) {
      if (!choice.arguments_->given(option)) continue;
      throw std::invalid_argument(fmt::format(
          "{} with --bus {}: only a simulated rig has it, expected --bus inproc", option, choice.bus));
    }
    link_ = std::make_unique<client::PatientLink>(client::open_link(address), choice.patience);
  }
  session_.emplace(*link_, static_cast<std::uint8_t>(choice.node), choice.session_config());
}

BoardAccess::BoardAccess(const rig::RigConfig& config)
    : rig_(std::make_unique<rig::Rig>(config)), link_(std::make_unique<RigLink>(*rig_)) {
  session_.emplace(*link_, config.board.front().settings.node.node_id);
}

BoardAccess::~BoardAccess() = default;

std::optional<double> BoardAccess::bus_load() {
  if (!rig_) return std::nullopt;
  return rig_->bus().busy_share();
}

std::vector<std::vector<std::uint8_t>> require_models(client::Session& session, const BoardChoice& choice) {
  std::vector<std::vector<std::uint8_t>> images;
  for (unsigned c = 0; c < choice.rig.chambers; ++c) {
    images.push_back(session.download_model(static_cast<std::uint8_t>(c)));
    if (!images.back().empty()) continue;
    throw std::runtime_error(fmt::format(
        "{}: the board has no model for chamber {}, expected one for each of its {} chambers: plenum upload",
        choice.name(), c + 1, choice.rig.chambers));
  }
  return images;
}

}  // namespace plenum::host::tools
