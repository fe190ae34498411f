// sqmap render: pictures of meshes and models.
#include "commands.h"
#include "raycast.h"
#include "shapes.h"

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

namespace sqmap::app {
namespace {

struct Arguments {
    std::string input, output, size = "900x700";
    View view;
};

void set_size(View& view, const std::string& text)
{
    char end = 0;
    if (std::sscanf(text.c_str(), "%dx%d%c", &view.width, &view.height, &end) != 2 || view.width < 16 || view.height < 16 ||
        view.width > 8192 || view.height > 8192)
        throw CLI::ValidationError("--size", "expected WIDTHxHEIGHT, 16 to 8192 each");
}

}  // namespace

void add_render(CLI::App& app, int& exit_code)
{
    auto arguments = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("render", "Draw a mesh or a model as a PNG picture");
    command->add_option("input", arguments->input, "Mesh or model")->required();
    command->add_option("-o,--output", arguments->output, "PNG file to write")->required();
    command->add_option("--azimuth", arguments->view.azimuth, "Degrees about the up axis; 0 is the front")->capture_default_str();
    command->add_option("--elevation", arguments->view.elevation, "Degrees above the horizon")->capture_default_str();
    command->add_option("--up", arguments->view.up, "The mesh's upward axis")
        ->check(CLI::IsMember({'x', 'y', 'z'}))
        ->capture_default_str();
    command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
    command->callback([arguments, &exit_code] {
        set_size(arguments->view, arguments->size);
        Layer layer{.mesh = made_shape(arguments->input)};
        layer.colours.assign(layer.mesh.triangles.size(), srgb(0xc9b8a0));
        write_png(arguments->output, render({layer}, arguments->view));
        exit_code = 0;
    });
}

}  // namespace sqmap::app
