#include "firmware/canopen/node.hpp"

#include <algorithm>

namespace plenum::canopen {
namespace {

using ports::CanFrame;

CanFrame eight_bytes(std::uint32_t id, const SdoServer::Bytes& bytes) {
  CanFrame frame;
  frame.id = id;
  frame.length = 8;
  frame.data = bytes;
  return frame;
}

bool is_synchronous(const PdoParameters& parameters) {
  return parameters.transmission_type <= 240;
}

/// Reads the mapped objects into the bytes of a PDO.
void pack(const Device& device, const Mapping& mapping, std::array<std::uint8_t, 8>& data) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < mapping.count; ++i) {
    const MappedObject& object = mapping.object[i];
    std::uint32_t bits = 0;
    // no mappable object refuses to be read
    static_cast<void>(object.entry->read_value(device, {object.instance, object.sub}, bits));
    store_le(bits, std::span(data).subspan(at, object.bytes));
    at += object.bytes;
  }
}

bool admissible(const Mapping& mapping, const std::array<std::uint8_t, 8>& data) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < mapping.count; ++i) {
    const MappedObject& object = mapping.object[i];
    const std::uint32_t bits = load_le(std::span(data).subspan(at, object.bytes));
    if (judge_value(*object.entry, bits) != Abort::none) return false;
    at += object.bytes;
  }
  return true;
}

}  // namespace

Node::Node(const Config& config, ProcessImage& image, config::ModelDesk& desk, config::SettingsDesk& settings,
           telemetry::Recorder& recorder) noexcept
    : config_(config),
      sheet_(config_.identity, settings, desk, recorder),
      device_{config_, image, desk, settings, recorder, sheet_, sheet_.delivered().communication,
              {},      {},    {}} {
  state_revision(config_.identity);
  begin_communication();
  boot_up();
}

void Node::receive(const CanFrame& frame) noexcept {
  if (frame.extended || frame.remote) return;
  if (frame.id == cob::kNmt) return receive_nmt(frame);
  if (frame.id == cob::kLssRequest) return receive_lss(frame);
  if (reset_ != Reset::none) return;
  if (frame.id > cob::kHeartbeat && frame.id <= cob::kHeartbeat + kMaxNodeId) return receive_heartbeat(frame);
  if (state_ == NmtState::stopped || state_ == NmtState::initialising) return;
  if (frame.id == cob::kSdoRequest + config_.node_id) return receive_sdo(frame);
  if (frame.id == device_.communication.sync_cob_id) return receive_sync(frame);
  if (state_ != NmtState::operational) return;
  for (Rpdo& rpdo : device_.communication.rpdo) {
    if (is_valid(rpdo.parameters()) && frame.id == (rpdo.parameters().cob_id & cob::kIdMask)) {
      receive_pdo(rpdo, frame);
    }
  }
}

void Node::receive_nmt(const CanFrame& frame) noexcept {
  if (frame.length != 2) {
    ++device_.counters.rejected;
    return;
  }
  if (frame.data[1] != 0 && frame.data[1] != config_.node_id) return;
  ++device_.counters.received;
  const auto command = static_cast<NmtCommand>(frame.data[0]);
  const bool is_reset = command == NmtCommand::reset_node || command == NmtCommand::reset_communication;
  if (state_ == NmtState::initialising && !is_reset) return;  // without a node id, or about to be reset
  switch (command) {
    case NmtCommand::start:
      return enter(NmtState::operational);
    case NmtCommand::stop:
      return enter(NmtState::stopped);
    case NmtCommand::enter_pre_operational:
      return enter(NmtState::pre_operational);
    case NmtCommand::reset_node:
      return ask_for(Reset::node);
    case NmtCommand::reset_communication:
      return ask_for(Reset::communication);
  }
  ++device_.counters.rejected;
}

void Node::keep(std::span<const std::uint8_t> rows, std::uint8_t saved_id) noexcept {
  kept_ = rows;
  saved_id_ = saved_id;
  step_ = Step::begin;  // the rows that a reset was reading are gone
}

