#include "firmware/canopen/communication.hpp"

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::canopen {
namespace {

struct Mapped {
  std::uint32_t index;
  std::uint32_t sub;
  std::uint32_t bits;
};

/// The defaults are constants of this file, and a test activates each of them: the result needs no check
/// here.
void map(PdoParameters& parameters, bool receive, std::initializer_list<Mapped> objects) {
  std::uint8_t count = 0;
  for (const Mapped& object : objects) {
    parameters.mapping.packed[count++] = mapping_entry(object.index, object.sub, object.bits);
  }
  static_cast<void>(activate_mapping(parameters.mapping, count, receive));
}

constexpr std::uint16_t kSetpointDeadline_ms = 100;  ///< ten set points of a 100 Hz stream
constexpr std::uint16_t kStatusEvent_ms = 500;

constexpr std::uint8_t kEachSync = 1;
constexpr std::uint8_t kOnEvent = 255;

void map_four_chambers(PdoParameters& parameters, bool receive, std::uint16_t index, std::uint32_t first) {
  const auto at = [index, first](std::uint32_t i) {
    return Mapped{object::of_module(index, first + i), 1, 16};
  };
  map(parameters, receive, {at(0), at(1), at(2), at(3)});
}

}  // namespace

void state_revision(Identity& identity) noexcept {
  if (identity.revision == 0) identity.revision = dictionary_revision();
}

Communication delivered_communication() noexcept {
  Communication communication;
  communication.emergency_cob_id = cob::kEmergency;

  for (std::uint32_t n = 0; n < kRpdos; ++n) {
    communication.rpdo[n].change([n](PdoParameters& rpdo) {
      rpdo.cob_id = cob::kRpdo1 + 0x100 * n;
      rpdo.transmission_type = n < 2 ? kEachSync : kOnEvent;
      if (n < 2) {
        map_four_chambers(rpdo, true, object::kSetpoint, 4 * n);
        rpdo.event_timer_ms = kSetpointDeadline_ms;
      } else {
        map(rpdo, true, {{object::kControlWord, 0, 16}});
      }
      // A master that mirrors both would send two control words, of which it has set one.
      if (n == 3) rpdo.cob_id |= cob::kInvalid;
    });
  }

  for (std::uint32_t n = 0; n < kTpdos; ++n) {
    PdoParameters& tpdo = communication.tpdo[n].parameters;
    if (n < 4) {
      tpdo.cob_id = cob::kNoRtr | (cob::kTpdo1 + 0x100 * n);
      tpdo.transmission_type = n < 2 ? kEachSync : kOnEvent;
    } else {
      tpdo.cob_id = cob::kInvalid | cob::kNoRtr;
      tpdo.transmission_type = kEachSync;
    }
    if (n < 2) map_four_chambers(tpdo, false, object::kActual, 4 * n);
  }
  map(communication.tpdo[2].parameters, false, {{object::kStatusWord, 0, 16}});
  map(communication.tpdo[3].parameters, false, {{object::kStatusWord, 0, 16}, {object::kErrorCode, 0, 16}});
  for (const std::size_t n : {2U, 3U}) communication.tpdo[n].parameters.event_timer_ms = kStatusEvent_ms;
  for (std::uint32_t chamber = 0; chamber < config::kChambers; ++chamber) {
    map(communication.tpdo[4 + chamber].parameters, false,
        {{object::kPascals + chamber, 2, 32},
         {object::kCodes + chamber, 1, 16},
         {object::kCodes + chamber, 2, 16}});
  }
  return communication;
}

void give_node_id(Communication& delivered, std::uint8_t node_id) noexcept {
  const auto give = [node_id](std::uint32_t& cob_id) {
    if ((cob_id & cob::kIdMask) != 0) cob_id += node_id;  // an empty one is nobody's
  };
  give(delivered.emergency_cob_id);
  for (Rpdo& rpdo : delivered.rpdo) rpdo.change([&](PdoParameters& parameters) { give(parameters.cob_id); });
  for (Tpdo& tpdo : delivered.tpdo) give(tpdo.parameters.cob_id);
}

ErrorState error_state(const ProcessImage& image) noexcept {
  if (image.error_code != 0) {
    return {image.error_code, static_cast<std::uint8_t>(image.error_register | 0x01U), image.fault_chamber};
  }
  return {0, image.error_register, 0};
}

}  // namespace plenum::canopen
