// Touch as the pages steer it: who holds the tool, with which settings and device, and what is recorded and streamed.
#pragma once

#include "viewer/server/http/audience.h"
#include "viewer/server/http/routes.h"
#include "viewer/server/jobs/worker.h"
#include "viewer/server/scene/scene.h"
#include "viewer/server/touch/recorder.h"
#include "viewer/server/touch/touch.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace sqmap::viewer {

/// All is called on the server's thread.
class Touching {
public:
    /// scene: what is touched. All must outlive this; the workers end before it.
    Touching(Audience& audience, Scene& scene, Worker& pictures, Worker& bakes);

    std::function<void()> on_status = [] {};  ///< something that add_status() says has changed

    /// Adds /api/tool and those of the recorder.
    void add_routes(Routes& routes);
    /// Looks for devices, on the worker that bakes.
    void list_devices();

    // Messages of a page.
    void hold(ConnectionId connection, const Message& message);
    /// The window that holds the tool lets go and is sent a message.
    void take(ConnectionId connection);
    /// The page shows nothing that is touched: where nobody else holds the tool the servo ends, and with it the stream.
    void rest(ConnectionId connection);
    void stop();
    void resume();
    void set(const Settings& settings);
    void choose_device(std::uint32_t device);
    void record(bool on);

    /// A page that is gone holds nothing: the force ends with it. last: no other page is left.
    void leave(ConnectionId connection, bool last);
    /// Objects are others than before.
    void restart();
    /// This object is gone; those behind it move up.
    void remove(std::uint32_t object);
    /// An object stands at this number; those from it on have moved down.
    void insert(std::uint32_t object);
    void end() { touch_.reset(); }

    /// Sends the newest frame, where there is one.
    void stream(std::uint64_t frame_number);
    [[nodiscard]] bool on() const { return touch_ != nullptr; }
    /// Adds the touch's share of the page's status.
    void add_status(nlohmann::ordered_json& out) const;

private:
    void begin_or_restart(bool begin);
    void move(ConnectionId connection, const Message& message);
    void drop_tool();
    void clear_tool();
    void end_idle();
    [[nodiscard]] bool has_wanted_force();
    void stream_floats(const std::vector<float>& values);
    void stream_feet();
    [[nodiscard]] ObjectPtr held_object() const;

    Audience& audience_;
    const Scene& scene_;
    Worker &pictures_, &bakes_;
    ConnectionId holder_ = 0;         ///< whose pointer moves the tool
    std::set<ConnectionId> refused_;  ///< who has pressed meanwhile
    Settings settings_{};
    std::unique_ptr<Touch> touch_;
    Vec3d target_{};
    bool stopped_ = false;
    Recorder recorder_;
    bool feet_shown_ = false;
    int caught_ = 0;  ///< frames in which a tool that nobody holds has touched
    int idle_ = 0;    ///< frames in which it has not
    TouchFrame frame_{};
    nlohmann::ordered_json devices_ = nlohmann::ordered_json::array();
    std::vector<std::string> device_specs_;
    std::uint32_t device_ = 0, tool_revision_ = 1;
};

}  // namespace sqmap::viewer
