// A node on the test bench: frames are written as a bus monitor prints them, "605 40 00 10 00 00 00 00 00".
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/canopen/node.hpp"

namespace plenum::canopen {

/// Judges an image when it is told to: takes any but one that starts with EEh. Commits when the CRC is that of the staged ones.
class FakeDesk final : public config::ModelDesk {
 public:
  config::ImageError hand_in(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept override {
    if (not_let_in != config::ImageError::none) return not_let_in;
    ++hand_ins;
    judged = {.pending = true, .verdict = {}};
    of_chamber = chamber;
    waiting.assign(image.begin(), image.end());
    return config::ImageError::none;
  }
  config::ImageJudgement judgement() const noexcept override { return judged; }
  /// As at a tick's edge.
  void judge() {
    if (!judged.pending) return;
    judged.pending = false;
    if (!waiting.empty() && waiting[0] == 0xEE) {
      judged.verdict = {refusal, 2, refused_value, 1.0F, 5.0F};
    } else {
      staged[of_chamber] = waiting;
    }
  }
  std::span<const std::uint8_t> active_image(std::uint8_t chamber) const noexcept override {
    return active[chamber];
  }
  config::CommitResult commit(std::uint8_t mask, std::uint32_t crc, std::uint32_t key) noexcept override {
    if (key != config::kCommitKey) return config::CommitResult::wrong_key;
    if (mask == 0) return config::CommitResult::nothing_staged;
    if (held_back != config::CommitResult::accepted) return held_back;
    std::vector<std::uint32_t> crcs;
    for (std::size_t c = 0; c < config::kChambers; ++c) {
      if ((std::uint32_t{mask} >> c & 1U) != 0) crcs.push_back(config::trailing_crc(staged[c]));
    }
    if (crc != config::commit_crc(crcs)) return config::CommitResult::wrong_crc;
    for (std::size_t c = 0; c < config::kChambers; ++c) {
      if ((std::uint32_t{mask} >> c & 1U) != 0) active[c] = staged[c];
    }
    ++commits;
    return config::CommitResult::accepted;
  }
  config::SetHandIn hand_in(std::span<const std::uint8_t> set) noexcept override {
    handed_in.assign(set.begin(), set.end());
    return hand_in_result;
  }
  config::SetProgress set_progress() const noexcept override { return progress; }
  config::SetState state(std::uint8_t chamber) const noexcept override {
    config::SetState state;
    state.phase = config::SetPhase::refused;
    state.refusal = {config::ImageError::out_of_range, 2, 7.0F, 1.0F, 5.0F};
    state.active_crc = 0x11223344U + chamber;
    state.generation = 9;
    state.trial = {config::Trial::worse, 3.5F, 1.25F};
    state.staged_crc = 0x55667788U;
    state.expected_serial = 4711;
    return state;
  }
  config::ModelPoint failing_point(std::uint8_t) const noexcept override {
    return {430.0F, 120.0F, 5.5F, 450.0F, 437.5F};
  }

  void forget_staged() noexcept override {
    for (auto& image : staged) image.clear();
    session.end();
  }
  config::UploadSession& upload_session() noexcept override { return session; }
  const config::UploadSession& upload_session() const noexcept override { return session; }

  config::UploadSession session;
  config::ImageError not_let_in = config::ImageError::none;
  config::ImageError refusal = config::ImageError::bad_crc;
  float refused_value = 7.0F;
  config::CommitResult held_back = config::CommitResult::accepted;
  config::SetHandIn hand_in_result = config::SetHandIn::taken;
  config::SetProgress progress;
  std::vector<std::uint8_t> handed_in;
  int hand_ins = 0;
  config::ImageJudgement judged;
  std::uint8_t of_chamber = 0;
  std::vector<std::uint8_t> waiting;
  int commits = 0;
  std::array<std::vector<std::uint8_t>, config::kChambers> staged;
  std::array<std::vector<std::uint8_t>, config::kChambers> active;
};

inline ports::CanFrame frame_from(const std::string& text) {
  std::istringstream in(text);
  ports::CanFrame frame;
  in >> std::hex >> frame.id;
  for (unsigned byte = 0; in >> byte;) frame.data.at(frame.length++) = static_cast<std::uint8_t>(byte);
  return frame;
}

inline std::string text_of(const ports::CanFrame& frame) {
  std::array<char, 8> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%03X", frame.id);
  std::string text = buffer.data();
  for (std::size_t i = 0; i < frame.length; ++i) {
    std::snprintf(buffer.data(), buffer.size(), " %02X", frame.data[i]);
    text += buffer.data();
  }
  return text;
}

using Frames = std::vector<std::string>;

/// Node 5. The boot-up message is already taken away.
struct Bench {
  ProcessImage image;
  FakeDesk desk;
  config::SettingsDesk settings;
  telemetry::Recorder recorder;
  Node node;

  explicit Bench(bool operational = false)
      : node(Config{.node_id = 5,
                    .identity = {.vendor_id = 0x11, .product_code = 0x22, .revision = 0x33, .serial = 0x44}},
             image, desk, settings, recorder) {
    drain();
    if (operational) {
      send("000 01 05");
      tick();
      drain();
    }
  }

  void send(const std::string& text) { node.receive(frame_from(text)); }
  void tick(int times = 1) {
    for (int i = 0; i < times; ++i) {
      desk.judge();
      node.tick(10'000);
    }
  }
  Frames drain() {
    Frames frames;
    for (ports::CanFrame frame; node.next_frame(frame);) frames.push_back(text_of(frame));
    return frames;
  }
  /// What the node says at once to one frame; empty when it says nothing.
  std::string answer(const std::string& text) {
    send(text);
    const Frames frames = drain();
    return frames.empty() ? "" : frames.size() == 1 ? frames[0] : "more than one frame";
  }
  /// What it says in the next tick to one frame that it says nothing to at once.
  std::string answer_in_tick(const std::string& text) {
    if (const std::string said = answer(text); !said.empty()) return "at once: " + said;
    tick();
    const Frames frames = drain();
    return frames.size() == 1 ? frames[0] : "no or more than one frame";
  }
};

}  // namespace plenum::canopen
