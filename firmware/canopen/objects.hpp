// Where things stand in the object dictionary: the names that a client and the node share.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/config/limits.hpp"
#include "firmware/config/model_desk.hpp"
#include "firmware/config/model_set.hpp"
#include "firmware/telemetry/recorder.hpp"

namespace plenum::canopen {

inline constexpr std::size_t kRpdos = 4;
inline constexpr std::size_t kTpdos = 12;
inline constexpr std::size_t kMappable = 8;  ///< objects in one PDO
inline constexpr std::size_t kErrorHistory =
    32;  ///< entries of 1003h: what began is not lost behind what followed from it

/// Largest DOMAIN that crosses the bus [bytes].
inline constexpr std::size_t kMaxDomainBytes = config::kMaxSetBytes;

/// Device type: low word 408 (fluid power), high word FFFFh (several modules).
inline constexpr std::uint32_t kDeviceType =
    0xFFFF'0198U;  ///< several modules, each of which says its own at 67FFh + 800h x
inline constexpr std::uint32_t kModuleType = 0x0198U;

namespace object {
/// The nth, from 0, of objects that follow each other: of a chamber, of a PDO.
constexpr std::uint16_t nth(std::uint16_t index, std::size_t n) noexcept {
  return static_cast<std::uint16_t>(index + n);
}

inline constexpr std::uint16_t kDeviceTypeIndex = 0x1000;
inline constexpr std::uint16_t kErrorRegister = 0x1001;
inline constexpr std::uint16_t kErrorHistoryIndex = 0x1003;
inline constexpr std::uint16_t kSyncCobId = 0x1005;
inline constexpr std::uint16_t kDeviceName = 0x1008;
inline constexpr std::uint16_t kHardwareVersion = 0x1009;
inline constexpr std::uint16_t kSoftwareVersion = 0x100A;
inline constexpr std::uint16_t kStore = 0x1010;    ///< {all, communication, application}
inline constexpr std::uint16_t kRestore = 0x1011;  ///< as kStore
inline constexpr std::uint16_t kEmergencyCobId = 0x1014;
inline constexpr std::uint16_t kHeartbeatTime = 0x1017;
inline constexpr std::uint16_t kIdentity = 0x1018;
inline constexpr std::uint16_t kSdoServer = 0x1200;
inline constexpr std::uint16_t kRpdoCommunication = 0x1400;
inline constexpr std::uint16_t kRpdoMapping = 0x1600;
inline constexpr std::uint16_t kTpdoCommunication = 0x1800;
inline constexpr std::uint16_t kTpdoMapping = 0x1A00;

inline constexpr std::uint16_t kSchema = 0x2100;       ///< {hash, parameter count, scalar format}
inline constexpr std::uint16_t kStagedModel = 0x2110;  ///< + chamber, DOMAIN, write only
inline constexpr std::uint16_t kActiveModel = 0x2118;  ///< + chamber, DOMAIN, read only
inline constexpr std::uint16_t kCommit = 0x2120;       ///< {mask, CRC-32, key}; writing the key commits
inline constexpr std::uint16_t kUploadSession =
    0x2121;  ///< {owner's token, release, ms left}: upload_session.hpp
inline constexpr std::uint16_t kStagedSet =
    0x2122;                                         ///< {images (DOMAIN, write only), outcome}: model_set.hpp
inline constexpr std::uint8_t kSetUnderWay = 0xFF;  ///< outcome of a set that is still being staged
/// + chamber {state, reason, CRC, generation, parameter, value, low, high, shadow run, RMS Pa staged, RMS Pa active,
/// CRC staged, serial expected, failing point: pressure Pa, volume m3, command V, pressure wanted Pa, that came Pa}
inline constexpr std::uint16_t kSetState = 0x2128;
inline constexpr std::uint16_t kStoredSet =
    0x2130;  ///< {phase, found at start, generation, rows skipped, first of them, failures}
inline constexpr std::uint16_t kSerials = 0x2148;  ///< + chamber {valve, sensor}: built in; 0: not stated
inline constexpr std::uint16_t kPascals =
    0x2150;  ///< + chamber {set point Pa, actual Pa, volume m3, position sensor V}
inline constexpr std::uint16_t kSupply = 0x2158;  ///< REAL32 [Pa]
inline constexpr std::uint16_t kPreviewTicks = 0x2160;
inline constexpr std::uint16_t kHealth = 0x2200;
inline constexpr std::uint16_t kLatency = 0x2201;  ///< + 1 + bin of telemetry/latency_histogram.hpp
inline constexpr std::uint16_t kRegulator =
    0x2210;  ///< + chamber {feedforward V, feedback V, command V, residual Pa, drift Pa}
inline constexpr std::uint16_t kCodes = 0x2220;          ///< + chamber {command code, volume code}
inline constexpr std::uint16_t kCodeScale = 0x2228;      ///< {command LSB V, volume LSB m3}
inline constexpr std::uint16_t kRegulation = 0x2230;     ///< + 1 + chamber: bits of `regulation`
inline constexpr std::uint16_t kCapture = 0x2300;        ///< {order, chamber, length, state, rows}
inline constexpr std::uint16_t kCaptureBuffer = 0x2301;  ///< DOMAIN, read only: telemetry/recorder.hpp
inline constexpr std::uint16_t kExcitation =
    0x2310;  ///< + chamber {seed, command low V, high V, pressure low Pa, high Pa}

inline constexpr std::uint16_t kChamberSettings =
    0x2400;                                               ///< + chamber, REAL32, as config/setting_fields.hpp
inline constexpr std::uint16_t kChamberTicks = 0x2408;    ///< + chamber, UNSIGNED16, likewise
inline constexpr std::uint16_t kChamberChoices = 0x2410;  ///< + chamber {in use, safe output}
inline constexpr std::uint16_t kBoardSettings = 0x2418;   ///< REAL32, likewise
inline constexpr std::uint16_t kBoardTicks = 0x2419;      ///< UNSIGNED16, likewise
inline constexpr std::uint16_t kSettingRefusal =
    0x241A;  ///< {chamber from 1, reason, field, value, low, high}
inline constexpr std::uint16_t kFaultReactions = 0x2830;  ///< + the faults, the most urgent first
inline constexpr std::uint16_t kStandingFaults =
    0x2831;  ///< {at each chamber, at the board}: bit k - 1 that of 2830h:k

inline constexpr std::uint16_t kControlWord = 0x6040;
inline constexpr std::uint16_t kStatusWord = 0x6041;
inline constexpr std::uint16_t kDeviceMode = 0x6042;
inline constexpr std::uint16_t kControlMode = 0x6043;
inline constexpr std::uint16_t kErrorCode = 0x604E;

inline constexpr std::uint16_t kChamberStride = 0x800;  ///< the indices below are of chamber 0
/// The object in the module of another chamber, from 0.
constexpr std::uint16_t of_module(std::uint16_t index, std::size_t chamber) noexcept {
  return static_cast<std::uint16_t>(index + chamber * kChamberStride);
}

inline constexpr std::uint16_t kSetpoint = 0x6380;  ///< {I16 mbar, unit, prefix}, as the next three
inline constexpr std::uint16_t kActual = 0x6381;
inline constexpr std::uint16_t kDemand = 0x6390;
inline constexpr std::uint16_t kUpperLimit = 0x63A0;
inline constexpr std::uint16_t kLowerLimit = 0x63A1;
inline constexpr std::uint16_t kHoldSetpoint = 0x6394;
inline constexpr std::uint16_t kDeviation = 0x63D0;
}  // namespace object

/// Bits of 6040h and 6041h (CiA 408). The state is the low four bits: 7 and Fh stand for ACTIVE.
namespace word {
inline constexpr std::uint16_t kDisabled = 0x1;  ///< D
inline constexpr std::uint16_t kHold = 0x3;      ///< D and H
inline constexpr std::uint16_t kActive = 0x7;    ///< D, H and M
inline constexpr std::uint16_t kStateMask = 0x7;
inline constexpr std::uint16_t kResetFault = 0x8;  ///< R of 6040h, on its rising edge
inline constexpr std::uint16_t kReady = 0x8;       ///< R of 6041h: no fault
}  // namespace word

/// Bits of 2230h. In 6041h they stand eight bits higher (CiA 408 has the last three there): those of any chamber, but of
/// kOnTarget that it is every one's that watches for it.
namespace regulation {
inline constexpr std::uint8_t kOnTarget = 0x1;
inline constexpr std::uint8_t kRampRuns = 0x2;
inline constexpr std::uint8_t kLimitTouched = 0x4;
inline constexpr std::uint8_t kDeviates = 0x8;
}  // namespace regulation

/// One LSB of a command code: FFFFh stands for 10 V.
inline constexpr float kCommandLsb_V = telemetry::kCommandLsb_V;
/// Default LSB of a volume code: FFFFh stands for 6.5535 L. Object 2228h:2 changes it.
inline constexpr float kVolumeLsb_m3 = 1.0e-7F;

/// Set points beyond these are refused [Pa, absolute]: what a 16-bit value in mbar can carry.
inline constexpr float kSetpointLow_Pa = 0.0F;
inline constexpr float kSetpointHigh_Pa = 3'276'700.0F;

}  // namespace plenum::canopen
