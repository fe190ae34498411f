// The table of addresses: which function answers which.
#pragma once

#include "viewer/server/http/server.h"
#include "viewer/server/protocol/text.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::viewer {

/// A request with what its address has for the pattern's stars. It lives as long as the handler runs.
struct Call {
    HttpRequest& request;
    std::vector<std::string_view> stars;
    const Answer& answer;
};

/// A pattern is a path with "*" for any one piece: "/api/object/*/mesh". The first that fits answers.
class Routes {
public:
    using Handler = std::function<void(const Call&)>;

    void get(std::string_view pattern, Handler handler) { add(false, pattern, std::move(handler)); }
    void post(std::string_view pattern, Handler handler) { add(true, pattern, std::move(handler)); }

    /// 404 where no pattern fits. Methods other than POST are taken for GET.
    void serve(HttpRequest request, const Answer& answer) const;

private:
    struct Route {
        bool post;
        std::vector<std::string> pieces;  // of its own: a pattern may be put together on the spot
        Handler handler;
    };
    void add(bool post, std::string_view pattern, Handler handler);

    std::vector<Route> routes_;
};

[[nodiscard]] HttpReply json_reply(const nlohmann::ordered_json& json, int status = 200);
[[nodiscard]] HttpReply bytes_reply(std::string bytes);
[[nodiscard]] HttpReply not_found();
[[nodiscard]] HttpReply busy();
/// Nothing for a text that is no whole number of 32 bits.
[[nodiscard]] std::optional<std::uint32_t> number_of(std::string_view text);

}  // namespace sqmap::viewer
