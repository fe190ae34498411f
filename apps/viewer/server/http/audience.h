// The pages that are connected, and what all of them are told.
#pragma once

#include "viewer/server/http/server.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>

namespace sqmap::viewer {

/// All but post() are called on the server's thread.
class Audience {
public:
    /// The server must outlive every use.
    void attach(Server& server) { server_ = &server; }
    /// Any thread: runs the work on the server's.
    void post(std::function<void()> work) { server_->post(std::move(work)); }

    void add(ConnectionId connection) { connections_.insert(connection); }
    void remove(ConnectionId connection) { connections_.erase(connection); }
    [[nodiscard]] bool empty() const { return connections_.empty(); }

    void send(ConnectionId connection, const nlohmann::ordered_json& message);
    void send_all(const nlohmann::ordered_json& message);
    void send_trouble(const std::string& why);
    /// name: of what is baked; done: share of the stage; upload: the page's number of its file, 0 where it is of none.
    void send_progress(const std::string& name, const std::string& stage, double done, std::uint32_t upload = 0);
    /// Left out for those that still have earlier ones to read.
    void stream(const std::shared_ptr<const std::string>& bytes);

private:
    Server* server_ = nullptr;
    std::set<ConnectionId> connections_;
};

}  // namespace sqmap::viewer
