#include "tests/board/drivers/iio_stand_in.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace plenum::board::drivers {
namespace {

namespace fs = std::filesystem;

const fs::path kDevices = "/sys/bus/iio/devices";

int full = -1;  // /dev/full for writing only, from outside of the namespace

bool put_file(const fs::path& path, const std::string& text) {
  return static_cast<bool>(std::ofstream(path) << text << std::flush);
}

/// Empty, or what the kernel refused.
std::string enter_namespace() {
  const auto refused = [](const std::string& what) { return what + ": " + std::strerror(errno); };
  const std::string user = std::to_string(::getuid());
  const std::string group = std::to_string(::getgid());
  full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
  if (full < 0) return refused("/dev/full");
  if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return refused("unshare");
  if (!put_file("/proc/self/setgroups", "deny") ||
      !put_file("/proc/self/uid_map", user + " " + user + " 1") ||
      !put_file("/proc/self/gid_map", group + " " + group + " 1"))
    return refused("uid_map");
  for (const char* const covered : {"/sys/bus", "/dev"}) {
    if (::mount("tmpfs", covered, "tmpfs", 0, nullptr) != 0) return refused(std::string("mount ") + covered);
  }
  return {};
}

const std::string& refusal() {
  static const std::string once = enter_namespace();
  return once;
}

void must(bool done, const std::string& what) {
  if (!done) throw std::runtime_error(what + ": " + std::strerror(errno));
}

}  // namespace

IioStandIn::IioStandIn() {
  if (!refusal().empty()) return;
  fs::create_directories(kDevices);
}

void IioStandIn::SetUp() {
  if (!refusal().empty()) {
    GTEST_SKIP()
        << "no mount namespace (" << refusal()
        << "); to enable: sysctl -w kernel.unprivileged_userns_clone=1, or a container that admits unshare";
  }
}

IioStandIn::~IioStandIn() {
  for (const auto& [id, fifo] : fifos_) ::close(fifo);
  if (!refusal().empty()) return;
  fs::remove_all(kDevices.parent_path());
  for (const auto& entry : fs::directory_iterator("/dev")) fs::remove_all(entry);
}

fs::path IioStandIn::folder(const std::string& id) {
  return kDevices / id;
}

void IioStandIn::add_device(const std::string& id, const std::string& name) {
  fs::create_directories(folder(id));
  put(id, "name", name);
}

void IioStandIn::put(const std::string& id, const std::string& file, const std::string& text) {
  fs::create_directories((folder(id) / file).parent_path());
  must(put_file(folder(id) / file, text + "\n"), file);
}

void IioStandIn::remove(const std::string& id, const std::string& file) {
  fs::remove_all(folder(id) / file);
}

std::string IioStandIn::text(const std::string& id, const std::string& file) {
  std::string line;
  std::ifstream stream(folder(id) / file);
  std::getline(stream, line);
  return line;
}

void IioStandIn::add_capture(const std::string& id, const std::vector<std::string>& channels,
                             const std::string& type) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const std::string element = "scan_elements/in_" + channels[i];
    put(id, element + "_en", "0");
    put(id, element + "_index", std::to_string(i));
    put(id, element + "_type", type);
  }
  put(id, "buffer/enable", "0");
  put(id, "buffer/length", "0");
  put(id, "buffer/watermark", "0");
  put(id, "trigger/current_trigger", "");
  const std::string path = "/dev/" + id;
  must(::mkfifo(path.c_str(), 0600) == 0, path);
  fifos_[id] = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  must(fifos_[id] >= 0, path);
}

void IioStandIn::bring(const std::string& id, const std::vector<std::uint8_t>& bytes) {
  must(::write(fifos_.at(id), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
       "/dev/" + id);
}

void IioStandIn::end(const std::string& id) {
  ::close(fifos_.at(id));
  fifos_.erase(id);
}

void IioStandIn::break_open(const fs::path& path) {
  int broken = 0;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (fs::read_symlink(entry.path(), gone) != path) continue;
    must(::dup2(full, std::stoi(entry.path().filename().string())) >= 0, path);
    ++broken;
  }
  if (broken == 0) throw std::runtime_error(path.string() + " is not open");
}

}  // namespace plenum::board::drivers
