// Admission to the viewer's server: pure functions over the header fields of a request, without a socket.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sqmap::viewer {

inline constexpr std::size_t k_max_target = 1024;  ///< bytes of a request's target

/// The fields of a request that decide on its admission.
struct RequestHead {
    std::string_view method, target, host, origin;
    bool has_origin = false;
    bool upgrade = false;  ///< asks for a WebSocket
};

/// The server's conditions for admission.
struct Guard {
    std::string token;  ///< in the query of every request but those for the page's own files
    std::uint16_t port = 0;
};

enum class Admission : std::uint8_t {
    Granted,
    BadTarget,  ///< too long, or letters that no address of ours has
    BadHost,    ///< another name than this machine's own: DNS rebinding
    BadOrigin,  ///< another site's page; or none where a browser always sends one
    BadToken,
};
[[nodiscard]] const char* describe(Admission admission) noexcept;

/// The part of a target before '?', and the value of a key behind it; empty where there is none. Nothing is unescaped.
[[nodiscard]] std::string_view path_of(std::string_view target) noexcept;
[[nodiscard]] std::string_view query_value(std::string_view target, std::string_view key) noexcept;

/// Files of the page hold no secret; everything else does or acts.
[[nodiscard]] bool needs_token(std::string_view path) noexcept;

/// Host must name this machine by number or as localhost, with the port; Origin must be one of these, and be there for whatever
/// acts: POST and WebSockets. CORS does not guard WebSockets, so this is what does.
[[nodiscard]] Admission admit(const RequestHead& head, const Guard& guard) noexcept;

/// 128 bits from the kernel, in hexadecimal.
/// @throw std::system_error where the kernel gives none.
[[nodiscard]] std::string random_token();

}  // namespace sqmap::viewer
