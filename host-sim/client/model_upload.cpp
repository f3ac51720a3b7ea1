// Session::upload_models(): stage, wait for the board's comparison, commit, read back.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "host-sim/client/abort_text.hpp"
#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {
namespace {

using canopen::Abort;
using plenum::config::ImageError;
using plenum::config::SetPhase;
namespace object = canopen::object;

constexpr double kPoll_s = 0.01;
/// Four times what a comparison of eight full logs takes (firmware/shadow_run.hpp).
constexpr double kCheckTimeout_s = 10.0;

bool is(const SdoAbort& abort, Abort code) {
  return abort.code == static_cast<std::uint32_t>(code);
}

/// Name of a parameter of the image's own kind.
std::string parameter_name(std::span<const std::uint8_t> image, std::size_t number) {
  constexpr std::size_t kKindAt = 8;
  if (image.size() >= kKindAt + 2) {
    const auto kind = static_cast<plenum::config::ModelKind>(canopen::load_le(image.subspan(kKindAt, 2)));
    const auto schema = plenum::config::parameter_schema(kind);
    if (number < schema.size()) return schema[number].name;
  }
  return fmt::format("parameter {}", number);
}

std::string where(const Session& session, const ModelUpload& upload) {
  return fmt::format("node {} chamber {}", session.node_id(), upload.chamber + 1);
}

/// Where a model has failed on the grid of its chamber: sub-indices 14 to 18 of its state.
struct FailingPoint {
  double pressure_kPa, volume_mL, command_V, wanted_kPa, came_kPa;
};

FailingPoint failing_point(Session& session, std::uint16_t state) {
  const auto number = [&](std::uint8_t sub) { return static_cast<double>(session.read<float>(state, sub)); };
  return {number(14) / 1e3, number(15) * 1e6, number(16), number(17) / 1e3, number(18) / 1e3};
}

std::string of_another(const char* what, std::uint32_t stated, std::uint32_t built_in) {
  return fmt::format("it is of {} {}, the board has {}", what, stated, built_in);
}

/// Of an image; none of one that is too short for them.
Serials stated_serials(std::span<const std::uint8_t> image) {
  constexpr std::size_t kValveAt = 20, kSensorAt = 24, kEnd = 28;
  if (image.size() < kEnd) return {};
  return {canopen::load_le(image.subspan(kValveAt, 4)), canopen::load_le(image.subspan(kSensorAt, 4))};
}

/// Before a byte of it is sent; the board would find it out when all images are there.
void require_serials(Session& session, const ModelUpload& upload) {
  const Serials stated = stated_serials(upload.image);
  if (stated.valve == 0 && stated.sensor == 0) return;
  const Serials built_in = read_serials(session, upload.chamber);
  const auto require = [&](const char* what, std::uint32_t of_image, std::uint32_t of_board) {
    if (of_image == 0 || of_board == 0 || of_image == of_board) return;
    throw Refused(fmt::format("{}: model refused: {}; to be committed with force only",
                              where(session, upload), of_another(what, of_image, of_board)));
  };
  require("valve", stated.valve, built_in.valve);
  require("sensor", stated.sensor, built_in.sensor);
}

/// Why the board does not take the image: a clause for a person.
std::string refusal(Session& session, const ModelUpload& upload, ImageError error) {
  const std::uint16_t state = object::nth(object::kSetState, upload.chamber);
  switch (error) {
    case ImageError::out_of_range:
    case ImageError::not_finite:
    case ImageError::not_admissible:
      return fmt::format("{} is {:g}, expected {:g}..{:g}",
                         parameter_name(upload.image, session.read<std::uint8_t>(state, 5)),
                         session.read<float>(state, 6), session.read<float>(state, 7),
                         session.read<float>(state, 8));
    case ImageError::predicts_worse:
      return fmt::format(
          "it predicts the board's log of the chamber with an error of {:.2f} kPa RMS, the model in force "
          "with "
          "{:.2f} kPa",
          session.read<float>(state, 10) / 1000.0F, session.read<float>(state, 11) / 1000.0F);
    case ImageError::inverse_fails: {
      const FailingPoint at = failing_point(session, state);
      return fmt::format("its inverse fails at {:.0f} kPa, {:.0f} mL, {:.2f} V: {:.1f} kPa off",
                         at.pressure_kPa, at.volume_mL, at.command_V, std::abs(at.came_kPa - at.wanted_kPa));
    }
    case ImageError::no_authority: {
      const FailingPoint at = failing_point(session, state);
      const double sign = at.wanted_kPa > at.pressure_kPa ? 1.0 : -1.0;
      return fmt::format(
          "its valve does not act: at {:.0f} kPa, {:.0f} mL, {:.2f} V {} the pressure by {:.3g} kPa a tick, "
          "expected {:.3g} at "
          "least",
          at.pressure_kPa, at.volume_mL, at.command_V, sign > 0.0 ? "raises" : "lowers",
          sign * (at.came_kPa - at.pressure_kPa), sign * (at.wanted_kPa - at.pressure_kPa));
    }
    case ImageError::wrong_serial: {
      const bool valve = session.read<std::uint8_t>(state, 5) == plenum::config::kValveSerialField;
      const Serials stated = stated_serials(upload.image);
      return of_another(valve ? "valve" : "sensor", valve ? stated.valve : stated.sensor,
                        session.read<std::uint32_t>(state, 13));
    }
    default:
      return fmt::format("the image {}", plenum::config::describe(error));
  }
}

ImageError reason(Session& session, const ModelUpload& upload) {
  return static_cast<ImageError>(
      session.read<std::uint8_t>(object::nth(object::kSetState, upload.chamber), 2));
}

SetPhase phase(Session& session, const ModelUpload& upload) {
  return static_cast<SetPhase>(session.read<std::uint8_t>(object::nth(object::kSetState, upload.chamber), 1));
}

/// The phase after `passing`, or `passing` when it has not ended in time.
SetPhase phase_after(Session& session, const ModelUpload& upload, SetPhase passing, double timeout_s) {
  const double end_s = session.link().now_s() + timeout_s;
  for (;;) {
    const SetPhase now = phase(session, upload);
    if (now != passing || session.link().now_s() >= end_s) return now;
    session.listen(kPoll_s);
  }
}

/// The board's upload session, held while models are staged and committed.
class HeldSession {
 public:
  explicit HeldSession(Session& session) : session_(session), token_(random_token()) {}
  ~HeldSession() {
    if (!held_) return;
    try {
      session_.write(object::kUploadSession, 2, token_);
    } catch (const std::exception&) {
      // it ends by itself; what is being thrown says more
    }
  }
  HeldSession(const HeldSession&) = delete;
  HeldSession& operator=(const HeldSession&) = delete;

