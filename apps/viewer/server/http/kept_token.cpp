#include "viewer/server/http/kept_token.h"

#include "viewer/server/http/request_check.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <system_error>

extern char** environ;

namespace sqmap::viewer {
namespace {

constexpr std::size_t k_token_length = 32;

/// True if this user owns the file and no one else may read it.
bool is_private(int file)
{
    struct stat facts {};
    return ::fstat(file, &facts) == 0 && S_ISREG(facts.st_mode) && facts.st_uid == ::geteuid() && (facts.st_mode & 077) == 0;
}

/// Replaces what was there; false where it cannot.
bool write_private(const std::filesystem::path& path, const std::string& text)
{
    std::error_code ignored;
    std::filesystem::create_directories(path.parent_path(), ignored);
    std::filesystem::remove(path, ignored);
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (file < 0) return false;
    const bool written = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    ::close(file);
    return written;
}

std::string read_token(const std::filesystem::path& path)
{
    const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return {};
    std::array<char, k_token_length + 1> text{};
    const ssize_t size = is_private(file) ? ::read(file, text.data(), text.size()) : -1;
    ::close(file);
    if (size != static_cast<ssize_t>(k_token_length)) return {};
    const std::string token(text.data(), k_token_length);
    return token.find_first_not_of("0123456789abcdef") == std::string::npos ? token : std::string();
}

}  // namespace

std::filesystem::path state_folder()
{
    if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state == '/')
        return std::filesystem::path(state) / "sqmap";
    if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/')
        return std::filesystem::path(home) / ".local/state/sqmap";
    return {};
}

std::string kept_token(const std::filesystem::path& folder, std::uint16_t port)
{
    if (port == 0 || folder.empty()) return random_token();
    const std::filesystem::path path = folder / ("view-" + std::to_string(port) + ".token");
    std::string token = read_token(path);
    if (!token.empty()) return token;
    token = random_token();
    (void)write_private(path, token);  // where that cannot be, a restart has another
    return token;
}

bool open_in_browser(const std::filesystem::path& folder, const std::string& url)
{
    const std::filesystem::path path = folder / "open.html";
    if (folder.empty() ||
        !write_private(path, "<!doctype html><meta charset=utf-8><meta http-equiv=refresh content='0;url=" + url + "'>\n"))
        return false;
    std::string program = "xdg-open", argument = path.string();
    char* const words[] = {program.data(), argument.data(), nullptr};
    pid_t child = 0;
    return ::posix_spawnp(&child, program.c_str(), nullptr, nullptr, words, environ) == 0;
}

}  // namespace sqmap::viewer
