// The parameter store in files: what it keeps, who writes it, and what it says when the disk does not take it. That a set
// survives a power cut is config::RecordStore's, and tested there.
#include "board/drivers/file_store.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
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

  std::filesystem::path folder_;
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
  std::filesystem::create_symlink("/dev/full", folder_ / "slot-a.bin");
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

TEST_F(FileStoreTest, ADiskThatIsFullFailsTheWriteAndTheOtherSlotWorks) {
  std::filesystem::create_symlink("/dev/full", folder_ / "slot-a.bin");
  FileStore store(folder_);
  EXPECT_EQ(write(store, 0, 0, {1}), StoreResult::failed);
  EXPECT_EQ(write(store, 0, 0, {1}), StoreResult::failed) << "tried again";
  EXPECT_EQ(write(store, 1, 0, {1}), StoreResult::done);
}

TEST_F(FileStoreTest, AMediumThatCannotSyncFailsTheSync) {
  std::filesystem::create_symlink("/dev/zero", folder_ / "slot-b.bin");
  FileStore store(folder_);
  EXPECT_EQ(write(store, 1, 0, {1}), StoreResult::done);
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
  std::filesystem::create_directory(folder_ / "slot-b.bin");
  EXPECT_THAT(failure(), HasSubstr("slot-b.bin: Is a directory"));
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
