// Shows a recording to the controller and compares the digest of what it answers with the one that every compiler, level of
// optimisation and architecture is to give.
//
// usage: plenum_same_bits RECORDING [EXPECTED]
//
// EXPECTED: a line a scalar type, its name and the digest in hexadecimal. Without it the commands of each tick are printed, as the
// bits that they are, and the digest: two such prints compared tell the first tick that differs.
//
// Exit code: 0 the digest is the expected one, 1 it is not, 2 bad usage or a file that is none.
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "firmware/numeric/scalar.hpp"
#include "tests/bits/replay.hpp"

namespace {

using namespace plenum;
using bits::Replay;

constexpr const char* kScalar = std::is_same_v<numeric::Scalar, float> ? "float" : "fixed";

std::ifstream opened(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::invalid_argument("cannot read " + path);
  return file;
}

ports::CanFrame frame_in(std::istringstream& line) {
  ports::CanFrame frame;
  line >> std::hex >> frame.id;
  for (unsigned byte = 0; line >> byte;) frame.data.at(frame.length++) = static_cast<std::uint8_t>(byte);
  return frame;
}

std::optional<bits::Tick> tick_in(std::istringstream& line) {
  bits::Tick tick;
  line >> std::hex >> tick.flags >> tick.stale;
  for (std::uint16_t& reading : tick.reading) line >> reading;
  return line ? std::optional(tick) : std::nullopt;
}

void print(const Outputs& outputs) {
  for (const float command_V : outputs.command_V)
    std::printf("%08x ", static_cast<unsigned>(std::bit_cast<std::uint32_t>(command_V)));
  std::printf("\n");
}

Replay::Digest digest_of(const std::string& path, bool printed) {
  std::ifstream file = opened(path);
  Replay replay;
  std::size_t ticks = 0;
  std::string text;
  for (int number = 1; std::getline(file, text); ++number) {
    std::istringstream line(text);
    std::string kind;
    line >> kind;
    if (kind == "F") {
      replay.receive(frame_in(line));
    } else if (const auto tick = kind == "T" ? tick_in(line) : std::nullopt) {
      const Outputs outputs = replay.step(*tick);
      if (printed) print(outputs);
      ++ticks;
    } else {
      throw std::invalid_argument(path + ":" + std::to_string(number) +
                                  ": expected F ID BYTES or T FLAGS STALE and " +
                                  std::to_string(bits::kReadings) + " readings");
    }
    replay.sent();
  }
  if (ticks == 0) throw std::invalid_argument(path + " holds no tick");
  return replay.digest();
}

std::string text_of(const Replay::Digest& digest) {
  std::ostringstream text;
  text << std::hex << std::uppercase << std::setfill('0') << kScalar;
  for (const std::uint32_t crc : digest) text << ' ' << std::setw(8) << crc;
  return text.str();
}

std::string expected_in(const std::string& path) {
  std::ifstream file = opened(path);
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(kScalar)) return line;
  }
  return "no line for " + std::string(kScalar);
}

int run(const std::vector<std::string>& words) {
  if (words.empty() || words.size() > 2) {
    std::cerr << "usage: plenum_same_bits RECORDING [EXPECTED]\n";
    return 2;
  }
  const bool compared = words.size() == 2;
  const std::string found = text_of(digest_of(words[0], !compared));
  std::cout << found << '\n';
  if (!compared || found == expected_in(words[1])) return 0;
  std::cerr << "the commands of chambers 1 to 8 and the frames have another digest.\nexpected "
            << expected_in(words[1]) << "\nfound    " << found << '\n';
  return 1;
}

}  // namespace

int main(int count, char** words) {
  try {
    return run({words + 1, words + count});
  } catch (const std::exception& error) {
    std::cerr << "plenum_same_bits: " << error.what() << '\n';
    return 2;
  }
}
