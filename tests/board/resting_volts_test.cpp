#include "board/resting_volts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>

namespace plenum::board {
namespace {

using testing::ElementsAre;
using testing::Optional;

constexpr RestingVolts::Volts kFirst{5.0F, 5.0F, 5.0F, 5.0F, 5.0F, 5.0F, 5.0F, 0.0F};

class RestingVoltsTest : public testing::Test {
 protected:
  RestingVoltsTest() { std::filesystem::create_directory(folder_); }
  ~RestingVoltsTest() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("plenum-resting-" + std::to_string(::getpid()));
};

TEST_F(RestingVoltsTest, AreLeftToWhoComesAfter) {
  EXPECT_EQ(RestingVolts::left_in(folder_), std::nullopt);
  {
    RestingVolts resting(kFirst, folder_);
    EXPECT_THAT(RestingVolts::left_in(folder_), Optional(kFirst));
    resting.set(2, 4.5F);
  }
  EXPECT_THAT(RestingVolts::left_in(folder_),
              Optional(ElementsAre(5.0F, 5.0F, 4.5F, 5.0F, 5.0F, 5.0F, 5.0F, 0.0F)));
}

TEST_F(RestingVoltsTest, AreSeenByAProcessThatWasForkedBefore) {
  for (const std::filesystem::path& folder : {folder_, std::filesystem::path(), folder_ / "none"}) {
    RestingVolts resting(kFirst, folder);
    std::array<int, 2> go{};
    ASSERT_EQ(::pipe(go.data()), 0);
    const pid_t guard = ::fork();
    if (guard == 0) {
      char none = 0;
      ::_exit(::read(go[0], &none, 1) == 1 && resting.now()[1] == 3.5F ? 0 : 1);
    }
    resting.set(1, 3.5F);
    ASSERT_EQ(::write(go[1], "", 1), 1);
    int status = -1;
    ASSERT_EQ(::waitpid(guard, &status, 0), guard);
    EXPECT_EQ(status, 0) << folder;
    ::close(go[0]);
    ::close(go[1]);
  }
}

TEST_F(RestingVoltsTest, KeepTheLastThatAnOutputCanHold) {
  RestingVolts resting(kFirst, {});
  for (const float none : {-0.1F, 10.1F, std::nanf(""), std::numeric_limits<float>::infinity()})
    resting.set(0, none);
  EXPECT_EQ(resting.now()[0], 5.0F);
  resting.set(0, 10.0F);
  EXPECT_EQ(resting.now()[0], 10.0F);
}

TEST_F(RestingVoltsTest, ThatAreNotWholeAreNone) {
  { const RestingVolts resting(kFirst, folder_); }
  const std::filesystem::path file = folder_ / "resting";
  std::filesystem::resize_file(file, 39);
  EXPECT_EQ(RestingVolts::left_in(folder_), std::nullopt) << "short";
  { const RestingVolts resting(kFirst, folder_); }
  {
    std::fstream damaged(file, std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(8 + 3);
    damaged.put('\x7F');  // 5 V become some 1e38
  }
  EXPECT_EQ(RestingVolts::left_in(folder_), std::nullopt) << "beyond what an output can hold";
}

}  // namespace
}  // namespace plenum::board
