#include "host-sim/trace/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

class RecordingFile : public testing::Test {
 protected:
  std::filesystem::path holding(const std::string& text) {
    std::ofstream(path_) << text;
    return path_;
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".csv");
  std::vector<std::string> notices_;
};

TEST_F(RecordingFile, HoldsTheColumnsThatWereAskedForWhateverTheirOrder) {
  const Recording read = read_recording(holding("force_N,remark,time_s\n1,by hand,0\n2,,0.5\n"),
                                        {"time_s", "force_N"}, {"speed_m_s"}, notices_);
  EXPECT_EQ(read.rows, 2U);
  EXPECT_THAT(read["time_s"], ElementsAre(0.0, 0.5));
  EXPECT_THAT(read["force_N"], ElementsAre(1.0, 2.0));
  EXPECT_FALSE(read.columns.contains("speed_m_s"));
  EXPECT_THAT(notices_, ElementsAre(AllOf(HasSubstr("column 'remark'"), HasSubstr("not asked for"))));
  EXPECT_DOUBLE_EQ(period_s(read), 0.5);
}

TEST_F(RecordingFile, IsKnownByTheColumnsThatItsHeaderNames) {
  const auto file = holding("t_s, p_bar ,remark\n0,7.5,fed\n");
  EXPECT_TRUE(has_columns(file, {"p_bar", "t_s"}));
  EXPECT_FALSE(has_columns(file, {"p_bar", "time_s"}));
  EXPECT_FALSE(has_columns("/dev/null", {}));  // no regular file
  EXPECT_FALSE(has_columns("missing.csv", {}));
}

TEST_F(RecordingFile, NamesTheFileWithoutItsFolder) {
  EXPECT_EQ(read_recording(holding("a\n1\n"), {"a"}, {}, notices_).name, path_.filename().string());
}

TEST_F(RecordingFile, MissingColumnIsNamedWithThoseThatAreThere) {
  EXPECT_THAT(
      [&] {
        read_recording(holding("time_s,power_W\n0,1\n"), {"time_s", "force_N"}, {}, notices_);
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("column 'force_N' is missing"), HasSubstr("power_W"))));
}

TEST_F(RecordingFile, BadCellIsNamedWithRowAndColumn) {
  EXPECT_THAT([&] { read_recording(holding("a,b\n1,2\n3,x\n"), {"a"}, {"b"}, notices_); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("row 2, column b"), HasSubstr("'x'"))));
}

TEST_F(RecordingFile, ColumnThatWasNotReadIsNotThere) {
  const Recording read = read_recording(holding("a,b\n1,2\n"), {"a"}, {}, notices_);
  EXPECT_THROW(static_cast<void>(read["b"]), std::out_of_range);
}

}  // namespace
}  // namespace plenum::host::trace
