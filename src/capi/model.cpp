// Models behind the C interface: opening, saving, facts.
#include "sqmap/model/model.h"
#include "io/replace_file.h"
#include "objects.h"
#include "sqmap/bake/notes.h"
#include "sqmap/bake/rebake.h"
#include "sqmap/io/model_archive.h"
#include "structs.h"
#include "words.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

namespace sqmap::capi {
namespace {

/// The text of an error without the path, which is the failure's element.
std::string words_of(const io::ModelFileError& error, const std::string& path)
{
    std::string out = error.what();
    if (const std::size_t at = out.find(path); at != std::string::npos && !path.empty()) out.erase(at, path.size());
    if (const std::size_t gap = out.find(" :"); gap != std::string::npos) out.erase(gap, 1);
    return out.substr(std::min(out.find_first_not_of(": "), out.size()));
}

io::MappedBytes mapped(const char* path)
{
    try {
        return io::MappedBytes(path);
    } catch (const io::ModelFileError& e) {
        throw Failure{SQMAP_E_FILE, path, words_of(e, path), "give the path of a model that can be read"};
    }
}

io::MappedBytes mapped(const char* path, std::string_view key)
{
    std::optional<io::ModelArchive> archive;
    try {
        archive.emplace(path);
        if (!archive->find(key))
            throw Failure{SQMAP_E_ARGUMENT, "key", "the archive holds no such model", "take one of 'sqmap batch list'"};
        return archive->map(key);
    } catch (const io::ModelArchiveError& e) {
        throw Failure{archive ? SQMAP_E_MODEL : SQMAP_E_FILE, path, e.why(), e.cure()};
    } catch (const io::ModelFileError& e) {
        throw Failure{SQMAP_E_FILE, path, words_of(e, path), "give the path of an archive that can be read"};
    }
}

mesh::Mesh mesh_of(const model::ModelView& view)
{
    if (!model::has_exact(view))
        throw Failure{SQMAP_E_MISSING,
                      "model",
                      "was baked without its triangles",
                      {"bake it with the exact layer: ", mesh::Setting::Exact}};
    mesh::Mesh mesh = bake::baked_mesh(view);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) mesh.vertices[v] = model::mesh_vertex(view, v);
    return mesh;
}

}  // namespace

Surface::Surface(const model::ModelView& view) : mesh(mesh_of(view)), bvh(mesh), source(view.input.source_triangle) {}

void refuse_bytes(model::ParseStatus status, const std::string& element)
{
    throw Failure{status == model::ParseStatus::WrongVersion ? SQMAP_E_VERSION : SQMAP_E_MODEL, element, model::to_string(status),
                  model::cure_of(status)};
}

Model::Model(const char* path) : Model(mapped(path), path) {}

Model::Model(io::MappedBytes file, const std::string& element)
    : file_(std::move(file)), opened_(open_model(file_->bytes(), element))
{
}

Model::Model(std::vector<std::byte> bytes, std::int32_t words)
    : bytes_(std::move(bytes)), words_(words), opened_(open_model(bytes_, "bytes"))
{
}

const Surface& Model::surface() const
{
    std::call_once(once_, [this] { surface_ = std::make_unique<Surface>(view()); });
    return *surface_;
}

}  // namespace sqmap::capi

using namespace sqmap;
using capi::guarded;
using capi::needed;

const char* sqmap_version(void) { return SQMAP_VERSION; }

uint32_t sqmap_format_version(void) { return model::k_format_version; }

sqmap_code sqmap_open(const char* path, sqmap_model* model)
{
    return capi::opened(model, "model", capi::models(), [&] { return std::make_shared<capi::Model>(&needed(path, "path")); });
}

sqmap_code sqmap_open_archived(const char* archive, const char* key, sqmap_model* model)
{
    return capi::opened(model, "model", capi::models(), [&] {
        const char* const path = &needed(archive, "archive");
        return std::make_shared<capi::Model>(capi::mapped(path, &needed(key, "key")), path);
    });
}

sqmap_code sqmap_open_bytes(const void* bytes, size_t size, sqmap_model* model)
{
    return capi::opened(model, "model", capi::models(), [&] {
        const auto* first = static_cast<const std::byte*>(bytes);
        if (size > 0) (void)needed(first, "bytes");
        return std::make_shared<capi::Model>(std::vector<std::byte>(first, first + size));
    });
}

