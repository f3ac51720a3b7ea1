#include "host-sim/report/assets.hpp"

#include <cstddef>

// Symbols of assets.S: the first byte of each file and the byte after its last.
extern "C" {
extern const char plenum_echarts_begin[], plenum_echarts_end[];
extern const char plenum_page_script_begin[], plenum_page_script_end[];
extern const char plenum_page_style_begin[], plenum_page_style_end[];
}

namespace plenum::host::report {
namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::string_view echarts_script() {
  return between(plenum_echarts_begin, plenum_echarts_end);
}
std::string_view page_script() {
  return between(plenum_page_script_begin, plenum_page_script_end);
}
std::string_view page_style() {
  return between(plenum_page_style_begin, plenum_page_style_end);
}

}  // namespace plenum::host::report
