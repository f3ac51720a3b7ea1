// The data sheet that some board keeps at 1021h, and the values that it tells of its PDOs: what `plenum describe` makes of them is a file,
// or they are refused.
#include <stdexcept>
#include <string>

#include "host-sim/dictionary/dbc.hpp"
#include "host-sim/dictionary/device_configuration.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum::host::dictionary;
using plenum::fuzz::require;

/// Behind the first zero byte: values of PDO parameters, three bytes of an object and four of its value each.
ObjectValues values_in(std::string_view bytes) {
  ObjectValues values;
  constexpr std::size_t kRow = 7;
  const auto byte = [&](std::size_t at) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at]));
  };
  for (; bytes.size() >= kRow; bytes.remove_prefix(kRow)) {
    const auto index = static_cast<std::uint16_t>(0x1400U + ((byte(0) | byte(1) << 8U) & 0x7FFU));
    values[{index, static_cast<std::uint8_t>(byte(2))}] =
        byte(3) | byte(4) << 8U | byte(5) << 16U | byte(6) << 24U;
  }
  return values;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input = plenum::fuzz::text_of(data, size);
  const std::size_t end = std::min(input.find('\0'), input.size());
  const std::string_view sheet = input.substr(0, end);
  const ObjectValues values = values_in(input.substr(std::min(end + 1, input.size())));
  const Commissioning node{.node_id = static_cast<std::uint8_t>(size % 127 + 1), .node_name = "fuzz"};
  try {
    const std::string configuration = device_configuration(sheet, node, values);
    require(configuration.find("[DeviceComissioning]\nNodeID=" + std::to_string(node.node_id) + "\n") !=
                std::string::npos,
            "a configuration says of which node it is");
    require(configuration.find("$NODEID+") == std::string::npos ||
                sheet.find("$NODEID+") != std::string_view::npos,
            "nothing is put in that has to be resolved");
  } catch (const std::invalid_argument& error) {
    require(std::string_view(error.what()).starts_with("data sheet, "), "a refusal says where");
  }
  try {
    require(dbc(node.node_id, values).starts_with("VERSION"), "PDOs are told as a DBC file");
  } catch (const std::invalid_argument&) {
    return 0;  // a mapping that no board has
  }
  return 0;
}