Restored Node::restart(std::uint8_t node_id) noexcept {
  if (node_id >= 1 && node_id <= 127) config_.node_id = node_id;
  reset_ = Reset::node;
  begin_reset();
  Work all(std::numeric_limits<int>::max());
  while (is_resetting()) go_on(all);
  return restored_;
}

/// Of a node that is reset twice the greater reset counts.
void Node::ask_for(Reset reset) noexcept {
  if (reset == Reset::node) device_.image.control_word = 0;
  if (reset > reset_) {
    reset_ = reset;
    step_ = Step::begin;
  }
  sdo_.reset();
  queue_.clear();
  enter(NmtState::initialising);
}

void Node::begin_reset() noexcept {
  restored_ = {};
  step_ = Step::communication_defaults;
  if (reset_ != Reset::node) return;
  device_.settings.begin_restore();
  restoration_.begin(Kept::application, kept_, saved_id_);
  step_ = Step::application;
}

/// What the bus wrote goes back to its power-on value or to the stored one; what the controller says stays its own.
void Node::forget_process() noexcept {
  ProcessImage& image = device_.image;
  static constexpr ProcessImage kFresh;
  image.control_word = kFresh.control_word;
  image.control_mode = kFresh.control_mode;
  image.volume_code = kFresh.volume_code;
  image.preview_ticks = kFresh.preview_ticks;
  image.parameter_set_code = kFresh.parameter_set_code;
  device_.desk.forget_staged();
  device_.recorder.forget_orders();
  for (ChamberImage& chamber : image.chamber) {
    chamber.setpoint_Pa = numeric::Scalar(0);
    chamber.hold_setpoint_Pa = numeric::Scalar(0);
    chamber.excitation = {};
  }
}

/// One step of a reset, or the part of it that `work` allows.
void Node::go_on(Work& work) noexcept {
  // callgrind, gcc 12 -O2
  constexpr int kBegin = 20;
  constexpr int kInstalled = 5;
  constexpr int kJudge = 40;
  constexpr int kDefaults = 60;
  switch (step_) {
    case Step::begin: {
      const bool rests = (device_.image.status_word & word::kStateMask) == 0;  // INIT, FAULT_INIT, NOT_READY
      if (reset_ == Reset::node && !rests) return work.end();
      work.take(kBegin);
      if (reset_ == Reset::node) forget_process();
      return begin_reset();
    }
    case Step::application:
      if (!restoration_.go_on(device_, restored_, work)) return;
      owner_ = config::kChambers;  // the board's first
      step_ = Step::settings;
      return;
    case Step::settings: {
      const int cost = device_.settings.has_restored(owner_) ? kJudge : kInstalled;
      if (!work.has_room_for(cost)) return work.end();
      work.take(cost);
      take_restored(owner_);
      return;
    }
    case Step::communication_defaults:
      if (!work.has_room_for(kDefaults)) return work.end();
      work.take(kDefaults);
      begin_communication();
      restoration_.begin(Kept::communication, kept_, saved_id_);
      step_ = Step::communication;
      return;
    case Step::communication:
      if (!restoration_.go_on(device_, restored_, work)) return;
      reset_ = Reset::none;
      step_ = Step::begin;
      boot_up();
      return;
  }
}

void Node::take_restored(std::size_t owner) noexcept {
  config::SettingsDesk& settings = device_.settings;
  const bool is_board = owner == config::kChambers;
  if (!settings.take_restored(owner))
    restored_.skip(
        static_cast<std::uint16_t>(is_board ? object::kBoardSettings : object::kChamberSettings + owner), 0);
  owner_ = is_board ? 0 : owner + 1;
  if (owner_ != config::kChambers) return;
  settings.end_restore();
  step_ = Step::communication_defaults;
}

