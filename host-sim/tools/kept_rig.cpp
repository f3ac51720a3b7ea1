#include "host-sim/tools/kept_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::tools {
namespace {

std::filesystem::path file_in(const std::filesystem::path& store) {
  return store / "rig.json";
}

RigChoice read_kept(const std::filesystem::path& file) try {
  const Json json = Json::parse(trace::read_whole_file(file));
  RigChoice kept;
  json.at("plant").get_to(kept.plant);
  json.at("chambers").get_to(kept.chambers);
  json.at("volume_swing").get_to(kept.volume_swing);
  json.at("spool").get_to(kept.spool);
  json.at("effects").get_to(kept.effects);
  json.at("rig").get_to(kept.rig_text);
  return kept;
} catch (const Json::exception&) {
  throw trace::InputError(fmt::format(
      "{}: is not what plenum keeps of a simulated rig, expected that or no such file", file.string()));
}

}  // namespace

void take_rig(RigChoice& rig, const Arguments& given, const std::filesystem::path& store) {
  const std::filesystem::path file = file_in(store);
  if (!std::filesystem::exists(file)) return;
  const RigChoice kept = read_kept(file);
  const auto require_same = [&](bool same, const std::string& option, const std::string& of_store) {
    if (same) return;
    throw std::invalid_argument(fmt::format(
        "{}: the simulated board in {} has {} ({}), expected the same, or the option left out, or another "
        "--store",
        option, store.string(), of_store, file.filename().string()));
  };
  const auto take = [&](const char* option, auto& mine, const auto& of_store) {
    if (given.given(option)) {
      require_same(mine == of_store, fmt::format("{} {}", option, mine), fmt::format("{}", of_store));
    }
    mine = of_store;
  };
  take("--plant", rig.plant, kept.plant);
  take("--chambers", rig.chambers, kept.chambers);
  take("--volume-swing", rig.volume_swing, kept.volume_swing);
  take("--effect", rig.effects, kept.effects);
  if (given.given("--spool")) {
    require_same(rig.spool == kept.spool, rig.spool ? "--spool" : "--no-spool",
                 kept.spool ? "--spool" : "--no-spool");
  }
  rig.spool = kept.spool;
  if (given.given("--rig")) {
    require_same(trace::format_rig(rig.description()) == trace::format_rig(kept.description()),
                 "--rig " + rig.rig_file, "other figures");
  }
  rig.rig_text = kept.rig_text;
}

void keep_rig(const RigChoice& rig, const std::filesystem::path& store) {
  const std::filesystem::path file = file_in(store);
  const Json json{{"plant", rig.plant},
                  {"chambers", rig.chambers},
                  {"volume_swing", rig.volume_swing},
                  {"spool", rig.spool},
                  {"effects", rig.effects},
                  {"rig", rig.rig_text.empty() ? trace::format_rig(rig.description()) : rig.rig_text}};
  const std::string text = json.dump(2) + '\n';
  if (std::filesystem::exists(file) && trace::read_whole_file(file) != text) {
    throw trace::InputError(fmt::format("{}: is of another rig, expected another --store", file.string()));
  }
  trace::write_whole_file(file, text);
}

}  // namespace plenum::host::tools
