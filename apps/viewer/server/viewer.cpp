#include "viewer/server/viewer.h"

#include "viewer/server/http/page.h"
#include "viewer/server/http/request_check.h"
#include "viewer/server/scene/downloads.h"

#include <optional>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr const char* k_no_page =
    "<!doctype html><meta charset=utf-8><title>sqmap</title><body style='font:18px sans-serif;max-width:40em;margin:4em auto'>"
    "<h1>The page is not built in</h1><p>This sqmap was built without its page, because npm or the page's packages were not "
    "there. "
    "Run <code>./dev view</code> in the sources: it sets up everything and opens the page.</p>";

void answer_index(const Call& call)
{
    call.answer({.type = "text/html; charset=utf-8", .body = std::string(has_page() ? page_file("index.html") : k_no_page)});
}

/// The page's own files.
void add_page(Routes& routes)
{
    routes.get("/", answer_index);
    routes.get("/index.html", answer_index);
    for (const auto& [name, type] : {std::pair{"app.js", "text/javascript; charset=utf-8"},
                                     {"app.css", "text/css; charset=utf-8"},
                                     {"favicon.svg", "image/svg+xml"}})
        routes.get(std::string("/") + name, [name = name, type = type](const Call& call) {
            call.answer({.type = type, .body = std::string(page_file(name))});
        });
}

}  // namespace

Viewer::Viewer(std::vector<std::shared_ptr<Object>> objects, const SceneOptions& options)
    : pictures_(send_trouble()),
      bakes_(send_trouble()),
      scene_(audience_, pictures_, bakes_, options),
      touching_(audience_, scene_, pictures_, bakes_),
      wardrobe_(audience_, pictures_),
      program_(random_token())
{
    for (auto& object : objects) scene_.add(std::move(object));
    scene_.on_objects = [this] { touching_.restart(); };
    scene_.on_remove = [this](std::uint32_t object) { touching_.remove(object); };
    scene_.on_insert = [this](std::uint32_t object) { touching_.insert(object); };
    touching_.on_status = wardrobe_.on_status = [this] { send_status(); };
    add_page(routes_);
    routes_.post("/api/upload", [this](const Call& call) { scene_.upload(std::move(call.request), call.answer); });
    add_downloads(routes_, scene_, pictures_);
    touching_.add_routes(routes_);
    wardrobe_.add_routes(routes_);
}

void Viewer::attach(Server& server)
{
    audience_.attach(server);
    touching_.list_devices();
}

Viewer::~Viewer() { finish(); }

void Viewer::finish()
{
    touching_.end();
    wardrobe_.end();
    pictures_.finish();
    bakes_.finish();
}

std::function<void(const std::string&)> Viewer::send_trouble()
{
    return [this](const std::string& why) { audience_.post([this, why] { audience_.send_trouble(why); }); };
}

void Viewer::on_open(ConnectionId connection)
{
    audience_.add(connection);
    audience_.send(connection, scene_.json());
    audience_.send(connection, status());
}

void Viewer::on_close(ConnectionId connection)
{
    audience_.remove(connection);
    const bool last = audience_.empty();
    if (last) wardrobe_.undress();
    touching_.leave(connection, last);
}

bool Viewer::on_text(ConnectionId connection, std::string_view text)
{
    const std::optional<Message> message = read_message(text);
    if (!message) return false;
    switch (message->say) {
        case Say::Touch:
            touching_.hold(connection, *message);
            return true;
        case Say::Take:
            touching_.take(connection);
            return true;
        case Say::Rest:
            touching_.rest(connection);
            break;
        case Say::Cancel:
            scene_.cancel(message->upload);
            return true;
        case Say::Stop:
            touching_.stop();
            break;
        case Say::Resume:
            touching_.resume();
            break;
        case Say::Settings:
            touching_.set(message->settings);
            break;
        case Say::Device:
            touching_.choose_device(message->device);
            break;
        case Say::Record:
            touching_.record(message->held);
            return true;
        case Say::Fit:
        case Say::Cloth:
        case Say::Undress:
            wardrobe_.dress(*message);
            return true;
        default:
            scene_.edit(*message);
            return true;
    }
    send_status();
    return true;
}

void Viewer::on_frame()
{
    if (audience_.empty()) return;
    ++frames_;
    wardrobe_.stream();
    if (frames_ % 30 == 0 && touching_.on()) send_status();
    touching_.stream(frames_);
}

ordered_json Viewer::status() const
{
    ordered_json out{{"say", "status"}, {"program", program_}};
    touching_.add_status(out);
    out["cloth"] = wardrobe_.json();
    return out;
}

void Viewer::send_status() { audience_.send_all(status()); }

}  // namespace sqmap::viewer
