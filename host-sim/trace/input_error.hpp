// Bad input: one line that says where, what was found, and what was expected. Tools map it to exit code 2.
#pragma once

#include <stdexcept>

namespace plenum::host::trace {

class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace plenum::host::trace
