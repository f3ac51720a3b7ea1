// The logs tell too little for a diagnosis: one line that says why. Tools map it to exit code 3.
#pragma once

#include <stdexcept>

namespace plenum::host::diagnose {

class CannotDiagnose : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace plenum::host::diagnose
