#include "viewer/server/http/audience.h"

#include "viewer/server/protocol/text.h"

namespace sqmap::viewer {

void Audience::send(ConnectionId connection, const nlohmann::ordered_json& message)
{
    server_->send_text(connection, text_of(message));
}

void Audience::send_all(const nlohmann::ordered_json& message)
{
    const std::string text = text_of(message);
    const std::set<ConnectionId> all = connections_;  // one that does not read is let go on the way
    for (const ConnectionId c : all) server_->send_text(c, text);
}

void Audience::send_trouble(const std::string& why) { send_all({{"say", "trouble"}, {"text", why}}); }

void Audience::send_progress(const std::string& name, const std::string& stage, double done, std::uint32_t upload)
{
    send_all({{"say", "progress"}, {"name", name}, {"stage", stage}, {"done", done}, {"upload", upload}});
}

void Audience::stream(const std::shared_ptr<const std::string>& bytes)
{
    const std::set<ConnectionId> all = connections_;  // one that does not read is let go on the way
    for (const ConnectionId c : all) server_->send_binary(c, bytes, true);
}

}  // namespace sqmap::viewer
