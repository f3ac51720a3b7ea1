// Command specifiers of the layer setting services (CiA 305), for the sources that speak or read them only.
#pragma once

namespace plenum::host::client::lss {

inline constexpr unsigned kSwitchGlobally = 0x04;
inline constexpr unsigned kConfigureNodeId = 0x11;
inline constexpr unsigned kConfigureBitTiming = 0x13;
inline constexpr unsigned kActivateBitTiming = 0x15;
inline constexpr unsigned kStore = 0x17;
inline constexpr unsigned kSwitchSelectively = 0x40;  ///< and the next: one number of the identity each
inline constexpr unsigned kSwitched = 0x44;
inline constexpr unsigned kIdentify =
    0x46;  ///< and the next: vendor, product, revision and serial from and to
inline constexpr unsigned kIdentifyUnconfigured = 0x4C;
inline constexpr unsigned kIdentified = 0x4F;
inline constexpr unsigned kUnconfigured = 0x50;
inline constexpr unsigned kFastscan = 0x51;
inline constexpr unsigned kInquire = 0x5A;  ///< and the next: one number of the identity each
inline constexpr unsigned kInquireNodeId = 0x5E;

inline constexpr unsigned kNumbers = 4;  ///< of an identity

}  // namespace plenum::host::client::lss