void Node::enter(NmtState state) noexcept {
  if (state == state_) return;
  if (state == NmtState::stopped) sdo_.reset();
  if (state == NmtState::operational) lss_.wait();  // CiA 305: where LSS is not served it begins anew
  if (state_ == NmtState::operational) queue_.clear_pdos();
  for (Rpdo& rpdo : device_.communication.rpdo) rpdo.latched = false;
  for (Tpdo& tpdo : device_.communication.tpdo) {
    tpdo.due = false;
    tpdo.ever_sent = false;
    tpdo.sync_started = false;
    tpdo.sync_count = 0;
  }
  state_ = state;
}

/// A reset of the communication leaves the machine regulating, and ends every watch over whoever makes it regulate: as if he had
/// fallen silent.
void Node::end_watches() noexcept {
  constexpr std::uint16_t kRegulates = word::kHold;
  if ((device_.image.control_word & kRegulates) != kRegulates) return;
  const std::array<Rpdo, kRpdos>& all = device_.communication.rpdo;
  setpoint_watch_ended_ = std::any_of(all.begin(), all.end(), [](const Rpdo& one) {
    return one.watched && one.parameters().event_timer_ms != 0;
  });
  heartbeat_watch_ended_ = device_.communication.heartbeats.is_watching();
}

void Node::begin_communication() noexcept {
  const std::uint8_t given = lss_.given_node_id();
  if (given != 0 && given != config_.node_id) {
    config_.node_id = given;
    device_.image.control_word = 0;  // its master knows it by the old one, and could not stop it
  }
  end_watches();
  device_.communication = sheet_.delivered().communication;
  give_node_id(device_.communication, config_.node_id);
}

void Node::boot_up() noexcept {
  sdo_.reset();
  lss_.wait();
  queue_.clear();
  since_heartbeat_us_ = 0;
  errors_.tell_again();
  if (config_.node_id == kUnconfiguredNodeId) return enter(NmtState::initialising);
  CanFrame boot_up;
  boot_up.id = cob::kHeartbeat + config_.node_id;
  boot_up.length = 1;
  boot_up.data[0] = static_cast<std::uint8_t>(NmtState::initialising);
  queue_.push_boot_up(boot_up);  // the queue has just been emptied
  enter(NmtState::pre_operational);
}

void Node::receive_lss(const CanFrame& frame) noexcept {
  // who regulates is not renamed, and HOLD regulates in PRE-OPERATIONAL, too
  const bool past_init = (device_.image.status_word & word::kStateMask) != 0;
  if (state_ == NmtState::operational || past_init || reset_ != Reset::none) {
    // whoever is not served must hear all the same that the configuration of others begins
    if (frame.length == 8 && LssSlave::switches_to_waiting(frame.data)) lss_.wait();
    return;
  }
  if (frame.length != 8) {
    ++device_.counters.rejected;
    return;
  }
  ++device_.counters.received;
  SdoServer::Bytes response;
  if (lss_.request(device_, frame.data, response)) send(cob::kLssResponse, response);
  const std::uint8_t given = lss_.given_node_id();
  const bool is_named = given != 0 && given != kUnconfiguredNodeId;
  if (state_ == NmtState::initialising && lss_.is_waiting() && is_named) ask_for(Reset::communication);
}

void Node::receive_sdo(const CanFrame& frame) noexcept {
  if (frame.length != 8) {
    ++device_.counters.rejected;
    return;
  }
  ++device_.counters.received;
  const std::uint8_t came = device_.image.setpoints_came;
  SdoServer::Bytes response;
  if (sdo_.request(device_, frame.data, response)) send(cob::kSdoResponse + config_.node_id, response);
  // a master that streams by PDO is not vouched for by whoever writes a set point besides
  if (device_.image.setpoints_came != came && !streams_setpoints()) ++device_.image.setpoint_count;
}

bool Node::streams_setpoints() const noexcept {
  const std::array<Rpdo, kRpdos>& all = device_.communication.rpdo;
  return std::any_of(all.begin(), all.end(), [](const Rpdo& one) { return one.watched && one.feeds; });
}

void Node::send(std::uint32_t id, const SdoServer::Bytes& bytes) noexcept {
  if (!queue_.push_sdo(eight_bytes(id, bytes))) ++device_.counters.queue_overflow;
}

