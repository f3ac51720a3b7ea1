#include "host-sim/identify/orifice/filter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace plenum::host::identify::orifice {
namespace {

// Means of `window` rows that begin every `stride` rows.
std::vector<double> means(const std::vector<double>& x, std::size_t window, std::size_t stride) {
  std::vector<double> mean;
  mean.reserve(x.size() / stride);
  for (std::size_t i = 0; i + window <= x.size(); i += stride) {
    const auto first = x.begin() + static_cast<std::ptrdiff_t>(i);
    const double sum = std::accumulate(first, first + static_cast<std::ptrdiff_t>(window), 0.0);
    mean.push_back(sum / static_cast<double>(window));
  }
  return mean;
}

VesselRecord averaged(const VesselRecord& record, const char* what, std::size_t window, std::size_t stride) {
  if (window == 0 || window > record.time_s.size())
    throw std::invalid_argument(
        fmt::format("{}: {} rows, expected 1 to the record's {}", what, window, record.time_s.size()));
  return {record.flow, means(record.time_s, window, stride), means(record.vessel_Pa, window, stride),
          means(record.far_Pa, window, stride)};
}

}  // namespace

std::vector<double> cyclic_average(const std::vector<double>& samples, std::size_t periods) {
  if (periods == 0 || samples.empty() || samples.size() % periods != 0)
    throw std::invalid_argument(
        fmt::format("cyclic_average: {} samples, expected {} whole periods", samples.size(), periods));
  const std::size_t rows = samples.size() / periods;
  std::vector<double> mean(rows, 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) mean[i % rows] += samples[i];
  for (double& value : mean) value /= static_cast<double>(periods);
  return mean;
}

VesselRecord moving_average(const VesselRecord& record, std::size_t window) {
  return averaged(record, "moving_average", window, 1);
}

VesselRecord block_means(const VesselRecord& record, std::size_t rows) {
  return averaged(record, "block_means", rows, rows);
}

VesselRecord rows_of(const VesselRecord& record, std::size_t first, std::size_t last) {
  if (first > last || last > record.time_s.size())
    throw std::invalid_argument(fmt::format("rows_of: {} to {}, expected rows of the record's {}", first,
                                            last, record.time_s.size()));
  const auto of = [&](const std::vector<double>& x) {
    return std::vector<double>(x.begin() + static_cast<std::ptrdiff_t>(first),
                               x.begin() + static_cast<std::ptrdiff_t>(last));
  };
  return {record.flow, of(record.time_s), of(record.vessel_Pa), of(record.far_Pa)};
}

VesselRecord steady_far_side(VesselRecord record) {
  if (record.far_Pa.empty()) return record;
  const double sum = std::accumulate(record.far_Pa.begin(), record.far_Pa.end(), 0.0);
  record.far_Pa.assign(record.far_Pa.size(), sum / static_cast<double>(record.far_Pa.size()));
  return record;
}

double noise_deviation(const std::vector<double>& signal) {
  if (signal.size() < 3)
    throw std::invalid_argument(fmt::format("noise_deviation: {} values, expected 3 or more", signal.size()));
  std::vector<double> second;
  for (std::size_t i = 1; i + 1 < signal.size(); ++i)
    second.push_back(std::abs(signal[i + 1] - 2.0 * signal[i] + signal[i - 1]));
  const auto middle = second.begin() + static_cast<std::ptrdiff_t>(second.size() / 2);
  std::nth_element(second.begin(), middle, second.end());
  return *middle / (0.6745 * std::sqrt(6.0));
}

RateRecord differentiated(const VesselRecord& record) {
  validate(record, 3);
  RateRecord rates;
  rates.at.flow = record.flow;
  for (std::size_t i = 1; i + 1 < record.time_s.size(); ++i) {
    rates.at.time_s.push_back(record.time_s[i]);
    rates.at.vessel_Pa.push_back(record.vessel_Pa[i]);
    rates.at.far_Pa.push_back(record.far_Pa[i]);
    rates.rate_Pa_s.push_back((record.vessel_Pa[i + 1] - record.vessel_Pa[i - 1]) /
                              (record.time_s[i + 1] - record.time_s[i - 1]));
  }
  return rates;
}

}  // namespace plenum::host::identify::orifice
