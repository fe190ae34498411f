#include "viewer/server/scene/load.h"

#include "io/files.h"
#include "sqmap/bake/rebake.h"

#include <optional>
#include <stdexcept>
#include <utility>

namespace sqmap::viewer {

std::shared_ptr<Object> object_from_model(std::vector<std::byte> bytes, const std::string& name, double size, const Words& words)
{
    auto object = std::make_shared<Object>();
    object->name = std::filesystem::path(name).stem().string();
    object->file = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    const auto model = std::make_shared<paper::AnyModel>();
    if (const model::ParseStatus status = model->parse(*object->file); status != model::ParseStatus::Ok)
        throw std::runtime_error(name + ": not a model: " + model::to_string(status));
    object->model = model;
    object->view = model->view();
    const model::ModelView& view = object->view;
    object->mesh = bake::baked_mesh(view);
    object->dual = mesh::dual_graph(object->mesh);
    Parts& parts = object->parts;
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t)
        parts.partition.part_of_triangle.push_back(model::part_of_triangle(view, t));
    parts.partition.part_count = static_cast<std::uint32_t>(view.parts.size());
    for (const model::Part& part : view.parts) {
        parts.superquadrics.push_back(shape::cast<double>(model::superquadric_of(part)));
        parts.largest_f.push_back(part.largest_f);
        parts.spheres.push_back({cast<double>(model::vec3(part.sphere)), static_cast<double>(part.sphere[3])});
    }
    object->words = words;
    parts.names = part_names(object->mesh, object->dual, parts.partition, parts.superquadrics, words, object->frame());
    object->put_at(size / (view.header.r_max * view.header.unit), {});
    object->notes = notes_of(paper::notes_of(*object->file));
    if (object->notes.empty())  // a model that was written before files kept notes
        if (const std::optional<Note> doubt = doubt_of(view)) object->notes.push_back(*doubt);
    return object;
}

std::shared_ptr<Object> object_from_mesh(AdmittedMesh mesh, const std::string& name, double size, BakeMeshOptions options)
{
    options.provenance = {.made_by = "sqmap view", .source = name};
    BakedModel baked = bake_mesh(std::move(mesh), options);
    auto object = object_from_model(baked.bytes(), name, size);
    options.bake.progress = nullptr;
    object->baked_with = std::move(options.bake);
    object->admission = baked.mesh.admission;
    return object;
}

std::filesystem::path names_file_of(const std::filesystem::path& model)
{
    std::filesystem::path out = model;
    out.replace_extension(".names.json");
    return out;
}

Words words_beside(const std::filesystem::path& model)
{
    const std::optional<std::string> text = io::text_of_file(names_file_of(model));
    return text ? read_names(*text).value_or(Words{}) : Words{};
}

}  // namespace sqmap::viewer
