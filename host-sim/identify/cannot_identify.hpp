// The computation could not be done on these data: one line that says why. Tools map it to exit code 3.
#pragma once

#include <stdexcept>

namespace plenum::host::identify {

class CannotIdentify : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace plenum::host::identify
