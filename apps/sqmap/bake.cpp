#include "sqmap/bake/bake.h"

#include "commands.h"
#include "common/reports.h"
#include "load_options.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/replace_file.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>
#include <span>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

/// Progress as one line that rewrites itself on a terminal and stays silent in a pipe.
void show_progress(const char* stage, double done)
{
    if (::isatty(STDERR_FILENO) == 0) return;
    std::fprintf(stderr, "\r%-12s %3.0f %%  ", stage, 100 * done);
    if (done >= 1) std::fprintf(stderr, "\r%-24s\r", "");
    std::fflush(stderr);
}

ordered_json report_json(const bake::BakeResult& baked)
{
    ordered_json out;
    out["parts"] = ordered_json::array();
    for (const bake::PartReport& p : baked.report.parts)
        out["parts"].push_back({{"area", p.area},
                                {"volume", p.volume},
                                {"solid_volume", p.solid_volume},
                                {"q2_share", p.q2_share},
                                {"largest_f", p.certificate.largest_f},
                                {"tolerance", p.certificate.tolerance},
                                {"fallback", p.fallback},
                                {"base", p.base},
                                {"map_bytes", p.map_bytes}});
    for (const auto& [stage, seconds] : baked.report.seconds) out["cpu_seconds"][stage] = seconds;
    out["target_met"] = baked.report.target_met;
    out["measured"] = measured_json(baked.model.measured);
    return out;
}

}  // namespace

