#include "viewer/server/viewer.h"

#include "common/layer_name.h"
#include "sqmap/device/open.h"
#include "sqmap/io/replace_file.h"
#include "sqmap/mesh/error.h"
#include "viewer/server/http/page.h"
#include "viewer/server/touch/tool.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t k_max_history = 64;
constexpr int k_max_jobs = 16;
constexpr std::size_t k_max_takes = 256;
#ifdef SQMAP_VIEWER_HAS_CLOTH
constexpr bool k_has_cloth = true;
#else
constexpr bool k_has_cloth = false;
#endif

/// JSON whatever bytes a file's name has.
std::string text_of(const ordered_json& json) { return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace); }

HttpReply json_reply(const ordered_json& json, int status = 200)
{
    return {.status = status, .type = "application/json", .body = text_of(json)};
}
HttpReply no_such() { return {.status = 404, .body = "no such address\n"}; }

std::optional<std::uint32_t> number_of(std::string_view text)
{
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// A file's name as the browser has it, for people and for its extension; it is never opened.
std::string harmless(std::string_view name)
{
    std::string out;
    for (std::size_t i = 0; i < name.size() && out.size() < 64; ++i) {
        char c = name[i];
        if (c == '%' && i + 2 < name.size()) {
            unsigned value = 0;
            const auto [end, error] = std::from_chars(name.data() + i + 1, name.data() + i + 3, value, 16);
            if (error == std::errc() && end == name.data() + i + 3) {
                c = static_cast<char>(value);
                i += 2;
            }
        }
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
        out += plain ? c : '_';
    }
    // The end matters most: it names the format.
    if (const std::size_t dot = name.rfind('.'); out.size() == 64 && dot != std::string_view::npos && name.size() - dot <= 5)
        out.replace(64 - (name.size() - dot), std::string::npos, name.substr(dot));
    return out.empty() ? "mesh" : out;
}

/// Ends a bake whose program is being closed.
struct Cancelled {};

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

constexpr const char* k_no_page =
    "<!doctype html><meta charset=utf-8><title>sqmap</title><body style='font:18px sans-serif;max-width:40em;margin:4em auto'>"
    "<h1>The page is not built in</h1><p>This sqmap was built without its page, because npm or the page's packages were not "
    "there. "
    "Run <code>./dev view</code> in the sources: it sets up everything and opens the page.</p>";

}  // namespace

Viewer::Viewer(std::vector<std::shared_ptr<Object>> objects, const ViewerOptions& options)
    : options_(options), pictures_(teller()), bakes_(teller())
{
    for (auto& object : objects) add(std::move(object));
}

void Viewer::attach(Server& server)
{
    server_ = &server;
    list_devices();
}

Viewer::~Viewer() { finish(); }

void Viewer::finish()
{
    touch_.reset();
    fitting_.reset();
    pictures_.finish();
    bakes_.finish();
}

std::function<void(const std::string&)> Viewer::teller()
{
    return [this](const std::string& why) {
        server_->post([this, why] { tell_all(text_of({{"say", "trouble"}, {"text", why}})); });
    };
}

// ---- Workers

void Worker::work(std::function<void()> job)
{
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    ++waiting_;
    wake_.notify_one();
}

void Worker::finish()
{
    {
        const std::lock_guard lock(mutex_);
        quit_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
    jobs_.clear();  // what they hold may have threads of its own that tell the server things
}

void Worker::toil()
{
    for (;;) {
        std::function<void()> job;
        {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [this] { return quit_ || !jobs_.empty(); });
            if (quit_) return;
            job = std::move(jobs_.front());
            jobs_.pop_front();
        }
        try {
            job();
        } catch (const Cancelled&) {
        } catch (const std::exception& e) {
            if (!quit_) trouble_(e.what());
        }
        --waiting_;
    }
}

// ---- HTTP

