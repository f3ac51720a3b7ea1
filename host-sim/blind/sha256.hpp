// SHA-256 (FIPS 180-4): what seals a label. Nothing else in the house needs a digest, so it is written out here.
#pragma once

#include <string>
#include <string_view>

namespace plenum::host::blind {

/// The digest of `bytes` in 64 lower-case hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

}  // namespace plenum::host::blind