sqmap_code sqmap_save(sqmap_model model, const char* path)
{
    return guarded([&] { io::replace_file(&needed(path, "path"), capi::model_of(model)->bytes()); });
}

sqmap_code sqmap_bytes(sqmap_model model, const void** bytes, size_t* size)
{
    return guarded([&] {
        const std::span<const std::byte> all = capi::model_of(model)->bytes();
        std::size_t& count = needed(size, "size");
        needed(bytes, "bytes") = all.data();
        count = all.size();
    });
}

sqmap_code sqmap_model_facts(sqmap_model model, sqmap_facts* facts)
{
    return guarded([&] {
        sqmap_facts out = capi::taken(&needed(facts, "facts"), "facts");
        const capi::Model& m = *capi::model_of(model);
        const model::ModelView& view = m.view();
        const model::Header& h = view.header;
        out.r_max = h.r_max * h.unit;
        out.band = static_cast<double>(view.distance.header.band) * h.unit;
        const Vec3d centre = model::to_mesh_units(h, model::vec3(h.sphere));
        for (int i = 0; i < 3; ++i) out.centre[i] = centre[i];
        out.radius = static_cast<double>(h.sphere[3]) * h.unit;
        out.bytes = m.bytes().size();
        out.parts = static_cast<std::uint32_t>(view.parts.size());
        out.vertices = h.vertex_count;
        out.triangles = h.triangle_count;
        out.is_solid = h.solid != 0 ? 1 : 0;
        out.has_exact = model::has_exact(view) ? 1 : 0;
        out.is_normal = m.is_paper() ? 1 : 0;
        out.is_doubtful = model::is_doubtful(view.measured) ? 1 : 0;
        out.has_input = model::has_input(view) ? 1 : 0;
        out.cure = static_cast<std::int32_t>(view.cure.rung);
        capi::give(facts, out);
    });
}

sqmap_code sqmap_info(sqmap_model model, sqmap_text* json)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        capi::give_text(json, capi::json_of(m.view(), m.bytes()), "json");
    });
}

sqmap_code sqmap_notes(sqmap_model model, sqmap_text* lines)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const std::int32_t wanted = capi::taken(&needed(lines, "lines"), "lines").words;
        const mesh::SettingNames& names = capi::names_of(wanted != 0 ? wanted : m.words(), "lines.words");
        std::string text;
        for (const std::string& line : words(notes_of(capi::notes_in(m.bytes())), names)) text += line + "\n";
        capi::give_text(lines, text, "lines");
    });
}

sqmap_code sqmap_triangles(sqmap_model model, double* vertices, uint32_t* triangles, int32_t* parts)
{
    return guarded([&] {
        const capi::Model& m = *capi::model_of(model);
        const mesh::Mesh mesh = capi::mesh_of(m.view());
        for (std::size_t v = 0; vertices != nullptr && v < mesh.vertices.size(); ++v)
            for (int k = 0; k < 3; ++k) vertices[3 * v + static_cast<std::size_t>(k)] = mesh.vertices[v][k];
        for (std::size_t t = 0; triangles != nullptr && t < mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) triangles[3 * t + k] = mesh.triangles[t][k];
        for (std::size_t t = 0; parts != nullptr && t < mesh.triangles.size(); ++t)
            parts[t] = static_cast<int32_t>(model::part_of_triangle(m.view(), t));
    });
}

sqmap_code sqmap_sources(sqmap_model model, int64_t* triangles, int64_t* vertices)
{
    return guarded([&] {
        const model::InputArrays<model::ArrayView>& input = capi::model_of(model)->view().input;
        if (input.source_vertex.empty())
            throw capi::Failure{
                SQMAP_E_MISSING, "model", "was baked without its input", {"bake it again with ", mesh::Setting::KeepInput}};
        const auto number = [](std::uint32_t source) { return source == model::k_no_source ? -1 : std::int64_t{source}; };
        if (triangles != nullptr) std::transform(input.source_triangle.begin(), input.source_triangle.end(), triangles, number);
        if (vertices != nullptr) std::transform(input.source_vertex.begin(), input.source_vertex.end(), vertices, number);
    });
}

sqmap_code sqmap_close_model(sqmap_model model)
{
    return guarded([&] { capi::models().close(model.id, "model"); });
}