void Viewer::on_http(HttpRequest request, Answer answer)
{
    const std::string_view path = path_of(request.target);
    if (request.method == "POST") {
        if (path == "/api/upload") return upload(std::move(request), answer);
        return answer(no_such());
    }
    if (path == "/" || path == "/index.html") {
        const std::string_view page = page_file("index.html");
        return answer({.type = "text/html; charset=utf-8", .body = std::string(has_page() ? page : k_no_page)});
    }
    if (path == "/app.js") return answer({.type = "text/javascript; charset=utf-8", .body = std::string(page_file("app.js"))});
    if (path == "/app.css") return answer({.type = "text/css; charset=utf-8", .body = std::string(page_file("app.css"))});
    if (path == "/favicon.svg")
        return answer({.type = "image/svg+xml",
                       .body =
                           "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'><rect x='1' y='3' width='14' height='10' "
                           "rx='4' fill='#0b6e8f'/><circle cx='8' cy='8' r='3' fill='#fff'/></svg>"});
    get(request, answer);
}

/// /api/object/N/WHAT[/M]
void Viewer::get(const HttpRequest& request, Answer& answer)
{
    const auto pieces = pieces_of(path_of(request.target));
    if (pieces.size() == 2 && pieces[0] == "api" && pieces[1] == "tool") {
        if (pictures_.waiting() >= k_max_jobs) return answer({.status = 503, .body = "busy: try again\n"});
        const ObjectPtr held = settings_.tool == ToolKind::Mesh && settings_.tool_object < entries_.size()
                                   ? entries_[settings_.tool_object].object
                                   : nullptr;
        return pictures_.work([answer, held, settings = settings_] {
            answer({.type = "application/octet-stream", .body = tool_bytes(make_tool(settings, held.get()))});
        });
    }
#ifdef SQMAP_VIEWER_HAS_CLOTH
    if (pieces.size() == 2 && pieces[0] == "api" && pieces[1] == "fitting") {
        const auto shapes = fitting_ != nullptr ? fitting_->shapes() : nullptr;
        return answer(shapes != nullptr ? HttpReply{.type = "application/octet-stream", .body = *shapes} : no_such());
    }
#endif
    // What was recorded, computed again: as it was, or with the objects and settings of now.
    if (pieces.size() == 3 && pieces[0] == "api" && pieces[1] == "again" && (pieces[2] == "then" || pieces[2] == "now")) {
        if (recording_ || recorded() == 0) return answer(no_such());
        if (pictures_.waiting() >= k_max_jobs) return answer({.status = 503, .body = "busy: try again\n"});
        std::optional<Other> other;
        if (pieces[2] == "now") {
            other.emplace();
            for (const Entry& entry : entries_) other->objects.push_back(entry.object);
            other->settings = settings_;
        }
        return pictures_.work([this, answer, other, takes = Recording(takes_.begin(), takes_.end())] {
            answer({.type = "application/octet-stream",
                    .body = again_bytes(compute_again(takes, other, [this] { return pictures_.quits(); }))});
        });
    }
    if (pieces.size() < 4 || pieces[0] != "api" || pieces[1] != "object") return answer(no_such());
    const auto index = number_of(pieces[2]);
    if (!index || *index >= entries_.size()) return answer(no_such());
    const ObjectPtr object = entries_[*index].object;
    const std::shared_ptr<const Parts> parts = entries_[*index].parts();
    const std::string_view what = pieces[3];
    if (pictures_.waiting() >= k_max_jobs) return answer({.status = 503, .body = "busy: try again\n"});
    const auto bytes = [&](auto make) {
        pictures_.work([answer, make] { answer({.type = "application/octet-stream", .body = make()}); });
    };
    const auto file = [&](const char* type, const char* extension, auto make) {
        pictures_.work([answer, make, type, name = harmless(object->name) + extension] {
            answer({.type = type, .body = make(), .file_name = name});
        });
    };
    if (pieces.size() == 4 && what == "mesh") return bytes([=] { return mesh_bytes(*object, *parts); });
    if (pieces.size() == 4 && what == "superquadrics") return bytes([=] { return superquadric_bytes(*object, *parts, 10); });
    const bool central = object->view.header.projection == static_cast<std::uint32_t>(model::Projection::Central);
    if (pieces.size() == 4 && what == "samples" && central) return bytes([=] { return sample_bytes(*object); });
    if (pieces.size() == 4 && what == "offset" && central) return bytes([=] { return offset_bytes(*object); });
    if (pieces.size() == 4 && what == "hidden" && central) return bytes([=] { return hidden_bytes(*object); });
    if (pieces.size() == 4 && what == "names")
        return file("application/json", ".names.json",
                    [words = entries_[*index].words] { return names_json(words).dump(1) + "\n"; });
    if (pieces.size() == 4 && what == "glb") return file("model/gltf-binary", ".glb", [=] { return glb_bytes(*object, *parts); });
    if (pieces.size() == 4 && what == "json")
        return file("application/json", ".json", [=] { return superquadrics_json(*object, *parts).dump(2) + "\n"; });
    if (pieces.size() == 4 && what == "sqmap" && entries_[*index].at > 0)
        return answer({.status = 409, .body = "bake the edited parts first: the model is of those before\n"});
    if (pieces.size() == 4 && what == "sqmap")
        return file("application/octet-stream", ".sqmap",
                    [=] { return std::string(reinterpret_cast<const char*>(object->blob.data()), object->blob.size()); });
    if (pieces.size() != 5) return answer(no_such());
    if (what == "field") {
        if (pieces[4] == "error") return bytes([=] { return field_bytes(*object, Field::Error); });
        if (pieces[4] == "protrusion") return bytes([=] { return field_bytes(*object, Field::Protrusion); });
        if (pieces[4] == "curvature") return bytes([=] { return field_bytes(*object, Field::Curvature); });
    }
    const auto part = number_of(pieces[4]);
    if (what == "map" && part && *part < object->view.parts.size() && central)
        return bytes([=] { return map_bytes(*object, *part, 48); });
    answer(no_such());
}

