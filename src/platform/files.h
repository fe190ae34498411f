// Files where the system decides how: mapping, and writing that leaves the old file or the new one.
// Any number of threads, on files of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <system_error>

namespace sqmap::platform {

/// A part of a regular file in memory, read only; pages is null where there is an error.
struct Mapping {
    const void* pages = nullptr;
    std::size_t skip = 0;   ///< bytes before the part in its first page
    std::size_t size = 0;   ///< of the part
    std::error_code error;  ///< std::errc::invalid_argument: empty, or no regular file; result_out_of_range: no such part
    bool was_opened = false;
    [[nodiscard]] const std::byte* bytes() const { return static_cast<const std::byte*>(pages) + skip; }
};
/// size 0: to the end of the file.
[[nodiscard]] Mapping map_file(const std::filesystem::path& path, std::uint64_t offset = 0, std::uint64_t size = 0);
/// Passes over a mapping without pages.
void unmap(const Mapping& mapping) noexcept;

/// Appends to a file that is open already: 1 is standard output, 2 standard error.
[[nodiscard]] std::error_code write_all(int descriptor, std::span<const std::byte> bytes);
/// Writes to what exists and is no regular file: a device, a pipe.
[[nodiscard]] std::error_code write_to_device(const std::filesystem::path& path, std::span<const std::byte> bytes);

struct Replaced {
    std::error_code error;
    bool was_made = false;  ///< a file beside the target could be made; it is gone again where there is an error
};
/// Writes a new file beside target, waits for the disk, and gives it target's name.
[[nodiscard]] Replaced write_and_rename(const std::filesystem::path& target, std::span<const std::byte> bytes);

}  // namespace sqmap::platform
