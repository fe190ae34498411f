#include "commands.h"
#include "common/program_words.h"
#include "io/files.h"
#include "io/replace_file.h"
#include "load_options.h"
#include "shape_options.h"
#include "sqmap/collider/export.h"
#include "sqmap/io/model_file.h"
#include "sqmap/robot/rewrite.h"
#include "urdf_sweep.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

namespace sqmap::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct UrdfArguments {
    std::string robot, output, report;
    std::vector<std::string> packages;
    robot::RewriteOptions rewrite;
    SweepArguments sweep;
};

std::string text_of_file(const std::string& path)
{
    std::optional<std::string> text = io::text_of_file(path);
    if (!text) throw io::ModelFileError(path + ": cannot be read");
    return *std::move(text);
}

/// "NAME=DIR"
void add_package(robot::Packages& packages, const std::string& text)
{
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
        throw WrongUsage("--package", "'" + text + "' is not NAME=DIR");
    std::error_code ignored;
    const fs::path folder = text.substr(equals + 1);
    if (!fs::is_directory(folder, ignored)) throw WrongUsage("--package", "there is no folder '" + folder.string() + "'");
    packages[text.substr(0, equals)] = folder;
}

std::string figure_text(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.5g", value);
    return value >= 0 ? text : "-";
}

void print(const robot::Rewritten& made)
{
    std::printf("%-20s %9s %-10s %6s %8s %14s %12s  %s\n", "link", "triangles", "solid", "shapes", "volume", "support excess",
                "protrusion", "mesh");
    for (const robot::RewrittenMesh& m : made.meshes) {
        if (!m.problem.empty()) continue;
        std::printf("%-20s %9zu %-10s %6zu %8s %14s %12s  %s\n", m.link.c_str(), m.triangles, m.verdict.c_str(), m.shapes,
                    figure_text(m.figures.volume_ratio).c_str(), figure_text(m.figures.support_excess).c_str(),
                    figure_text(m.figures.protrusion).c_str(), m.filename.c_str());
    }
}

std::string report_json(const robot::Rewritten& made)
{
    const auto known = [](double v) { return v >= 0 ? ordered_json(v) : ordered_json(nullptr); };
    ordered_json out = ordered_json::array();
    for (const robot::RewrittenMesh& m : made.meshes)
        out.push_back(
            {{"link", m.link},
             {"mesh", m.filename},
             {"line", m.line},
             {"triangles", m.triangles},
             {"verdict", m.verdict},
             {"shapes", m.shapes},
             {"volume_ratio", known(m.figures.volume_ratio)},
             {"support_excess", known(m.figures.support_excess)},
             {"protrusion", known(m.figures.protrusion)},
             {"coverage", m.figures.coverage},
             {"problem", m.problem.empty() ? ordered_json(nullptr) : ordered_json(m.problem.text(k_program_settings))}});
    return out.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

int run(const UrdfArguments& o)
{
    io::check_output(o.output, {o.robot});
    io::check_output(o.report, {o.robot, o.output});
    if (o.sweep.sweep)
        return run_sweep(o.sweep, text_of_file(o.robot), {.robot = o.robot, .output = o.output, .report = o.report});
    if (o.output.empty()) throw WrongUsage("--output", "name the URDF file to write");
    robot::Rewritten made = robot::rewrite(text_of_file(o.robot), o.robot, o.output, o.rewrite);
    if (!o.report.empty()) made.files.insert(made.files.begin(), {o.report, report_json(made)});
    for (const collider::ExportFile& f : made.files) {
        io::check_output(f.path, {o.robot});
        for (const robot::RewrittenMesh& m : made.meshes)
            io::check_output(f.path, {robot::mesh_path(m.filename, o.robot, o.rewrite.packages)});
    }
    collider::write(made.files);
    print(made);
    int left = 0;
    for (const robot::RewrittenMesh& m : made.meshes) {
        if (m.problem.empty()) continue;
        ++left;
        std::fprintf(stderr, "%s:%zu: link '%s' keeps its collision element: %s\n", o.robot.c_str(), m.line, m.link.c_str(),
                     m.problem.text(k_program_settings).c_str());
    }
    std::printf("wrote %s: %zu of %zu collision meshes replaced\n", o.output.c_str(),
                made.meshes.size() - static_cast<std::size_t>(left), made.meshes.size());
    return left > 0 ? 2 : 0;
}

}  // namespace

void add_urdf(CommandLine& line)
{
    const auto options = std::make_shared<UrdfArguments>();
    Command command =
        line.add("urdf", "Replace a robot's collision meshes by shapes that are certified to hold them, or sweep its joints");
    command.option("robot", options->robot, "URDF file").required().existing_file();
    command.option("-o,--output", options->output, "URDF to write; meshes that it needs are written beside it");
    add_shape_option(command, options->rewrite.shape);
    command.option("--max-parts", options->rewrite.max_parts, "Parts into which a mesh is cut, a shape each; 1: not cut")
        .in_range(1, 256);
    command
        .option(
            "--package", options->packages,
            "Folder of a ROS package in mesh names, NAME=DIR; without it, a folder of that name around the file. May be repeated")
        .type_name("NAME=DIR")
        .shows_default("");
    command.option("--report", options->report, "Write the table as JSON");
    command.option("--threads", options->rewrite.threads, "Threads, 0 for one a core; the files do not depend on it");
    add_sweep_options(command, options->sweep);
    add_load_options(command, options->rewrite.mesh);
    command.footer(
        "All else in the file stays as it is. Xacro files: expand them first, xacro FILE > robot.urdf.\n"
        "Exit code: 0 written, 2 the file was refused, or a mesh could not be replaced and its element stays, 64 wrong usage, 70 "
        "internal error.");
    command.run<robot::DescriptionError, io::ModelFileError, mesh::Error>([options, command] {
        for (const std::string& package : options->packages) add_package(options->rewrite.packages, package);
        for (const char* name : {"--pairs", "--seconds", "--json"})
            if (!options->sweep.sweep && command.given(name)) throw WrongUsage(name, "give --sweep too");
        for (const char* name : {"--shape", "--max-parts"})
            if (options->sweep.sweep && command.given(name))
                throw WrongUsage(name, "a sweep makes no shapes: sweep the file that holds them");
        options->sweep.options.packages = options->rewrite.packages;
        options->sweep.options.mesh = options->rewrite.mesh;
        options->sweep.options.threads = options->rewrite.threads;
        return run(*options);
    });
}

}  // namespace sqmap::app
