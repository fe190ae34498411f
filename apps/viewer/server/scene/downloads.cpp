#include "viewer/server/scene/downloads.h"

#include "sqmap/mesh/error.h"
#include "sqmap/paper/model.h"
#include "viewer/server/scene/exports.h"
#include "viewer/server/scene/fields.h"
#include "viewer/server/scene/file_name.h"
#include "viewer/server/scene/geometry.h"
#include "viewer/server/scene/inspect.h"
#include "viewer/server/scene/meetings.h"

#include <cmath>
#include <vector>

namespace sqmap::viewer {
namespace {

/// An object as it is shown now: shared with the worker that answers.
struct Shown {
    ObjectPtr object;
    std::shared_ptr<const Parts> parts;
    Words words;
    bool edited = false;
    ObjectPtr twin;  ///< of the other projection; null: none
};

/// /api/object/N/NAME
struct Download {
    const char* name;
    const char *type, *extension;         ///< of a file; null: bytes to draw
    std::string (*make)(const Shown& s);  ///< on the worker's thread
};

constexpr const char* k_json = "application/json";
constexpr Download k_downloads[] = {
    {"mesh", nullptr, nullptr, [](const Shown& s) { return mesh_bytes(*s.object, *s.parts); }},
    {"superquadrics", nullptr, nullptr, [](const Shown& s) { return superquadric_bytes(*s.object, *s.parts, 10); }},
    {"samples", nullptr, nullptr, [](const Shown& s) { return sample_bytes(*s.object); }},
    {"offset", nullptr, nullptr, [](const Shown& s) { return offset_bytes(*s.object); }},
    {"hidden", nullptr, nullptr, [](const Shown& s) { return hidden_bytes(*s.object); }},
    {"names", k_json, ".names.json", [](const Shown& s) { return names_json(s.words).dump(1) + "\n"; }},
    {"glb", "model/gltf-binary", ".glb", [](const Shown& s) { return glb_bytes(*s.object, *s.parts); }},
    {"json", k_json, ".json", [](const Shown& s) { return json_text(*s.object, *s.parts); }},
    {"sqmap", "application/octet-stream", ".sqmap",
     [](const Shown& s) { return std::string(reinterpret_cast<const char*>(s.object->file->data()), s.object->file->size()); }},
};

constexpr std::pair<const char*, Field> k_fields[] = {{"error", Field::Error},           {"error-2", Field::ErrorOfTwo},
                                                      {"protrusion", Field::Protrusion}, {"curvature", Field::Curvature},
                                                      {"locales", Field::Locales},       {"strength", Field::Strength},
                                                      {"regions", Field::Regions},       {"made-up", Field::MadeUp}};

std::optional<Shown> shown(const Scene& scene, std::string_view number)
{
    const auto index = number_of(number);
    if (!index || *index >= scene.entries().size()) return std::nullopt;
    const Scene::Entry& entry = scene.entries()[*index];
    const std::optional<std::size_t> twin = scene.twin_of(*index);
    return Shown{entry.object, entry.parts(), entry.words, entry.at > 0, twin ? scene.entries()[*twin].object : nullptr};
}

void download(const Call& call, const Shown& s, Worker& pictures)
{
    for (const Download& d : k_downloads) {
        if (call.stars[1] != d.name) continue;
        if (s.edited && call.stars[1] == "sqmap")
            return call.answer({.status = 409, .body = "bake the edited parts first: the model is of those before\n"});
        return pictures.work([answer = call.answer, s, &d] {
            try {
                HttpReply reply = bytes_reply(d.make(s));
                if (d.type != nullptr) reply.type = d.type, reply.file_name = harmless(s.object->name) + d.extension;
                answer(std::move(reply));
            } catch (const mesh::InvalidInput& e) {
                answer({.status = 409, .body = std::string(e.what()) + '\n'});
            }
        });
    }
    call.answer(not_found());
}

void field(const Call& call, const Shown& s, Worker& pictures)
{
    for (const auto& [name, field] : k_fields)
        if (call.stars[1] == name)
            return pictures.work(
                [answer = call.answer, s, field = field] { answer(bytes_reply(field_bytes(*s.object, field))); });
    if (call.stars[1] == "difference" && s.twin != nullptr)
        return pictures.work([answer = call.answer, s] { answer(bytes_reply(difference_bytes(*s.object, *s.twin))); });
    call.answer(not_found());
}

void map(const Call& call, const Shown& s, Worker& pictures)
{
    constexpr int k_side = 48;  // pixels of a face of the cube
    const auto part = number_of(call.stars[1]);
    if (!part || *part >= s.object->view.parts.size()) return call.answer(not_found());
    pictures.work([answer = call.answer, s, part = *part] { answer(bytes_reply(map_bytes(*s.object, part, k_side))); });
}

/// "x_y_z" in metres of the world: no address has a comma.
std::optional<Vec3d> point_of(std::string_view text)
{
    Vec3d out;
    for (int k = 0; k < 3; ++k) {
        const std::optional<double> number = take_number(text);
        if (!number || !(std::abs(*number) <= 100)) return std::nullopt;
        out[k] = *number;
        if (k < 2 && !text.starts_with('_')) return std::nullopt;
        if (k < 2) text.remove_prefix(1);
    }
    return text.empty() ? std::optional(out) : std::nullopt;
}

void answers(const Call& call, const Shown& s, Worker& pictures)
{
    const std::optional<Vec3d> at = point_of(query_value(call.request.target, "at"));
    if (!at) return call.answer(not_found());
    pictures.work([answer = call.answer, s, at = *at] { answer(json_reply(answers_json(*s.object, at))); });
}

void search(const Call& call, const Shown& s, Worker& pictures)
{
    const std::optional<Vec3d> at = point_of(query_value(call.request.target, "at"));
    const auto part = number_of(call.stars[1]);
    if (!at || !part || *part >= s.object->view.parts.size() || !paper::is_paper(s.object->view)) return call.answer(not_found());
    pictures.work([answer = call.answer, s, part = *part, at = *at] { answer(json_reply(search_json(*s.object, part, at))); });
}

void section(const Call& call, const Shown& s, Worker& pictures)
{
    const std::optional<Vec3d> at = point_of(query_value(call.request.target, "at"));
    const auto part = number_of(call.stars[1]), axis = number_of(call.stars[2]);
    if (!at || !part || !axis || *part >= s.parts->superquadrics.size() || *axis > 2) return call.answer(not_found());
    pictures.work([answer = call.answer, s, plane = SectionPlane{*part, static_cast<int>(*axis), *at}] {
        answer(bytes_reply(section_bytes(*s.object, *s.parts, plane)));
    });
}

void slice(const Call& call, const Shown& s, Worker& pictures)
{
    const std::optional<Vec3d> at = point_of(query_value(call.request.target, "at"));
    const auto axis = number_of(call.stars[1]);
    if (!at || !axis || *axis > 2) return call.answer(not_found());
    pictures.work([answer = call.answer, s, axis = static_cast<int>(*axis), at = *at] {
        answer(bytes_reply(slice_bytes(*s.object, axis, at)));
    });
}

/// The objects that are seen; null in place of the others.
std::vector<ObjectPtr> seen(const Scene& scene)
{
    std::vector<ObjectPtr> out;
    for (const Scene::Entry& entry : scene.entries()) out.push_back(entry.hidden ? nullptr : entry.object);
    return out;
}

}  // namespace

void add_downloads(Routes& routes, const Scene& scene, Worker& pictures)
{
    using Make = void (*)(const Call&, const Shown&, Worker&);
    for (const auto& [pattern, make] : {std::pair<const char*, Make>{"/api/object/*/*", download},
                                        {"/api/object/*/field/*", field},
                                        {"/api/object/*/map/*", map},
                                        {"/api/object/*/at/answers", answers},
                                        {"/api/object/*/search/*", search},
                                        {"/api/object/*/section/*/*", section},
                                        {"/api/object/*/slice/*", slice}})
        routes.get(pattern, [&scene, &pictures, make = make](const Call& call) {
            const std::optional<Shown> s = shown(scene, call.stars[0]);
            if (!s) return call.answer(not_found());
            if (pictures.busy()) return call.answer(busy());
            make(call, *s, pictures);
        });
    routes.get("/api/contacts", [&scene, &pictures](const Call& call) {
        if (pictures.busy()) return call.answer(busy());
        pictures.work([answer = call.answer, objects = seen(scene)] { answer(json_reply(meetings_json(objects))); });
    });
}

}  // namespace sqmap::viewer
