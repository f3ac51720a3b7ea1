// A log, from any bytes: it is accepted and holds together, or refused with an error that names the file.
#include <string>
#include <vector>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/log_csv.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plenum::host;
  using plenum::fuzz::require;
  const std::string_view text = plenum::fuzz::text_of(data, size);
  try {
    std::vector<std::string> notices;
    const trace::Log log = trace::parse_log(text, "input.csv", &notices);
    // what is accepted is written and read back to the same numbers
    const std::string written = trace::format_log(log);
    require(trace::format_log(trace::parse_log(written, "written.csv")) == written,
            "an accepted log reads back");
    require(log.command_V.size() == log.size() && log.pressure_Pa.size() == log.size(),
            "columns are of one length");
  } catch (const trace::InputError& error) {
    require(std::string_view(error.what()).find("input.csv") != std::string_view::npos,
            "an error names the file that was read");
  }
  return 0;
}
