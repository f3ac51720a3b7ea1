// A model file, from any bytes: it is accepted and holds together, or refused with an error that names the file.
#include <string>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/model_json.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plenum::host;
  using plenum::fuzz::require;
  const std::string_view text = plenum::fuzz::text_of(data, size);
  try {
    const std::string written = trace::format_model(trace::parse_model(text, "input.json"));
    require(trace::format_model(trace::parse_model(written, "written.json")) == written,
            "an accepted model reads back");
  } catch (const trace::InputError& error) {
    require(std::string_view(error.what()).find("input.json") != std::string_view::npos,
            "an error names the file that was read");
  }
  return 0;
}
