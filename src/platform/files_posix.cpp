#include "files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>

namespace sqmap::platform {

namespace {

std::error_code last_error() { return {errno, std::generic_category()}; }

}  // namespace

Mapping map_file(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t size)
{
    Mapping out;
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        out.error = last_error();
        return out;
    }
    out.was_opened = true;
    struct stat info {};
    if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size == 0) {
        out.error = std::make_error_code(std::errc::invalid_argument);
    } else if (const auto whole = static_cast<std::uint64_t>(info.st_size); offset >= whole || size > whole - offset) {
        out.error = std::make_error_code(std::errc::result_out_of_range);
    } else {
        out.size = static_cast<std::size_t>(size > 0 ? size : whole - offset);
        out.skip = static_cast<std::size_t>(offset % static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)));
        void* const pages =
            ::mmap(nullptr, out.skip + out.size, PROT_READ, MAP_PRIVATE, fd, static_cast<off_t>(offset - out.skip));
        if (pages == MAP_FAILED)
            out.error = last_error();
        else
            out.pages = pages;
    }
    ::close(fd);
    return out;
}

void unmap(const Mapping& mapping) noexcept
{
    if (mapping.pages != nullptr) ::munmap(const_cast<void*>(mapping.pages), mapping.skip + mapping.size);
}

std::error_code write_all(int descriptor, std::span<const std::byte> bytes)
{
    while (!bytes.empty()) {
        const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
        if (n > 0)
            bytes = bytes.subspan(static_cast<std::size_t>(n));
        else if (n == 0)
            return std::make_error_code(std::errc::no_space_on_device);
        else if (errno != EINTR)
            return last_error();
    }
    return {};
}

std::error_code write_to_device(const std::filesystem::path& path, std::span<const std::byte> bytes)
{
    const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd < 0) return last_error();
    const std::error_code error = write_all(fd, bytes);
    ::close(fd);
    return error;
}

Replaced write_and_rename(const std::filesystem::path& target, std::span<const std::byte> bytes)
{
    std::string pattern = target.string() + ".XXXXXX";
    const int fd = ::mkstemp(pattern.data());
    if (fd < 0) return {last_error(), false};
    ::fchmod(fd, 0644);
    std::error_code error = write_all(fd, bytes);
    if (!error && ::fsync(fd) != 0) error = last_error();
    ::close(fd);
    if (!error && std::rename(pattern.c_str(), target.c_str()) != 0) error = last_error();
    if (error) ::unlink(pattern.c_str());
    return {error, true};
}

}  // namespace sqmap::platform