  /// Before each set.
  void take() {
    try {
      session_.write(object::kUploadSession, 1, token_);
      held_ = true;
    } catch (const SdoAbort& abort) {
      if (!is(abort, Abort::device_state)) throw;
      throw Refused(fmt::format("node {}: another master is uploading models, for another {:.1f} s at most",
                                session_.node_id(),
                                session_.read<std::uint16_t>(object::kUploadSession, 3) / 1000.0));
    }
  }

 private:
  static std::uint32_t random_token() {
    std::random_device bits;
    return std::uniform_int_distribution<std::uint32_t>(1)(bits);
  }

  Session& session_;
  std::uint32_t token_;
  bool held_ = false;
};

using OfChamber = std::array<const ModelUpload*, kChambers>;  ///< null: none

std::uint8_t mask_of(const OfChamber& uploads) {
  unsigned mask = 0;
  for (const ModelUpload* upload : uploads) mask |= upload != nullptr ? 1U << upload->chamber : 0U;
  return static_cast<std::uint8_t>(mask);
}

/// What has become of the set, of which the board stages one image a tick: 0, or the chamber + 1 whose image was refused.
std::uint8_t await_outcome(Session& session, double timeout_s) {
  const double end_s = session.link().now_s() + timeout_s;
  for (;;) {
    const auto outcome = session.read<std::uint8_t>(object::kStagedSet, 2);
    if (outcome != object::kSetUnderWay) return outcome;
    if (session.link().now_s() >= end_s) {
      throw Timeout(
          fmt::format("node {}: the set of models was not staged within {} s", session.node_id(), timeout_s));
    }
    session.listen(kPoll_s);
  }
}

bool are_staged(Session& session, const OfChamber& uploads) {
  return std::all_of(uploads.begin(), uploads.end(), [&](const ModelUpload* upload) {
    return upload == nullptr ||
           session.read<std::uint32_t>(object::nth(object::kSetState, upload->chamber), 12) ==
               plenum::config::trailing_crc(upload->image);
  });
}

/// All images in one transfer: alone, each would take the five frames around it that a block transfer always has.
void stage(Session& session, const OfChamber& uploads, double timeout_s) {
  std::vector<std::uint8_t> set{mask_of(uploads)};
  for (const ModelUpload* upload : uploads) {
    if (upload != nullptr) set.insert(set.end(), upload->image.begin(), upload->image.end());
  }
  try {
    session.sdo_write(object::kStagedSet, 1, set);
  } catch (const SdoAbort& abort) {
    if (is(abort, Abort::length_mismatch)) {
      throw Refused(fmt::format("node {}: models refused: an image of the set {} (abort {:08X}h)",
                                session.node_id(), plenum::config::describe(ImageError::wrong_size),
                                abort.code));
    }
    if (is(abort, Abort::device_state)) {
      // a transfer that was begun again, because another master spoke into its end, may have done all the first time
      if (await_outcome(session, timeout_s) == 0 && are_staged(session, uploads)) return;
      throw Refused(fmt::format("node {}: models refused: the set {} (abort {:08X}h)", session.node_id(),
                                plenum::config::describe(ImageError::staged_by_another), abort.code));
    }
    throw;
  }
  const std::uint8_t outcome = await_outcome(session, timeout_s);
  if (outcome == 0) return;
  if (outcome > kChambers || uploads[outcome - 1U] == nullptr) {
    throw ProtocolError(fmt::format("node {}: outcome {} of a set of models, expected one of its chambers",
                                    session.node_id(), outcome));
  }
  const ModelUpload& refused = *uploads[outcome - 1U];
  throw Refused(fmt::format("{}: model refused: {}", where(session, refused),
                            refusal(session, refused, reason(session, refused))));
}

/// Why the board doubts the model: a clause for a person; empty: it does not.
std::string await_doubt(Session& session, const ModelUpload& upload) {
  const SetPhase found = phase_after(session, upload, SetPhase::checking, kCheckTimeout_s);
  if (found == SetPhase::checking) {
    throw Timeout(fmt::format("{}: the comparison with the model in force had no result within {} s",
                              where(session, upload), kCheckTimeout_s));
  }
  return found == SetPhase::doubted ? refusal(session, upload, reason(session, upload)) : std::string();
}

/// After the take-over; `crc_before` is of the image in force before it, 0: none.
Comparison read_comparison(Session& session, const ModelUpload& upload, std::uint32_t crc_before,
                           Doubted doubted) {
  using Outcome = Comparison::Outcome;
  using plenum::config::Trial;
  const std::uint16_t state = object::nth(object::kSetState, upload.chamber);
  Comparison comparison;
  if (crc_before == 0) return comparison;
  comparison.outcome = Outcome::same;
  if (crc_before == plenum::config::trailing_crc(upload.image)) return comparison;
  const auto trial = static_cast<Trial>(session.read<std::uint8_t>(state, 9));
  if (trial != Trial::passed && trial != Trial::worse) {
    comparison.outcome = doubted == Doubted::force ? Outcome::not_awaited : Outcome::no_movement;
    return comparison;
  }
  comparison.outcome = trial == Trial::passed ? Outcome::passed : Outcome::worse;
  comparison.rms_Pa = static_cast<double>(session.read<float>(state, 10));
  comparison.before_rms_Pa = static_cast<double>(session.read<float>(state, 11));
  return comparison;
}

void await_take_over(Session& session, const ModelUpload& upload, double timeout_s) {
  const SetPhase found = phase_after(session, upload, SetPhase::committed, timeout_s);
  if (found != SetPhase::active) {
    throw Timeout(fmt::format("{}: set in phase {} within {} s after the commit, expected {} (active)",
                              where(session, upload), static_cast<int>(found), timeout_s,
                              static_cast<int>(SetPhase::active)));
  }
  const std::vector<std::uint8_t> back = session.download_model(upload.chamber);
  if (back == upload.image) return;
  const auto differ = std::mismatch(back.begin(), back.end(), upload.image.begin(), upload.image.end());
  throw ProtocolError(fmt::format("{}: model read back differs at byte {} ({} bytes), expected the {} sent",
                                  where(session, upload), differ.first - back.begin(), back.size(),
                                  upload.image.size()));
}

}  // namespace

