#include "host-sim/rig/model_store.hpp"

#include <algorithm>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::rig {
namespace {

std::filesystem::path file_of(const std::filesystem::path& folder, std::size_t id) {
  return folder / ("chamber-" + std::to_string(id + 1) + ".plm");
}

}  // namespace

ModelStore::ModelStore(const std::optional<std::filesystem::path>& folder) : folder_(folder) {
  if (!folder_) return;
  std::error_code error;
  std::filesystem::create_directories(*folder_, error);
  if (error) throw trace::InputError(folder_->string() + ": cannot make this folder: " + error.message());
  for (std::size_t id = 0; id < record_.size(); ++id) {
    const std::filesystem::path file = file_of(*folder_, id);
    if (!std::filesystem::exists(file)) continue;
    const std::string bytes = trace::read_whole_file(file);
    record_[id].assign(bytes.begin(), bytes.end());
  }
}

std::size_t ModelStore::load(std::uint8_t id, std::span<std::uint8_t> bytes) noexcept {
  if (id >= record_.size() || record_[id].size() > bytes.size()) return 0;
  std::copy(record_[id].begin(), record_[id].end(), bytes.begin());
  return record_[id].size();
}

bool ModelStore::store(std::uint8_t id, std::span<const std::uint8_t> bytes) noexcept {
  if (id >= record_.size()) return false;
  try {
    if (folder_) {
      const std::string text(bytes.begin(), bytes.end());
      trace::write_whole_file(file_of(*folder_, id), text);
    }
    record_[id].assign(bytes.begin(), bytes.end());
    return true;
  } catch (const std::exception&) {
    return false;  // the port's contract: the old record stands
  }
}

}  // namespace plenum::host::rig
