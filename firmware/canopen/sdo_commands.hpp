// Command bytes of the SDO protocol (CiA 301, 7.2.4.3), for the sources of the SDO server only.
#pragma once

#include "firmware/canopen/sdo_server.hpp"

namespace plenum::canopen::sdo {

// command specifiers of the client, in bits 7..5
inline constexpr unsigned kDownloadSegment = 0;
inline constexpr unsigned kInitiateDownload = 1;
inline constexpr unsigned kInitiateUpload = 2;
inline constexpr unsigned kUploadSegment = 3;
inline constexpr unsigned kAbortTransfer = 4;
inline constexpr unsigned kBlockUpload = 5;
inline constexpr unsigned kBlockDownload = 6;

inline constexpr std::uint8_t kToggleBit = 0x10;
inline constexpr std::uint8_t kCrcBit = 0x04;       ///< of initiating a block transfer, either side
inline constexpr std::uint8_t kSizeBit = 0x02;      ///< likewise: the size is announced
inline constexpr std::uint8_t kLastSegment = 0x80;  ///< of a block's segment
inline constexpr std::uint8_t kMaxBlockSize = 127;  ///< segments of a sub-block

/// An answer that names an object.
inline void multiplex(SdoServer::Bytes& response, std::uint8_t command, std::uint16_t index,
                      std::uint8_t sub) noexcept {
  response = {command, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub, 0, 0, 0,
              0};
}

inline std::uint16_t index_of(const SdoServer::Bytes& request) noexcept {
  return static_cast<std::uint16_t>(load_le(std::span(request).subspan<1, 2>()));
}

inline std::uint32_t size_in(const SdoServer::Bytes& request) noexcept {
  return load_le(std::span(request).subspan<4, 4>());
}

}  // namespace plenum::canopen::sdo
