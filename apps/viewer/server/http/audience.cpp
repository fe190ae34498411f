#include "viewer/server/http/audience.h"

#include "viewer/server/protocol/text.h"

namespace sqmap::viewer {

void Audience::tell(ConnectionId connection, const nlohmann::ordered_json& message)
{
    server_->send_text(connection, text_of(message));
}

void Audience::tell_all(const nlohmann::ordered_json& message)
{
    const std::string text = text_of(message);
    const std::set<ConnectionId> all = connections_;  // one that does not read is let go on the way
    for (const ConnectionId c : all) server_->send_text(c, text);
}

void Audience::tell_trouble(const std::string& why) { tell_all({{"say", "trouble"}, {"text", why}}); }

void Audience::tell_progress(const std::string& name, const std::string& stage, double done)
{
    tell_all({{"say", "progress"}, {"name", name}, {"stage", stage}, {"done", done}});
}

void Audience::stream(const std::shared_ptr<const std::string>& bytes)
{
    const std::set<ConnectionId> all = connections_;  // one that does not read is let go on the way
    for (const ConnectionId c : all) server_->send_binary(c, bytes, true);
}

}  // namespace sqmap::viewer
