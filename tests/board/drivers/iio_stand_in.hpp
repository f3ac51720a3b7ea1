// A stand-in for the kernel's Industrial I/O: a mount namespace of the test's own, in which ordinary files stand at
// /sys/bus/iio/devices, and a FIFO at /dev/iio:deviceN. A write to an attribute so keeps its text and has no effect; what the
// FIFO brings are the bytes that the test writes into it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace plenum::board::drivers {

/// A test of its own executable: the process stays in the namespace. Skips, and says why, where it may not have one.
class IioStandIn : public ::testing::Test {
 protected:
  IioStandIn();
  void SetUp() override;
  ~IioStandIn() override;

  /// A device without channels. `id`: "iio:device0", or "trigger0".
  static void add_device(const std::string& id, const std::string& name);
  /// The attribute `file` of a device, below its folder.
  static void put(const std::string& id, const std::string& file, const std::string& text);
  static void remove(const std::string& id, const std::string& file);
  /// Its first line.
  static std::string text(const std::string& id, const std::string& file);
  static std::filesystem::path folder(const std::string& id);

  /// Adds to a device the buffer, and scan elements in_<channel> of this type, numbered as they come; a FIFO at /dev/<id>.
  void add_capture(const std::string& id, const std::vector<std::string>& channels, const std::string& type);
  /// What the converter brings.
  void bring(const std::string& id, const std::vector<std::uint8_t>& bytes);
  /// From now on it brings the end of the file.
  void end(const std::string& id);

  /// From now on what this process has open at `path` can be neither read nor written.
  static void break_open(const std::filesystem::path& path);

 private:
  std::map<std::string, int> fifos_;  ///< their other ends
};

}  // namespace plenum::board::drivers
