// A description of a rig, from any bytes: it is accepted and holds together, or refused with an error that names the file.
#include <string>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/rig_toml.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plenum::host;
  using plenum::fuzz::require;
  const std::string_view text = plenum::fuzz::text_of(data, size);
  try {
    const trace::RigDescription rig = trace::parse_rig(text, "input.toml");
    require(rig.supply.pressure_Pa > rig.ambient.pressure_Pa, "the supply is above ambient");
    require(
        rig.sampling.rate_Hz > 0.0 && rig.sampling.pressure_average_s * rig.sampling.rate_Hz <= 1.0 + 1e-9,
        "a pressure is averaged within its tick");
  } catch (const trace::InputError& error) {
    require(std::string_view(error.what()).find("input.toml") != std::string_view::npos,
            "an error names the file that was read");
  }
  return 0;
}
