// The scalar of the control core, chosen at build time, and the few functions of it that the core needs.
//
// All of firmware/control computes in Scalar; no file there names float or double. The functions below are the
// whole vocabulary: a fixed-point type that supplies them drops in without a change to a controller.
#pragma once

namespace plenum::numeric {

using Scalar = float;

}  // namespace plenum::numeric
