#include "export_labels.h"

#include "common/polygon_labels.h"
#include "io/replace_file.h"
#include "load_options.h"
#include "model_mesh.h"
#include "sqmap/model/named_parts.h"
#include "sqmap/paper/model_file.h"

#include <cstdio>
#include <functional>
#include <optional>
#include <span>

namespace sqmap::app {

void add_label_options(Command& command, LabelOptions& options)
{
    Command labels = command.titled("Labels");
    labels.flag("--labels", options.wanted,
                "Write a number for each polygon of --mesh, a line each, in the file's order: its named part, -1 for a polygon "
                "that was dropped");
    labels.option("--mesh", options.mesh, "The mesh it was baked from").existing_file();
    add_load_options(labels, options.load);
}

int write_labels(const std::string& model, const std::string& output, const LabelOptions& options)
{
    if (options.mesh.empty()) throw WrongUsage("--labels", "needs the mesh file whose polygons are labelled: give --mesh FILE");
    io::check_output(output, {model, options.mesh});
    const paper::MappedModel file(model);
    const model::ModelView& view = file.view();
    if (!model::has_exact(view)) {
        std::fprintf(stderr, "%s: the model does not keep which triangle belongs to which part: bake it with --exact\n",
                     model.c_str());
        return 2;
    }
    io::PolygonSoup soup;
    MeshOptions load = options.load;
    const std::function<void(io::PolygonSoup&)> keep = [&](const io::PolygonSoup& read) { soup = read; };
    load.as_read = &keep;
    const std::optional<AdmittedMesh> mesh = mesh_of_model(view, model, options.mesh, load);
    if (!mesh) return 2;
    std::vector<std::uint32_t> names;
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t)
        names.push_back(model::group_of_part(view, model::part_of_triangle(view, t)));
    const std::vector<std::int32_t> labels = polygon_labels(soup, *mesh, names, options.load.admit.unit.value_or(1));
    std::string text;
    for (const std::int32_t label : labels) text += std::to_string(label) + '\n';
    io::replace_file(output, std::as_bytes(std::span(text)));
    std::printf("wrote %s: %zu polygons, %u named parts\n", output.c_str(), labels.size(), model::group_count(view));
    return 0;
}

}  // namespace sqmap::app
