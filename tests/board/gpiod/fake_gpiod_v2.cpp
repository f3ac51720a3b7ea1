// The calls of libgpiod 2 that the board makes, before fake_chip.hpp.
#include <gpiod.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include "tests/board/gpiod/fake_chip.hpp"

namespace fake = plenum::board::drivers::fake;

struct gpiod_chip {};
struct gpiod_chip_info {};
struct gpiod_line_info {
  fake::Line line;
};
struct gpiod_line_settings {
  fake::Request request;
};
struct gpiod_line_config {
  unsigned offset = 0;
  fake::Request request;
};
struct gpiod_request_config {
  std::string consumer;
};
struct gpiod_line_request {
  unsigned offset;
};
struct gpiod_edge_event_buffer {
  std::size_t capacity;
};

extern "C" {

gpiod_chip* gpiod_chip_open(const char* path) {
  if (std::strcmp(path, fake::kChip) == 0) return new gpiod_chip;
  errno = ENOENT;
  return nullptr;
}
void gpiod_chip_close(gpiod_chip* chip) {
  delete chip;
}
gpiod_chip_info* gpiod_chip_get_info(gpiod_chip*) {
  return new gpiod_chip_info;
}
void gpiod_chip_info_free(gpiod_chip_info* info) {
  delete info;
}
const char* gpiod_chip_info_get_label(gpiod_chip_info*) {
  return "fake";
}
int gpiod_chip_get_line_offset_from_name(gpiod_chip*, const char* name) {
  const auto offset = fake::chip().offset(name);
  if (offset) return static_cast<int>(*offset);
  errno = ENOENT;
  return -1;
}
gpiod_line_info* gpiod_chip_get_line_info(gpiod_chip*, unsigned int offset) {
  if (offset < fake::chip().line.size()) return new gpiod_line_info{fake::chip().line[offset]};
  errno = EINVAL;
  return nullptr;
}
void gpiod_line_info_free(gpiod_line_info* info) {
  delete info;
}
bool gpiod_line_info_is_used(gpiod_line_info* info) {
  return !info->line.holder.empty();
}
const char* gpiod_line_info_get_consumer(gpiod_line_info* info) {
  return info->line.holder.empty() ? nullptr : info->line.holder.c_str();
}
gpiod_line_direction gpiod_line_info_get_direction(gpiod_line_info* info) {
  return info->line.output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT;
}

gpiod_line_settings* gpiod_line_settings_new() {
  return new gpiod_line_settings;
}
void gpiod_line_settings_free(gpiod_line_settings* settings) {
  delete settings;
}
int gpiod_line_settings_set_direction(gpiod_line_settings* settings, gpiod_line_direction direction) {
  settings->request.direction = direction == GPIOD_LINE_DIRECTION_OUTPUT  ? fake::Direction::output
                                : direction == GPIOD_LINE_DIRECTION_INPUT ? fake::Direction::input
                                                                          : fake::Direction::as_is;
  return 0;
}
int gpiod_line_settings_set_edge_detection(gpiod_line_settings* settings, gpiod_line_edge edge) {
  settings->request.edges = edge == GPIOD_LINE_EDGE_BOTH;
  return 0;
}
void gpiod_line_settings_set_active_low(gpiod_line_settings* settings, bool active_low) {
  settings->request.active_low = active_low;
}
int gpiod_line_settings_set_output_value(gpiod_line_settings* settings, gpiod_line_value value) {
  settings->request.active = value == GPIOD_LINE_VALUE_ACTIVE;
  return 0;
}
gpiod_line_config* gpiod_line_config_new() {
  return new gpiod_line_config;
}
void gpiod_line_config_free(gpiod_line_config* config) {
  delete config;
}
int gpiod_line_config_add_line_settings(gpiod_line_config* config, const unsigned int* offsets,
                                        size_t num_offsets, gpiod_line_settings* settings) {
  if (num_offsets != 1) {
    errno = EINVAL;
    return -1;
  }
  *config = {.offset = *offsets, .request = settings->request};
  return 0;
}
gpiod_request_config* gpiod_request_config_new() {
  return new gpiod_request_config;
}
void gpiod_request_config_free(gpiod_request_config* config) {
  delete config;
}
void gpiod_request_config_set_consumer(gpiod_request_config* config, const char* consumer) {
  config->consumer = consumer;
}

gpiod_line_request* gpiod_chip_request_lines(gpiod_chip*, gpiod_request_config* req_cfg,
                                             gpiod_line_config* line_cfg) {
  if (line_cfg->offset >= fake::chip().line.size()) {
    errno = EINVAL;
    return nullptr;
  }
  const int done = fake::chip().request(line_cfg->offset, line_cfg->request, req_cfg->consumer.c_str());
  return done == 0 ? new gpiod_line_request{line_cfg->offset} : nullptr;
}
void gpiod_line_request_release(gpiod_line_request* request) {
  fake::chip().release(request->offset);
  delete request;
}
gpiod_line_value gpiod_line_request_get_value(gpiod_line_request*, unsigned int offset) {
  return static_cast<gpiod_line_value>(fake::chip().value(offset));
}
int gpiod_line_request_set_value(gpiod_line_request*, unsigned int offset, gpiod_line_value value) {
  return fake::chip().set(offset, value == GPIOD_LINE_VALUE_ACTIVE);
}
int gpiod_line_request_get_fd(gpiod_line_request*) {
  return fake::kEventDescriptor;
}
int gpiod_line_request_wait_edge_events(gpiod_line_request* request, int64_t) {
  return fake::chip().events(request->offset);
}
int gpiod_line_request_read_edge_events(gpiod_line_request* request, gpiod_edge_event_buffer* buffer,
                                        size_t max_events) {
  return fake::chip().take_events(request->offset,
                                  static_cast<unsigned>(std::min(max_events, buffer->capacity)));
}
gpiod_edge_event_buffer* gpiod_edge_event_buffer_new(size_t capacity) {
  return new gpiod_edge_event_buffer{capacity};
}
void gpiod_edge_event_buffer_free(gpiod_edge_event_buffer* buffer) {
  delete buffer;
}

}  // extern "C"
