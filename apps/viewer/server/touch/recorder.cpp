#include "viewer/server/touch/recorder.h"

#include "common/hash_text.h"
#include "sqmap/device/trace.h"
#include "sqmap/model/parse.h"
#include "sqmap/paper/model.h"
#include "viewer/server/scene/file_name.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace sqmap::viewer {
namespace {

/// How the scene is to stand so that it is the recording's.
struct Arrangement {
    std::vector<ObjectPtr> objects;                       // of the recording, in its order
    std::vector<std::pair<ObjectPtr, ObjectPtr>> copies;  // of the scene's objects, where one must move
};

HttpReply refused(const char* code, const std::string& message, const std::string& cure)
{
    return json_reply({{"accepted", false}, {"verdict", "REFUSED"}, {"code", code}, {"message", message}, {"cure", cure}});
}

/// The models of a recording that the scene does not have, and what helps; nothing where it has all.
std::optional<HttpReply> missing(const RecordingFile& file, const std::vector<ObjectPtr>& scene)
{
    std::string names, files;
    std::set<std::uint64_t> named;
    bool other = false;
    for (const RecordingFile::NamedObject& object : file.objects) {
        const auto has_hash = [&](const ObjectPtr& o) { return paper::content_hash(o->view) == object.hash; };
        if (std::any_of(scene.begin(), scene.end(), has_hash) || !named.insert(object.hash).second) continue;
        other = other || std::any_of(scene.begin(), scene.end(), [&](const ObjectPtr& o) { return o->name == object.name; });
        names += (names.empty() ? "" : ", ") + object.name + " (model " + app::hash_text(object.hash) + ")";
        files += (files.empty() ? "" : " and ") + object.name + ".sqmap";
    }
    if (names.empty()) return std::nullopt;
    return refused("E_MODEL",
                   "it is a recording of " + names + ", which is not open" +
                       (other ? "; what is open under that name is another model" : ""),
                   "open " + files + ", or the mesh that it was baked from, then this recording again");
}

/// @pre none is missing
Arrangement arrangement_of(const RecordingFile& file, const std::vector<ObjectPtr>& scene)
{
    Arrangement out;
    std::vector<ObjectPtr> left = scene, standing;  // not of the recording so far; where all stand then
    for (const RecordingFile::NamedObject& named : file.objects) {
        const auto is_it = [&](const ObjectPtr& o) { return paper::content_hash(o->view) == named.hash; };
        auto at = std::find_if(left.begin(), left.end(), [&](const ObjectPtr& o) { return is_it(o) && o->name == named.name; });
        if (at == left.end()) at = std::find_if(left.begin(), left.end(), is_it);
        const bool shown = at != left.end();
        const ObjectPtr object = shown ? *at : *std::find_if(scene.begin(), scene.end(), is_it);
        const Vec3d from_origin = named.metres_per_unit * (object->centre - object->frame().origin);
        const Vec3d position = file.of_touch ? named.position + from_origin : named.position;
        const bool stands =
            shown && object->position == position && object->metres_per_unit == named.metres_per_unit && object->up == named.up;
        ObjectPtr then = object;
        if (!stands) {
            const auto there = std::make_shared<Object>(*object);
            there->put_at(named.metres_per_unit, position, named.up);
            then = there;
        }
        out.objects.push_back(then);
        if (!shown) continue;  // one that was there twice, and is once
        left.erase(at);
        standing.push_back(then);
        if (!stands) out.copies.emplace_back(object, then);
    }
    if (out.copies.empty()) return out;
    for (const ObjectPtr& object : left) {
        const auto beside = std::make_shared<Object>(*object);
        put_beside(*beside, standing);
        standing.push_back(beside);
        out.copies.emplace_back(object, beside);
    }
    return out;
}

/// The settings at the take's end; a tool of the scene has its number in the scene of now.
Settings settings_now(const Take& take, const std::vector<ObjectPtr>& scene)
{
    Settings out = take.settings.back();
    if (out.tool != ToolKind::Mesh) return out;
    const bool known = out.tool_object < take.objects.size();
    const auto at = known ? std::find(scene.begin(), scene.end(), take.objects[out.tool_object]) : scene.end();
    if (at == scene.end())
        out.tool = ToolKind::Ball;
    else
        out.tool_object = static_cast<std::uint32_t>(at - scene.begin());
    return out;
}

}  // namespace

