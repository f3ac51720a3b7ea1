// plantd: the chambers behind the emulated front end, for as long as the virtual board runs.
//
//   plantd [PINS]
//
// At each conversion it takes the valve commands at the pins from /dev/plenum-plant, lets the time pass that the door says has
// passed, and puts the sensors' voltages there. A processor that is late makes the steps longer and loses no time.
//
// To PINS it adds a line whenever what the board does at its pins has changed: the time of day [us], 1 where the valves have power,
// 1 where the emergency stop is pressed, and the code of each output. The time is that of the look, so that it is never early.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>

#include "tests/virtual-board/frontend/plant_door.h"
#include "tests/virtual-board/guest/chambers.hpp"

namespace {

using plenum::virtual_board::Chambers;
using plenum::virtual_board::code_of;

constexpr const char* kDoor = "/dev/plenum-plant";

int fail(const char* doing) {
  std::fprintf(stderr, "plantd: %s %s: %s\n", doing, kDoor, std::strerror(errno));
  return 1;
}

plant_door_world world_of(const Chambers& chambers) {
  plant_door_world world{};
  const auto readings_V = chambers.readings_V();
  for (std::size_t i = 0; i < readings_V.size(); ++i) {
    world.input[i] =
        static_cast<__s16>(code_of(readings_V[i], -0.5 * PLANT_DOOR_INPUT_SPAN_V, PLANT_DOOR_INPUT_SPAN_V));
  }
  return world;
}

/// What is written to PINS, one line a change.
class Pins {
 public:
  explicit Pins(std::FILE* file) : file_(file) {}

  void look(const plant_door_board& board) {
    const bool same = board.valve_power == last_.valve_power &&
                      board.emergency_stop == last_.emergency_stop &&
                      std::memcmp(board.output, last_.output, sizeof board.output) == 0;
    if (same && begun_) return;
    begun_ = true;
    last_ = board;
    using std::chrono::microseconds;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto now_us = static_cast<long long>(std::chrono::duration_cast<microseconds>(now).count());
    std::fprintf(file_, "%lld %u %u", now_us, board.valve_power, board.emergency_stop);
    for (const unsigned code : board.output) std::fprintf(file_, " %u", code);
    std::fputc('\n', file_);
    std::fflush(file_);
  }

 private:
  std::FILE* file_;
  plant_door_board last_{};
  bool begun_ = false;
};

}  // namespace

int main(int count, char** words) {
  static_assert(Chambers::kInputs == PLANT_DOOR_INPUTS && Chambers::kChambers == PLANT_DOOR_OUTPUTS);
  const int door = ::open(kDoor, O_RDWR | O_CLOEXEC);
  if (door < 0) return fail("cannot open");
  std::FILE* const file = count > 1 ? std::fopen(words[1], "ae") : nullptr;
  if (count > 1 && file == nullptr) {
    std::fprintf(stderr, "plantd: %s: %s\n", words[1], std::strerror(errno));
    return 1;
  }
  std::optional<Pins> pins;
  if (file != nullptr) pins.emplace(file);
  Chambers chambers;
  for (;;) {
    const plant_door_world world = world_of(chambers);
    if (::write(door, &world, sizeof world) != sizeof world) return fail("cannot write to");
    plant_door_board board{};
    if (::read(door, &board, sizeof board) != sizeof board) return fail("cannot read from");
    if (pins) pins->look(board);
    std::array<double, Chambers::kChambers> command_V{};
    for (std::size_t c = 0; c < command_V.size(); ++c) {
      command_V[c] = board.output[c] * (PLANT_DOOR_OUTPUT_SPAN_V / 65536.0);
    }
    chambers.advance(1e-9 * static_cast<double>(board.elapsed_ns), command_V, board.valve_power != 0);
  }
}
