// What LSS gave a board, as it stands in a stored set: bytes written by hand from the rows of parameter_record.hpp.
#include "firmware/config/lss_settings.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace plenum::config {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(LssSettings, StandInTheirRowsAmongOthers) {
  const Bytes body = {0x17, 0x10, 0, 2, 0xE8, 0x03,  // 1017h: 1000 ms
                      0,    0,    1, 1, 127,         // node id
                      0,    0,    3, 1, 5,           // the id at which parameters were saved
                      0,    0,    2, 2, 0x7D, 0x00};
  EXPECT_EQ(lss_in(body), (LssSettings{.node_id = 127, .bit_rate_kbit = 125}));
  EXPECT_EQ(lss_in({}), LssSettings{});
}

TEST(LssSettings, ValuesThatTheyCannotHaveAreLeftAlone) {
  const LssSettings before{.node_id = 5, .bit_rate_kbit = 500};
  for (const Bytes& row : {Bytes{0, 0, 1, 1, 128}, Bytes{0, 0, 1, 2, 6, 0}, Bytes{0, 0, 2, 1, 6},
                           Bytes{0, 0, 2, 4, 6, 0, 0, 0}, Bytes{0, 0, 4, 1, 6}, Bytes{1, 0, 1, 1, 6}}) {
    LssSettings settings = before;
    RecordRow parsed;
    ASSERT_TRUE(RowReader(row).next(parsed));
    EXPECT_FALSE(take_row(settings, parsed));
    EXPECT_EQ(settings, before);
  }
}

}  // namespace
}  // namespace plenum::config