bool Node::next_frame(CanFrame& frame) noexcept {
  if (queue_.pop(frame)) return true;
  SdoServer::Bytes segment;
  if (!sdo_.next_segment(device_, segment)) return false;
  frame = eight_bytes(cob::kSdoResponse + config_.node_id, segment);
  return true;
}

bool Node::is_tpdo(const CanFrame& frame) const noexcept {
  const std::array<Tpdo, kTpdos>& all = device_.communication.tpdo;
  return std::any_of(all.begin(), all.end(), [&frame](const Tpdo& one) {
    return is_valid(one.parameters) && (one.parameters.cob_id & cob::kIdMask) == frame.id;
  });
}

void Node::receive_heartbeat(const CanFrame& frame) noexcept {
  const HeartbeatConsumer::Heard heard = device_.communication.heartbeats.hear(
      static_cast<std::uint8_t>(frame.id - cob::kHeartbeat), std::span(frame.data).first(frame.length));
  if (heard == HeartbeatConsumer::Heard::taken) ++device_.counters.received;
  if (heard == HeartbeatConsumer::Heard::malformed) ++device_.counters.rejected;
}

void Node::receive_sync(const CanFrame& frame) noexcept {
  // without 1019h empty or with a counter that says nothing; with it counting from 1 to 1019h
  const std::uint8_t overflow = device_.communication.sync_overflow;
  const std::uint8_t counter = frame.data[0];
  if (frame.length > 1 || (overflow != 0 && (frame.length == 0 || counter == 0 || counter > overflow))) {
    ++device_.counters.rejected;
    sync_misfits_.happens();
    return;
  }
  ++device_.counters.received;
  ++device_.counters.sync;
  if (state_ != NmtState::operational) return;
  ++device_.image.sync_count;
  for (Rpdo& rpdo : device_.communication.rpdo) {
    if (rpdo.latched) apply(rpdo);
  }
  for (Tpdo& tpdo : device_.communication.tpdo) {
    const PdoParameters& parameters = tpdo.parameters;
    if (!is_valid(parameters) || !is_synchronous(parameters)) continue;
    tpdo.sync_started =
        tpdo.sync_started || overflow == 0 || parameters.sync_start == 0 || counter == parameters.sync_start;
    if (!tpdo.sync_started) continue;
    ++tpdo.sync_count;
    if (tpdo.sync_count < parameters.transmission_type)
      continue;  // type 0: with any SYNC, when the value has changed
    tpdo.sync_count = 0;
    tpdo.due = true;
  }
}

void Node::receive_pdo(Rpdo& rpdo, const CanFrame& frame) noexcept {
  const Mapping& mapping = rpdo.parameters().mapping;
  const bool too_short = frame.length < mapping.bytes;
  if (too_short) pdo_short_.happens();
  // checked on arrival: a bad frame must not displace the good one that waits for its SYNC
  if (mapping.count == 0 || too_short || !admissible(mapping, frame.data)) {
    ++device_.counters.rejected;
    return;
  }
  // CiA 301: of a longer one the beginning is taken, as masters that pad their frames expect
  if (frame.length > mapping.bytes) pdo_long_.happens();
  ++device_.counters.received;
  rpdo.data = frame.data;
  if (is_synchronous(rpdo.parameters())) {
    rpdo.latched = true;
    rpdo.latched_us = 0;
  } else {
    apply(rpdo);
  }
}

/// What was ordered so long ago that its SYNC was lost, or its master, must not move the machine with somebody else's.
void Node::forget_old_orders(std::uint32_t elapsed_us) noexcept {
  constexpr std::uint32_t kLongestWait_us = 1'000'000;
  const std::uint32_t period_us = std::min(device_.communication.cycle_period_us, UINT32_MAX / 2);
  const std::uint32_t longest_us = std::max(kLongestWait_us, 2 * period_us);
  for (Rpdo& rpdo : device_.communication.rpdo) {
    if (!rpdo.latched) continue;
    rpdo.latched_us = add_saturating(rpdo.latched_us, elapsed_us);
    rpdo.latched = rpdo.latched_us <= longest_us;
  }
}

