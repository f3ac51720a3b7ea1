// The duty of a guard, at a post of memory; tests/board/guarded_process_test.cpp has real processes.
#include "board/guard.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace plenum::board {
namespace {

using testing::ElementsAre;

class Post final : public GuardPost {
 public:
  explicit Post(Seen seen) : seen_(seen) {}

  Seen watch() noexcept override {
    did.emplace_back("watch");
    return seen_;
  }
  void kill() noexcept override { did.emplace_back("kill"); }
  void wait_for_end() noexcept override { did.emplace_back("wait"); }
  void make_safe() noexcept override { did.emplace_back("safe"); }
  void report(std::string_view line) noexcept override {
    EXPECT_EQ(line.substr(0, 3), "<3>") << "an error, to the journal";
    EXPECT_EQ(line.back(), '\n');
    did.emplace_back("report");
  }

  std::vector<std::string> did;

 private:
  Seen seen_;
};

TEST(GuardDuty, WhenTheLoopHasEndedTheOutputsAreMadeSafeBeforeAnythingElse) {
  Post post(GuardPost::Seen::end);
  stand_guard(post);
  EXPECT_THAT(post.did, ElementsAre("watch", "safe", "report"));
}

TEST(GuardDuty, ASilentLoopIsKilledAndWhatItStillWroteIsWrittenOver) {
  Post post(GuardPost::Seen::silence);
  stand_guard(post);
  EXPECT_THAT(post.did, ElementsAre("watch", "kill", "safe", "wait", "safe", "report"));
}

}  // namespace
}  // namespace plenum::board
