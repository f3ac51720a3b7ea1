#include <memory>
#include <stdexcept>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/calibration.hpp"
#include "host-sim/client/settings.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  unsigned chamber = 1;
  client::SensorError error{.ambient_kPa = 101.325};
  bool keep = false;
  Output output;
};

Json json_of(const client::PressureCalibration& calibration) {
  return {{"pressure_gain_kPa_per_V", calibration.gain_kPa_per_V},
          {"pressure_offset_kPa", calibration.offset_kPa}};
}

int run(const Arguments& arguments, const Options& options) {
  if (!arguments.given("--offset") && !arguments.given("--gain-error"))
    throw std::invalid_argument("nothing to correct, expected --offset, --gain-error or both");
  options.board.require_store();
  const StopSignal until_whole;  // a first Ctrl-C does not leave one half of a calibration
  BoardAccess access(options.board);
  client::Session& session = access.session();
  client::require_compatible(session);
  const auto chamber = static_cast<std::uint8_t>(options.chamber - 1);
  const client::PressureCalibration before = client::read_calibration(session, chamber);
  const client::PressureCalibration after =
      client::write_calibration(session, chamber, client::corrected(before, options.error));
  options.output.print(
      "chamber {}: absolute pressure = {:.6g} kPa + {:.6g} kPa/V; it was {:.6g} kPa + {:.6g} kPa/V\n",
      options.chamber, after.offset_kPa, after.gain_kPa_per_V, before.offset_kPa, before.gain_kPa_per_V);
  if (options.keep) {
    if (!client::store_settings(session))
      throw client::Refused("the board has no place to keep its settings");
    options.board.keep_rig();
    options.output.print("the board has stored its settings (1010h)\n");
  } else {
    options.output.print("{}; --keep stores it\n",
                         options.board.simulated()
                             ? "gone with this command, as a simulated board starts anew with each"
                             : "in force until the board starts anew");
  }
  options.output.finish({{"chamber", options.chamber},
                         {"before", json_of(before)},
                         {"after", json_of(after)},
                         {"kept", options.keep}});
  return kDone;
}

}  // namespace

Command add_calibrate(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "calibrate", "Correct a board's calibration for the sensor error that a diagnosis found");
  options->board.add_to(arguments);
  arguments.option("--chamber", options->chamber, "Whose sensor").within(1, 8).show_default();
  arguments
      .option("--offset", options->error.offset_kPa,
              "Reading at ambient pressure less ambient pressure [kPa]")
      .within(-100.0, 100.0)
      .show_default();
  arguments.option("--gain-error", options->error.gain_error, "Relative, of the pressure above ambient [1]")
      .within(-0.3, 0.3)
      .show_default();
  arguments.option("--ambient", options->error.ambient_kPa, "Of the rig that was diagnosed [kPa, absolute]")
      .within(10.0, 200.0)
      .show_default();
  arguments.flag("--keep", options->keep, "Store the board's settings (1010h)");
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum calibrate --bus can:can0 --node 5 --chamber 3 --offset 5.07 --gain-error -0.0005 --keep"));
  return {arguments, [arguments, options] { return run(arguments, *options); }};
}

}  // namespace plenum::host::tools
