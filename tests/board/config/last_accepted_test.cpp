// The board.toml that was run by last: kept whole or not at all, and taken for nothing else.
#include "board/config/last_accepted.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace plenum::board::config {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kText = R"([can]
interface = "can0"
node_id = 5
[analog_input]
rate_Hz = 0
[[chamber]]
in_use = false
null_V = 4.5
[store]
folder = "/var/lib/plenum"
)";

class LastAccepted : public testing::Test {
 protected:
  LastAccepted() {
    std::filesystem::create_directory(folder_);
    write(installed_, "[can\n");
  }
  ~LastAccepted() override { std::filesystem::remove_all(folder_); }

  static void write(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  static std::string read(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }
  std::string refusal() const {
    try {
      choose_board(installed_, folder_);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "not refused";
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("plenum-accepted-" + std::to_string(::getpid()));
  const std::filesystem::path installed_ = folder_ / "board.toml";
  const std::filesystem::path kept_ = last_accepted_path(folder_);
};

TEST_F(LastAccepted, AFileThatIsRightIsTakenWhateverIsKept) {
  ASSERT_EQ(keep_accepted(kText, folder_), "");
  std::string changed = kText;
  write(installed_, changed.replace(changed.find("= 5"), 3, "= 6"));
  const ChosenBoard chosen = choose_board(installed_, folder_);
  EXPECT_EQ(chosen.board.settings.node.node_id, 6);
  EXPECT_FALSE(chosen.board.settings.configuration_refused);
  EXPECT_EQ(chosen.board.text, changed);
  EXPECT_EQ(chosen.refusal, "");
}

TEST_F(LastAccepted, StandsInForAFileThatIsRefusedWithItsFault) {
  ASSERT_EQ(keep_accepted(kText, folder_), "");
  const ChosenBoard chosen = choose_board(installed_, folder_);
  EXPECT_EQ(chosen.board.interface, "can0");
  EXPECT_EQ(chosen.board.settings.node.node_id, 5);
  EXPECT_EQ(chosen.board.analog_out.safe_V[0], 4.5F);
  EXPECT_TRUE(chosen.board.settings.configuration_refused);
  EXPECT_THAT(chosen.refusal, StartsWith(installed_.string() + ": line 1: "));
  EXPECT_THAT(chosen.refusal, HasSubstr("\n" + kept_.string() + ": was accepted last"));
}

TEST_F(LastAccepted, WithoutOneTheRefusalIsThatOfTheFile) {
  EXPECT_THAT(refusal(), StartsWith(installed_.string() + ": line 1: "));
  EXPECT_THAT(refusal(), testing::Not(HasSubstr("\n")));
  EXPECT_THROW(choose_board(installed_, ""), ConfigError);
}

TEST_F(LastAccepted, WithAnyByteOfItChangedOrMissingIsNotTaken) {
  ASSERT_EQ(keep_accepted(kText, folder_), "");
  const std::string whole = read(kept_);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write(kept_, damaged);
    EXPECT_THAT(refusal(), HasSubstr("\n" + kept_.string() + ": is damaged")) << "byte " << at;
    write(kept_, whole.substr(0, at));
    EXPECT_THAT(refusal(), HasSubstr("\n" + kept_.string() + ": is damaged")) << "of " << at << " bytes";
  }
}

TEST_F(LastAccepted, ThatThisProgramDoesNotAcceptIsNamedWithItsMistake) {
  ASSERT_EQ(keep_accepted("[can]\n", folder_), "");
  EXPECT_THAT(refusal(), HasSubstr("\n" + kept_.string() + ": line 1: can.interface is missing"));
}

TEST_F(LastAccepted, IsReplacedAsAWholeAndNotTouchedWhereItIsTheSame) {
  ASSERT_EQ(keep_accepted(kText, folder_), "");
  struct stat first {
  }, again{}, other{};
  ASSERT_EQ(::stat(kept_.c_str(), &first), 0);
  ASSERT_EQ(keep_accepted(kText, folder_), "");
  ASSERT_EQ(::stat(kept_.c_str(), &again), 0);
  EXPECT_EQ(again.st_ino, first.st_ino);
  EXPECT_EQ(again.st_mtim.tv_nsec, first.st_mtim.tv_nsec);
  write(folder_ / "board.toml.accepted.new",
        "what a power cut has left, longer than what is written now" + kText);
  const std::filesystem::path reader = folder_ / "as one reads it";
  std::filesystem::create_hard_link(kept_, reader);
  const std::string before = read(kept_);
  ASSERT_EQ(keep_accepted(kText + "# another\n", folder_), "");
  ASSERT_EQ(::stat(kept_.c_str(), &other), 0);
  EXPECT_NE(other.st_ino, first.st_ino);
  EXPECT_EQ(read(reader), before) << "written in place: a power cut would leave half of it";
  EXPECT_EQ(choose_board(installed_, folder_).board.text, kText + "# another\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "board.toml.accepted.new"));
}

// `--safe` reads it as root, in a folder where the service may put what it likes.
TEST_F(LastAccepted, IsNeitherALinkNorAPipeNorWithoutEnd) {
  ASSERT_EQ(keep_accepted(kText, folder_), "");
  const std::filesystem::path elsewhere = folder_ / "elsewhere";
  std::filesystem::rename(kept_, elsewhere);
  std::filesystem::create_symlink(elsewhere, kept_);
  EXPECT_THAT(refusal(), HasSubstr(kept_.string() + ": Too many levels of symbolic links"));
  std::filesystem::remove(kept_);
  ASSERT_EQ(::mkfifo(kept_.c_str(), 0600), 0);
  EXPECT_THAT(refusal(), HasSubstr(kept_.string() + ": Invalid argument"));
  std::filesystem::remove(kept_);
  write(kept_, "");
  std::filesystem::resize_file(kept_, std::uintmax_t{2} << 20U);
  EXPECT_THAT(refusal(), HasSubstr(kept_.string() + ": Invalid argument"));
}

TEST_F(LastAccepted, IsNotKeptWithoutAFolderAndAFolderThatTakesNothingIsNamed) {
  EXPECT_EQ(keep_accepted(kText, ""), "");
  EXPECT_EQ(keep_accepted(kText, "/nowhere"),
            "/nowhere/board.toml.accepted: No such file or directory, expected a folder that this user may "
            "write, with room for a board.toml");
}

}  // namespace
}  // namespace plenum::board::config