void Viewer::upload(HttpRequest request, Answer& answer)
{
    if (entries_.size() >= options_.max_objects || bakes_.waiting() >= k_max_jobs)
        return answer(json_reply({{"accepted", false},
                                  {"verdict", "REFUSED"},
                                  {"code", "E_LIMIT"},
                                  {"element", "scene"},
                                  {"message", "the scene is full or busy"},
                                  {"cure", "remove an object, or wait"}},
                                 503));
    const std::string name = harmless(query_value(request.target, "name"));
    mesh::GateOptions gate;
    if (query_value(request.target, "repair") == "holes") gate.repair = mesh::Repair::Holes;
    if (query_value(request.target, "repair") == "surface") gate.accept_surface = true;
    if (name.ends_with(".names.json")) {
        // For the object whose name the file has.
        const std::string stem = name.substr(0, name.size() - std::strlen(".names.json"));
        const auto at =
            std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return harmless(e.object->name) == stem; });
        const std::optional<Words> words = read_names(request.body);
        if (!words || at == entries_.end() || at->object->mesh.triangles.empty())
            return answer(
                json_reply({{"accepted", false},
                            {"verdict", "REFUSED"},
                            {"code", "E_NAMES"},
                            {"element", "file"},
                            {"message", !words ? "this is no file of names" : "no open object with triangles is called " + stem},
                            {"cure", !words ? "save one from the page to see what it holds" : "open the object first"}}));
        set_words(*at, *words);
        return answer(json_reply({{"accepted", true}, {"verdict", "NAMES"}, {"notes", ordered_json::array()}}));
    }
    bakes_.work([this, answer, name, gate, body = std::move(request.body)] {
        const std::span<const std::byte> bytes = std::as_bytes(std::span(body));
        if (name.ends_with(".sqmap")) {
            try {
                // Copied, so that it is aligned.
                const auto object = object_from_model({bytes.begin(), bytes.end()}, name, options_.size);
                answer(json_reply({{"accepted", true}, {"verdict", "MODEL"}, {"notes", ordered_json::array()}}));
                server_->post([this, object] { add(object), tell_scene(), restart_touch(); });
            } catch (const std::runtime_error& e) {
                answer(json_reply({{"accepted", false},
                                   {"verdict", "REFUSED"},
                                   {"code", "E_FORMAT"},
                                   {"element", "file"},
                                   {"message", e.what()},
                                   {"cure", "bake the mesh again with this version"}}));
            }
            return;
        }
        auto judged = std::make_shared<Judgement>(judge(bytes, name, options_.limits, gate));
        answer(json_reply({{"accepted", judged->accepted},
                           {"verdict", judged->verdict},
                           {"code", judged->code},
                           {"element", judged->element},
                           {"message", judged->message},
                           {"cure", judged->cure},
                           {"notes", judged->notes},
                           {"triangles", judged->mesh.triangles.size()}}));
        if (!judged->accepted) return;
        bake::BakeOptions options = options_.bake;
        options.progress = [this, name](const char* stage, double done) {
            if (bakes_.quits()) throw Cancelled{};
            server_->post([this, name, text = std::string(stage), done] { tell_progress(name, text, done); });
        };
        try {
            const auto object = object_from_mesh(*judged, name, options_.size, options);
            server_->post([this, object, name] {
                tell_progress(name, "done", 1);
                add(object);
                tell_scene();
                restart_touch();
            });
        } catch (const mesh::Error& e) {
            server_->post([this, name, why = std::string(e.what())] {
                tell_progress(name, "failed", 1);
                tell_all(text_of({{"say", "trouble"}, {"text", name + ": " + why}}));
            });
        }
    });
}