Recorder::Recorder(Audience& audience, Scene& scene, Worker& pictures, Worker& bakes)
    : audience_(audience), scene_(scene), pictures_(pictures), bakes_(bakes)
{
}

void Recorder::add_routes(Routes& routes)
{
    routes.get("/api/recording", [this](const Call& call) {
        answer_with(call, [](const Recording& takes) {
            return HttpReply{.type = "text/csv", .body = recording_text(takes), .file_name = "touch.csv"};
        });
    });
    routes.get("/api/recording/frames", [this](const Call& call) {
        answer_with(call, [this, scene = scene_.objects()](const Recording& takes) {
            return bytes_reply(frames_bytes(takes, scene, [this] { return pictures_.quits(); }));
        });
    });
    for (const bool now : {false, true})
        routes.get(now ? "/api/again/now" : "/api/again/then", [this, now](const Call& call) {
            std::optional<Other> other;
            if (now) other = Other{scene_.touchable(settings()), settings()};
            answer_with(call, [this, other](const Recording& takes) {
                return bytes_reply(again_bytes(compute_again(takes, other, [this] { return pictures_.quits(); })));
            });
        });
    routes.post("/api/recording", [this](const Call& call) { open(std::move(call.request), call.answer); });
}

/// Makes the reply from the recording on the worker's thread.
void Recorder::answer_with(const Call& call, std::function<HttpReply(const Recording&)> make)
{
    if (recording_ || ticks() == 0) return call.answer({.status = 404, .body = "the program has no recording\n"});
    if (pictures_.busy()) return call.answer(busy());
    pictures_.work([answer = call.answer, make = std::move(make), takes = Recording(takes_.begin(), takes_.end())] {
        try {
            answer(make(takes));
        } catch (const device::TraceError& e) {
            answer({.status = 500, .body = std::string(e.what()) + "\n"});
        }
    });
}

/// The scene comes to stand as it stood then, and the settings are those of the recording's end.
void Recorder::open(HttpRequest request, const Answer& answer)
{
    if (bakes_.busy() || recording_)
        return answer(refused("E_BUSY", recording_ ? "another recording goes on" : "other files are being baked",
                              "wait, and send it again"));
    const std::string name = harmless(query_value(request.target, "name"));
    bakes_.work([this, answer, name, scene = scene_.objects(), body = std::move(request.body)] {
        auto file = std::make_shared<RecordingFile>();
        try {
            *file = read_recording(body, name);
        } catch (const device::TraceError& e) {
            return answer(refused("E_RECORDING", e.what(), "open a file that the page or sqmap touch has recorded"));
        }
        if (const std::optional<HttpReply> without = missing(*file, scene)) return answer(*without);
        const Arrangement then = arrangement_of(*file, scene);
        for (std::size_t i = 0; i < file->takes.size(); ++i)
            for (const std::uint32_t number : file->objects_of[i])
                file->takes[i]->objects.push_back(number == k_hidden_object ? nullptr : then.objects[number]);
        audience_.post([this, answer, file, then] {
            if (recording_ || !scene_.rearrange(then.copies))
                return answer(refused("E_BUSY", "the scene has changed meanwhile", "open it again"));
            takes_ = file->takes;
            on_open(settings_now(*takes_.back(), scene_.objects()));
            auto notes = nlohmann::ordered_json::array();
            if (file->of_touch)
                notes.push_back("sqmap touch recorded it: the forces are those of then, Compute again computes the page's");
            answer(json_reply({{"accepted", true}, {"verdict", "RECORDING"}, {"notes", std::move(notes)}}));
        });
    });
}

void Recorder::begin()
{
    recording_ = true;
    takes_.clear();
}

std::shared_ptr<Take> Recorder::next_take()
{
    if (!recording_ || full() || takes_.size() >= k_max_takes) return nullptr;
    return takes_.emplace_back(std::make_shared<Take>());
}

std::size_t Recorder::ticks() const
{
    std::size_t out = 0;
    for (const auto& take : takes_) out += take->ticks.size();
    return out;
}

}  // namespace sqmap::viewer