std::string caveat_of(const Comparison& comparison) {
  if (!comparison.doubt.empty()) return "taken by force: " + comparison.doubt;
  switch (comparison.outcome) {
    case Comparison::Outcome::no_model:
      return "not compared: the chamber had no model before";
    case Comparison::Outcome::no_movement:
      return "not compared with the model before: the board has no log in which the chamber's pressure moves "
             "enough";
    case Comparison::Outcome::not_awaited:
      return "not compared with the model before: the commit was forced";
    case Comparison::Outcome::same:
    case Comparison::Outcome::worse:
    case Comparison::Outcome::passed:
      break;
  }
  return {};
}

std::vector<Comparison> Session::upload_models(std::span<const ModelUpload> uploads, Doubted doubted) {
  OfChamber of_chamber{};
  for (const ModelUpload& upload : uploads) {
    if (upload.chamber >= kChambers) {
      throw std::invalid_argument(fmt::format("node {}: model for chamber {}, expected 1..{}", node_id_,
                                              upload.chamber + 1, kChambers));
    }
    if (of_chamber[upload.chamber] != nullptr) {
      throw std::invalid_argument(
          fmt::format("node {}: two models for chamber {}, expected one", node_id_, upload.chamber + 1));
    }
    of_chamber[upload.chamber] = &upload;
  }
  if (uploads.empty()) return {};

  if (doubted == Doubted::refuse) {
    for (const ModelUpload& upload : uploads) require_serials(*this, upload);
  }
  HeldSession held(*this);
  held.take();
  std::array<std::uint32_t, kChambers> crc_before{};
  for (const ModelUpload& upload : uploads)
    crc_before[upload.chamber] = read<std::uint32_t>(object::nth(object::kSetState, upload.chamber), 3);
  stage(*this, of_chamber, config_.state_timeout_s);
  const std::uint8_t mask = mask_of(of_chamber);
  std::vector<std::uint32_t> crcs;
  std::array<std::string, kChambers> doubts;
  for (const ModelUpload* upload : of_chamber) {
    if (upload == nullptr) continue;
    crcs.push_back(plenum::config::trailing_crc(upload->image));
    if (doubted == Doubted::force) continue;
    std::string& doubt = doubts[upload->chamber];
    doubt = await_doubt(*this, *upload);
    if (doubted == Doubted::refuse && !doubt.empty()) {
      throw Refused(fmt::format("{}: model refused: {}; to be committed with force only",
                                where(*this, *upload), doubt));
    }
  }
  write(object::kCommit, 1, mask);
  write(object::kCommit, 2, plenum::config::commit_crc(crcs));
  try {
    write(object::kCommit, 3,
          doubted == Doubted::refuse ? plenum::config::kCommitKey : plenum::config::kForceKey);
  } catch (const SdoAbort& abort) {
    throw Refused(fmt::format("node {}: commit of chambers {:02X}h refused (abort {:08X}h, {})", node_id_,
                              mask, abort.code, abort_text(abort.code)));
  }
  std::vector<Comparison> comparisons;
  for (const ModelUpload& upload : uploads) {
    await_take_over(*this, upload, config_.state_timeout_s);
    comparisons.push_back(read_comparison(*this, upload, crc_before[upload.chamber], doubted));
    comparisons.back().doubt = doubts[upload.chamber];
  }
  return comparisons;
}

Comparison Session::upload_model(std::uint8_t chamber, std::span<const std::uint8_t> image, Doubted doubted) {
  return upload_models(std::array{ModelUpload{chamber, {image.begin(), image.end()}}}, doubted).front();
}

}  // namespace plenum::host::client
