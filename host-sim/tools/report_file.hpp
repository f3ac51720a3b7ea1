// The page of a command, where --report asks for one.
#pragma once

#include <string>

#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

/// Makes the page and writes it to `file`; empty: neither. Throws as report::Page::write().
template <class MakePage>
void write_report(const Output& output, const std::string& file, MakePage&& make_page) {
  if (file.empty()) return;
  make_page().write(file);
  output.print("report: {}\n", file);
}

}  // namespace plenum::host::tools
