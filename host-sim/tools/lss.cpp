#include <memory>
#include <optional>
#include <stdexcept>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/lss_master.hpp"
#include "host-sim/client/scan.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  std::optional<int> node;
  std::optional<int> bit_rate;
  Output output;
};

/// Two nodes of one id would answer for each other. Throws Refused when something on the bus speaks for `node_id`.
void require_free(client::Link& link, std::uint8_t node_id) {
  constexpr double kHeartbeat_s = 1.2;  // one comes each second by default
  if (client::is_on_bus(link, node_id, kHeartbeat_s)) {
    throw client::Refused(
        fmt::format("node {}: is on the bus already, expected a node id that no other has", node_id));
  }
}

/// LSS is not served by a board that is about its work. Throws Refused.
void take_from_rest_to_init(client::Session& session) {
  client::require_at_rest(session, "it takes another node id in INIT, in which nothing is regulated");
  session.take_to_init();
}

/// LSS is not served while OPERATIONAL. A board that was it is so again afterwards, also when something fails, unless it is reset.
class OutOfOperational {
 public:
  explicit OutOfOperational(client::Session& session) : session_(session) {
    constexpr double kHeartbeat_s = 1.2;  // one comes each second by default
    try {
      was_operational_ = session.wait_heartbeat(kHeartbeat_s) == canopen::NmtState::operational;
    } catch (const client::Timeout&) {
      // of a board that does not beat nothing is known: it is left in PRE-OPERATIONAL
    }
    session.nmt(canopen::NmtCommand::enter_pre_operational);
  }
  ~OutOfOperational() {
    if (!was_operational_) return;
    try {
      session_.nmt(canopen::NmtCommand::start);
    } catch (const std::exception&) {  // what is being thrown says more
    }
  }
  OutOfOperational(const OutOfOperational&) = delete;
  OutOfOperational& operator=(const OutOfOperational&) = delete;

  void reset_communication() {
    was_operational_ = false;
    session_.nmt(canopen::NmtCommand::reset_communication);
  }
  /// The state that the board is left in.
  canopen::NmtState state() const {
    return was_operational_ ? canopen::NmtState::operational : canopen::NmtState::pre_operational;
  }

 private:
  client::Session& session_;
  bool was_operational_ = false;
};

void wait_for_boot(client::Link& link, std::uint8_t node_id) {
  constexpr double kBoot_s = 10.0;
  client::Session(link, node_id).wait_boot_up(kBoot_s);
}

int run(const Arguments& arguments, const Options& options) {
  const bool has_id = arguments.given("--node");
  if (has_id && !options.node && !options.bit_rate)
    throw std::invalid_argument("--node, and nothing to set, expected --set-node or --set-bit-rate");
  const std::uint8_t node_id = static_cast<std::uint8_t>(options.node.value_or(0));
  const bool named = options.node && node_id != canopen::kUnconfiguredNodeId;
  if (options.node && node_id > canopen::kMaxNodeId && named)
    throw std::invalid_argument(
        fmt::format("--set-node {}: expected 1 to 127, or 255 to take its node id away", node_id));
  if (has_id && options.node && node_id == options.board.node)
    throw std::invalid_argument(fmt::format("--set-node {}: the board's own, expected another one", node_id));
  if (options.bit_rate) client::bit_timing_row(static_cast<std::uint32_t>(*options.bit_rate));

  const StopSignal until_whole;  // a first Ctrl-C does not leave a board in "configuration"
  BoardAccess access(options.board);
  client::Session& session = access.session();
  client::Link& link = access.link();
  if (named) require_free(link, node_id);
  client::Identity identity;
  std::optional<OutOfOperational> out;  // until no board is in "configuration" any more
  {
    client::LssMaster lss(link);
    if (has_id) {
      take_from_rest_to_init(session);
      identity = client::read_identity(session);
      out.emplace(session);
      lss.select(identity);
    } else {
      const auto found = lss.find_unconfigured();
      if (!found)
        throw std::runtime_error(
            "no board without a node id answers, expected one; of a board that has one --node tells which it "
            "is");
      identity = *found;
    }
    // What a board may refuse comes first: a node id that was given counts once the board waits again.
    if (options.bit_rate) lss.give_bit_rate(static_cast<std::uint32_t>(*options.bit_rate));
    if (options.node) lss.give_node_id(node_id);
    try {
      if (options.node || options.bit_rate) {
        options.board.keep_rig();
        lss.store();
      }
    } catch (const std::runtime_error&) {
      if (options.node) lss.give_node_id(has_id ? session.node_id() : canopen::kUnconfiguredNodeId);
      throw;
    }
  }
  if (options.node && out) out->reset_communication();
  if (named) wait_for_boot(link, node_id);
  // without a node id it has none of these states
  std::optional<canopen::NmtState> left_in;
  if (named) left_in = canopen::NmtState::pre_operational;
  if (out && !options.node) left_in = out->state();
  out.reset();

  options.output.print(
      "vendor {:X}h, product {:X}h, revision {:X}h, serial {}: {}\n", identity.vendor_id,
      identity.product_code, identity.revision, identity.serial,
      named ? fmt::format("is node {} now, and stays it", node_id)
      : options.node
          ? std::string("has no node id any more, and is silent until LSS gives it one, or until it starts "
                        "where its board.toml states one")
      : has_id ? fmt::format("node {}", session.node_id())
               : std::string("has no node id, and is silent until LSS gives it one"));
  if (left_in)
    options.output.print(
        "it is {}{}\n", client::nmt_name(*left_in),
        *left_in == canopen::NmtState::operational ? " again" : ": its PDOs wait for NMT start");
  if (options.bit_rate) options.output.print("{} bit/s from its next start on\n", *options.bit_rate);
  options.output.finish({{"identity", identity_json(identity)},
                         {"node", named                     ? Json(node_id)
                                  : has_id && !options.node ? Json(session.node_id())
                                                            : Json(nullptr)},
                         {"nmt", left_in ? Json(client::nmt_name(*left_in)) : Json(nullptr)},
                         {"bit_rate", options.bit_rate ? Json(*options.bit_rate) : Json(nullptr)}});
  return kDone;
}

}  // namespace

Command add_lss(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("lss",
                      "Find a board that has no node id yet, and give it one and a bit "
                      "rate (LSS, CiA 305); or, with --node, another one to "
                      "a board that has one. The board keeps them. It has to be at rest. Of several "
                      "without a node id the one of the least identity is found. With another node id "
                      "it is pre-operational; otherwise as it was before");
  options->board.add_to(arguments);
  arguments.option("--set-node", options->node, "Node id for the board, 1 to 127; 255: none").within(1, 255);
  arguments.option("--set-bit-rate", options->bit_rate, "Of the bus, from the board's next start on [bit/s]");
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum lss --bus socketcand:127.0.0.1:29536/can0 --set-node 5    # the board without a node id\n"
      "  plenum lss --bus socketcand:127.0.0.1:29536/can0 --node 1 --set-node 5"));
  return {arguments, [arguments, options] { return run(arguments, *options); }};
}

}  // namespace plenum::host::tools
