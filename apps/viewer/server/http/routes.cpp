#include "viewer/server/http/routes.h"

#include "viewer/server/http/request_check.h"

#include <charconv>

namespace sqmap::viewer {
namespace {

std::vector<std::string_view> pieces_of(std::string_view path)
{
    std::vector<std::string_view> out;
    while (!path.empty()) {
        path.remove_prefix(1);
        const std::string_view piece = path.substr(0, path.find('/'));
        out.push_back(piece);
        path.remove_prefix(piece.size());
    }
    return out;
}

/// The path's words in place of the pattern's stars; nothing where the path is another.
std::optional<std::vector<std::string_view>> match(const std::vector<std::string>& pattern,
                                                   const std::vector<std::string_view>& path)
{
    if (pattern.size() != path.size()) return std::nullopt;
    std::vector<std::string_view> stars;
    for (std::size_t i = 0; i < path.size(); ++i) {
        if (pattern[i] == "*")
            stars.push_back(path[i]);
        else if (pattern[i] != path[i])
            return std::nullopt;
    }
    return stars;
}

}  // namespace

void Routes::add(bool post, std::string_view pattern, Handler handler)
{
    const std::vector<std::string_view> pieces = pieces_of(pattern);
    routes_.push_back({post, {pieces.begin(), pieces.end()}, std::move(handler)});
}

void Routes::serve(HttpRequest request, const Answer& answer) const
{
    const bool post = request.method == "POST";
    const std::vector<std::string_view> path = pieces_of(path_of(request.target));
    for (const Route& route : routes_) {
        if (route.post != post) continue;
        if (auto stars = match(route.pieces, path)) return route.handler({request, std::move(*stars), answer});
    }
    answer(not_found());
}

HttpReply json_reply(const nlohmann::ordered_json& json, int status)
{
    return {.status = status, .type = "application/json", .body = text_of(json)};
}

HttpReply bytes_reply(std::string bytes) { return {.type = "application/octet-stream", .body = std::move(bytes)}; }
HttpReply not_found() { return {.status = 404, .body = "no such address\n"}; }
HttpReply busy() { return {.status = 503, .body = "busy: try again\n"}; }

std::optional<std::uint32_t> number_of(std::string_view text)
{
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace sqmap::viewer
