// A gap report in words: what the terminal and the page both say.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"

namespace plenum::host::tools {

/// The effects that the model holds, each with the rivals listed that it is not told from: "dead_time or sensor_lag".
std::vector<std::string> causes_of(const diagnose::GapReport& report);

/// One sentence that answers the question, with the effects named and the errors in kPa.
std::string verdict_sentence(const diagnose::GapReport& report);

/// What the model makes of the baseline; only where there is one.
std::string baseline_sentence(const diagnose::GapReport& report);

/// "p = 0.23": of so large an error of the recalibrated model, were there no gap.
std::string p_text(const diagnose::GapReport& report);

/// "noise alone makes 0.31 kPa", or what stands in its place with a baseline.
std::string floor_text(const diagnose::GapReport& report);

/// "natural_frequency_Hz 9.8 (9.7 to 9.9)"; an end that the log leaves open, and a bound that was hit, are told.
std::string text_of(const diagnose::Estimate& estimate);

/// The parameters worth a line each: all, or where a refinement has freed many, such as a spline's, those that do not refine.
std::vector<diagnose::Estimate> plain_parameters(const diagnose::NamedEffect& effect);

/// Those in one line, and how many more there are.
std::string parameters_text(const diagnose::NamedEffect& effect);

std::string percent(double share);

/// Three significant digits, in kPa.
std::string kPa_text(double pressure_Pa);

/// "a, b or c"
std::string listed(const std::vector<std::string>& names, std::string_view conjunction);

/// By how much the pressures are stamped early; empty where that does not show.
std::string stamps_sentence(const diagnose::GapReport& report);

/// What to do next, why, and what that parts with which probability; empty where the report plans nothing.
std::string next_text(const diagnose::GapReport& report);

}  // namespace plenum::host::tools
