#include "host-sim/plant/relief_valve/multi_input.hpp"

#include <cmath>
#include <vector>

#include "host-sim/reproduce/relief_valve/parts.hpp"
#include "host-sim/reproduce/relief_valve/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::relief_valve {
namespace {

using namespace plant::relief_valve;

// Appendix A's volume, fluid and spool: (3.18) to (3.20) with numbers that the section itself does not give.
const MultiInputConfig kValve{.alpha1_m2 = 1.436 * kInch2_m2,
                              .alpha2_m2_s_sqrtPa = 1.157 * kInch_m * std::sqrt(2.0 / 961.0),
                              .alpha3_m3_s_sqrtPa = 1e-8,
                              .upstream_volume_m3 = 250.0 * kInch3_m3,
                              .bulk_modulus_Pa = 2.0e5 * kPsi_Pa};

constexpr double kStep_s = 1e-5;
constexpr int kRows = 20000;
constexpr double kInflow_m3_s = 1.6e-3;
constexpr double kSecondary_Pa = 2e5;

double x_m(double t) {
  return 4e-4 + 1e-4 * std::sin(60.0 * t);
}
double x_rate_m_s(double t) {
  return 6e-3 * std::cos(60.0 * t);
}
double primary_Pa(double t) {
  return 3e5 + 1e5 * std::sin(200.0 * t);
}
double primary_rate_Pa_s(double t) {
  return 2e7 * std::cos(200.0 * t);
}

/// (3.18) to (3.20) with the displacement known.
double rate_from_inside_Pa_s(double Ps, double t) {
  const double Q_pr = kValve.alpha2_m2_s_sqrtPa * x_m(t) * std::sqrt(Ps - primary_Pa(t));
  const double Q_sec = kValve.alpha3_m3_s_sqrtPa * std::sqrt(Ps - kSecondary_Pa);
  return kValve.bulk_modulus_Pa / kValve.upstream_volume_m3 *
         (kInflow_m3_s - Q_pr - Q_sec - kValve.alpha1_m2 * x_rate_m_s(t));
}

/// What a stand would measure at the ports.
MultiInputPorts ports(double Ps, double Ps_rate, double t) {
  const double drop = Ps - primary_Pa(t);
  const double gain = kValve.alpha2_m2_s_sqrtPa;
  return {
      .inflow_m3_s = kInflow_m3_s,
      .upstream_Pa = Ps,
      .primary_Pa = primary_Pa(t),
      .secondary_Pa = kSecondary_Pa,
      .primary_flow_m3_s = gain * x_m(t) * std::sqrt(drop),
      .primary_flow_rate_m3_s2 = gain * (x_rate_m_s(t) * std::sqrt(drop) +
                                         0.5 * x_m(t) * (Ps_rate - primary_rate_Pa_s(t)) / std::sqrt(drop)),
      .primary_rate_Pa_s = primary_rate_Pa_s(t)};
}

}  // namespace

Part multi_input_valve() {
  double inside_Pa = 5e6;
  double worst_rate = 0.0;
  double worst_x = 0.0;
  double largest_rate = 0.0;
  double from_ports_Pa = inside_Pa;
  double worst_Pa = 0.0;
  std::vector<double> time_s;
  std::vector<double> inside_psi;
  std::vector<double> ports_psi;
  for (int k = 0; k < kRows; ++k) {
    const double t = kStep_s * k;
    // One step of the inside by Runge-Kutta; the ports' rates at its middle carry the other model along.
    const double r1 = rate_from_inside_Pa_s(inside_Pa, t);
    const double r2 = rate_from_inside_Pa_s(inside_Pa + 0.5 * kStep_s * r1, t + 0.5 * kStep_s);
    const double r3 = rate_from_inside_Pa_s(inside_Pa + 0.5 * kStep_s * r2, t + 0.5 * kStep_s);
    const double r4 = rate_from_inside_Pa_s(inside_Pa + kStep_s * r3, t + kStep_s);
    const MultiInputPorts now = ports(inside_Pa, r1, t);
    const double rate = upstream_rate_Pa_s(kValve, now);
    worst_rate = greater_of(worst_rate, std::abs(rate - r1));
    largest_rate = greater_of(largest_rate, std::abs(r1));
    worst_x = greater_of(worst_x, std::abs(displacement_m(kValve, now) - x_m(t)));
    const double middle_Pa = inside_Pa + 0.5 * kStep_s * r2;
    from_ports_Pa +=
        kStep_s *
        upstream_rate_Pa_s(
            kValve, ports(middle_Pa, rate_from_inside_Pa_s(middle_Pa, t + 0.5 * kStep_s), t + 0.5 * kStep_s));
    inside_Pa += kStep_s / 6.0 * (r1 + 2.0 * (r2 + r3) + r4);
    worst_Pa = greater_of(worst_Pa, std::abs(from_ports_Pa - inside_Pa));
    if (k % 40 == 0) {
      time_s.push_back(t + kStep_s);
      inside_psi.push_back(inside_Pa / kPsi_Pa);
      ports_psi.push_back(from_ports_Pa / kPsi_Pa);
    }
  }
  Part part{.title = "(3.18) to (3.24): multi-input valve",
            .text =
                "A known movement of the element in (3.18) to (3.20) gives the flows and pressures at the "
                "ports; (3.24) gets the rate of "
                "the supply pressure from these alone. The section prints no numbers: volume, fluid and "
                "spool are those of appendix A. Two "
                "readings: the text calls for the derivatives of the first two of Q_in, P1, P2, the equation "
                "holds those of Q_pr and P1; and "
                "its denominator, alpha4 - alpha5 Q_pr/(Ps - P1)^1.5, vanishes where the volume swept for "
                "each unit of pressure equals the volume "
                "compressed, beyond which the model is refused.",
            .findings = {}};
  part.findings = {
      {.item = "(3.24)",
       .quantity =
           "largest difference of the supply's rate of pressure from (3.18) to (3.20), of the largest rate",
       .unit = "ppm",
       .paper = 0.0,
       .ours = 1e6 * worst_rate / largest_rate,
       .tolerance = 0.01,
       .source = Source::kPapersOwnEquation,
       .why = "(3.24) does not follow from (3.18) to (3.21)"},
      {.item = "(3.24)",
       .quantity = "largest difference of the supply pressure after 0.2 s",
       .unit = "psi",
       .paper = 0.0,
       .ours = worst_Pa / kPsi_Pa,
       .tolerance = 0.01,
       .why = "the pressure integrated from the ports leaves that from the inside"},
      {.item = "(3.19)",
       .quantity = "largest difference of the displacement inferred from the ports",
       .unit = "um",
       .paper = 0.0,
       .ours = 1e6 * worst_x,
       .tolerance = 1e-6,
       .source = Source::kPapersOwnEquation,
       .why = "(3.19) is not inverted"}};
  part.charts = {
      report::LineChart{.title = "Supply pressure",
                        .y = {"Pressure", "psi"},
                        .curves = {{"(3.18) to (3.20), movement known", time_s, inside_psi,
                                    report::Stroke::kSolid, report::Ink::kNeutral},
                                   {"(3.24), from the ports", time_s, ports_psi, report::Stroke::kDashed}}}};
  return part;
}

}  // namespace plenum::host::reproduce::relief_valve
