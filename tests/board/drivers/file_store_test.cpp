// The parameter store in files: what it keeps, who writes it, and what it says when the disk does not take it. That a set
// survives a power cut is config::RecordStore's, and tested there.
#include "board/drivers/file_store.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "firmware/config/parameter_record.hpp"

namespace plenum::board::drivers {
namespace {

using ports::StoreResult;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

class FileStoreTest : public ::testing::Test {
 protected:
  FileStoreTest() {
    std::string name = ::testing::TempDir() + "plenum-store-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder " + name);
    folder_ = name;
  }
  ~FileStoreTest() override { std::filesystem::remove_all(folder_); }

  std::string failure() const {
    try {
      const FileStore store(folder_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no failure";
  }

  std::string found_by_a_look() const {
    try {
      FileStore::look(folder_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no failure";
  }

  std::filesystem::path folder_;
};

/// A regular file that takes no byte more, as on a disk that is full.
class FullFile {
 public:
  FullFile() : file_(::memfd_create("full", MFD_ALLOW_SEALING | MFD_CLOEXEC)) {
    if (::fcntl(file_, F_ADD_SEALS, F_SEAL_GROW) != 0) throw std::runtime_error("no file that can be sealed");
  }
  ~FullFile() { ::close(file_); }
  FullFile(const FullFile&) = delete;
  FullFile& operator=(const FullFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

/// Asks until the answer comes, as the board's ticks do.
template <class Ask>
StoreResult answer(const Ask& ask) {
  StoreResult result = ask();
  while (result == StoreResult::busy) {
    std::this_thread::yield();
    result = ask();
  }
  return result;
}

StoreResult write(FileStore& store, std::uint8_t slot, std::size_t offset, const Bytes& bytes) {
  return answer([&] { return store.write(slot, offset, bytes); });
}

StoreResult sync(FileStore& store, std::uint8_t slot) {
  return answer([&] { return store.sync(slot); });
}

Bytes read(FileStore& store, std::uint8_t slot, std::size_t offset, std::size_t size) {
  Bytes bytes(size, 0xEE);
  EXPECT_TRUE(store.read(slot, offset, bytes));
  return bytes;
}

Bytes counting(std::size_t size) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
  return bytes;
}

TEST_F(FileStoreTest, IsOfOneProgramAtATime) {
  {
    const FileStore store(folder_);
    EXPECT_THAT(failure(),
                HasSubstr("store:" + folder_.string() + ": another program stores in it, expected"));
  }
  EXPECT_EQ(failure(), "no failure") << "it is gone";
}

TEST_F(FileStoreTest, WhatWasWrittenIsThereAfterReopening) {
  const Bytes first = counting(512);
  const Bytes second = counting(77);
  {
    FileStore store(folder_);
    EXPECT_EQ(write(store, 0, 0, first), StoreResult::done);
    EXPECT_EQ(write(store, 1, config::kMaxSlotBytes - second.size(), second), StoreResult::done);
    EXPECT_EQ(sync(store, 0), StoreResult::done);
    EXPECT_EQ(sync(store, 1), StoreResult::done);
  }
  FileStore store(folder_);
  EXPECT_EQ(read(store, 0, 0, first.size()), first);
  EXPECT_EQ(read(store, 1, config::kMaxSlotBytes - second.size(), second.size()), second);
  EXPECT_THAT(read(store, 0, first.size(), 100), Each(0)) << "what was never written";
}

TEST_F(FileStoreTest, AWriteChangesTheBytesItNamesAndNoOthers) {
  FileStore store(folder_);
  ASSERT_EQ(write(store, 0, 0, Bytes(10, 7)), StoreResult::done);
  ASSERT_EQ(write(store, 0, 4, {1, 2}), StoreResult::done);
  EXPECT_EQ(read(store, 0, 0, 11), (Bytes{7, 7, 7, 7, 1, 2, 7, 7, 7, 7, 0}));
  EXPECT_THAT(read(store, 1, 0, 11), Each(0)) << "the other slot";
}

TEST_F(FileStoreTest, AFolderOfACrashedStoreIsTakenAsItIs) {
  std::ofstream(folder_ / "slot-b.bin", std::ios::binary) << "half";
  FileStore store(folder_);
  EXPECT_EQ(read(store, 1, 0, 6), (Bytes{'h', 'a', 'l', 'f', 0, 0}));
}

TEST_F(FileStoreTest, EachOrderIsBusyFirstAndAnsweredOnce) {
  FileStore store(folder_);
  const Bytes bytes = counting(3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(store.write(0, 0, bytes), StoreResult::busy) << "order " << i;
    EXPECT_EQ(write(store, 0, 0, bytes), StoreResult::done);
  }
  EXPECT_EQ(store.sync(0), StoreResult::busy);
  EXPECT_EQ(sync(store, 0), StoreResult::done);
}

TEST_F(FileStoreTest, AnOrderThatWasGivenUpAnswersNoOther) {
  const FullFile full;
  std::filesystem::create_symlink(full.path(), folder_ / "slot-a.bin");
  FileStore store(folder_);
  const Bytes refused = counting(3);
  const Bytes taken = counting(3);
  EXPECT_EQ(store.write(0, 0, refused), StoreResult::busy);
  EXPECT_EQ(write(store, 1, 0, taken), StoreResult::done);
}

TEST_F(FileStoreTest, TheCallersThreadWritesNothing) {
  // The kernel counts the write system calls of each thread.
  const auto own_writes = []() -> std::string {
    std::ifstream file("/proc/thread-self/io");
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("syscw:")) return line;
    }
    return {};
  };
  FileStore store(folder_);
  const std::string before = own_writes();
  if (before.empty()) GTEST_SKIP() << "no /proc/thread-self/io: this kernel lacks CONFIG_TASK_IO_ACCOUNTING";
  ASSERT_EQ(write(store, 0, 0, counting(512)), StoreResult::done);
  EXPECT_EQ(own_writes(), before);
}

TEST_F(FileStoreTest, AStoreThatEndsHasCarriedOutItsOrder) {
  const Bytes bytes = counting(512);
  {
    FileStore store(folder_);
    EXPECT_EQ(store.write(0, 0, bytes), StoreResult::busy);
  }
  FileStore store(folder_);
  EXPECT_EQ(read(store, 0, 0, bytes.size()), bytes);
}

TEST_F(FileStoreTest, AnOrderIsCarriedOutThoughItsBytesAreGone) {
  const Bytes bytes = counting(512);
  for (int i = 0; i < 20; ++i) {
    {
      FileStore store(folder_);
      ASSERT_EQ(write(store, 0, 0, Bytes(512)), StoreResult::done);
      Bytes passing = bytes;
      EXPECT_EQ(store.write(0, 0, passing), StoreResult::busy);
      std::fill(passing.begin(), passing.end(), std::uint8_t{0xEE});
    }
    FileStore store(folder_);
    ASSERT_EQ(read(store, 0, 0, bytes.size()), bytes) << "round " << i;
  }
}

TEST_F(FileStoreTest, ADiskThatIsFullFailsTheWriteAndTheOtherSlotWorks) {
  const FullFile full;
  std::filesystem::create_symlink(full.path(), folder_ / "slot-a.bin");
  FileStore store(folder_);
  EXPECT_EQ(write(store, 0, 0, {1}), StoreResult::failed);
  EXPECT_EQ(write(store, 0, 0, {1}), StoreResult::failed) << "tried again";
  EXPECT_EQ(write(store, 1, 0, {1}), StoreResult::done);
}

TEST_F(FileStoreTest, AMediumThatCannotSyncFailsTheSync) {
  // a regular file that takes a number, and has no fdatasync
  std::filesystem::create_symlink("/proc/self/coredump_filter", folder_ / "slot-b.bin");
  FileStore store(folder_);
  EXPECT_EQ(write(store, 1, 0, {'3'}), StoreResult::done);
  EXPECT_EQ(sync(store, 1), StoreResult::failed);
}

TEST_F(FileStoreTest, TheSlotsHaveTheirBlocksBeforeTheyAreWritten) {
  const int probe = ::open((folder_ / "probe").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const bool can = ::fallocate(probe, 0, 0, 1) == 0;
  ::close(probe);
  if (!can) GTEST_SKIP() << folder_ << " is on a file system without fallocate";
  const FileStore store(folder_);
  struct stat slot {};
  ASSERT_EQ(::stat((folder_ / "slot-a.bin").c_str(), &slot), 0);
  EXPECT_EQ(slot.st_size, static_cast<off_t>(config::kMaxSlotBytes));
  EXPECT_GE(slot.st_blocks * 512, slot.st_size);
}

TEST_F(FileStoreTest, NothingOutsideTheTwoSlotsIsReadOrWritten) {
  FileStore store(folder_);
  Bytes bytes(2);
  EXPECT_FALSE(store.read(2, 0, bytes));
  EXPECT_FALSE(store.read(0, config::kMaxSlotBytes - 1, bytes));
  EXPECT_EQ(store.write(2, 0, bytes), StoreResult::failed);
  EXPECT_EQ(store.write(0, config::kMaxSlotBytes - 1, bytes), StoreResult::failed);
  EXPECT_EQ(store.sync(2), StoreResult::failed);
}

TEST_F(FileStoreTest, AFolderThatIsNoneIsToldByTheNameOfTheFile) {
  folder_ /= "none";
  EXPECT_THAT(failure(), HasSubstr("store:" + (folder_ / "slot-a.bin").string() +
                                   ": No such file or directory, expected a folder"));
}

TEST_F(FileStoreTest, ASlotThatIsNoFileIsToldByItsName) {
  const std::filesystem::path slot = folder_ / "slot-b.bin";
  std::filesystem::create_directory(slot);
  EXPECT_THAT(failure(), HasSubstr("slot-b.bin: Is a directory"));
  std::filesystem::remove(slot);
  ASSERT_EQ(::mkfifo(slot.c_str(), 0600), 0);
  EXPECT_THAT(failure(), HasSubstr("slot-b.bin: no regular file"));
  std::filesystem::remove(slot);
  std::filesystem::create_symlink("/dev/null", slot);
  EXPECT_THAT(failure(), HasSubstr("slot-b.bin: no regular file"));
}

TEST_F(FileStoreTest, ALookTellsWhatOpeningWouldAndMakesNothing) {
  EXPECT_EQ(found_by_a_look(), "no failure");
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  { const FileStore store(folder_); }
  EXPECT_EQ(found_by_a_look(), "no failure") << "with slots in it";

  const std::filesystem::path slot = folder_ / "slot-a.bin";
  std::filesystem::remove(slot);
  std::filesystem::create_directory(slot);
  EXPECT_THAT(found_by_a_look(), HasSubstr("slot-a.bin: no regular file"));
  std::filesystem::remove(slot);
  ASSERT_EQ(::mkfifo(slot.c_str(), 0600), 0);
  EXPECT_THAT(found_by_a_look(), HasSubstr("slot-a.bin: no regular file"));
  std::filesystem::remove(slot);

  const std::filesystem::path folder = folder_;
  folder_ = folder / "none";
  EXPECT_THAT(found_by_a_look(), HasSubstr("none: No such file or directory, expected a folder"));
  folder_ = folder / "slot-b.bin";
  EXPECT_THAT(found_by_a_look(), HasSubstr("slot-b.bin: Not a directory, expected a folder"));
  folder_ = "/dev/null";
  EXPECT_THAT(found_by_a_look(), HasSubstr("/dev/null: Not a directory, expected a folder"));
  folder_ = folder;
}

TEST_F(FileStoreTest, ALookTellsWhatThisUserMayNot) {
  { const FileStore store(folder_); }
  std::filesystem::permissions(folder_ / "slot-a.bin", std::filesystem::perms::all);
  if (::geteuid() == 0 && ::seteuid(65534) != 0) GTEST_SKIP() << "no user without rights";
  using std::filesystem::perms;
  std::vector<std::string> found;
  const auto with = [&](perms folder, perms slot) {
    const uid_t user = ::geteuid();
    ASSERT_EQ(::seteuid(::getuid()), 0);
    std::filesystem::permissions(folder_, folder);
    std::filesystem::permissions(folder_ / "slot-b.bin", slot);
    ASSERT_EQ(::seteuid(user), 0);
    found.push_back(found_by_a_look());
  };
  constexpr perms kNotWritten = perms::all & ~(perms::owner_write | perms::group_write | perms::others_write);
  constexpr perms kNotEntered = perms::all & ~(perms::owner_exec | perms::group_exec | perms::others_exec);
  constexpr perms kNotRead = perms::all & ~(perms::owner_read | perms::group_read | perms::others_read);
  with(kNotWritten, perms::all);
  with(kNotEntered, perms::all);
  with(kNotRead, perms::all);
  with(perms::all, kNotWritten);
  with(perms::all, kNotRead);
  with(perms::all, perms::all);
  ASSERT_EQ(::seteuid(::getuid()), 0);
  const auto folder = HasSubstr("store:" + folder_.string() + ": Permission denied");
  const auto slot = HasSubstr("slot-b.bin: Permission denied");
  EXPECT_THAT(found, ElementsAre(folder, folder, folder, slot, slot, "no failure"));
}

TEST_F(FileStoreTest, AFolderThatMayNotBeWrittenIsRefusedAtTheStart) {
  std::filesystem::permissions(folder_,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  // The superuser writes everywhere.
  if (::access(folder_.c_str(), W_OK) == 0 && ::seteuid(65534) != 0) GTEST_SKIP() << "no user without rights";
  const std::string found = failure();
  ASSERT_EQ(::seteuid(::getuid()), 0);
  EXPECT_THAT(found, HasSubstr("slot-a.bin: Permission denied"));
}

}  // namespace
}  // namespace plenum::board::drivers
