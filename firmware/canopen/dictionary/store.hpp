// Object 2130h: what is stored, and how storing goes (own).
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"

namespace plenum::canopen::dictionary {

template <auto member>
Abort read_store(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.image.store.*member);
  return Abort::none;
}

inline constexpr Entry kStoreRows[] = {
    highest<6>(0x2130, kOnce, "Stored parameter set"),
    value(0x2130, 1, kOnce, "Phase of storing", unsigned8, read_only, no, kAny,
          read_store<&StoreImage::phase>),
    value(0x2130, 2, kOnce, "Found at start", unsigned8, read_only, no, kAny,
          read_store<&StoreImage::loaded>),
    value(0x2130, 3, kOnce, "Generation", unsigned32, read_only, no, kAny,
          read_store<&StoreImage::generation>),
    value(0x2130, 4, kOnce, "Rows skipped at start", unsigned16, read_only, no, kAny,
          read_store<&StoreImage::skipped_rows>),
    value(0x2130, 5, kOnce, "First row skipped (index, sub-index)", unsigned32, read_only, no, kAny,
          read_store<&StoreImage::first_skipped>),
    value(0x2130, 6, kOnce, "Failed attempts to store", unsigned32, read_only, no, kAny,
          read_store<&StoreImage::failures>),
};

}  // namespace plenum::canopen::dictionary
