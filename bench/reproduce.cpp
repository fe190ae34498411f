// The paper's evaluation: Fig. 3 (sampling), Fig. 5 (step 3), Figs. 6 and 7 (search), Table 1 and Fig. 12 (memory), Fig. 14c
// (time against error).
#include "reproduce.h"

#include "error.h"
#include "field_bytes.h"
#include "frames.h"
#include "io/replace_file.h"
#include "paper_maps.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/model.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/shape/surface.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

namespace sqmap::bench {
namespace {

using nlohmann::ordered_json;

void write(const std::filesystem::path& path, const std::string& text) { io::replace_file(path, std::as_bytes(std::span(text))); }

/// Both parameterizations of eq. 8: angles uniform as printed, and uniform before the transform of eqs. 9 and 10.
std::string sampling_text(const shape::Superquadricd& sq, int rows, int columns)
{
    std::string text = "row,column,x,y,z,spaced_x,spaced_y,spaced_z\n";
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const double eta = std::numbers::pi * (static_cast<double>(i) / (rows - 1) - 0.5);
            const double omega = std::numbers::pi * (2.0 * j / columns - 1);
            const Vec3d p = shape::printed::point(sq, eta, omega);
            const Vec3d q = shape::surface_point(sq, shape::SurfaceAngles<double>{eta, omega}).point;
            char line[160];
            std::snprintf(line, sizeof line, "%d,%d,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g\n", i, j, p.x, p.y, p.z, q.x, q.y, q.z);
            text += line;
        }
    return text;
}

void add_sampling(CLI::App& app)
{
    struct Options {
        shape::Superquadricd superquadric;
        int rows = 25, columns = 48;
        std::filesystem::path output;
    };
    const auto options = std::make_shared<Options>();
    options->superquadric.eps1 = options->superquadric.eps2 = 0.3;
    CLI::App* command = app.add_subcommand("sampling", "Points of a superquadric before and after eq. 9 (Fig. 3), as CSV");
    command->add_option("--eps1", options->superquadric.eps1)->check(CLI::Range(0.1, 2.0))->capture_default_str();
    command->add_option("--eps2", options->superquadric.eps2)->check(CLI::Range(0.1, 2.0))->capture_default_str();
    command->add_option("--rows", options->rows)->check(CLI::Range(2, 1000))->capture_default_str();
    command->add_option("--columns", options->columns)->check(CLI::Range(3, 1000))->capture_default_str();
    command->add_option("-o,--output", options->output, "CSV to write")->required();
    command->callback(
        [options] { write(options->output, sampling_text(options->superquadric, options->rows, options->columns)); });
}

/// Every sample that the search as printed looks at, with its position; the first row is the point itself.
std::string search_text(const shape::Superquadricd& sq, Vec3d point)
{
    const mesh::Mesh ball = mesh::sphere(0.01, 1);  // the search does not depend on what is mapped
    const paper::Map map = paper::bake_map(paper::MapRays(ball), {}, sq, {.min_level = 7, .max_level = 7, .subdivisions = 0});
    std::vector<paper::FootSearchStep> steps(4096);
    steps.resize(
        std::min(steps.size(), paper::record_foot_search(map.view(), cast<float>(point), paper::Projector::Printed, steps)));
    std::string text = "stride,eta,omega,distance,collinearity,better,x,y,z\n";
    const auto add = [&text](const paper::FootSearchStep& step, Vec3d p) {
        char line[200];
        std::snprintf(line, sizeof line, "%u,%.7g,%.7g,%.7g,%.7g,%d,%.7g,%.7g,%.7g\n", step.stride,
                      static_cast<double>(step.angles.eta), static_cast<double>(step.angles.omega),
                      static_cast<double>(step.distance), static_cast<double>(step.collinearity), step.better ? 1 : 0, p.x, p.y,
                      p.z);
        text += line;
    };
    add({}, point);
    for (const paper::FootSearchStep& step : steps) {
        const shape::SurfaceAngles<double> angles{static_cast<double>(step.angles.eta), static_cast<double>(step.angles.omega)};
        add(step, shape::surface_point(sq, angles).point);
    }
    return text;
}

void add_search(CLI::App& app)
{
    struct Options {
        shape::Superquadricd superquadric;
        std::array<double, 3> point{};
        std::filesystem::path output;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        app.add_subcommand("search", "Samples of a superquadric at which the search as printed looks (Figs. 6 and 7), as CSV");
    command->add_option("--eps1", options->superquadric.eps1)->check(CLI::Range(0.1, 2.0))->capture_default_str();
    command->add_option("--eps2", options->superquadric.eps2)->check(CLI::Range(0.1, 2.0))->capture_default_str();
    command->add_option("--point", options->point, "Inside the superquadric")->delimiter(',')->required();
    command->add_option("-o,--output", options->output, "CSV to write")->required();
    command->callback([options] {
        const auto& [x, y, z] = options->point;
        write(options->output, search_text(options->superquadric, {x, y, z}));
    });
}

/// Points of a square in a plane through the z axis, whose lower corner is (0, low).
struct Section {
    double azimuth = 0, low = 0, side = 1;
    int points = 200;  ///< along a side
};

/// A section as the first part's map has it: depth along the normal of layer 3 with and without step 3, foot P_M, surface point
/// and normal.
std::string vertices_text(const paper::ModelView& model, const Section& section)
{
    const paper::MapView map = paper::map_of(model, 0);
    const model::Header& header = model.common.header;
    const double c = std::cos(section.azimuth), s = std::sin(section.azimuth), step = section.side / (section.points - 1);
    std::string text = "x,z,with,without,foot_x,foot_z,surface_x,surface_z,normal_x,normal_z\n";
    for (int i = 0; i < section.points * section.points; ++i) {
        const double x = step * (i % section.points), z = section.low + step * (i / section.points);
        const Vec3f p = model::to_model_space(header, {c * x, s * x, z});
        paper::ProjectionOptions options;
        options.nearest_steps = 0;
        options.gaps = false;
        const paper::PartAnswer with = paper::project(map, p, options);
        options.corrections = false;
        const paper::PartAnswer without = paper::project(map, p, options);
        if (with.verdict == paper::Verdict::Outside) continue;
        const Vec3d foot = model::to_mesh_units(header, with.foot), surface = model::to_mesh_units(header, with.surface);
        const Vec3d normal = cast<double>(with.normal);
        char line[240];
        std::snprintf(line, sizeof line, "%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", x, z,
                      header.unit * static_cast<double>(with.depth_along), header.unit * static_cast<double>(without.depth_along),
                      c * foot.x + s * foot.y, foot.z, c * surface.x + s * surface.y, surface.z, c * normal.x + s * normal.y,
                      normal.z);
        text += line;
    }
    return text;
}

void add_vertices(CLI::App& app)
{
    struct Options {
        std::filesystem::path model, output;
        Section section;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "vertices",
        "Layer 3 of a section through a paper model's first part, with and without the vertices of step 3 (Fig. 5), as CSV");
    Section& section = options->section;
    command->add_option("model", options->model, "Paper model (.sqmap)")->required();
    command->add_option("--azimuth", section.azimuth, "Of the section's plane about z, radians")->capture_default_str();
    command->add_option("--low", section.low, "Least z of the square of points, whose least x is 0")->capture_default_str();
    command->add_option("--side", section.side, "Of the square")->check(CLI::PositiveNumber)->capture_default_str();
    command->add_option("--points", section.points, "Along a side")->check(CLI::Range(2, 2000))->capture_default_str();
    command->add_option("-o,--output", options->output, "CSV to write")->required();
    command->callback([options] {
        const paper::MappedModel model(options->model);
        if (model.paper() == nullptr) throw CLI::ValidationError("model", "not a paper model");
        write(options->output, vertices_text(*model.paper(), options->section));
    });
}

void add_memory(CLI::App& app)
{
    struct Options {
        std::filesystem::path object, json;
        std::vector<std::uint32_t> cells{64, 128, 256, 512};
        std::vector<int> levels{3, 4, 5, 6, 7};
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        app.add_subcommand("memory", "Bytes of distance fields and of the paper's maps at several densities (Table 1, Fig. 12)");
    command->add_option("--object", options->object, "Mesh of the object: closed")->required();
    command->add_option("--cells", options->cells, "Cells along the longest side: powers of two up to 512")
        ->delimiter(',')
        ->check(CLI::IsMember({16, 32, 64, 128, 256, 512}));
    command->add_option("--levels", options->levels, "Maps of 2^level + 1 by 2^(level + 1) samples a part")
        ->delimiter(',')
        ->check(CLI::Range(3, 9));
    command->add_option("--json", options->json, "File to write")->required();
    command->callback([options] {
        const std::unique_ptr<Setting> setting = load_setting({options->object, options->object});
        const auto parts = std::make_shared<const PaperParts>(*setting);
        ordered_json out{{"object", options->object.filename().string()},
                         {"triangles", setting->object.triangles.size()},
                         {"parts", parts->model.parts.size()}};
        for (const std::uint32_t cells : options->cells) {
            const FieldDensity density{cells};
            out["fields"].push_back({{"cells", cells},
                                     {"dense_bytes", dense_bytes(*setting, density)},
                                     {"adf_bytes", adf_bytes(*setting, density)},
                                     {"full_octree_bytes", full_octree_bytes(*setting, density)},
                                     {"tree512_bytes", tree512_bytes(*setting, density)},
                                     {"error_pct", field_error(*setting, density)}});
        }
        // The same points as the fields' error is measured at, all of those inside a superquadric.
        const std::vector<Vec3d> points = bake::sample_points(setting->object, setting->r_max, {.points = 4000});
        const double longest = cell_side(*setting, {1}) / parts->model.header.unit;
        for (const int level : options->levels) {
            const PaperMaps maps(parts, {level, 0});
            const ProjectionError error = projection_error(maps, points, query::Layer::Three);
            out["maps"].push_back({{"level", level},
                                   {"samples", maps.samples},
                                   {"bytes", maps.bytes},
                                   {"cells", longest / maps.spacing},
                                   {"build_s", maps.build_s},
                                   {"error_pct", error.mean},
                                   {"one_sided_pct", error.one_sided_pct}});
        }
        const PaperMaps usual(parts, Density{});
        out["usual_map"] = {{"bytes", usual.bytes}, {"build_s", usual.build_s}};
        write(options->json, out.dump(1) + '\n');
    });
}

void add_density(CLI::App& app)
{
    struct Options {
        Files files;
        std::filesystem::path path, json;
        std::vector<int> levels{4, 5, 6};
        int subdivisions = 3;
        std::size_t frames = 50;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        app.add_subcommand("density", "Time and eq. 35 of the paper's maps at several densities and subdivisions (Fig. 14c)");
    command->add_option("--object", options->files.object, "Mesh of the object: closed")->required();
    command->add_option("--probe", options->files.probe, "Mesh of the probe")->required();
    command->add_option("--path", options->path, "CSV: poses of the probe in the object's frame")->required();
    command->add_option("--levels", options->levels, "Base grids of 2^level + 1 by 2^(level + 1) samples a part")
        ->delimiter(',')
        ->check(CLI::Range(3, 7));
    command->add_option("--subdivisions", options->subdivisions, "Layer 3 with A_S from 1 to this")
        ->check(CLI::Range(0, 4))
        ->capture_default_str();
    command->add_option("--frames", options->frames, "Of the path, evenly spread")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--json", options->json, "File to write")->required();
    command->callback([options] {
        const std::vector<Pose> path = read_path(options->path);
        std::vector<Pose> poses;
        const std::size_t stride = std::max<std::size_t>(1, path.size() / options->frames);
        for (std::size_t f = 0; f < path.size(); f += stride) poses.push_back(path[f]);
        const std::unique_ptr<Setting> setting = load_setting(options->files);
        const std::vector<std::vector<TrueContact>> truth = true_contacts(*setting, poses);
        std::vector<Vec3d> points;
        for (const Pose& pose : poses)
            for (const Vec3d& v : setting->probe.vertices) points.push_back(apply(pose, v));
        const auto parts = std::make_shared<const PaperParts>(*setting);

        // All in one race, so that their times are of one time.
        struct Case {
            Density density;
            query::Layer layer;
            std::shared_ptr<const PaperMaps> maps;
            MethodEntry entry;
            std::unique_ptr<Method> method;
        };
        std::vector<std::unique_ptr<Case>> cases;
        for (const int level : options->levels)
            for (int s = 0; s <= options->subdivisions; ++s) {
                const query::Layer layer = s == 0 ? query::Layer::Two : query::Layer::Three;
                auto maps = std::make_shared<const PaperMaps>(parts, Density{level, s});
                auto method = make_paper_query(*setting, maps, {layer, paper::Projector::Pyramid});
                cases.push_back(std::make_unique<Case>(Case{{level, s}, layer, std::move(maps), {}, std::move(method)}));
                cases.back()->entry.name = "level " + std::to_string(level) + " A_S " + std::to_string(s);
            }
        std::vector<Contestant> contestants;
        for (const auto& c : cases) contestants.push_back({&c->entry, c->method.get()});
        const std::vector<Record> records = race(*setting, poses, truth, contestants, {});
        ordered_json out = ordered_json::array();
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const Case& c = *cases[i];
            const ProjectionError error = projection_error(*c.maps, points, c.layer);
            out.push_back({{"rows", (1 << c.density.level) + 1},
                           {"columns", 2 << c.density.level},
                           {"subdivisions", c.density.subdivisions},
                           {"layer", c.layer == query::Layer::Two ? 2 : 3},
                           {"p50_us", records[i].p50_us},
                           {"p99_us", records[i].p99_us},
                           {"bytes", c.maps->bytes},
                           {"eq35_mean_pct", error.mean},
                           {"eq35_p99_pct", error.p99},
                           {"one_sided_pct", error.one_sided_pct},
                           {"points", error.points},
                           {"depth_error_mean_pct", records[i].accuracy->depth_error_mean_pct}});
        }
        write(options->json, out.dump(1) + '\n');
    });
}

}  // namespace

void add_reproduce(CLI::App& app)
{
    add_sampling(app);
    add_search(app);
    add_vertices(app);
    add_memory(app);
    add_density(app);
}

}  // namespace sqmap::bench
