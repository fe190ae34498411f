#include "files.h"

#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <algorithm>
#include <climits>
#include <string>

#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>

#include <cerrno>

namespace sqmap::platform {

namespace {

std::error_code last_error() { return {static_cast<int>(::GetLastError()), std::system_category()}; }
std::error_code error_number() { return {errno, std::generic_category()}; }

std::error_code written(int descriptor, std::span<const std::byte> bytes, bool to_the_disk)
{
    std::error_code error = write_all(descriptor, bytes);
    if (!error && to_the_disk && ::_commit(descriptor) != 0) error = error_number();
    if (::_close(descriptor) != 0 && !error) error = error_number();
    return error;
}

}  // namespace

Mapping map_file(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t size)
{
    Mapping out;
    const HANDLE file = ::CreateFileW(path.c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_DELETE, nullptr, OPEN_EXISTING,
                                      FILE_ATTRIBUTE_NORMAL, nullptr);
    if (file == INVALID_HANDLE_VALUE) {
        out.error = last_error();
        return out;
    }
    out.was_opened = true;
    LARGE_INTEGER length{};
    if (::GetFileSizeEx(file, &length) == 0 || length.QuadPart <= 0) {
        out.error = std::make_error_code(std::errc::invalid_argument);
    } else if (const auto whole = static_cast<std::uint64_t>(length.QuadPart); offset >= whole || size > whole - offset) {
        out.error = std::make_error_code(std::errc::result_out_of_range);
    } else if (const HANDLE mapping = ::CreateFileMappingW(file, nullptr, PAGE_READONLY, 0, 0, nullptr); mapping == nullptr) {
        out.error = last_error();
    } else {
        SYSTEM_INFO system;
        ::GetSystemInfo(&system);
        out.size = static_cast<std::size_t>(size > 0 ? size : whole - offset);
        out.skip = static_cast<std::size_t>(offset % system.dwAllocationGranularity);
        const std::uint64_t from = offset - out.skip;
        out.pages = ::MapViewOfFile(mapping, FILE_MAP_READ, static_cast<DWORD>(from >> 32), static_cast<DWORD>(from),
                                    out.skip + out.size);
        if (out.pages == nullptr) out.error = last_error();
        ::CloseHandle(mapping);
    }
    ::CloseHandle(file);
    return out;
}

void unmap(const Mapping& mapping) noexcept
{
    if (mapping.pages != nullptr) ::UnmapViewOfFile(mapping.pages);
}

std::error_code write_all(int descriptor, std::span<const std::byte> bytes)
{
    if (descriptor <= 2) ::_setmode(descriptor, _O_BINARY);
    while (!bytes.empty()) {
        const int n = ::_write(descriptor, bytes.data(), static_cast<unsigned>(std::min<std::size_t>(bytes.size(), INT_MAX)));
        if (n < 0) return error_number();
        if (n == 0) return std::make_error_code(std::errc::no_space_on_device);
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return {};
}

std::error_code write_to_device(const std::filesystem::path& path, std::span<const std::byte> bytes)
{
    const int descriptor = ::_wopen(path.c_str(), _O_WRONLY | _O_BINARY | _O_NOINHERIT);
    return descriptor < 0 ? error_number() : written(descriptor, bytes, false);
}

Replaced write_and_rename(const std::filesystem::path& target, std::span<const std::byte> bytes)
{
    std::filesystem::path beside;
    int descriptor = -1;
    for (int attempt = 0; descriptor < 0 && attempt < 1000; ++attempt) {
        beside = target;
        beside += "." + std::to_string(::GetCurrentProcessId()) + "-" + std::to_string(attempt);
        descriptor = ::_wopen(beside.c_str(), _O_WRONLY | _O_CREAT | _O_EXCL | _O_BINARY | _O_NOINHERIT, _S_IREAD | _S_IWRITE);
        if (descriptor < 0 && errno != EEXIST) break;
    }
    if (descriptor < 0) return {error_number(), false};
    std::error_code error = written(descriptor, bytes, true);
    if (!error && ::MoveFileExW(beside.c_str(), target.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) == 0)
        error = last_error();
    if (error) ::_wunlink(beside.c_str());
    return {error, true};
}

}  // namespace sqmap::platform