// ---- Messages

void Viewer::on_open(ConnectionId connection)
{
    connections_.insert(connection);
    server_->send_text(connection, scene_text());
    server_->send_text(connection, status_text());
}

void Viewer::on_close(ConnectionId connection)
{
    connections_.erase(connection);
    refused_.erase(connection);
    // A page that is gone holds nothing: the force ends with it.
    if (connection == holder_ || connections_.empty()) stop_touch();
    if (connections_.empty()) {
        undress();
        record(false);
    }
}

bool Viewer::on_text(ConnectionId connection, std::string_view text)
{
    const std::optional<Message> message = read_message(text);
    if (!message) return false;
    switch (message->say) {
        case Say::Touch:
            if (holder_ != 0 && holder_ != connection) {
                // Said once a press.
                if (message->held && refused_.insert(connection).second)
                    server_->send_text(
                        connection,
                        text_of({{"say", "trouble"}, {"text", "Another window has the tool in hand: let go there first."}}));
                if (!message->held) refused_.erase(connection);
                return true;
            }
            refused_.erase(connection);
            touch(connection, *message);
            return true;
        case Say::Stop:
            stopped_ = true;
            if (touch_ != nullptr) touch_->stop();
            tell_all(status_text());
            return true;
        case Say::Resume:
            stopped_ = false;
            if (touch_ != nullptr) touch_->resume();
            tell_all(status_text());
            return true;
        case Say::Settings:
            settings_ = message->settings;
            if (settings_.tool == ToolKind::Mesh && settings_.tool_object >= entries_.size()) settings_.tool = ToolKind::Ball;
            ++tool_revision_;
            if (touch_ != nullptr && !touch_->adjust(settings_)) restart_touch();
            tell_all(status_text());
            return true;
        case Say::Device:
            if (message->device > device_specs_.size()) return true;
            device_ = message->device;
            touch_.reset();
            restart_touch();
            tell_all(status_text());
            return true;
        case Say::Record:
            record(message->held);
            return true;
        case Say::Fit:
        case Say::Cloth:
        case Say::Undress:
            dress(*message);
            return true;
        default:
            edit(*message);
            return true;
    }
}

