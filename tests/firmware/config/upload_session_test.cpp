#include "firmware/config/upload_session.hpp"

#include <gtest/gtest.h>

namespace plenum::config {
namespace {

constexpr std::uint32_t kA = 0xA, kB = 0xB;

TEST(UploadSession, LetsEverybodyInWhileThereIsNone) {
  UploadSession session;
  EXPECT_TRUE(session.admit());
  EXPECT_TRUE(session.admit());
  EXPECT_EQ(session.owner(), 0U);
}

TEST(UploadSession, RefusesASecondMasterUntilTheFirstOneIsDone) {
  UploadSession session;
  EXPECT_TRUE(session.take(kA));
  EXPECT_FALSE(session.take(kB));
  EXPECT_EQ(session.owner(), kA);
  EXPECT_TRUE(session.take(kA)) << "its own goes on";
  EXPECT_FALSE(session.release(kB));
  EXPECT_TRUE(session.release(kA));
  EXPECT_TRUE(session.take(kB));
}

TEST(UploadSession, LetsOneImageInForEachTake) {
  UploadSession session;
  ASSERT_TRUE(session.take(kA));
  EXPECT_TRUE(session.admit());
  EXPECT_FALSE(session.admit()) << "a master without a token";
  ASSERT_TRUE(session.take(kA));
  EXPECT_TRUE(session.admit());
  ASSERT_TRUE(session.release(kA));
  EXPECT_TRUE(session.admit());
}

TEST(UploadSession, KnowsNoMasterOfToken0) {
  UploadSession session;
  EXPECT_FALSE(session.take(0));
  EXPECT_FALSE(session.release(0));
}

TEST(UploadSession, EndsByItselfWhenItsMasterIsGone) {
  UploadSession session;
  ASSERT_TRUE(session.take(kA));
  for (std::uint32_t i = 1; i < UploadSession::kTimeout_ticks; ++i) session.tick();
  EXPECT_FALSE(session.take(kB));
  EXPECT_EQ(session.left_ticks(), 1U);
  session.tick();
  EXPECT_EQ(session.owner(), 0U);
  EXPECT_TRUE(session.admit()) << "what take() gave ends with the session, and nothing is left to refuse for";
  EXPECT_TRUE(session.take(kB));
}

TEST(UploadSession, IsRenewedByEachTake) {
  UploadSession session;
  ASSERT_TRUE(session.take(kA));
  for (int round = 0; round < 3; ++round) {
    for (std::uint32_t i = 1; i < UploadSession::kTimeout_ticks; ++i) session.tick();
    ASSERT_TRUE(session.take(kA));
  }
  EXPECT_EQ(session.left_ticks(), UploadSession::kTimeout_ticks);
}

}  // namespace
}  // namespace plenum::config
