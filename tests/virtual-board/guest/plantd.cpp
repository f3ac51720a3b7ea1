// plantd: the chambers behind the emulated front end, for as long as the virtual board runs.
//
// At each conversion it takes the valve commands at the pins from /dev/plenum-plant, lets the time pass that the door says has
// passed, and puts the sensors' voltages there. A processor that is late makes the steps longer and loses no time.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

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

}  // namespace

int main() {
  static_assert(Chambers::kInputs == PLANT_DOOR_INPUTS && Chambers::kChambers == PLANT_DOOR_OUTPUTS);
  const int door = ::open(kDoor, O_RDWR | O_CLOEXEC);
  if (door < 0) return fail("cannot open");
  Chambers chambers;
  for (;;) {
    const plant_door_world world = world_of(chambers);
    if (::write(door, &world, sizeof world) != sizeof world) return fail("cannot write to");
    plant_door_board board{};
    if (::read(door, &board, sizeof board) != sizeof board) return fail("cannot read from");
    std::array<double, Chambers::kChambers> command_V{};
    for (std::size_t c = 0; c < command_V.size(); ++c) {
      command_V[c] = board.output[c] * (PLANT_DOOR_OUTPUT_SPAN_V / 65536.0);
    }
    chambers.advance(1e-9 * static_cast<double>(board.elapsed_ns), command_V, board.valve_power != 0);
  }
}
