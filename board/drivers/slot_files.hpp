// The two slots of a parameter store as files in a folder: what the board's store and the simulated one share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace plenum::board::drivers {

/// slot-a.bin, slot-b.bin.
std::filesystem::path slot_path(const std::filesystem::path& folder, std::size_t slot);

/// Whether a slot holds `size` bytes from `offset` on.
bool in_a_slot(std::uint8_t slot, std::size_t offset, std::size_t size) noexcept;

/// Bytes beyond the end of the file were never written, and read as 00h. False: the file cannot be read.
bool read_at(int file, std::size_t offset, std::span<std::uint8_t> bytes) noexcept;
/// False: not all of them were written.
bool write_at(int file, std::size_t offset, std::span<const std::uint8_t> bytes) noexcept;

/// Holds the folder against every other program that asks for it so (flock), as long as the descriptor is open. -1, and errno: it cannot
/// be opened, or is held (EWOULDBLOCK).
int hold_folder(const std::filesystem::path& folder) noexcept;

/// A new file is not there after a power cut before its name is.
bool sync_folder(const std::filesystem::path& folder) noexcept;

/// Closes those that are open, and makes them -1.
void close_slots(std::span<int> files) noexcept;

}  // namespace plenum::board::drivers
