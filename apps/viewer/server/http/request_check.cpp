#include "viewer/server/http/request_check.h"

#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

namespace sqmap::viewer {
namespace {

bool is_own_authority(std::string_view authority, std::uint16_t port) noexcept
{
    const std::size_t colon = authority.rfind(':');
    if (colon == std::string_view::npos) return false;
    const std::string_view name = authority.substr(0, colon), digits = authority.substr(colon + 1);
    if (name != "127.0.0.1" && name != "localhost" && name != "[::1]") return false;
    if (digits.empty() || digits.size() > 5 || digits.front() == '0') return false;
    std::uint32_t number = 0;
    for (const char c : digits) {
        if (c < '0' || c > '9') return false;
        number = 10 * number + static_cast<std::uint32_t>(c - '0');
    }
    return number == port;
}

/// Takes as long for any wrong token of the right length, so that its time tells nothing.
bool same_token(std::string_view a, std::string_view b) noexcept
{
    if (a.size() != b.size() || b.empty()) return false;
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
    return difference == 0;
}

bool is_plain(char c) noexcept
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("/._-?&=%~+!*'()").find(c) != std::string_view::npos;
}

}  // namespace

const char* describe(Admission admission) noexcept
{
    switch (admission) {
        case Admission::Granted:
            return "granted";
        case Admission::BadTarget:
            return "no such address";
        case Admission::BadHost:
            return "this server answers under 127.0.0.1 and localhost only";
        case Admission::BadOrigin:
            return "only the page that this server itself has sent may ask this";
        case Admission::BadToken:
            break;
    }
    return "the address needs the token: open the whole address that sqmap view has printed";
}

std::string_view path_of(std::string_view target) noexcept { return target.substr(0, target.find('?')); }

std::string_view query_value(std::string_view target, std::string_view key) noexcept
{
    const std::size_t begin = target.find('?');
    if (begin == std::string_view::npos) return {};
    std::string_view rest = target.substr(begin + 1);
    while (!rest.empty()) {
        const std::string_view field = rest.substr(0, rest.find('&'));
        rest.remove_prefix(std::min(rest.size(), field.size() + 1));
        const std::size_t equals = field.find('=');
        if (equals != std::string_view::npos && field.substr(0, equals) == key) return field.substr(equals + 1);
    }
    return {};
}

bool needs_token(std::string_view path) noexcept { return path != "/app.js" && path != "/app.css" && path != "/favicon.svg"; }

Admission admit(const RequestHead& head, const Guard& guard) noexcept
{
    if (!is_own_authority(head.host, guard.port)) return Admission::BadHost;
    if (head.has_origin) {
        constexpr std::string_view k_scheme = "http://";
        if (!head.origin.starts_with(k_scheme) || !is_own_authority(head.origin.substr(k_scheme.size()), guard.port))
            return Admission::BadOrigin;
    } else if (head.upgrade || (head.method != "GET" && head.method != "HEAD")) {
        return Admission::BadOrigin;
    }
    if (head.target.empty() || head.target.front() != '/' || head.target.size() > k_max_target ||
        !std::all_of(head.target.begin(), head.target.end(), is_plain) ||
        path_of(head.target).find("..") != std::string_view::npos)
        return Admission::BadTarget;
    if (needs_token(path_of(head.target)) && !same_token(query_value(head.target, "token"), guard.token))
        return Admission::BadToken;
    return Admission::Granted;
}

std::string random_token()
{
    std::array<unsigned char, 16> bytes;
    if (::getentropy(bytes.data(), bytes.size()) != 0)
        throw std::system_error(errno, std::generic_category(), "no random numbers from the kernel");
    std::string out;
    for (const unsigned char byte : bytes) {
        out += "0123456789abcdef"[byte >> 4];
        out += "0123456789abcdef"[byte & 15];
    }
    return out;
}

}  // namespace sqmap::viewer
