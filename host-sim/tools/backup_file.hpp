// A whole board as a file: its settings and models, and what it was taken from.
//
//   {"schema": "plenum-backup/1", "node": 5, "identity": {...}, "versions": {...},
//    "settings": [{"index": "1017h", "sub": 0, "name": "...", "type": "UNSIGNED16", "value": 1000}, ...],
//    "models": [{"chamber": 1, "image": "504C4D31..."}, ...]}
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/settings.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

struct Backup {
  unsigned node = 0;
  client::Identity identity;
  client::Versions versions;
  std::vector<client::Setting> settings;
  std::vector<client::ModelUpload> models;
};

/// Everything that can be read from the board and written to it again.
Backup read_backup(client::Session& session);

Json backup_json(const Backup& backup);

/// Whether the file says that it is a backup. Throws InputError when it is not JSON.
bool is_backup(const std::filesystem::path& file);
/// Throws InputError: file, field, what was found, what was expected.
Backup load_backup(const std::filesystem::path& file);
/// As load_backup(), from memory; `name` is that of errors.
Backup parse_backup(std::string_view text, const std::string& name);

}  // namespace plenum::host::tools
