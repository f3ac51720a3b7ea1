#include "host-sim/diagnose/gap_report.hpp"

namespace plenum::host::diagnose {

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::none:
      return "none";
    case Verdict::calibration:
      return "calibration";
    case Verdict::explained:
      return "explained";
    case Verdict::partly_explained:
      return "partly_explained";
    case Verdict::ambiguous:
      return "ambiguous";
    case Verdict::unexplained:
      break;
  }
  return "unexplained";
}

}  // namespace plenum::host::diagnose
