#include "host-sim/trace/whole_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

namespace fs = std::filesystem;

class WholeFile : public testing::Test {
 protected:
  WholeFile() { fs::create_directories(folder_); }
  ~WholeFile() override { fs::remove_all(folder_); }

  fs::path at(const std::string& name) const { return folder_ / name; }
  std::ptrdiff_t entries() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

 private:
  fs::path folder_ = fs::temp_directory_path() / ("plenum-whole-file-" + std::to_string(::getpid()));
};

TEST_F(WholeFile, WritesIntoAPipeAndLeavesItAPipe) {
  ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
  const int reader = ::open(at("pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  write_whole_file(at("pipe"), "answer");
  EXPECT_TRUE(fs::is_fifo(at("pipe")));
  std::array<char, 16> read{};
  EXPECT_EQ(::read(reader, read.data(), read.size()), 6);
  EXPECT_STREQ(read.data(), "answer");
  EXPECT_EQ(entries(), 1);
  ::close(reader);
}

TEST_F(WholeFile, ReplacesWhatALinkLeadsToAndNotTheLink) {
  fs::create_directory(at("there"));
  fs::create_symlink("there/file", at("middle"));
  fs::create_symlink("middle", at("link"));
  for (const char* bytes : {"new, where the link dangled", "old replaced"}) {
    write_whole_file(at("link"), bytes);
    EXPECT_TRUE(fs::is_symlink(at("link")));
    EXPECT_TRUE(fs::is_symlink(at("middle")));
    EXPECT_EQ(read_whole_file(at("there/file")), bytes);
  }
  EXPECT_EQ(entries(), 3);
}

TEST_F(WholeFile, RefusesALinkThatLeadsToItself) {
  fs::create_symlink("loop", at("loop"));
  EXPECT_THROW(write_whole_file(at("loop"), "x"), InputError);
  EXPECT_TRUE(fs::is_symlink(at("loop")));
  EXPECT_EQ(entries(), 1);
}

TEST_F(WholeFile, KeepsTheModeOfTheFileThatItReplaces) {
  write_whole_file(at("secret"), "old");
  fs::permissions(at("secret"), fs::perms::owner_read | fs::perms::owner_write);
  write_whole_file(at("secret"), "new");
  EXPECT_EQ(fs::status(at("secret")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(read_whole_file(at("secret")), "new");
}

}  // namespace
}  // namespace plenum::host::trace
