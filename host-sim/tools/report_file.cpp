#include "host-sim/tools/report_file.hpp"

#include <fmt/format.h>
#include <plenum_version.hpp>  // written by the build

namespace plenum::host::tools {

void write_report(const Output& output, const std::string& file,
                  const std::function<report::Page()>& make_page) {
  if (file.empty()) return;
  make_page().made_by(fmt::format("plenum {}", kVersion)).write(file);
  output.print("report: {}\n", file);
}

}  // namespace plenum::host::tools
