// The page's recording: kept with the poses of every tick, computed again, saved as a file and opened from one.
#pragma once

#include "viewer/server/http/audience.h"
#include "viewer/server/http/routes.h"
#include "viewer/server/jobs/worker.h"
#include "viewer/server/scene/scene.h"
#include "viewer/server/touch/recording.h"
#include "viewer/server/touch/recording_file.h"

#include <functional>
#include <memory>
#include <vector>

namespace sqmap::viewer {

/// All is called on the server's thread.
class Recorder {
public:
    /// All must outlive this; the workers end before it.
    Recorder(Audience& audience, Scene& scene, Worker& pictures, Worker& bakes);

    std::function<Settings()> settings = [] { return Settings{}; };     ///< of now
    std::function<void(const Settings&)> on_open = [](const auto&) {};  ///< another recording is there: its last settings

    /// Adds /api/recording, /api/recording/frames, /api/again/then, /api/again/now.
    void add_routes(Routes& routes);

    /// Forgets the recording of before and begins another.
    void begin();
    void end() { recording_ = false; }
    [[nodiscard]] bool recording() const { return recording_; }
    /// The take that the next Touch fills; null where nothing is recorded, or no more can be.
    [[nodiscard]] std::shared_ptr<Take> next_take();
    [[nodiscard]] std::size_t ticks() const;
    [[nodiscard]] bool full() const { return ticks() >= k_max_recorded; }

private:
    void answer_with(const Call& call, std::function<HttpReply(const Recording&)> make);
    void open(HttpRequest request, const Answer& answer);

    Audience& audience_;
    Scene& scene_;
    Worker &pictures_, &bakes_;
    std::vector<std::shared_ptr<Take>> takes_;  ///< the last one may still grow
    bool recording_ = false;
};

}  // namespace sqmap::viewer
