#include "sqmap/collider/export.h"
#include "commands.h"
#include "export_labels.h"
#include "io/replace_file.h"
#include "shape_options.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/error.h"
#include "sqmap/paper/model_file.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sqmap::app {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
    std::string model, output, report;
    std::optional<collider::Format> format;
    collider::ShapeChoice shape;
    unsigned threads = 0;
    LabelOptions labels;
};

collider::Format format_of(const ExportArguments& o)
{
    if (o.format) return *o.format;
    if (const std::optional<collider::Format> format = collider::format_by_ending(o.output)) return *format;
    throw WrongUsage("--as", "the name '" + o.output +
                                 "' does not say which file it is: give urdf, mjcf, sdf, srdf, spheres, json, "
                                 "obj or glb");
}

int run(const ExportArguments& o)
{
    const collider::Format format = format_of(o);
    io::check_output(o.output, {o.model});
    io::check_output(o.report, {o.model, o.output});
    if (collider::holds_spheres_alone(format) && o.shape.spheres == 0 && o.shape.kind != collider::Kind::Sphere)
        throw mesh::InvalidInput(std::string("--as ") + name_of(format) +
                                 " holds spheres alone: take --shape sphere or spheres:N");
    const paper::MappedModel file(o.model);
    if (!model::has_exact(file.view()))
        throw mesh::InvalidInput("the model was baked without its triangles, which say what a part is; bake it with --exact");
    const collider::Colliders made = collider::colliders_of(file.view(), fs::path(o.model).stem().string(), o.shape, o.threads);
    std::vector<collider::ExportFile> files = collider::files_of(made, format, o.output);
    if (!o.report.empty()) files.insert(files.begin(), {o.report, collider::report_json(made) + '\n'});
    for (const collider::ExportFile& f : files) io::check_output(f.path, {o.model});
    collider::write(files);
    print_colliders(made);
    for (const collider::ExportFile& f : files) std::printf("wrote %s\n", f.path.string().c_str());
    return 0;
}

}  // namespace

void add_export(CommandLine& line)
{
    const auto options = std::make_shared<ExportArguments>();
    Command command = line.add(
        "export",
        "Write shapes that enclose a model's parts, for robots, simulators and planners, or labels of a mesh's polygons");
    command.option("model", options->model, "Model (.sqmap) with its exact layer").required().existing_file();
    command.option("-o,--output", options->output, "File to write; meshes that it needs are written beside it").required();
    const auto take = [options](const std::string& text) {
        options->format = collider::format_named(text);
        if (!options->format) throw WrongUsage("--as", "'" + text + "' is none of urdf|mjcf|sdf|srdf|spheres|json|obj|glb");
    };
    command.text("--as", take, "Kind of file; without it the ending of the name says")
        .type_name("urdf|mjcf|sdf|srdf|spheres|json|obj|glb")
        .shows_default("");
    add_shape_option(command, options->shape);
    command.option("--report", options->report, "Write the figures as JSON");
    add_label_options(command, options->labels);
    command.option("--threads", options->threads, "Threads, 0 for one a core; the file does not depend on it");
    command.footer(
        "Every shape is certified to hold its part as it is written, its decimals rounded outwards.\n"
        "Exit code: 0 written, 2 not a valid model or nothing written, 64 wrong usage, 70 internal error.");
    command.run<io::ModelFileError, mesh::Error>([options, command] {
        const std::vector<std::string> of_shapes{"--as", "--shape", "--report", "--threads"};
        if (options->labels.wanted) {
            for (const std::string& name : of_shapes)
                if (command.given(name)) throw WrongUsage(name, "--labels writes no shapes: leave one of them out");
            return write_labels(options->model, options->output, options->labels);
        }
        std::vector<std::string> taken = of_shapes;
        taken.push_back("--output");
        for (const std::string& given : command.given_but(taken))
            throw WrongUsage(given.substr(0, given.find('=')), "give --labels too: shapes are made of the model alone");
        return run(*options);
    });
}

}  // namespace sqmap::app