void Viewer::edit(const Message& m)
{
    if (m.object >= entries_.size()) return;
    Entry& entry = entries_[m.object];
    const std::uint32_t count = entry.parts()->partition.part_count;
    switch (m.say) {
        case Say::Undo:
            if (entry.at > 0) --entry.at, ++entry.revision;
            if (entry.renamed) refresh_names(entry);
            return tell_scene();
        case Say::Redo:
            if (entry.at + 1 < entry.history.size()) ++entry.at, ++entry.revision;
            if (entry.renamed) refresh_names(entry);
            return tell_scene();
        case Say::Remove:
            entries_.erase(entries_.begin() + m.object);
            if (settings_.tool == ToolKind::Mesh && settings_.tool_object >= m.object) {
                if (settings_.tool_object == m.object)
                    settings_.tool = ToolKind::Ball;
                else
                    --settings_.tool_object;
                ++tool_revision_;
                tell_all(status_text());
            }
            tell_scene();
            return restart_touch();
        case Say::Bake:
            return bake_edited(m.object);
        default:
            break;
    }
    if (m.say == Say::Name) {
        if (m.part < count && !entry.object->mesh.triangles.empty()) name_part(entry, m.part, m.name);
        return;
    }
    if (m.part >= count || ((m.say == Say::Merge || m.say == Say::MoveCut) && m.other >= count) ||
        entry.object->mesh.triangles.empty() || pictures_.waiting() >= k_max_jobs)
        return;
    pictures_.work([this, m, object = entry.object, before = entry.parts(), words = entry.words] {
        std::shared_ptr<const Parts> after;
        if (m.say == Say::Refit) {
            after = std::make_shared<const Parts>(refitted(*object, *before, m.part));
        } else if (m.say == Say::MoveCut) {
            if (auto moved = moved_cut(*object, before->partition, m.part, m.other, m.distance))
                after = std::make_shared<const Parts>(fitted(*object, std::move(*moved), before.get(), words));
        } else {
            const decompose::Cutter cutter(object->mesh);
            if (m.say == Say::Merge) {
                after = std::make_shared<const Parts>(
                    fitted(*object, cutter.merge(before->partition, m.part, m.other), before.get(), words));
            } else {
                decompose::Split split = cutter.split(before->partition, m.part);
                if (split.found)
                    after = std::make_shared<const Parts>(fitted(*object, std::move(split.partition), before.get(), words));
            }
        }
        server_->post([this, object, before, after, say = m.say] {
            const auto at = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.object == object; });
            if (at == entries_.end() || at->parts() != before) return;  // the scene has moved on
            if (after == nullptr)
                return tell_all(text_of(
                    {{"say", "trouble"},
                     {"text", say == Say::MoveCut ? "These parts do not touch, or too little of the other one would be left."
                                                  : "This part has no place for a cut."}}));
            change(static_cast<std::uint32_t>(at - entries_.begin()), after);
        });
    });
}

void Viewer::change(std::uint32_t index, std::shared_ptr<const Parts> parts)
{
    Entry& entry = entries_[index];
    entry.history.resize(entry.at + 1);
    if (entry.history.size() >= k_max_history) entry.history.erase(entry.history.begin() + 1);
    entry.history.push_back(std::move(parts));
    entry.at = entry.history.size() - 1;
    ++entry.revision;
    tell_scene();
}

void Viewer::bake_edited(std::uint32_t index)
{
    Entry& entry = entries_[index];
    if (entry.at == 0 || bakes_.waiting() >= k_max_jobs) return;
    bakes_.work([this, object = entry.object, parts = entry.parts(), words = entry.words] {
        bake::BakeOptions options = options_.bake;
        options.progress = [this, name = object->name](const char* stage, double done) {
            if (bakes_.quits()) throw Cancelled{};
            server_->post([this, name, text = std::string(stage), done] { tell_progress(name, text, done); });
        };
        try {
            const auto after = rebaked(*object, *parts, options, words);
            server_->post([this, object, after] {
                tell_progress(object->name, "done", 1);
                replace(object, after);
            });
        } catch (const mesh::Error& e) {
            server_->post([this, name = object->name, why = std::string(e.what())] {
                tell_progress(name, "failed", 1);
                tell_all(text_of({{"say", "trouble"}, {"text", name + ": " + why}}));
            });
        }
    });
}

