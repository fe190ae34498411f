#include "viewer/server/scene/file_name.h"

#include <charconv>

namespace sqmap::viewer {

std::string harmless(std::string_view name)
{
    std::string out;
    for (std::size_t i = 0; i < name.size() && out.size() < 64; ++i) {
        char c = name[i];
        if (c == '%' && i + 2 < name.size()) {
            unsigned value = 0;
            const auto [end, error] = std::from_chars(name.data() + i + 1, name.data() + i + 3, value, 16);
            if (error == std::errc() && end == name.data() + i + 3) {
                c = static_cast<char>(value);
                i += 2;
            }
        }
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
        out += plain ? c : '_';
    }
    // The end matters most: it names the format.
    if (const std::size_t dot = name.rfind('.'); out.size() == 64 && dot != std::string_view::npos && name.size() - dot <= 5)
        out.replace(64 - (name.size() - dot), std::string::npos, name.substr(dot));
    return out.empty() ? "mesh" : out;
}

}  // namespace sqmap::viewer