void add_bake(CLI::App& app, int& exit_code)
{
    struct Options {
        std::string mesh, model, report, projection = "central";
        LoadOptions load;
        bake::BakeOptions bake;
        bool no_exact = false;
        bool no_taper = false, no_bend = false;
        bool exact_geodesics = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("bake", "Bake a mesh into an SQ-Map model");
    command->add_option("mesh", options->mesh, "OFF, OBJ, STL, PLY, glTF or GLB")->required()->check(CLI::ExistingFile);
    command->add_option("-o,--output", options->model, "Model to write (.sqmap)")->required();
    command->add_option("--projection", options->projection, "central, or normal: the paper's own maps")
        ->check(CLI::IsMember({"central", "normal"}))
        ->capture_default_str();
    command
        ->add_option("--target-error", options->bake.target_error,
                     "Layer-3 depth error to reach, 99th percentile, percent of R_max")
        ->check(above_zero())
        ->capture_default_str();
    command
        ->add_option("--subdivisions", options->bake.subdivisions,
                     "A_S of the normal projection: layer 3 halves the spacing of layer 2 this often")
        ->check(in_range(0, 5))
        ->capture_default_str();
    command->add_option("--max-parts", options->bake.max_parts, "Most parts that cuts may make; a mesh of more pieces has more")
        ->check(in_range(1, 1000))
        ->capture_default_str();
    command->add_flag("--no-exact", options->no_exact, "Leave the exact layer out: a smaller model, approximate answers");
    command->add_option("--threads", options->bake.threads, "Threads, 0 for one a core; the model does not depend on it")
        ->capture_default_str();
    command->add_option("--report", options->report, "Write what happened, a part and a stage at a time, as JSON");
    command
        ->add_option("--max-looseness", options->bake.max_looseness,
                     "Split a part while its superquadric has more than this times its solid's volume")
        ->capture_default_str();
    command
        ->add_option("--max-q2", options->bake.max_q2_share,
                     "Split a part while more than this share of its area is hidden from its projection")
        ->capture_default_str();
    add_load_options(*command, options->load);
    decompose::DecomposeOptions& d = options->bake.decompose;
    const char* const k_decomposition =
        "Decomposition (section 3 of the paper; lengths in roots of the surface area, areas as shares of it)";
    command->add_flag("--exact-geodesics", options->exact_geodesics, "Protrusion over every triangle (eq. 4): quadratic cost")
        ->group(k_decomposition);
    command->add_option("--salient-window", d.salient_window, "Geodesic window of a salient feature (eq. 5)")
        ->group(k_decomposition)
        ->capture_default_str();
    command
        ->add_option("--boundary-strength", d.boundary_strength,
                     "Growth of a locale's radius over distance that makes a cut; a tube on a plane has 0.5 to 1")
        ->group(k_decomposition)
        ->capture_default_str();
    command
        ->add_option("--hyperbolic-share", d.hyperbolic_share,
                     "k_h: least share of a locale that must be hyperbolic for a cut by curvature")
        ->group(k_decomposition)
        ->capture_default_str();
    command
        ->add_option("--hyperbolic-curvature", d.hyperbolic_curvature,
                     "t_h: curvature times area between such cuts; 3 is a tube that turns by 86 degrees")
        ->group(k_decomposition)
        ->capture_default_str();
    command->add_option("--minimum-part", d.minimum_part_area, "Least area of a part")
        ->group(k_decomposition)
        ->capture_default_str();
    command->add_flag("--no-taper", options->no_taper, "Do not try tapering")->group("Superquadrics (section 2 of the paper)");
    command->add_flag("--no-bend", options->no_bend, "Do not try bending")->group("Superquadrics (section 2 of the paper)");
    command->footer(
        "Exit code: 0 written (it says so where the target error was not reached), 2 mesh refused or model not written, 64 wrong "
        "usage, 70 internal error.");
    command->callback([options, &exit_code] {
        try {
            io::refuse_to_replace(options->model, {options->mesh});
            io::refuse_to_replace(options->report, {options->mesh});
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n", e.what());
            exit_code = 2;
            return;
        }
        const LoadedMesh loaded = load_mesh(options->mesh, options->load);
        if (loaded.refused() || !loaded.repairs.empty() || !loaded.warnings.empty())
            std::fprintf(loaded.refused() ? stderr : stdout, "%s: %s", options->mesh.c_str(), report(loaded).c_str());
        if (loaded.refused()) {
            exit_code = 2;
            return;
        }
        options->bake.projection = options->projection == "normal" ? model::Projection::Normal : model::Projection::Central;
        options->bake.exact = !options->no_exact;
        options->bake.fit.allow_taper = !options->no_taper;
        options->bake.fit.allow_bend = !options->no_bend;
        if (options->exact_geodesics) options->bake.decompose.protrusion = decompose::ProtrusionSum::Exact;
        options->bake.progress = show_progress;
        bake::BakeResult baked;
        try {
            baked = bake::bake(loaded.mesh, loaded.solid, options->bake);
        } catch (const mesh::RefusedMesh& e) {
            std::fprintf(stderr, "%s: REFUSED %s\n  cure: %s\n", options->mesh.c_str(), e.what(), e.diagnosis().cure.c_str());
            exit_code = 2;
            return;
        } catch (const mesh::Error& e) {
            std::fprintf(stderr, "%s: %s\n", options->mesh.c_str(), e.what());
            exit_code = 2;
            return;
        }
        baked.model.made_by = "sqmap " SQMAP_VERSION;
        baked.model.source = std::filesystem::path(options->mesh).filename().string();
        try {
            // The report first: where it cannot be written, no model is left behind either.
            if (!options->report.empty()) {
                const std::string text = report_json(baked).dump(2) + '\n';
                io::replace_file(options->report, std::as_bytes(std::span(text)));
            }
            io::write_model(baked.model, options->model);
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n", e.what());
            exit_code = 2;
            return;
        }
        const std::size_t bytes = std::filesystem::file_size(options->model);
        double seconds = 0;
        for (const auto& [stage, s] : baked.report.seconds) seconds += s;
        std::printf("%s: %zu parts, %.0f kB, baked in %.2f s of CPU time\n", options->model.c_str(), baked.report.parts.size(),
                    static_cast<double>(bytes) / 1000, seconds);
        print_measured(baked.model.measured);
        if (!baked.report.target_met)
            std::printf("  target error of %g %% not reached: the best model found has %.3f %%\n", options->bake.target_error,
                        baked.model.measured.depth_p99);
        exit_code = 0;
    });
}

}  // namespace sqmap::app
