// The inner loops of squares.cpp on plain arrays: compiled once for every x86-64 machine and once for those
// with AVX2 and FMA (x86-64-v3), and chosen at run time. Nothing but these loops may stand in
// tick_kernel.cpp: an inline function of a library compiled there could be picked by the linker for the whole
// program, and fail on an older machine.
//
// Quantities of a tick, all functions of s and r of (10), with x = r h limited to [least, greatest], z = x
// a/h:
//   decay  = e^-x                     p_end = s + (p - s) decay                                         (7)
//   unseen = z/(e^z - 1)              p_end = s + (y - s) unseen        y the mean over the last a
//   seen   = decay/unseen             y     = s + (p - s) seen
#pragma once

#include <cstddef>

namespace plenum::host::identify {

struct KernelInput {
  const double* command_V;
  const double* volume_mL;
  const double* volume_rate_mL_s;
  double shape[9];  ///< as Shape in squares.hpp
  double c_b_kPa, c_s_kPa, c_gamma_V;
  double period_s;            ///< h
  double share;               ///< a/h, 0 to 1
  double per_mean_volume_mL;  ///< 1/V
  double least, greatest;     ///< of r h
  double pole;                ///< kPole
  bool repaired;              ///< the form
};

/// Arrays of as many doubles as ticks are asked for.
struct KernelTerms {
  double *s, *decay, *seen, *unseen;
  double *decay_by_r, *seen_by_r, *unseen_by_r;  ///< [s]
  double* by_s[9];                               ///< ds by shape; null where it does not depend
  double* by_r[9];                               ///< dr by shape, likewise
};

/// Whether s and r of a form depend on the shape's figure at `place`.
constexpr bool in_s(bool repaired, int place) {
  return place < 3 || (repaired ? place == 4 || place >= 6 : place == 3);
}
constexpr bool in_r(int place) {
  return place == 0 || place >= 4;
}

struct Kernel {
  /// Fills s, decay, seen, unseen of n ticks, and with `slopes` the rest.
  void (*terms)(const KernelInput& input, std::size_t n, bool slopes, KernelTerms& out);
  /// Sum of squared one-step errors of n ticks whose terms start one tick before them; y[i], y[i + 1] their
  /// samples.
  double (*one_step_squares)(const KernelTerms& terms, const double* y, std::size_t n);
  /// Adds to gram[i * columns + j], j <= i, the products of the columns of [J e]; `columns` has 10 columns of
  /// `stride`.
  void (*one_step_gram)(const KernelTerms& terms, const double* y, std::size_t n, double* columns,
                        std::size_t stride, double* gram);
};

/// The fastest kernel that this machine runs.
const Kernel& kernel();

}  // namespace plenum::host::identify