void Node::apply(Rpdo& rpdo) noexcept {
  const Mapping& mapping = rpdo.parameters().mapping;
  std::size_t at = 0;
  for (std::size_t i = 0; i < mapping.count; ++i) {
    const MappedObject& object = mapping.object[i];
    const std::uint32_t bits = load_le(std::span(rpdo.data).subspan(at, object.bytes));
    // no object that an RPDO may carry refuses an admissible value
    static_cast<void>(object.entry->write_value(device_, {object.instance, object.sub}, bits));
    at += object.bytes;
  }
  rpdo.latched = false;
  // a stream that goes on with something else has ended, too
  const bool carries = carries_setpoint(mapping);
  if (rpdo.watched && rpdo.feeds && !carries) return;
  rpdo.watched = rpdo.came = true;
  rpdo.feeds = carries;
  rpdo.silence.end();
  if (!carries) return;
  // a stream that goes on does not vouch for one that has ended
  std::array<Rpdo, kRpdos>& all = device_.communication.rpdo;
  const auto missing = [](const Rpdo& one) { return one.watched && !one.came && one.feeds; };
  if (std::any_of(all.begin(), all.end(), missing)) return;
  for (Rpdo& one : all) one.came = false;
  ++device_.image.setpoint_count;
}

void Node::work_off_reset() noexcept {
  constexpr int kWorkATick = 130;
  for (Work work(kWorkATick); is_resetting() && work.is_left();) go_on(work);
}

void Node::tick(std::uint32_t elapsed_us) noexcept {
  work_off_reset();
  forget_old_orders(elapsed_us);
  watch_setpoints(elapsed_us);
  watch_heartbeats(elapsed_us);
  device_.image.pdo_short = pdo_short_.elapse(elapsed_us);
  device_.image.pdo_long = pdo_long_.elapse(elapsed_us);
  device_.image.sync_misfits = sync_misfits_.elapse(elapsed_us);
  // before 1029h may stop the node, which tells of nothing then
  if (state_ != NmtState::initialising && state_ != NmtState::stopped) errors_.step(device_, queue_);
  obey_error_behaviour();
  if (device_.image.bus_off) forget_unsent_tpdos();
  SdoServer::Bytes lss_response;
  if (lss_.elapse(device_, elapsed_us, lss_response)) send(cob::kLssResponse, lss_response);
  // in every state, for a done order is to be taken away; no transfer that could be answered lives on outside of the two that have SDO
  SdoServer::Bytes response;
  if (sdo_.elapse(device_, elapsed_us, response)) send(cob::kSdoResponse + config_.node_id, response);
  if (state_ == NmtState::initialising) return;
  beat(elapsed_us);
  if (state_ == NmtState::operational) {
    for (std::size_t number = 0; number < kTpdos; ++number) transmit_pdo(number, elapsed_us);
  }
}

/// Runs in every NMT state: a stream that ends because the master stopped this node has ended all the same.
/// Only while 6040h asks for ACTIVE is its end an error; a stream then is watched from its first frame on.
void Node::watch_setpoints(std::uint32_t elapsed_us) noexcept {
  const bool active = (device_.image.control_word & word::kStateMask) == word::kActive;
  const bool excites = device_.image.control_mode == ControlMode::excitation;  // which needs no set points
  bool lost = false;
  for (Rpdo& rpdo : device_.communication.rpdo) {
    if (!active || (excites && rpdo.feeds)) rpdo.watched = false;
    const std::uint32_t deadline_us = 1000U * rpdo.parameters().event_timer_ms;
    const bool is_due = rpdo.watched && deadline_us != 0;
    const std::uint32_t silent_us = rpdo.silence.elapse(is_due ? elapsed_us : 0);
    lost = lost || (is_due && silent_us > deadline_us);
  }
  device_.image.setpoint_lost = lost || setpoint_watch_ended_;
  setpoint_watch_ended_ = false;
}

