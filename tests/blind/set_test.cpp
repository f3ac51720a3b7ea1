#include "host-sim/blind/blind_set.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>

#include "host-sim/blind/score.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/log_csv.hpp"
#include "host-sim/trace/rig_toml.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::blind {
namespace {

class BlindSet : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("plenum-blind-test-" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  SetRequest request(const char* name, unsigned threads = 2) const {
    SetRequest made;
    made.folder = folder_ / name;
    made.cases = 3;
    made.seconds = 10.0;
    made.threads = threads;
    return made;
  }

  static std::map<std::string, std::string> files(const std::filesystem::path& folder) {
    std::map<std::string, std::string> found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) {
        found[entry.path().lexically_relative(folder).string()] = trace::read_whole_file(entry.path());
      }
    }
    return found;
  }

  std::filesystem::path folder_;
};

TEST_F(BlindSet, TheSameSeedGivesTheSameBytesOnAnyNumberOfThreads) {
  write_set(request("a", 1));
  write_set(request("b", 3));
  const auto a = files(folder_ / "a");
  EXPECT_EQ(a.size(), 3U * 5U);
  EXPECT_EQ(a, files(folder_ / "b"));
}

TEST_F(BlindSet, WhatTheUserHasReadsBackAndDoesNotNameTheCause) {
  write_set(request("set"));
  for (std::size_t i = 0; i < 3; ++i) {
    const auto folder = folder_ / "set" / case_name(i);
    const auto rig = trace::read_rig(folder / "rig.toml");
    EXPECT_EQ(trace::read_log(folder / "log.csv", rig).size(), 1001U);
    EXPECT_EQ(trace::read_log(folder / "heldout.csv", rig).size(), 601U);
    for (const auto& [name, text] : files(folder)) {
      for (const DepartureKind& kind : departure_kinds()) {
        EXPECT_EQ(text.find(kind.id), std::string::npos) << name << " tells " << kind.id;
      }
    }
  }
}

TEST_F(BlindSet, AChangedLabelLogOrRigIsRefused) {
  write_set(request("set"));
  EXPECT_NO_THROW(read_label(folder_ / "set", "case-0001"));
  for (const char* file :
       {"labels/case-0001.json", "case-0001/log.csv", "case-0001/heldout.csv", "case-0001/rig.toml"}) {
    const auto path = folder_ / "set" / file;
    const std::string before = trace::read_whole_file(path);
    std::string after = before;
    after[after.size() / 2] = after[after.size() / 2] == '1' ? '2' : '1';
    trace::write_whole_file(path, after);
    EXPECT_THROW(read_label(folder_ / "set", "case-0001"), trace::InputError) << file;
    trace::write_whole_file(path, before);
  }
  EXPECT_NO_THROW(read_label(folder_ / "set", "case-0001"));
}

TEST_F(BlindSet, ASetIsNotWrittenOverAnother) {
  write_set(request("set"));
  EXPECT_THROW(write_set(request("set")), trace::InputError);
}

TEST(BlindRecipes, EveryEffectMeetsEveryTier) {
  SetRequest request;
  request.kind = "one";
  std::set<std::pair<std::string, int>> met;
  for (std::size_t i = 0; i < 14 * 3; ++i) {
    const Recipe recipe = recipe_of(request, i);
    met.emplace(recipe.effects.front(), recipe.tier);
  }
  EXPECT_EQ(met.size(), 14U * 3U);
}

TEST(BlindRecipes, AMixedSetHoldsEveryKindInItsShare) {
  const SetRequest request;
  std::map<std::string, int> kinds;
  std::set<std::string> effects;
  for (std::size_t i = 0; i < 200; ++i) {
    const Recipe recipe = recipe_of(request, i);
    ++kinds[recipe.kind];
    if (recipe.kind == "many") {
      const std::set<std::string> different(recipe.effects.begin(), recipe.effects.end());
      EXPECT_EQ(different.size(), recipe.effects.size());
      EXPECT_GE(different.size(), 2U);
    }
    effects.insert(recipe.effects.begin(), recipe.effects.end());
  }
  EXPECT_EQ(kinds, (std::map<std::string, int>{{"one", 120}, {"many", 40}, {"none", 20}, {"unknown", 20}}));
  EXPECT_EQ(effects.size(), departure_kinds().size());
}

TEST(BlindRecipes, RefuseWhatContradictsItself) {
  SetRequest request;
  request.effect = "gremlin";
  EXPECT_THROW(recipe_of(request, 0), std::invalid_argument);
  request.effect = "neighbour";
  EXPECT_EQ(recipe_of(request, 0).kind, "unknown");
  request.kind = "one";
  EXPECT_THROW(recipe_of(request, 0), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::blind
