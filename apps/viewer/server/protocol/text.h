// JSON as it is sent.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace sqmap::viewer {

/// Valid UTF-8 whatever bytes a file's name has.
[[nodiscard]] inline std::string text_of(const nlohmann::ordered_json& json)
{
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace sqmap::viewer
