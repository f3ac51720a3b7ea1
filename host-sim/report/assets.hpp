// The files that every page carries, embedded into the library when it is built (assets.S).
#pragma once

#include <string_view>

namespace plenum::host::report {

std::string_view echarts_script();
std::string_view page_script();
std::string_view page_style();

}  // namespace plenum::host::report
