// Block transfers over a channel that loses, doubles and swaps frames, driven by a small client that knows CiA 301 and not
// the code under test. Whatever happens a transfer ends, and what is taken is whole.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <random>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

using ports::CanFrame;
using Data = std::vector<std::uint8_t>;
using Payload = std::array<std::uint8_t, 8>;

/// CRC-16-CCITT bit by bit, as its polynomial is written.
std::uint16_t crc_of(const Data& data) {
  unsigned crc = 0;
  for (const std::uint8_t byte : data) {
    crc ^= unsigned{byte} << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? (crc << 1 ^ 0x1021U) : crc << 1;
  }
  return static_cast<std::uint16_t>(crc);
}

struct Channel {
  std::mt19937 random;
  double fault_rate;
  bool spares_first =
      false;  ///< of the frames that come together: what is said alone, and one segment, arrive

  std::vector<CanFrame> pass(const std::vector<CanFrame>& frames) {
    std::vector<CanFrame> passed;
    bool passed_twice = false;  // no bus lets anything come between a frame and its double
    const std::size_t spared = spares_first ? 1 : 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const double draw = i < spared ? 0.5 : std::uniform_real_distribution<>()(random);
      const bool lost = draw < fault_rate / 2;
      const bool doubled = !lost && draw < fault_rate * 0.75;
      const bool overtakes = draw > 1.0 - fault_rate / 4 && passed.size() > spared && !passed_twice;
      if (!lost) passed.push_back(frames[i]);
      if (doubled) passed.push_back(frames[i]);
      if (overtakes) std::swap(passed.back(), passed[passed.size() - 2]);
      passed_twice = doubled;
    }
    return passed;
  }
};

enum class End { none, complete, aborted };

struct Client {
  static constexpr int kPatience = 120;  ///< ticks without an answer
  std::vector<CanFrame> out;
  int silence = 0;
  End end = End::none;

  virtual ~Client() = default;
  virtual void take(const Payload& answer) = 0;
  virtual void wait() {}

  void say(const Payload& data) {
    CanFrame frame;
    frame.id = 0x605;
    frame.length = 8;
    frame.data = data;
    out.push_back(frame);
  }
  void give_up() {
    say({0x80, 0, 0, 0, 0, 0, 4, 5});
    end = End::aborted;
  }
  void hear(const std::vector<CanFrame>& frames) {
    ++silence;
    const CanFrame* before = nullptr;
    for (const CanFrame& frame : frames) {
      const bool doubled = before != nullptr && *before == frame;
      before = &frame;
      if (doubled || end != End::none) continue;
      silence = 0;
      if (frame.data[0] == 0x80) {
        end = End::aborted;
      } else {
        take(frame.data);
      }
    }
    if (end != End::none) return;
    wait();
    if (silence > kPatience) give_up();
  }
};

/// Writes `data` to 2110h.
struct Downloader : Client {
  Data data;
  std::size_t confirmed = 0;  ///< segments

  explicit Downloader(Data bytes) : data(std::move(bytes)) {
    say({0xC6, 0x10, 0x21, 0, static_cast<std::uint8_t>(data.size()), 0, 0, 0});
  }
  std::size_t segments() const { return (data.size() + 6) / 7; }
  void send_block(std::size_t block_size) {
    for (std::size_t n = 1; n <= block_size && confirmed + n <= segments(); ++n) {
      const std::size_t at = 7 * (confirmed + n - 1);
      Payload payload{static_cast<std::uint8_t>(n | (confirmed + n == segments() ? 0x80U : 0U))};
      std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(at), std::min<std::size_t>(7, data.size() - at),
                  payload.begin() + 1);
      say(payload);
    }
  }
  void take(const Payload& answer) override {
    if (answer[0] == 0xA4) {
      send_block(answer[4]);
    } else if (answer[0] == 0xA2) {
      confirmed += answer[1];
      if (confirmed > segments()) {
        give_up();
      } else if (confirmed < segments()) {
        send_block(answer[2]);
      } else {
        const std::uint16_t crc = crc_of(data);
        say({static_cast<std::uint8_t>(0xC1U | (7 * segments() - data.size()) << 2),
             static_cast<std::uint8_t>(crc), static_cast<std::uint8_t>(crc >> 8), 0, 0, 0, 0, 0});
      }
    } else {
      end = answer[0] == 0xA1 ? End::complete : End::aborted;
    }
  }
};

/// Reads 2118h with block sizes of its own choice.
struct Uploader : Client {
  std::mt19937 random;
  Data data;
  std::uint8_t block_size = 0;
  std::uint8_t taken = 0;  ///< of this sub-block
  Payload last_word{};