void Viewer::add(std::shared_ptr<Object> object)
{
    std::vector<ObjectPtr> others;
    for (const Entry& entry : entries_) others.push_back(entry.object);
    place_beside(*object, others);
    // Two of one name could not be told apart in a list.
    const std::string name = object->name;
    for (int n = 2; std::any_of(others.begin(), others.end(), [&](const ObjectPtr& o) { return o->name == object->name; }); ++n)
        object->name = name + " " + std::to_string(n);
    Entry entry;
    entry.history.push_back(std::make_shared<const Parts>(object->parts));
    entry.words = object->words;
    entry.id = next_id_++;
    entry.object = std::move(object);
    entries_.push_back(std::move(entry));
}

void Viewer::replace(const ObjectPtr& before, std::shared_ptr<Object> after)
{
    for (Entry& entry : entries_) {
        if (entry.object != before) continue;
        entry.history = {std::make_shared<const Parts>(after->parts)};
        entry.at = 0;
        ++entry.revision;
        entry.object = std::move(after);
        break;
    }
    tell_scene();
    restart_touch();
}

void Viewer::name_part(Entry& entry, std::uint32_t part, const std::string& name)
{
    set_words(entry, renamed(entry.words, entry.object->mesh, entry.parts()->partition, part, name, entry.object->frame()));
}

/// Names are of places, not of parts: undo does not take them back. The step that is shown gets them now, another when it is
/// shown.
void Viewer::refresh_names(Entry& entry)
{
    auto named = std::make_shared<Parts>(*entry.parts());
    named->names = part_names(entry.object->mesh, entry.object->dual, named->partition, named->superquadrics, entry.words,
                              entry.object->frame());
    entry.history[entry.at] = std::move(named);
}

void Viewer::set_words(Entry& entry, const Words& words)
{
    entry.words = words;
    entry.renamed = true;
    refresh_names(entry);
    if (!entry.object->names_file.empty()) {
        const std::string text = names_json(words).dump(1) + "\n";
        try {
            io::replace_file(entry.object->names_file, std::as_bytes(std::span(text)));
        } catch (const std::exception& e) {
            tell_all(text_of({{"say", "trouble"}, {"text", std::string("The names are not kept: ") + e.what()}}));
        }
    }
    tell_scene();
}

// ---- Cloth

#ifdef SQMAP_VIEWER_HAS_CLOTH
void Viewer::dress(const Message& message)
{
    if (message.say == Say::Undress) {
        undress();
        tell_progress("the figure", "done", 1);
        return tell_all(status_text());
    }
    if (fitting_ == nullptr) {
        if (message.say != Say::Fit) return;
        fitting_ = std::make_shared<Fitting>(
            [this](double done) {
                server_->post([this, done] {
                    if (fitting_ != nullptr) tell_progress("the figure", "bones", done);
                });
            },
            teller());
    }
    fitting_->tell(message);
}

/// The figure stays for the next visit. Where it is not made yet, the making ends, elsewhere: its thread may be baking a bone,
/// and STOP must not wait for that.
void Viewer::undress()
{
    if (fitting_ == nullptr) return;
    if (fitting_->ready()) {
        Message message;
        message.say = Say::Undress;
        return fitting_->tell(message);
    }
    pictures_.work([gone = std::move(fitting_)]() mutable { gone.reset(); });
    fitting_ = nullptr;
    told_fitting_.clear();
}

void Viewer::stream_cloth()
{
    if (fitting_ == nullptr) return;
    if (const std::string state = text_of(fitting_->status()); state != told_fitting_) {
        told_fitting_ = state;
        if (state != "null") tell_progress("the figure", "done", 1);
        tell_all(status_text());
    }
    const auto bytes = fitting_->frame();
    if (bytes == nullptr) return;
    const std::set<ConnectionId> all = connections_;
    for (const ConnectionId c : all) server_->send_binary(c, bytes, true);
}
#else
void Viewer::dress(const Message& /*message*/) {}
void Viewer::undress() {}
void Viewer::stream_cloth() {}
#endif

