// Objects 2100h..212Fh (own): model images, their commit, the state of the sets.
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/config/units.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::canopen::dictionary {

inline Abort read_schema_hash(const Device&, Place, std::uint32_t& bits) noexcept {
  bits = config::schema_hash(config::ModelKind::tassa9);
  return Abort::none;
}

inline Abort read_schema_count(const Device&, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(config::required_count(config::ModelKind::tassa9));
  return Abort::none;
}

/// 1: IEEE 754 binary32, 2: fixed point.
inline constexpr std::uint32_t kScalarFormat = std::is_same_v<numeric::Scalar, float> ? 1 : 2;

/// It is judged at the tick's edge: some thousand instructions that no frame is to cost.
inline Abort write_staged_model(Device& device, Place at, std::span<const std::uint8_t> image) noexcept {
  switch (device.desk.hand_in(at.instance, image)) {
    case config::ImageError::none:
      return Abort::pending;
    case config::ImageError::commit_pending:
    case config::ImageError::staged_by_another:
      return Abort::device_state;
    default:
      return Abort::cannot_store;
  }
}

inline Abort staged_model_outcome(const Device& device, Place) noexcept {
  const config::ImageJudgement judgement = device.desk.judgement();
  if (judgement.pending) return Abort::pending;
  const config::ImageVerdict& verdict = judgement.verdict;
  switch (verdict.error) {
    case config::ImageError::none:
      return Abort::none;
    case config::ImageError::out_of_range:
      return verdict.value > verdict.high ? Abort::value_too_high : Abort::value_too_low;
    case config::ImageError::not_finite:
    case config::ImageError::not_admissible:
      return Abort::value_range;
    default:
      return Abort::cannot_store;
  }
}

inline Abort write_staged_set(Device& device, Place, std::span<const std::uint8_t> set) noexcept {
  switch (device.desk.hand_in(set)) {
    case config::SetHandIn::taken:
      return Abort::none;
    case config::SetHandIn::malformed:
      return Abort::length_mismatch;
    case config::SetHandIn::not_now:
      return Abort::device_state;
  }
  return Abort::general;
}

inline Abort read_set_outcome(const Device& device, Place, std::uint32_t& bits) noexcept {
  const config::SetProgress progress = device.desk.set_progress();
  bits = progress.staging ? object::kSetUnderWay : progress.refused;
  return Abort::none;
}

inline std::span<const std::uint8_t> read_active_model(const Device& device, Place at) noexcept {
  return device.desk.active_image(at.instance);
}

inline Abort write_commit_key(Device& device, Place, std::uint32_t key) noexcept {
  Communication& communication = device.communication;
  const config::CommitResult result =
      device.desk.commit(communication.commit_mask, communication.commit_crc, key);
  // one commit for one mask and CRC: a replayed key finds an empty mask. Who is told to wait need but write the key again.
  const bool waits = result == config::CommitResult::checking || result == config::CommitResult::not_now;
  if (!waits) {
    communication.commit_mask = 0;
    communication.commit_crc = 0;
  }
  switch (result) {
    case config::CommitResult::accepted:
      return Abort::none;
    case config::CommitResult::wrong_key:
      return Abort::value_range;
    case config::CommitResult::nothing_staged:
    case config::CommitResult::wrong_crc:
    case config::CommitResult::doubted:
      return Abort::cannot_store;
    case config::CommitResult::checking:
    case config::CommitResult::not_now:
      return Abort::device_state;
  }
  return Abort::general;
}

inline Abort read_set_state(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const config::SetState state = device.desk.state(at.instance);
  switch (at.sub) {
    case 1:
      bits = static_cast<std::uint32_t>(state.phase);
      break;
    case 2:
      bits = static_cast<std::uint32_t>(state.refusal.error);
      break;
    case 3:
      bits = state.active_crc;
      break;
    case 4:
      bits = state.generation;
      break;
    case 5:
      bits = state.refusal.parameter;
      break;
    case 6:
      bits = bits_of(state.refusal.value);
      break;
    case 7:
      bits = bits_of(state.refusal.low);
      break;
    case 8:
      bits = bits_of(state.refusal.high);
      break;
    case 9:
      bits = static_cast<std::uint32_t>(state.trial.outcome);
      break;
    case 10:
      bits = bits_of(state.trial.staged_rms_kPa * config::kPascal_per_kPa);
      break;
    case 11:
      bits = bits_of(state.trial.active_rms_kPa * config::kPascal_per_kPa);
      break;
    case 12:
      bits = state.staged_crc;
      break;
    default:
      bits = state.expected_serial;
      break;
  }
  return Abort::none;
}

inline Abort read_failing_point(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const config::ModelPoint point = device.desk.failing_point(at.instance);
  switch (at.sub) {
    case 14:
      bits = bits_of(point.pressure_kPa * config::kPascal_per_kPa);
      break;
    case 15:
      bits = bits_of(point.volume_mL * config::kM3_per_mL);
      break;
    case 16:
      bits = bits_of(point.command_V);
      break;
    case 17:
      bits = bits_of(point.wanted_kPa * config::kPascal_per_kPa);
      break;
    default:
      bits = bits_of(point.came_kPa * config::kPascal_per_kPa);
      break;
  }
  return Abort::none;
}

inline Abort read_upload_session(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const config::UploadSession& session = device.desk.upload_session();
  constexpr std::uint32_t kTick_ms = config::kTick_us / 1000;
  bits = at.sub == 1 ? session.owner() : session.left_ticks() * kTick_ms;
  return Abort::none;
}

inline Abort take_upload_session(Device& device, Place, std::uint32_t token) noexcept {
  if (token == 0) return Abort::value_range;
  return device.desk.upload_session().take(token) ? Abort::none : Abort::device_state;
}

inline Abort release_upload_session(Device& device, Place, std::uint32_t token) noexcept {
  return device.desk.upload_session().release(token) ? Abort::none : Abort::device_state;
}

constexpr std::size_t kTrailingCrcBytes = 4;

/// Sub-index k is the k-th parameter of the model's schema, as it stands in the image in force.
inline Abort read_model_parameter(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const std::span<const std::uint8_t> image = device.desk.active_image(at.instance);
  const std::size_t begin = config::kImageHeaderBytes + std::size_t{4} * (at.sub - 1U);
  if (begin + 4 + kTrailingCrcBytes > image.size()) return Abort::no_data;
  bits = load_le(image.subspan(begin, 4));
  return Abort::none;
}

inline Abort read_serial(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const config::ChamberSettings& chamber = device.settings.chamber(at.instance);
  bits = at.sub == 1 ? chamber.valve_serial : chamber.sensor_serial;
  return Abort::none;
}

inline constexpr Entry kModelRows[] = {
    highest<3>(0x2100, kOnce, "Model schema"),
    value(0x2100, 1, kOnce, "Schema hash", unsigned32, constant, no, kAny, read_schema_hash),
    value(0x2100, 2, kOnce, "Parameter count", unsigned16, constant, no, kAny, read_schema_count),
    value(0x2100, 3, kOnce, "Scalar format", unsigned8, constant, no, kAny, fixed<kScalarFormat>),
    waiting_for(staged_model_outcome, domain_taken(0x2110, kChambersNext, "Staged model image",
                                                   config::kMaxImageBytes, write_staged_model)),
    bytes(0x2118, kChambersNext, "Active model image", domain, read_only, read_active_model),
    highest<3>(0x2120, kOnce, "Commit of staged models"),
    value(0x2120, 1, kOnce, "Commit: chamber mask", unsigned8, read_write, no, kAny,
          read_communication<&Communication::commit_mask>, write_communication<&Communication::commit_mask>),
    value(0x2120, 2, kOnce, "Commit: CRC-32 of the images' CRCs", unsigned32, read_write, no, kAny,
          read_communication<&Communication::commit_crc>, write_communication<&Communication::commit_crc>),
    value(0x2120, 3, kOnce, "Commit: key", unsigned32, write_only, no, kAny, nullptr, write_commit_key),
    highest<3>(0x2121, kOnce, "Upload session"),
    value(0x2121, 1, kOnce, "Upload session: token of its owner", unsigned32, read_write, no, kAny,
          read_upload_session, take_upload_session),
    value(0x2121, 2, kOnce, "Upload session: release by token", unsigned32, write_only, no, kAny, nullptr,
          release_upload_session),
    value(0x2121, 3, kOnce, "Upload session: time left [ms]", unsigned16, read_only, no, kAny,
          read_upload_session),
    highest<2>(object::kStagedSet, kOnce, "Staged models of several chambers"),
    at_sub(1, domain_taken(object::kStagedSet, kOnce, "Mask and model images", config::kMaxSetBytes,
                           write_staged_set)),
    value(object::kStagedSet, 2, kOnce,
          "Outcome (0 staged, 1 to 8 none: that chamber's refused, 255 under way)", unsigned8, read_only, no,
          kAny, read_set_outcome),
    highest<18>(0x2128, kChambersNext, "State of the parameter set"),
    value(0x2128, 1, kChambersNext,
          "State (0 no model, 1 active, 2 staged, 3 committed, 4 refused, 5 checking, 6 doubted)", unsigned8,
          read_only, no, kAny, read_set_state),
    value(0x2128, 2, kChambersNext, "Reason of refusal", unsigned8, read_only, no, kAny, read_set_state),
    value(0x2128, 3, kChambersNext, "CRC of the active image", unsigned32, read_only, no, kAny,
          read_set_state),
    value(0x2128, 4, kChambersNext, "Generation", unsigned32, read_only, no, kAny, read_set_state),
    value(0x2128, 5, kChambersNext, "Refused parameter", unsigned8, read_only, no, kAny, read_set_state),
    value(0x2128, {6, 8}, kChambersNext, "Refused value, its low and high limit", real32, read_only, no, kAny,
          read_set_state),
    value(0x2128, 9, kChambersNext, "Shadow run (0 none, 1 running, 2 not compared, 3 passed, 4 worse)",
          unsigned8, read_only, no, kAny, read_set_state),
    value(0x2128, {10, 11}, kChambersNext, "RMS error of the staged, of the active model over the log [Pa]",
          real32, read_only, no, kAny, read_set_state),
    value(0x2128, 12, kChambersNext, "CRC of the staged image", unsigned32, read_only, no, kAny,
          read_set_state),
    value(0x2128, 13, kChambersNext, "Serial number expected", unsigned32, read_only, no, kAny,
          read_set_state),
    value(0x2128, 14, kChambersNext, "Failing point: pressure [Pa]", real32, read_only, no, kAny,
          read_failing_point),
    value(0x2128, 15, kChambersNext, "Failing point: volume [m3]", real32, read_only, no, kAny,
          read_failing_point),
    value(0x2128, 16, kChambersNext, "Failing point: command [V]", real32, read_only, no, kAny,
          read_failing_point),
    value(0x2128, {17, 18}, kChambersNext, "Failing point: pressure asked for, that came [Pa]", real32,
          read_only, no, kAny, read_failing_point),
};

inline constexpr Entry kModelParameterRows[] = {
    highest<config::kMaxParameters>(0x2140, kChambersNext, "Parameters of the active model"),
    value(0x2140, {1, config::kMaxParameters}, kChambersNext, "Parameter", real32, read_only, no, kAny,
          read_model_parameter),
    highest<2>(object::kSerials, kChambersNext, "Serial numbers of what is built in"),
    value(object::kSerials, 1, kChambersNext, "Serial number of the valve (0: not stated)", unsigned32,
          read_only, no, kAny, read_serial),
    value(object::kSerials, 2, kChambersNext, "Serial number of the pressure sensor (0: not stated)",
          unsigned32, read_only, no, kAny, read_serial),
};

}  // namespace plenum::canopen::dictionary