void Node::watch_heartbeats(std::uint32_t elapsed_us) noexcept {
  const bool lost = device_.communication.heartbeats.elapse(elapsed_us);
  device_.image.heartbeat_lost = lost || heartbeat_watch_ended_;
  heartbeat_watch_ended_ = false;
}

/// 1029h acts when the error comes, so that a master may start the node again while it stands.
void Node::obey_error_behaviour() noexcept {
  const ProcessImage& image = device_.image;
  const bool communication = image.heartbeat_lost || image.bus_off;
  const bool device = image.error_code != 0 && (image.status_word & word::kReady) == 0;
  if (communication && !communication_failed_) obey(device_.communication.on_communication_error);
  if (device && !device_failed_) obey(device_.communication.on_device_error);
  communication_failed_ = communication;
  device_failed_ = device;
}

void Node::obey(ErrorBehaviour behaviour) noexcept {
  if (state_ != NmtState::operational) return;
  switch (behaviour) {
    case ErrorBehaviour::pre_operational:
      return enter(NmtState::pre_operational);
    case ErrorBehaviour::no_change:
      return;
    case ErrorBehaviour::stopped:
      return enter(NmtState::stopped);
  }
}

/// Nobody is to take a value of before for one of now. What a TPDO says on change it says again, as it then is.
void Node::forget_unsent_tpdos() noexcept {
  queue_.clear_pdos();
  for (Tpdo& tpdo : device_.communication.tpdo) tpdo.ever_sent = false;
}

void Node::beat(std::uint32_t elapsed_us) noexcept {
  const std::uint32_t period_us = 1000U * device_.communication.heartbeat_ms;
  if (period_us == 0) {
    since_heartbeat_us_ = 0;
    return;
  }
  since_heartbeat_us_ = add_saturating(since_heartbeat_us_, elapsed_us);
  if (since_heartbeat_us_ < period_us) return;
  since_heartbeat_us_ %= period_us;  // keeps the phase where the period is no multiple of the tick
  CanFrame frame;
  frame.id = cob::kHeartbeat + config_.node_id;
  frame.length = 1;
  frame.data[0] = static_cast<std::uint8_t>(state_);
  if (!queue_.push_heartbeat(frame)) ++device_.counters.queue_overflow;
}

void Node::transmit_pdo(std::size_t number, std::uint32_t elapsed_us) noexcept {
  Tpdo& tpdo = device_.communication.tpdo[number];
  const PdoParameters& parameters = tpdo.parameters;
  if (!is_valid(parameters) || parameters.mapping.count == 0) return;
  tpdo.since_sent_us = add_saturating(tpdo.since_sent_us, elapsed_us);
  const bool synchronous = is_synchronous(parameters);
  if (synchronous && !tpdo.due) return;

  CanFrame frame;
  pack(device_, parameters.mapping, frame.data);
  const auto changed = [&]() noexcept { return !tpdo.ever_sent || frame.data != tpdo.last; };
  if (synchronous) {
    tpdo.due = false;
    if (parameters.transmission_type == 0 && !changed()) return;
  } else {
    const bool inhibited = tpdo.ever_sent && tpdo.since_sent_us < 100U * parameters.inhibit_100us;
    // the longest pause: a tick later it would be exceeded
    const std::uint32_t longest_us = 1000U * parameters.event_timer_ms;
    const bool expired = longest_us != 0 && add_saturating(tpdo.since_sent_us, config::kTick_us) > longest_us;
    if (inhibited || !(expired || changed())) return;
  }
  frame.id = parameters.cob_id & cob::kIdMask;
  frame.length = parameters.mapping.bytes;
  tpdo.last = frame.data;
  tpdo.ever_sent = true;
  tpdo.since_sent_us = 0;
  if (!queue_.put_pdo(number, frame)) ++device_.counters.pdo_overwritten;
}

}  // namespace plenum::canopen
