// sqmap shapes: writes meshes that the project makes itself, and subdivides others.
#include "shapes.h"

#include "commands.h"
#include "common/program_words.h"
#include "sqmap/io/write_mesh.h"
#include "sqmap/mesh/shapes.h"

#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace sqmap::app {
namespace {

using Maker = std::function<mesh::Mesh()>;

const std::map<std::string, Maker>& makers()
{
    static const std::map<std::string, Maker> k_makers{
        {"sphere", [] { return mesh::sphere(1, 4); }},
        {"ellipsoid",
         [] {
             return mesh::ellipsoid({1.6, 1.0, 0.7}, 4);
         }},
        {"rounded_box",
         [] {
             return mesh::rounded_box({1.2, 0.8, 0.6}, 0.2, 6);
         }},
        {"torus", [] { return mesh::torus(); }},
        {"dumbbell", [] { return mesh::dumbbell(); }},
        {"tapered",
         [] {
             return mesh::superquadric_surface({.a = {0.6, 0.8, 1.2}, .eps1 = 0.5, .eps2 = 0.7, .taper_x = 0.4, .taper_y = -0.3},
                                               24);
         }},
        {"bent",
         [] {
             return mesh::superquadric_surface({.a = {0.4, 0.4, 1.5}, .eps1 = 0.6, .eps2 = 1.0, .bend = 0.5}, 24);
         }},
        {"hand", [] { return mesh::polygonized(mesh::hand_capsules(), 0.0312); }},
    };
    return k_makers;
}

struct ShapesArguments {
    std::string name, output;
    int subdivide = 0;
};

}  // namespace

std::vector<std::string> shape_names()
{
    std::vector<std::string> names;
    for (const auto& [name, maker] : makers()) names.push_back(name);
    return names;
}

mesh::Mesh made_shape(const std::string& name) { return makers().at(name)(); }

void add_shapes(CommandLine& line)
{
    auto arguments = std::make_shared<ShapesArguments>();
    Command command = line.add("shapes", "Write a mesh that the project makes itself, or a finer one of a file");
    std::string names;
    for (const std::string& name : shape_names()) names += name + ", ";
    command.option("name", arguments->name, "Which shape: " + names + "or a mesh file").required();
    command.option("-o,--output", arguments->output, "File to write: .obj or .off").required();
    command.option("--subdivide", arguments->subdivide, "Loop subdivisions: each makes four triangles of one").in_range(0, 4);
    command.footer("Exit code: 0 written, 2 no such shape, mesh refused or not closed, 64 wrong usage, 70 internal error.");
    command.run<std::runtime_error, std::invalid_argument>([arguments] {
        mesh::Mesh made;
        if (makers().contains(arguments->name)) {
            made = made_shape(arguments->name);
        } else {
            AdmittedMesh loaded = admit_mesh(arguments->name);
            if (loaded.refused()) {
                std::fprintf(stderr, "%s: %s", arguments->name.c_str(), report(loaded).c_str());
                return 2;
            }
            made = std::move(loaded.mesh);
        }
        made = mesh::loop_subdivided(made, arguments->subdivide);
        io::write_mesh(arguments->output, made.vertices, made.triangles);
        std::printf("%s: %zu vertices, %zu triangles -> %s\n", arguments->name.c_str(), made.vertices.size(),
                    made.triangles.size(), arguments->output.c_str());
        return 0;
    });
}

}  // namespace sqmap::app
