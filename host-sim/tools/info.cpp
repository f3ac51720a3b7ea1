#include <memory>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/board_log.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/client/settings.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  Output output;
};

struct HealthValue {
  std::uint8_t sub;
  const char* key;
  const char* text;
};
constexpr std::array kHealth{HealthValue{1, "ticks", "ticks"},
                             HealthValue{2, "overruns", "ticks begun late"},
                             HealthValue{3, "latency_max_us", "us: the latest that a tick began"},
                             HealthValue{4, "latency_p999_us", "us: 999 of 1000 ticks began no later"},
                             HealthValue{5, "scan_age_us", "us: age of the newest scan at the last tick"},
                             HealthValue{6, "frames_received", "frames taken"},
                             HealthValue{7, "frames_rejected", "frames refused"},
                             HealthValue{8, "syncs", "SYNCs"},
                             HealthValue{9, "queue_overflows", "frames that found a transmit queue full"},
                             HealthValue{10, "tpdos_overwritten", "TPDOs overtaken by newer values"},
                             HealthValue{11, "sdo_aborts", "SDO transfers aborted"},
                             HealthValue{12, "saturations", "fixed-point results cut off"}};

/// "2026-11-21", or "-" for a date that is not stated.
std::string date_text(std::uint32_t date_s) {
  if (date_s == 0) return "-";
  const std::chrono::year_month_day day{
      std::chrono::floor<std::chrono::days>(std::chrono::sys_seconds(std::chrono::seconds(date_s)))};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(day.year()), static_cast<unsigned>(day.month()),
                     static_cast<unsigned>(day.day()));
}

Json health(client::Session& session, const Output& output) {
  Json result = Json::object();
  output.print("health\n");
  for (const HealthValue& one : kHealth) {
    const auto value = session.read<std::uint32_t>(canopen::object::kHealth, one.sub);
    output.print("  {:>10}  {}\n", value, one.text);
    result[one.key] = value;
  }
  return result;
}

/// The bins that hold a tick.
Json latency(client::Session& session, const Output& output) {
  Json list = Json::array();
  output.print("latency\n");
  for (const client::LatencyBin& bin : client::read_latency(session)) {
    if (bin.ticks == 0) continue;
    output.print("  {:>10}  ticks from {} us\n", bin.ticks, bin.lowest_us);
    list.push_back({{"lowest_us", bin.lowest_us}, {"ticks", bin.ticks}});
  }
  return list;
}

Json models(client::Session& session, const Output& output) {
  Json list = Json::array();
  output.print("models\n  {:>7}  {:<9}  {:<9}  {:>10}  {:<10}  {:>15}  {:>12}  {:>20}  {:>12}  {:>13}\n",
               "chamber", "state", "CRC", "generation", "fitted", "fit error [kPa]", "misses [kPa]",
               "in fixed point [kPa]", "valve serial", "sensor serial");
  const auto serial = [](std::uint32_t value) {
    return value == 0 ? std::string("-") : fmt::format("{}", value);
  };
  const auto stated = [](double value_kPa, int digits) {
    return value_kPa > 0 ? fmt::format("{:.{}g}", value_kPa, digits) : std::string("-");
  };
  for (std::uint8_t chamber = 0; chamber < client::kChambers; ++chamber) {
    const client::ModelSet set = client::read_model_set(session, chamber);
    Json one{{"chamber", chamber + 1},
             {"state", client::phase_name(set.phase)},
             {"crc", set.image.empty() ? Json(nullptr) : Json(hex(set.crc, 8))},
             {"generation", set.generation}};
    if (set.image.empty()) {
      output.print("  {:>7}  {}\n", chamber + 1, client::phase_name(set.phase));
    } else {
      const client::ModelOrigin origin = client::decode_model(set.image).origin;
      const double misses_kPa = client::read_drift_Pa(session, chamber) / 1e3;
      output.print("  {:>7}  {:<9}  {:<9}  {:>10}  {:<10}  {:>15}  {:>12.3g}  {:>20}  {:>12}  {:>13}\n",
                   chamber + 1, client::phase_name(set.phase), hex(set.crc, 8), set.generation,
                   date_text(origin.fit_date_s), stated(origin.fit_error_kPa, 3), misses_kPa,
                   stated(origin.fixed_error_kPa, 2), serial(origin.valve_serial),
                   serial(origin.sensor_serial));
      one["fit_date_s"] = origin.fit_date_s;
      one["fit_error_kPa"] = origin.fit_error_kPa;
      one["misses_kPa"] = misses_kPa;
      one["fixed_error_kPa"] = origin.fixed_error_kPa > 0 ? Json(origin.fixed_error_kPa) : Json(nullptr);
      one["valve_serial"] = origin.valve_serial;
      one["sensor_serial"] = origin.sensor_serial;
    }
    list.push_back(one);
  }
  return list;
}

/// Mappings take many rows and say little: they are in the JSON alone.
Json settings(client::Session& session, const Output& output) {
  Json list = Json::array();
  output.print("settings (PDO parameters: --json)\n");
  for (const client::Setting& setting : client::read_settings(session)) {
    const bool pdo = setting.id.index >= 0x1400 && setting.id.index < 0x1C00;
    const Json value = std::visit([](auto number) { return Json(number); }, client::number_of(setting));
    if (!pdo) {
      output.print("  {:04X}h:{:<2}  {:>12}  {}\n", setting.id.index, setting.id.sub, value.dump(),
                   setting.name);
    }
    list.push_back({{"index", hex(setting.id.index, 4)},
                    {"sub", setting.id.sub},
                    {"name", setting.name},
                    {"value", value}});
  }
  return list;
}

int run(const Options& options) {
  BoardAccess access(options.board);
  client::Session& session = access.session();
  const Output& output = options.output;
  const ShownTransfers shown(session, "reading");
  client::require_compatible(session);
  const client::Identity identity = client::read_identity(session);
  const client::Versions versions = client::read_versions(session);
  const std::uint16_t status = session.status_word();
  const auto fault = client::read_fault(session);
  const char* state = client::state_name(status, fault ? fault->code : std::uint16_t{0});
  output.print("node {}: {}\n", session.node_id(), versions.device);
  output.print("  vendor {:X}h, product {:X}h, revision {:X}h, serial {}\n", identity.vendor_id,
               identity.product_code, identity.revision, identity.serial);
  output.print("  hardware {}, software {}, computing in {}\n", versions.hardware, versions.software,
               versions.in_float() ? "float" : "fixed point");
  output.print("  models of schema {}, {} parameters\n", hex(versions.schema_hash, 8),
               versions.parameter_count);
  output.print("  {}; {}\n", state, fault ? client::fault_text(*fault) : "no fault");
  Json result{{"node", session.node_id()},
              {"identity", identity_json(identity)},
              {"versions", versions_json(versions)},
              {"state", state},
              {"fault", fault_json(fault)}};
  result["health"] = health(session, output);
  result["latency"] = latency(session, output);
  const bool frozen = client::log_is_frozen(session);
  if (frozen)
    output.print("  its log is frozen, and models are compared by it: plenum reset --log lets it go on\n");
  result["log_frozen"] = frozen;
  result["models"] = models(session, output);
  result["settings"] = settings(session, output);
  output.finish(result);
  return kDone;
}

}  // namespace

Command add_info(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("info", "One board whole: identity, versions, state, health, models, settings");
  options->board.add_to(arguments);
  options->output.add_to(arguments);
  arguments.footer(example("  plenum info --bus socketcand:127.0.0.1:29536/can0 --node 5"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
