#include "viewer/server/scene/downloads.h"

#include "viewer/server/scene/file_name.h"

namespace sqmap::viewer {
namespace {

/// An object as it is shown now: shared with the worker that answers.
struct Shown {
    ObjectPtr object;
    std::shared_ptr<const Parts> parts;
    Words words;
    bool edited = false;
};

bool is_central(const Shown& s)
{
    return s.object->view.header.projection == static_cast<std::uint32_t>(model::Projection::Central);
}

/// /api/object/N/NAME
struct Download {
    const char* name;
    bool central;                         ///< of a model with central maps alone
    const char *type, *extension;         ///< of a file; null: bytes to draw
    std::string (*make)(const Shown& s);  ///< on the worker's thread
};

constexpr const char* k_json = "application/json";
constexpr Download k_downloads[] = {
    {"mesh", false, nullptr, nullptr, [](const Shown& s) { return mesh_bytes(*s.object, *s.parts); }},
    {"superquadrics", false, nullptr, nullptr, [](const Shown& s) { return superquadric_bytes(*s.object, *s.parts, 10); }},
    {"samples", true, nullptr, nullptr, [](const Shown& s) { return sample_bytes(*s.object); }},
    {"offset", true, nullptr, nullptr, [](const Shown& s) { return offset_bytes(*s.object); }},
    {"hidden", true, nullptr, nullptr, [](const Shown& s) { return hidden_bytes(*s.object); }},
    {"names", false, k_json, ".names.json", [](const Shown& s) { return names_json(s.words).dump(1) + "\n"; }},
    {"glb", false, "model/gltf-binary", ".glb", [](const Shown& s) { return glb_bytes(*s.object, *s.parts); }},
    {"json", false, k_json, ".json", [](const Shown& s) { return superquadrics_json(*s.object, *s.parts).dump(2) + "\n"; }},
    {"sqmap", false, "application/octet-stream", ".sqmap",
     [](const Shown& s) { return std::string(reinterpret_cast<const char*>(s.object->blob.data()), s.object->blob.size()); }},
};

constexpr std::pair<const char*, Field> k_fields[] = {
    {"error", Field::Error}, {"protrusion", Field::Protrusion}, {"curvature", Field::Curvature}};

std::optional<Shown> shown(const Scene& scene, std::string_view number)
{
    const auto index = number_of(number);
    if (!index || *index >= scene.entries().size()) return std::nullopt;
    const Scene::Entry& entry = scene.entries()[*index];
    return Shown{entry.object, entry.parts(), entry.words, entry.at > 0};
}

void download(const Call& call, const Shown& s, Worker& pictures)
{
    for (const Download& d : k_downloads) {
        if (call.stars[1] != d.name || (d.central && !is_central(s))) continue;
        if (s.edited && call.stars[1] == "sqmap")
            return call.answer({.status = 409, .body = "bake the edited parts first: the model is of those before\n"});
        return pictures.work([answer = call.answer, s, &d] {
            HttpReply reply = bytes_reply(d.make(s));
            if (d.type != nullptr) reply.type = d.type, reply.file_name = harmless(s.object->name) + d.extension;
            answer(std::move(reply));
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
    call.answer(not_found());
}

void map(const Call& call, const Shown& s, Worker& pictures)
{
    constexpr int k_side = 48;  // pixels of a face of the cube
    const auto part = number_of(call.stars[1]);
    if (!part || *part >= s.object->view.parts.size() || !is_central(s)) return call.answer(not_found());
    pictures.work([answer = call.answer, s, part = *part] { answer(bytes_reply(map_bytes(*s.object, part, k_side))); });
}

}  // namespace

void add_downloads(Routes& routes, const Scene& scene, Worker& pictures)
{
    using Make = void (*)(const Call&, const Shown&, Worker&);
    for (const auto& [pattern, make] : {std::pair<const char*, Make>{"/api/object/*/*", download},
                                        {"/api/object/*/field/*", field},
                                        {"/api/object/*/map/*", map}})
        routes.get(pattern, [&scene, &pictures, make = make](const Call& call) {
            const std::optional<Shown> s = shown(scene, call.stars[0]);
            if (!s) return call.answer(not_found());
            if (pictures.busy()) return call.answer(busy());
            make(call, *s, pictures);
        });
}

}  // namespace sqmap::viewer
