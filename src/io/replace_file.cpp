#include "sqmap/io/replace_file.h"

#include "sqmap/io/model_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace sqmap::io {

namespace {

/// 0, or the error number.
int write_all(int fd, std::span<const std::byte> bytes)
{
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n > 0)
            bytes = bytes.subspan(static_cast<std::size_t>(n));
        else if (n == 0)
            return ENOSPC;
        else if (errno != EINTR)
            return errno;
    }
    return 0;
}

}  // namespace

void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes)
{
    if (path == "/dev/stdout" || path == "/dev/stderr") {
        // Whatever they lead to is someone else's: written on, never replaced.
        if (const int error = write_all(path == "/dev/stdout" ? 1 : 2, bytes); error != 0)
            throw ModelFileError("cannot write " + path.string() + ": " + std::strerror(error));
        return;
    }
    std::error_code ignored;
    const std::filesystem::path target =
        std::filesystem::is_symlink(path, ignored) ? std::filesystem::weakly_canonical(path, ignored) : path;
    struct stat info {};
    if (::stat(target.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode)) {
        const int fd = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
        const int error = fd < 0 ? errno : write_all(fd, bytes);
        if (fd >= 0) ::close(fd);
        if (error != 0) throw ModelFileError("cannot write " + path.string() + ": " + std::strerror(error));
        return;
    }
    std::string pattern = target.string() + ".XXXXXX";
    const int fd = ::mkstemp(pattern.data());
    if (fd < 0)
        throw ModelFileError("cannot write beside " + path.string() + ": " + std::strerror(errno) + "; choose another folder");
    ::fchmod(fd, 0644);
    int error = write_all(fd, bytes);
    if (error == 0 && ::fsync(fd) != 0) error = errno;
    ::close(fd);
    if (error == 0 && ::rename(pattern.c_str(), target.c_str()) != 0) error = errno;
    if (error != 0) {
        ::unlink(pattern.c_str());
        throw ModelFileError("cannot write " + path.string() + ": " + std::strerror(error) + "; nothing was left behind");
    }
}

void refuse_to_replace(const std::filesystem::path& output, std::initializer_list<std::filesystem::path> inputs)
{
    for (const std::filesystem::path& input : inputs) {
        std::error_code ignored;
        if (!input.empty() && std::filesystem::is_regular_file(output, ignored) &&
            std::filesystem::equivalent(output, input, ignored))
            throw ModelFileError(output.string() + " is read, too: choose another name to write");
    }
}

}  // namespace sqmap::io
