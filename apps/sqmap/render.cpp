// sqmap render: pictures of meshes and models.
#include "bake_options.h"
#include "commands.h"
#include "common/program_words.h"
#include "common/render/pictures.h"
#include "io/replace_file.h"
#include "load_options.h"
#include "sqmap/paper/model_file.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::app {
namespace {

constexpr const char* k_section_three[] = {"protrusion", "features", "locales", "strength", "curvature", "hyperbolic"};

struct RenderArguments {
    std::string input, mesh, output, up = "y", size;
    std::vector<std::string> what;
    std::optional<double> azimuth;
    View view;
    MeshOptions load;
    DecomposeSettings cuts;
};

void set_size(View& view, const std::string& text)
{
    char end = 0;
    if (std::sscanf(text.c_str(), "%dx%d%c", &view.width, &view.height, &end) != 2 || view.width < 64 || view.height < 64 ||
        view.width > 8192 || view.height > 8192)
        throw WrongUsage("--size", "expected WIDTHxHEIGHT, 64 to 8192 each");
}

void set_up(View& view, const std::string& text)
{
    view.up = {};
    view.up[text.back() - 'x'] = text.front() == '-' ? -1 : 1;
}

/// A mesh file that was refused; its report is printed already.
struct Refused {};

mesh::Mesh loaded(const std::string& path, const MeshOptions& options)
{
    AdmittedMesh loaded = admit_mesh(path, options);
    if (loaded.refused()) {
        std::fprintf(stderr, "%s: %s", path.c_str(), report(loaded).c_str());
        throw Refused{};
    }
    return std::move(loaded.mesh);
}

bool is_of_section_three(const std::string& what)
{
    return std::ranges::find(k_section_three, what) != std::end(k_section_three);
}

Image picture(const Subject& subject, const std::string& what, const View& view)
{
    if (what == "parts") return parts_picture(subject, view);
    if (what == "superquadrics") return superquadrics_picture(subject, view);
    if (what == "bounds") return bounds_picture(subject, view);
    if (is_of_section_three(what)) return section_three_picture(subject, what, view);
    if (what == "regions") {
        if (subject.regions.empty())
            throw SubjectError(
                "regions are those of a paper model on the mesh that it was baked from: bake it with --projection "
                "normal, and give that mesh");
        return regions_picture(subject, view);
    }
    if (what == "error") return error_picture(subject, view);
    if (what == "map") return map_picture(subject, view.width, view.height);
    return plain_picture(subject, view);
}

/// @throw WrongUsage for a threshold of section 3 that changes none of the pictures
void check_thresholds(const DecomposeSettings& cuts, bool has_fields, bool has_cuts)
{
    if (has_cuts) return;  // decompose_options() checks them
    if (!has_fields && (cuts.options != cuts.defaults || cuts.exact_geodesics))
        throw WrongUsage("--what", "draws nothing that the thresholds of section 3 change: give a mesh, or a field of section 3");
    decompose::DecomposeOptions printed = cuts.options;
    printed.cutting = decompose::Cutting::Printed;
    if (const auto idle = decompose::idle_threshold(printed)) throw WrongUsage(option_of(*idle), reason_of(*idle));
}

/// All pictures that were asked for, side by side.
Image pictures(const RenderArguments& a)
{
    const bool is_model = std::filesystem::path(a.input).extension() == ".sqmap";
    std::vector<std::string> kinds = a.what;
    if (kinds.empty()) kinds.push_back(is_model ? "parts" : "mesh");
    for (const std::string& what : kinds)
        if (!is_model && (what == "error" || what == "map" || what == "regions" || what == "bounds"))
            throw WrongUsage("--what", what + " needs a model (.sqmap)");
    if (!is_model && !a.mesh.empty()) throw WrongUsage("mesh", "a second mesh goes with a model (.sqmap) only");
    std::optional<mesh::Mesh> mesh;
    if (!is_model)
        mesh = loaded(a.input, a.load);
    else if (!a.mesh.empty())
        mesh = loaded(a.mesh, a.load);
    const bool needs_parts =
        std::any_of(kinds.begin(), kinds.end(), [](const auto& kind) { return kind == "parts" || kind == "superquadrics"; });
    const bool has_fields = std::ranges::any_of(kinds, is_of_section_three), has_cuts = needs_parts && !is_model;
    check_thresholds(a.cuts, has_fields, has_cuts);
    Subject subject = is_model      ? subject_of_model(paper::MappedModel(a.input), mesh ? &*mesh : nullptr)
                      : needs_parts ? subject_of_mesh(*mesh, decompose_options(a.cuts))
                                    : bare_subject(*mesh);
    if (has_fields) subject.section_three = section_three_of(subject, field_options(a.cuts));

    View view = a.view;
    if (a.size.empty() && kinds == std::vector<std::string>{"map"}) set_size(view, "1600x1200");
    view.azimuth = a.azimuth ? *a.azimuth : broad_azimuth(subject.mesh, view.up);
    Image row;
    for (const std::string& what : kinds) row = beside(row, picture(subject, what, view));
    return row;
}

}  // namespace

void add_render(CommandLine& line)
{
    const auto arguments = std::make_shared<RenderArguments>();
    Command command = line.add("render", "Draw a mesh or a model as a PNG picture");
    command.option("input", arguments->input, "Model (.sqmap) or mesh").required().existing_file();
    command.option("mesh", arguments->mesh, "Mesh to draw instead of the model's own triangles").existing_file();
    command
        .option(
            "--what", arguments->what,
            "mesh, parts, superquadrics; section 3's protrusion, features (salient), locales, strength (Boundary Strength), "
            "curvature, hyperbolic (where that is negative); of a model also bounds (layer 1), map (unrolled), error (of "
            "layer 3) and, of a paper model, regions (convex, Q1, Q2); several stand side by side; default: parts of a model, "
            "the plain mesh otherwise")
        .delimiter(',')
        .one_of({"mesh", "parts", "superquadrics", "protrusion", "features", "locales", "strength", "curvature", "hyperbolic",
                 "map", "error", "regions", "bounds"})
        .type_name("KIND");
    command.option("-o,--output", arguments->output, "PNG file to write").required();
    command.option("--azimuth", arguments->azimuth, "Degrees about the up axis, 0 the front; default: off the broadest side");
    command.option("--elevation", arguments->view.elevation, "Degrees above the horizon").in_range(-90, 90);
    command.option("--up", arguments->up, "The mesh's upward axis: x, y, z, -x, -y or -z")
        .one_of({"x", "y", "z", "-x", "-y", "-z"})
        .type_name("AXIS");
    command.option("--size", arguments->size, "Pixels of each picture; default: 900x700, a map alone 1600x1200")
        .type_name("WIDTHxHEIGHT");
    add_load_options(command, arguments->load);
    add_decompose_options(command, arguments->cuts);
    command.footer("Exit code: 0 drawn, 2 bad model or mesh, or PNG not written, 64 wrong usage, 70 internal error.");
    command.run<io::ModelFileError, ImageError>([arguments] {
        if (!arguments->size.empty()) set_size(arguments->view, arguments->size);
        set_up(arguments->view, arguments->up);
        try {
            io::check_output(arguments->output, {arguments->input, arguments->mesh});
            write_png(arguments->output, pictures(*arguments));
            return 0;
        } catch (const Refused&) {
            return 2;
        } catch (const SubjectError& e) {
            std::fprintf(stderr, "%s\n", e.what());
            return 64;
        }
    });
}

}  // namespace sqmap::app