// ---- Touch

/// A new grasp begins where the page says, off the surface: a tool that flew there might pass through something.
void Viewer::touch(ConnectionId connection, const Message& message)
{
    constexpr double k_near = 0.03;  // m
    const bool begins = message.held && holder_ == 0;
    const bool far = norm(message.target - target_) > k_near;
    holder_ = message.held ? connection : 0;
    target_ = message.target;
    if (begins && device_ == 0 && (touch_ == nullptr || far)) restart_touch(true);
    if (touch_ == nullptr) return;
    // To grasp anew is the user's act that ends a fault; STOP holds until it is taken back.
    if (begins && !stopped_ && frame_.faults != 0) touch_->resume();
    touch_->aim(target_);
}

void Viewer::stop_touch()
{
    touch_.reset();
    holder_ = 0;
}

/// The touch begins anew, so that nothing that was felt before has a part in what is recorded.
void Viewer::record(bool on)
{
    recording_ = on;
    if (on) {
        takes_.clear();
        restart_touch();
    } else if (touch_ != nullptr) {
        touch_->end_take();
    }
}

std::size_t Viewer::recorded() const
{
    std::size_t ticks = 0;
    for (const auto& take : takes_) ticks += take->ticks.size();
    return ticks;
}

void Viewer::restart_touch(bool begin)
{
    const bool wanted = begin || touch_ != nullptr || device_ > 0;
    touch_.reset();
    if (!wanted || entries_.empty()) return;
    std::vector<ObjectPtr> objects;
    for (const Entry& entry : entries_) objects.push_back(entry.object);
    frame_ = {};
    try {
        std::unique_ptr<device::Device> device;
        if (device_ > 0) device = device::open_device(device_specs_[device_ - 1]);
        std::shared_ptr<Take> take;
        if (recording_ && recorded() < k_max_recorded && takes_.size() < k_max_takes)
            takes_.push_back(take = std::make_shared<Take>());
        touch_ = std::make_unique<Touch>(std::move(objects), settings_, std::move(device), target_, take);
        if (stopped_) touch_->stop();
    } catch (const std::exception& e) {
        device_ = 0;
        tell_all(text_of({{"say", "trouble"}, {"text", e.what()}}));
    }
}

void Viewer::on_frame()
{
    if (connections_.empty()) return;
    ++frames_;
    stream_cloth();
    if (frames_ % 30 == 0 && touch_ != nullptr) tell_all(status_text());
    if (touch_ == nullptr || !touch_->frame(frame_)) return;
    const TouchFrame& f = frame_;
    std::vector<float> out{1, static_cast<float>(frames_ & 0xffff)};
    const auto vector = [&](Vec3d v) {
        for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(v[k]));
    };
    vector(f.tool);
    vector(f.force);
    vector(f.torque);
    vector(f.point);
    vector(f.normal);
    for (const double x : {f.depth, static_cast<double>(f.contacts), static_cast<double>(f.object), static_cast<double>(f.part),
                           static_cast<double>(f.acted), static_cast<double>(f.faults), f.late * 1e3, f.degraded ? 1.0 : 0.0,
                           f.engaged ? 1.0 : 0.0, f.connected ? 1.0 : 0.0, static_cast<double>(f.ticks.size()),
                           recording_ && !f.cut && recorded() < k_max_recorded ? static_cast<double>(recorded()) : 0.0})
        out.push_back(static_cast<float>(x));
    for (int row = 0; row < 3; ++row) vector(f.turn.row[row]);
    for (const TickPoint& t : f.ticks) out.insert(out.end(), {t.force, t.torque, t.depth, t.cpu});
    auto bytes = std::make_shared<std::string>(4 * out.size(), '\0');
    std::memcpy(bytes->data(), out.data(), bytes->size());
    const std::set<ConnectionId> all = connections_;  // one that does not read is let go on the way
    for (const ConnectionId c : all) server_->send_binary(c, bytes, true);
}

