// The data sheet that a board answers at 1021h.
#include <gtest/gtest.h>

#include <string>

#include "host-sim/client/session.hpp"
#include "host-sim/dictionary/data_sheet.hpp"
#include "tests/client/board_on_bus.hpp"

namespace plenum::host::dictionary {
namespace {

TEST(SheetOnBus, IsTheTextThatTheToolWrites) {
  client::BoardOnBus world;
  client::Session session(world, 5);
  const std::vector<std::uint8_t> bytes = session.sdo_read_domain(0x1021, 0);
  EXPECT_TRUE(std::string(bytes.begin(), bytes.end()) ==
              electronic_data_sheet({.vendor_id = 1, .product_code = 2}));
  EXPECT_EQ(session.read<std::uint8_t>(0x1022, 0), 0) << "plain text";
}

}  // namespace
}  // namespace plenum::host::dictionary