  explicit Uploader(unsigned seed) : random(seed) {
    choose();
    say({0xA4, 0x18, 0x21, 0, block_size, 0, 0, 0});
  }
  void choose() {
    block_size = static_cast<std::uint8_t>(std::uniform_int_distribution<>(1, 127)(random) % 13 + 1);
  }
  void confirm() {
    choose();
    last_word = {0xA2, taken, block_size};
    taken = 0;
    say(last_word);
  }
  void take(const Payload& answer) override {
    const bool in_block = last_word[0] != 0;
    if (!in_block && answer[0] == 0xC6) {
      last_word = {0xA3};
      say(last_word);
    } else if (in_block && (answer[0] & 0xE3U) == 0xC1U && last_taken) {
      data.resize(data.size() - (answer[0] >> 2 & 7U));
      const bool whole = crc_of(data) == (answer[1] | answer[2] << 8);
      end = whole ? End::complete : End::aborted;
      say(whole ? Payload{0xA1} : Payload{0x80, 0, 0, 0, 4, 0, 4, 5});
    } else if (in_block) {
      const unsigned sequence = answer[0] & 0x7FU;
      const bool last = (answer[0] & 0x80U) != 0;
      if (sequence == taken + 1U) {
        data.insert(data.end(), answer.begin() + 1, answer.end());
        ++taken;
        last_taken = last;
      }
      if (last || sequence == block_size) confirm();
    }
  }
  void wait() override {
    if (last_word[0] != 0 && !whole() && silence % 30 == 29) confirm();
  }
  bool whole() const { return last_taken && taken == 0; }
  bool last_taken = false;
};

/// Runs to the client's end, at most for a minute of ticks.
void run(Bench& bench, Client& client, Channel& channel) {
  for (int tick = 0; tick < 6000 && client.end == End::none; ++tick) {
    std::vector<CanFrame> said;
    said.swap(client.out);
    for (const CanFrame& frame : channel.pass(said)) bench.node.receive(frame);
    bench.tick();
    std::vector<CanFrame> answers;
    for (CanFrame frame; bench.node.next_frame(frame);) {
      if (frame.id == 0x585) answers.push_back(frame);
    }
    client.hear(channel.pass(answers));
  }
  for (const CanFrame& frame : client.out) bench.node.receive(frame);  // its last word arrives
  bench.drain();
}

Data any_data(std::size_t most) {
  return *rc::gen::container<Data>(*rc::gen::inRange<std::size_t>(5, most + 1),
                                   rc::gen::arbitrary<std::uint8_t>());
}

double any_fault_rate() {
  return *rc::gen::element(0.0, 0.01, 0.05, 0.2, 0.5);
}

struct DownloadRun {
  Bench bench;
  Data data = any_data(160);
  End end;

  DownloadRun(double fault_rate, bool spares_first) {
    data[0] = 1;  // no image that the bench's desk refuses
    Channel channel{std::mt19937(*rc::gen::arbitrary<unsigned>()), fault_rate, spares_first};
    Downloader client(data);
    run(bench, client, channel);
    end = client.end;
  }
};

struct UploadRun {
  Bench bench;
  Data read;
  End end;

  UploadRun(double fault_rate, bool spares_first) {
    bench.desk.active[0] = any_data(160);
    Channel channel{std::mt19937(*rc::gen::arbitrary<unsigned>()), fault_rate, spares_first};
    Uploader client(*rc::gen::arbitrary<unsigned>());
    run(bench, client, channel);
    end = client.end;
    read = client.data;
  }
};

bool answers_after_a_while(Bench& bench) {
  bench.tick(120);
  bench.drain();
  return bench.answer("605 40 00 10 00 00 00 00 00") == "585 43 00 10 00 98 01 FF FF";
}

RC_GTEST_PROP(LossyChannel, LeavesADownloadWholeOrUndone, ()) {
  DownloadRun run(any_fault_rate(), false);
  RC_ASSERT(run.end != End::none);
  if (run.end == End::complete) RC_ASSERT(run.bench.desk.staged[0] == run.data);
  RC_ASSERT(run.bench.desk.staged[0].empty() || run.bench.desk.staged[0] == run.data);
  RC_ASSERT(answers_after_a_while(run.bench));
}

RC_GTEST_PROP(LossyChannel, LeavesAnUploadWholeOrUnfinished, ()) {
  UploadRun run(any_fault_rate(), false);
  RC_ASSERT(run.end != End::none);
  if (run.end == End::complete) RC_ASSERT(run.read == run.bench.desk.active[0]);
  RC_ASSERT(answers_after_a_while(run.bench));
}

RC_GTEST_PROP(LossyChannel, ThatDisturbsSegmentsOnlyDelaysADownload, ()) {
  DownloadRun run(any_fault_rate(), true);
  RC_ASSERT(run.end == End::complete);
  RC_ASSERT(run.bench.desk.staged[0] == run.data);
}

RC_GTEST_PROP(LossyChannel, ThatDisturbsSegmentsOnlyDelaysAnUpload, ()) {
  UploadRun run(any_fault_rate(), true);
  RC_ASSERT(run.end == End::complete);
  RC_ASSERT(run.read == run.bench.desk.active[0]);
}

}  // namespace
}  // namespace plenum::canopen
