// The calls of libgpiod 1.6 that the board makes, before fake_chip.hpp. The program's own win over those of the library.
#include <gpiod.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "tests/board/gpiod/fake_chip.hpp"

namespace fake = plenum::board::drivers::fake;

struct gpiod_line {
  unsigned offset = 0;
  bool held = false;
};
struct gpiod_chip {
  std::array<gpiod_line, 4> line{{{0}, {1}, {2}, {3}}};
};

namespace {

int request(gpiod_line* line, const char* consumer, int flags, fake::Request request) {
  request.active_low = (flags & GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW) != 0;
  const int done = fake::chip().request(line->offset, request, consumer);
  line->held = done == 0;
  return done;
}

}  // namespace

extern "C" {

gpiod_chip* gpiod_chip_open(const char* path) {
  if (std::strcmp(path, fake::kChip) == 0) return new gpiod_chip;
  errno = ENOENT;
  return nullptr;
}
void gpiod_chip_close(gpiod_chip* chip) {
  for (const gpiod_line& line : chip->line)
    if (line.held) fake::chip().release(line.offset);
  delete chip;
}
const char* gpiod_chip_label(gpiod_chip*) {
  return "fake";
}
gpiod_line* gpiod_chip_get_line(gpiod_chip* chip, unsigned int offset) {
  if (offset < chip->line.size()) return &chip->line[offset];
  errno = EINVAL;
  return nullptr;
}
gpiod_line* gpiod_chip_find_line(gpiod_chip* chip, const char* name) {
  const auto offset = fake::chip().offset(name);
  if (offset) return &chip->line.at(*offset);
  errno = ENOENT;
  return nullptr;
}
unsigned int gpiod_line_offset(gpiod_line* line) {
  return line->offset;
}
bool gpiod_line_is_used(gpiod_line* line) {
  return !fake::chip().line.at(line->offset).holder.empty();
}
const char* gpiod_line_consumer(gpiod_line* line) {
  const std::string& holder = fake::chip().line.at(line->offset).holder;
  return holder.empty() ? nullptr : holder.c_str();
}
int gpiod_line_direction(gpiod_line* line) {
  return fake::chip().line.at(line->offset).output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT;
}
int gpiod_line_request(gpiod_line* line, const gpiod_line_request_config* config, int default_val) {
  const bool output = config->request_type == GPIOD_LINE_REQUEST_DIRECTION_OUTPUT;
  const bool as_is = config->request_type == GPIOD_LINE_REQUEST_DIRECTION_AS_IS;
  return request(line, config->consumer, config->flags,
                 {.direction = as_is    ? fake::Direction::as_is
                               : output ? fake::Direction::output
                                        : fake::Direction::input,
                  .active = default_val != 0,
                  .edges = config->request_type == GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES});
}
int gpiod_line_request_both_edges_events_flags(gpiod_line* line, const char* consumer, int flags) {
  return request(line, consumer, flags, {.direction = fake::Direction::input, .edges = true});
}
int gpiod_line_request_output_flags(gpiod_line* line, const char* consumer, int flags, int default_val) {
  return request(line, consumer, flags, {.direction = fake::Direction::output, .active = default_val != 0});
}
int gpiod_line_get_value(gpiod_line* line) {
  return fake::chip().value(line->offset);
}
int gpiod_line_set_value(gpiod_line* line, int value) {
  return fake::chip().set(line->offset, value != 0);
}
int gpiod_line_event_wait(gpiod_line* line, const timespec*) {
  return fake::chip().events(line->offset);
}
int gpiod_line_event_read_multiple(gpiod_line* line, gpiod_line_event*, unsigned int num_events) {
  return fake::chip().take_events(line->offset, num_events);
}
int gpiod_line_event_get_fd(gpiod_line*) {
  return fake::kEventDescriptor;
}

}  // extern "C"
