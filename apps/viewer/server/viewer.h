// The viewer joins the page, the scene, touch and the dressed figure, and hands each request to the one that answers it.
#pragma once

#include "viewer/server/cloth/wardrobe.h"
#include "viewer/server/http/audience.h"
#include "viewer/server/http/routes.h"
#include "viewer/server/jobs/worker.h"
#include "viewer/server/scene/scene.h"
#include "viewer/server/touch/touching.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::viewer {

/// All members but the constructor are called on the server's thread.
class Viewer final : public Application {
public:
    Viewer(std::vector<std::shared_ptr<Object>> objects, const SceneOptions& options);
    ~Viewer() override;

    /// Before run(): the server must outlive every answer.
    void attach(Server& server);
    /// Makes objects and sends each to the pages when it is ready; as Scene::load.
    void load(std::vector<std::function<std::shared_ptr<Object>(const BakeMeshOptions&)>> makers,
              const std::function<void(const std::string&)>& on_failure)
    {
        scene_.load(std::move(makers), on_failure);
    }
    /// One job of a worker on the caller's thread, where there are no others; pictures first. False where none waits.
    bool do_next() { return pictures_.do_next() || bakes_.do_next(); }
    /// Ends the workers; nothing is posted to the server after it.
    void finish();

    void on_http(HttpRequest request, Answer answer) override { routes_.serve(std::move(request), answer); }
    void on_open(ConnectionId connection) override;
    bool on_text(ConnectionId connection, std::string_view text) override;
    void on_close(ConnectionId connection) override;
    void on_frame() override;

private:
    [[nodiscard]] std::function<void(const std::string&)> send_trouble();
    [[nodiscard]] nlohmann::ordered_json status() const;
    void send_status();

    Audience audience_;
    // Baking takes seconds: what the page draws does not wait for it. No more threads: the rest is left to the servo.
    Worker pictures_, bakes_;
    Scene scene_;
    Touching touching_;
    Wardrobe wardrobe_;
    Routes routes_;
    std::uint64_t frames_ = 0;
    std::string program_;  ///< no other start of the program has it
};

}  // namespace sqmap::viewer
