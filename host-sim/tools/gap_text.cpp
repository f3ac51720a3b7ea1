#include "host-sim/tools/gap_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "host-sim/diagnose/found_rig.hpp"
#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::tools {
namespace {

using diagnose::Estimate;
using diagnose::GapReport;
using diagnose::NamedEffect;
using diagnose::Verdict;

std::string number_text(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : std::string("-");
}

}  // namespace

std::vector<std::string> causes_of(const GapReport& report) {
  std::vector<std::string> causes;
  for (const NamedEffect& held : diagnose::effects_in_model(report)) {
    std::vector<std::string> rivals{held.id};
    for (const NamedEffect& one : report.effects) {
      if (std::find(held.aliases.begin(), held.aliases.end(), one.id) != held.aliases.end()) {
        rivals.push_back(one.id);
      }
    }
    causes.push_back(listed(rivals, "or"));
  }
  return causes;
}

std::string percent(double share) {
  if (!std::isfinite(share)) return "-";
  const double value = 100.0 * share;
  return value > 0.0 && value < 1.0 ? std::string("< 1 %") : fmt::format("{:.0f} %", value);
}

std::string kPa_text(double pressure_Pa) {
  return fmt::format("{:.3g} kPa", 1e-3 * pressure_Pa);
}

std::string listed(const std::vector<std::string>& names, std::string_view conjunction) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? fmt::format(" {} ", conjunction) : ", ";
    text += names[i];
  }
  return text;
}

std::string text_of(const Estimate& of) {
  return fmt::format("{} {} ({} to {}{})", of.name, number_text(of.value), number_text(of.low95),
                     number_text(of.high95), of.at_bound ? ", at its bound" : "");
}

std::vector<Estimate> plain_parameters(const NamedEffect& effect) {
  constexpr std::size_t kMany = 6;
  std::vector<Estimate> plain = effect.parameters;
  const auto known = effects::find(effect.id);
  if (plain.size() < kMany || !known) return plain;
  const auto refines = [&](const Estimate& of) {
    const auto parameters = effects::kCatalogue[*known]->parameters;
    return std::any_of(parameters.begin(), parameters.end(),
                       [&](const effects::Parameter& one) { return one.name == of.name && one.refines; });
  };
  std::erase_if(plain, refines);
  return plain;
}

std::string parameters_text(const NamedEffect& effect) {
  std::string text;
  const std::vector<Estimate> plain = plain_parameters(effect);
  for (const Estimate& one : plain) text += (text.empty() ? "" : ", ") + text_of(one);
  const auto is_told = [&](const Estimate& one) {
    return std::any_of(plain.begin(), plain.end(),
                       [&](const Estimate& other) { return other.name == one.name; });
  };
  const auto more = std::count_if(effect.parameters.begin(), effect.parameters.end(),
                                  [&](const Estimate& one) { return !is_told(one) && !one.is_given(); });
  return more == 0 ? text : fmt::format("{}, and {} that refine it", text, more);
}

std::string p_text(const GapReport& report) {
  constexpr double kLeast = 1e-3;  // of 999 stretches that are drawn
  return report.gap_p_value > kLeast ? fmt::format("p = {:.2g}", report.gap_p_value) : "p <= 0.001";
}

std::string floor_text(const GapReport& report) {
  return fmt::format("{} makes {}", report.baseline ? "what the model leaves of the baseline" : "noise alone",
                     kPa_text(report.noise_floor_Pa));
}

std::string baseline_sentence(const GapReport& report) {
  std::vector<std::string> effects;
  for (const NamedEffect& effect : report.baseline->effects) effects.push_back(effect.id);
  return fmt::format("the baseline ({}): with its valve fitted{} the model errs by {} instead of {}.",
                     name_of(report.baseline->verdict),
                     effects.empty() ? "" : fmt::format(", {},", listed(effects, "and")),
                     kPa_text(report.baseline->with_effects_Pa), kPa_text(report.baseline->as_configured_Pa));
}

std::string verdict_sentence(const GapReport& report) {
  const std::string recalibrated = kPa_text(report.recalibrated_Pa);
  const std::string with_effects = kPa_text(report.with_effects_Pa);
  const std::vector<std::string> causes = causes_of(report);
  const bool several = causes.size() > 1;
  const std::string closed = percent(report.closed_fraction);
  switch (report.verdict) {
    case Verdict::none:
      return fmt::format("No gap: {} the model errs by {} in free run, where {}.",
                         report.baseline ? "as it was" : "as configured", kPa_text(report.as_configured_Pa),
                         floor_text(report));
    case Verdict::calibration:
      return fmt::format(
          "Calibration is all that can be told: with the valve's figures fitted the model errs by {} instead "
          "of {}, where {}; no effect {}.",
          recalibrated, kPa_text(report.as_configured_Pa), floor_text(report),
          report.baseline ? "is seen to have come" : "is seen to be missing");
    case Verdict::explained:
    case Verdict::partly_explained: {
      const bool all = report.verdict == Verdict::explained;
      return fmt::format("{} {} {}the gap: with {} the model errs by {} instead of {}, which closes {}{}.",
                         listed(causes, "and"), several ? "explain" : "explains", all ? "" : "part of ",
                         several ? "them" : "it", with_effects, recalibrated, closed,
                         all ? " of what could be closed" : "; a rest beyond noise stays unexplained");
    }
    case Verdict::ambiguous:
      return fmt::format(
          "{}: these logs cannot tell which; the model errs by {} with the likeliest, {} without.",
          fmt::join(causes, ", and "), with_effects, recalibrated);
    case Verdict::unexplained:
      break;
  }
  return fmt::format("A gap of {} that no effect of the catalogue closes; {}.", recalibrated,
                     floor_text(report));
}

std::string stamps_sentence(const GapReport& report) {
  if (report.stamped_early_s <= 0.0) return "";
  return fmt::format("The pressures are stamped {:.2g} ms early, which counts as calibration.",
                     1e3 * report.stamped_early_s);
}

std::string next_text(const GapReport& report) {
  if (!report.next) return "";
  std::string text =
      fmt::format("{}: {} {}", report.next->excitation, report.next->instruction, report.next->why);
  if (!report.next->separates.empty()) {
    const bool many = report.next->separates.size() > 2;
    text += fmt::format(" It parts {}{} with probability {}.", listed(report.next->separates, "and"),
                        many ? ", two of them in the mean," : "", percent(report.next->power));
  }
  return text;
}

}  // namespace plenum::host::tools
