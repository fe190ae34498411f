#include "io/replace_file.h"

#include "platform/files.h"
#include "sqmap/io/model_file.h"

#include <string>

namespace sqmap::io {

namespace {

void check(const std::error_code& error, const std::filesystem::path& path, const char* cure = "")
{
    if (error) throw ModelFileError("cannot write " + path.string() + ": " + error.message() + cure);
}

/// True of two names of one file, which need not exist yet.
bool are_same(const std::filesystem::path& a, const std::filesystem::path& b)
{
    std::error_code ignored;
    if (std::filesystem::is_other(a, ignored)) return false;  // a device takes what several write
    return std::filesystem::equivalent(a, b, ignored) ||
           std::filesystem::absolute(a).lexically_normal() == std::filesystem::absolute(b).lexically_normal();
}

}  // namespace

void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes)
{
    if (path == "/dev/stdout" || path == "/dev/stderr") {
        // Whatever they lead to is someone else's: written on, never replaced.
        check(platform::write_all(path == "/dev/stdout" ? 1 : 2, bytes), path);
        return;
    }
    std::error_code ignored;
    const std::filesystem::path target =
        std::filesystem::is_symlink(path, ignored) ? std::filesystem::weakly_canonical(path, ignored) : path;
    const std::filesystem::file_status status = std::filesystem::status(target, ignored);
    if (std::filesystem::is_other(status)) {
        check(platform::write_to_device(target, bytes), path);
        return;
    }
    const platform::Replaced replaced = platform::write_and_rename(target, bytes);
    if (!replaced.was_made)
        throw ModelFileError("cannot write beside " + path.string() + ": " + replaced.error.message() +
                             "; choose another folder");
    check(replaced.error, path, "; nothing was left behind");
}

void check_output(const std::filesystem::path& output, std::initializer_list<std::filesystem::path> others)
{
    const std::filesystem::path folder = output.parent_path();
    if (std::error_code ignored; !folder.empty() && !std::filesystem::is_directory(folder, ignored))
        throw ModelFileError("cannot write " + output.string() + ": there is no folder " + folder.string() +
                             "\n  cure: make it first");
    if (output.empty()) return;
    for (const std::filesystem::path& other : others)
        if (!other.empty() && are_same(output, other))
            throw ModelFileError(output.string() + " is read or written besides: choose another name to write");
}

}  // namespace sqmap::io
