// How the SDO client shares a channel that is made for one.
#include <fmt/format.h>

#include <algorithm>

#include "host-sim/client/sdo_client.hpp"
#include "host-sim/client/sdo_frames.hpp"

namespace plenum::host::client {
namespace {

namespace cob = canopen::cob;

constexpr int kTries = 8;
/// Longer than a frame needs to be heard at the other end, so that of two clients the one with the shorter pause is heard by the other.
constexpr double kShortestPause_s = 0.005;
constexpr double kPause_s = 0.02;  ///< doubled with each of the first tries
constexpr int kDoublings = 3;
/// Longest pause before a transfer while another master is about, so that neither is always the first.
constexpr double kGap_s = 0.01;

bool begins_download(std::uint8_t command) {
  return (command & 0xE2U) == 0x20U || sdo::begins_block_download(command);
}

}  // namespace

void SdoClient::observe(const CanFrame& frame) {
  if (frame.extended || frame.remote) return;
  const double now_s = link_.now_s();
  if (frame.id == cob::kHeartbeat + node_id_ && frame.length == 1)
    beat_ = Beat{static_cast<canopen::NmtState>(frame.data[0] & 0x7FU), now_s};
  if (frame.length != 8) return;
  if (frame.id == cob::kSdoRequest + node_id_) {
    foreign_.hear_request(frame.data, now_s);
    if (!under_way_) return;
    const Bytes named = sdo::request(0, under_way_->index, under_way_->sub);
    disturbance_.heard = true;
    disturbance_.downloads = disturbance_.downloads || begins_download(frame.data[0]);
    disturbance_.of_our_object = disturbance_.of_our_object ||
                                 std::equal(named.begin() + 1, named.begin() + 4, frame.data.begin() + 1);
  } else if (frame.id == cob::kSdoResponse + node_id_) {
    if (!listened_ && config_.listen_first_s > 0.0) foreign_.hear_stray_answer(now_s);
    foreign_.hear_answer(frame.data, now_s);
  }
}

void SdoClient::hear(const CanFrame& frame) {
  observe(frame);
  const bool is_answer =
      !frame.extended && !frame.remote && frame.length == 8 && frame.id == cob::kSdoResponse + node_id_;
  if (heard_ && !is_answer) heard_(frame);
}

void SdoClient::listen(double duration_s) {
  const double end_s = link_.now_s() + duration_s;
  while (const auto frame = link_.receive(std::max(0.0, end_s - link_.now_s()))) hear(*frame);
}

void SdoClient::pause(double shortest_s, double longest_s) {
  listen(std::uniform_real_distribution<double>(shortest_s, longest_s)(random_));
}

/// Until no transfer of another master is under way. What has come meanwhile is taken off the link.
void SdoClient::await_channel(const Object& object) {
  listen(listened_ ? 0.0 : config_.listen_first_s);
  listened_ = true;
  const double begin_s = link_.now_s();
  if (foreign_.is_near(begin_s)) pause(0.0, kGap_s);
  while (foreign_.is_open(link_.now_s())) {
    if (link_.now_s() - begin_s >= config_.taken_timeout_s)
      give_up(object, fmt::format("waited {} s for the channel", config_.taken_timeout_s));
    pause(0.0, kGap_s);
  }
}

void SdoClient::give_up(const Object& object, const std::string& what) const {
  throw ChannelTaken(fmt::format(
      "node {}: {} {:04X}h:{}: another master talks to the board on {:03X}h, which has room for one; {}",
      node_id_, object.doing, object.index, object.sub, cob::kSdoRequest + node_id_, what));
}

/// Whether the end of our transfer may be that of another's.
bool SdoClient::is_spoilt(Outcome outcome) const {
  const bool was_one_exchange = answers_ == 1 && outcome != Outcome::failed;
  if (was_one_exchange) return disturbance_.of_our_object;
  // of what another may have done, only a download ends as a download does
  return outcome == Outcome::written ? disturbance_.downloads : disturbance_.heard;
}

void SdoClient::share(const Object& object, Outcome wanted, const std::function<void()>& transfer) {
  for (int tries = 1;; ++tries) {
    await_channel(object);
    under_way_ = object;
    answers_ = 0;
    disturbance_ = {};
    std::string what = "its requests came between ours";
    try {
      transfer();
      under_way_.reset();
      if (!is_spoilt(wanted)) return;
    } catch (const std::runtime_error& error) {
      under_way_.reset();
      const bool was_aborted = dynamic_cast<const SdoAbort*>(&error) != nullptr;
      if (!is_spoilt(was_aborted ? Outcome::aborted : Outcome::failed)) throw;
      what = error.what();
    }
    if (tries == kTries) give_up(object, fmt::format("{} tries, the last: {}", tries, what));
    pause(kShortestPause_s, kShortestPause_s + kPause_s * (1 << std::min(tries, kDoublings)));
  }
}

}  // namespace plenum::host::client