void Viewer::list_devices()
{
    bakes_.work([this] {
        const std::vector<device::DeviceListing> list = device::list_devices();
        ordered_json json = ordered_json::array();
        std::vector<std::string> specs;
        json.push_back({{"name", "Pointer or keys, through a simulated device"},
                        {"here", true},
                        {"state", "no hardware: force is drawn and heard"},
                        {"rate", 1000},
                        {"limit", 3.3}});
        for (const device::DeviceListing& d : list) {
            // Those that need a file or a script are for the command line.
            specs.push_back(d.spec);
            json.push_back({{"name", d.capabilities.name.empty() ? d.spec : d.capabilities.name},
                            {"here", d.presence == device::Presence::Here && !d.capabilities.simulated},
                            {"state", d.state},
                            {"rate", d.capabilities.rate},
                            {"limit", d.capabilities.max_force}});
        }
        server_->post([this, text = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace), specs] {
            devices_ = text;
            device_specs_ = specs;
            tell_all(status_text());
        });
    });
}

// ---- What is told

void Viewer::tell_all(const std::string& text)
{
    const std::set<ConnectionId> all = connections_;
    for (const ConnectionId c : all) server_->send_text(c, text);
}

void Viewer::tell_scene() { tell_all(scene_text()); }

void Viewer::tell_progress(const std::string& name, const std::string& stage, double done)
{
    tell_all(text_of({{"say", "progress"}, {"name", name}, {"stage", stage}, {"done", done}}));
}

std::string Viewer::scene_text() const
{
    ordered_json out{{"say", "scene"}, {"objects", ordered_json::array()}};
    for (const Entry& entry : entries_) {
        ordered_json facts = facts_json(*entry.object, *entry.parts(), entry.at > 0);
        facts["id"] = entry.id;
        facts["namesKept"] = !entry.object->names_file.empty();
        facts["revision"] = entry.revision;
        facts["canUndo"] = entry.at > 0;
        facts["canRedo"] = entry.at + 1 < entry.history.size();
        out["objects"].push_back(std::move(facts));
    }
    return text_of(out);
}

std::string Viewer::status_text() const
{
    ordered_json out{{"say", "status"}, {"touching", touch_ != nullptr}, {"stopped", stopped_}, {"device", device_}};
    out["devices"] = ordered_json::parse(devices_);
    out["settings"] = {{"layer", app::layer_name(settings_.layer)},
                       {"stiffness", settings_.stiffness},
                       {"damping", settings_.damping},
                       {"friction", settings_.friction},
                       {"texture", settings_.texture},
                       {"smoothing", settings_.smoothing},
                       {"toolRadius", settings_.tool_radius},
                       {"zone", settings_.zone},
                       {"forceLimit", settings_.force_limit},
                       {"tool", settings_.tool == ToolKind::Ball   ? ordered_json("ball")
                                : settings_.tool == ToolKind::Hand ? ordered_json("hand")
                                                                   : ordered_json(settings_.tool_object)},
                       {"toolSize", settings_.tool_size},
                       {"toolTurn", settings_.tool_turn},
                       {"toolTilt", settings_.tool_tilt}};
    out["toolRevision"] = tool_revision_;
    out["cloth"] = {{"here", k_has_cloth}, {"worn", nullptr}};
#ifdef SQMAP_VIEWER_HAS_CLOTH
    if (fitting_ != nullptr) out["cloth"]["worn"] = fitting_->status();
#endif
    if (touch_ != nullptr) {
        const device::ServoCounters c = touch_->counters();
        out["counters"] = {
            {"ticks", c.ticks},       {"late", c.late},         {"missed", c.missed},   {"overruns", c.overruns},
            {"degraded", c.degraded}, {"watchdog", c.watchdog}, {"dropped", c.dropped}, {"worstLate", 1e3 * c.worst_late}};
        out["limit"] = touch_->force_limit();
        out["safeStiffness"] = touch_->safe_stiffness();
        out["deviceName"] = touch_->capabilities().name;
    }
    return text_of(out);
}

}  // namespace sqmap::viewer
