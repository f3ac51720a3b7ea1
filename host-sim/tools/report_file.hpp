// The page of a command, where --report asks for one.
#pragma once

#include <functional>
#include <string>

#include "host-sim/report/page.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

/// Makes the page, which says of which version of the program it is, and writes it to `file`; empty: neither. Throws as
/// report::Page::write().
void write_report(const Output& output, const std::string& file,
                  const std::function<report::Page()>& make_page);

}  // namespace plenum::host::tools
