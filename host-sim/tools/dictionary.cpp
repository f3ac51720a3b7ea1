// plenum_dictionary, a developer's tool: writes what the object dictionary says into files.
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <string>

#include "host-sim/dictionary/data_sheet.hpp"
#include "host-sim/dictionary/dbc.hpp"
#include "host-sim/dictionary/device_configuration.hpp"
#include "host-sim/dictionary/object_table.hpp"

namespace {

/// `file` - is standard output. Returns false, and says so, when it cannot be written.
bool write(const std::string& file, const std::string& text) {
  if (file.empty()) return true;
  if (file == "-") return static_cast<bool>(std::cout << text << std::flush);
  std::ofstream out(file, std::ios::binary);
  out << text << std::flush;
  if (!out) std::cerr << "plenum_dictionary: " << file << " cannot be written\n";
  return static_cast<bool>(out);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace plenum;
  CLI::App app{"Writes what the object dictionary of the firmware says into files; - is standard output."};
  app.footer("example: plenum_dictionary --eds plenum.eds --dcf node-5.dcf --dbc node-5.dbc --node 5");
  std::string eds, dcf, dbc, table;
  std::uint16_t node = 1;
  canopen::Identity identity;
  app.add_option("--eds", eds, "electronic data sheet (CiA 306)")->type_name("FILE");
  app.add_option("--dcf", dcf, "the same for one node, as delivered: device configuration file")
      ->type_name("FILE");
  app.add_option("--dbc", dbc, "the default PDOs, for bus monitors")->type_name("FILE");
  app.add_option("--table", table, "the table of firmware/canopen/OBJECTS.md")->type_name("FILE");
  app.add_option("--node", node, "node id of DCF and DBC file")
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    if (eds.empty() && dcf.empty() && dbc.empty() && table.empty())
      throw CLI::RequiredError("one of --eds, --dcf, --dbc and --table");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const auto node_id = static_cast<std::uint8_t>(node);
  const std::string sheet = host::dictionary::electronic_data_sheet(identity);
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  const bool written =
      write(eds, sheet) &&
      write(dcf, host::dictionary::device_configuration(
                     sheet, {.node_id = node_id, .node_name = identity.device_name, .created = now})) &&
      write(dbc, host::dictionary::dbc(node_id, host::dictionary::delivered_values(node_id))) &&
      write(table, host::dictionary::object_table());
  return written ? 0 : 2;
}
