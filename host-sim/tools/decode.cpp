#include "host-sim/client/decode.hpp"

#include <fstream>
#include <memory>

#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/legible.hpp"
#include "host-sim/wire/candump.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  std::string file;
  Output output;
};

Json json_of(const wire::LoggedFrame& logged, const client::Decoded& decoded) {
  Json values = Json::array();
  for (const client::DecodedValue& one : decoded.values)
    values.push_back({{"name", one.name}, {"value", number(one.value)}, {"unit", one.unit}});
  return {{"time_s", static_cast<double>(logged.time_us) * 1e-6},
          {"channel", logged.channel},
          {"id", logged.frame.id},
          {"kind", decoded.kind},
          {"node", decoded.node},
          {"text", decoded.text},
          {"values", values}};
}

/// A clock that was set while it was recorded may have gone back.
double seconds_since(const wire::LoggedFrame& first, const wire::LoggedFrame& frame) {
  return 1e-6 * static_cast<double>(static_cast<std::int64_t>(frame.time_us - first.time_us));
}

int run(const Options& options) {
  std::ifstream file(options.file);
  if (!file)
    throw trace::InputError(fmt::format("{}: cannot be read, expected a log of candump", options.file));
  // The whole log is read before anything is said of it: a bad line is no half of an answer.
  std::vector<wire::LoggedFrame> frames;  // and where some are missing
  std::size_t row = 0;
  std::size_t passed_over = 0;
  for (std::string line; std::getline(file, line);) {
    ++row;
    if (line.find_first_not_of(" \r") == std::string::npos) continue;
    auto logged = wire::parse_candump(line);
    if (!logged) {
      throw trace::InputError(
          fmt::format("{}: line {}: '{}', expected '(SECONDS.MICROSECONDS) CHANNEL ID#BYTES'", options.file,
                      row, trace::legible(line.substr(0, 80))));
    }
    if (logged->classic || logged->frames_missing) {
      frames.push_back(std::move(*logged));
    } else {
      ++passed_over;
    }
  }
  if (file.bad()) {  // a folder, too, opens as a file does
    throw trace::InputError(
        fmt::format("{}: cannot be read beyond line {}, expected a log of candump", options.file, row));
  }
  client::Decoder decoder;
  Json list = Json::array();
  std::size_t gaps = 0;
  for (const wire::LoggedFrame& logged : frames) {
    if (logged.frames_missing) {
      ++gaps;
      options.output.print("{:.6f} frames are missing here: a receive buffer was full\n",
                           seconds_since(frames.front(), logged));
      continue;
    }
    const client::Decoded decoded = decoder.decode(logged.frame);
    const std::string node = decoded.node == 0 ? "" : fmt::format("{}", decoded.node);
    options.output.print("{:.6f} {:03X} {:>9} {:>3}  {}\n", seconds_since(frames.front(), logged),
                         logged.frame.id, decoded.kind, node, decoded.text);
    list.push_back(json_of(logged, decoded));
  }
  if (passed_over > 0) {
    options.output.print("{} lines are passed over: CAN FD frames or errors of the bus, no CANopen\n",
                         passed_over);
  }
  options.output.finish(
      {{"file", options.file}, {"frames", list}, {"passed_over", passed_over}, {"gaps", gaps}});
  return kDone;
}

}  // namespace

Command add_decode(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("decode",
                      "Say what the frames of a log are as CANopen: NMT, SYNC, emergencies, PDOs in SI "
                      "units, SDOs by name. CAN FD frames and errors of the bus are counted alone");
  arguments.option("LOG", options->file, "A log of plenum record or candump -l")
      .type_name("FILE.log")
      .required();
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum decode bus.log    # seconds since the first frame, identifier, kind, node, what it says"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
