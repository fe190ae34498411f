// What the server serves: the page, the scene, touch, uploads and edits.
#pragma once

#include "viewer/server/cloth/fitting.h"
#include "viewer/server/http/server.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/object.h"
#include "viewer/server/touch/touch.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace sqmap::viewer {

struct ViewerOptions {
    double size = 0.2;  ///< m, that R_max of every object becomes
    bake::BakeOptions bake{};
    std::size_t max_objects = 16;
    io::ReadLimits limits{.max_bytes = 64u << 20, .max_faces = 500'000};  ///< of an uploaded mesh
};

/// A thread that does one job after the other.
class Worker {
public:
    /// trouble: told of a job that threw.
    explicit Worker(std::function<void(const std::string&)> trouble) : trouble_(std::move(trouble)), thread_([this] { toil(); })
    {
    }
    ~Worker() { finish(); }
    void work(std::function<void()> job);
    void finish();  ///< after the job at hand; the others are forgotten
    [[nodiscard]] int waiting() const noexcept { return waiting_; }
    [[nodiscard]] bool quits() const noexcept { return quit_; }

private:
    void toil();

    std::function<void(const std::string&)> trouble_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> jobs_;
    std::atomic<bool> quit_{false};
    std::atomic<int> waiting_{0};
    std::thread thread_;
};

/// All members but the constructor are called on the server's thread.
class Viewer final : public Application {
public:
    Viewer(std::vector<std::shared_ptr<Object>> objects, const ViewerOptions& options);
    ~Viewer() override;

    /// Before run(): the server must outlive every answer.
    void attach(Server& server);
    /// Ends the worker; nothing is posted to the server after it.
    void finish();

    void on_http(HttpRequest request, Answer answer) override;
    void on_open(ConnectionId connection) override;
    bool on_text(ConnectionId connection, std::string_view text) override;
    void on_close(ConnectionId connection) override;
    void on_frame() override;

private:
    /// An object and its edits, newest last; the first are the model's own parts.
    struct Entry {
        ObjectPtr object;
        std::vector<std::shared_ptr<const Parts>> history;
        std::size_t at = 0;
        std::uint32_t revision = 0;  ///< grows with every change of what the page shows
        std::uint32_t id = 0;        ///< no other object of this program has it
        Words words;                 ///< what its parts are called; edits of parts keep it
        bool renamed = false;        ///< since it was opened: steps of the history may have other names
        [[nodiscard]] std::shared_ptr<const Parts> parts() const { return history[at]; }
    };

    void get(const HttpRequest& request, Answer& answer);
    void upload(HttpRequest request, Answer& answer);
    void edit(const Message& message);
    void change(std::uint32_t index, std::shared_ptr<const Parts> parts);
    void bake_edited(std::uint32_t index);
    void name_part(Entry& entry, std::uint32_t part, const std::string& name);
    void set_words(Entry& entry, const Words& words);
    static void refresh_names(Entry& entry);
    void dress(const Message& message);
    void undress();
    void stream_cloth();
    void add(std::shared_ptr<Object> object);
    void replace(const ObjectPtr& before, std::shared_ptr<Object> after);

    [[nodiscard]] std::function<void(const std::string&)> teller();
    void tell_all(const std::string& text);
    void tell_scene();
    void tell_progress(const std::string& name, const std::string& stage, double done);
    void touch(ConnectionId connection, const Message& message);
    void restart_touch(bool begin = false);  ///< where there is one, or one is to begin
    void stop_touch();
    void record(bool on);
    [[nodiscard]] std::size_t recorded() const;  ///< ticks
    [[nodiscard]] std::string scene_text() const;
    [[nodiscard]] std::string status_text() const;
    void list_devices();

    ViewerOptions options_;
    Server* server_ = nullptr;
    std::vector<Entry> entries_;
    std::set<ConnectionId> connections_;
    ConnectionId holder_ = 0;         ///< whose pointer moves the tool
    std::set<ConnectionId> refused_;  ///< who has pressed meanwhile

    Settings settings_{};
    std::unique_ptr<Touch> touch_;
    Vec3d target_{};
    bool stopped_ = false;
    std::vector<std::shared_ptr<Take>> takes_;  ///< of the recording; the last one may still grow
    bool recording_ = false;
    TouchFrame frame_{};
    std::uint64_t frames_ = 0;
    std::string devices_ = "[]";
    std::vector<std::string> device_specs_;
    std::uint32_t device_ = 0;
    std::uint32_t next_id_ = 1, tool_revision_ = 1;
    std::shared_ptr<Fitting> fitting_;  ///< shared, so that a program without cloth need not know how to destroy one
    std::string told_fitting_;

    // Baking takes seconds: what the page draws does not wait for it. No more threads: the rest is left to the servo.
    Worker pictures_, bakes_;
};

}  // namespace sqmap::viewer
