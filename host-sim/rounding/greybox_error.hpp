// A bound of what rounding in Q31.32 changes in a tick of a grey-box model.
//
// A tick of the core solves p' = f(p) from corner to corner of a broken line f (firmware/control/greybox.hpp). Which corner comes
// next, and by which formula a piece is solved, the board decides by comparing rounded numbers, so that no interval can follow it.
// But whatever it decides, what it walks along is a solution of p' = f(p) + e, with
//   - e the difference between f and the broken line through the board's own corners and rates, and
//   - jumps where a piece is computed: the time to a corner rounded, a series for a logarithm, the last piece's exponential,
// and the core in exact numbers, which decides for itself, differs from the solution by the jumps of its decisions alone. So (Gronwall)
//   |p_board - p| <= G (sup |e| + sum of the jumps),   G the most that a difference grows within a tick.
// `e` needs no analysis: the tables of a parameter set are the same on every board, so the board's are made here and compared with
// those in double (greybox_tables.hpp). Times and rates are bounded over all states at once, in the smallest volume, where all of
// them are greatest; so the bound is some hundred times what a chamber of usual size sees.
//
// Growth: J = df/dp <= J_+, hence G <= e^J_+. Where J_+ is large, because the choked flow of an inlet rises with the pressure, a
// second bound is better: J p - f is a sum over ports of c (phi' p - phi), in which speed and leak have no positive part, so with
// E the largest such sum, J <= (f + E)/p and G <= (highest pressure/lowest) e^(E/lowest).
#pragma once

#include "host-sim/rounding/greybox_tables.hpp"

namespace rounding {

/// [kPa], of end and mean of a tick, over
///   pressures from ambient to supply,   commands of 0 to 10 V,   volumes of 1 mL to 10 L, dead volume included and
///   not below it,   speeds that change that volume by half in a tick at most, and 1.5 L/s,   the supply's pressure as the model states it;
/// infinite where the bound cannot be had (a number may pass the range, or a difference grows beyond all use).
/// `board`: the tables in fixed point; `exact`: in double, of the same parameters.
double greybox_tick_error_kPa(const GreyboxTables& board, const GreyboxTables& exact);

}  // namespace rounding
