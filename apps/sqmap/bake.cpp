#include "sqmap/bake/bake.h"

#include "commands.h"
#include "common/reports.h"
#include "load_options.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/model_json.h"
#include "sqmap/io/replace_file.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <charconv>
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

ordered_json report_json(const bake::BakeResult& baked, const LoadedMesh& loaded)
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
    out["verdict"] = verdict_name(loaded.verdict);
    out["notes"] = notes_of(loaded);
    out["cure"] = ordered_json::parse(io::cure_json(baked.model.cure));
    out["measured"] = ordered_json::parse(io::measured_json(baked.model.measured));
    return out;
}

struct Options {
    std::string mesh, model, report, projection = "central";
    LoadOptions load;
    bake::BakeOptions bake;
    bool exact = false, no_exact = false;
    bool no_taper = false, no_bend = false;
    bool exact_geodesics = false;
};

/// What the flags say, put in where bake reads it.
bake::BakeOptions bake_options(const Options& o)
{
    bake::BakeOptions out = o.bake;
    out.projection = o.projection == "normal" ? model::Projection::Normal : model::Projection::Central;
    // A normal model is the paper's maps; triangles are beside them.
    out.exact = o.exact || (!o.no_exact && out.projection == model::Projection::Central);
    out.fit.allow_taper = !o.no_taper;
    out.fit.allow_bend = !o.no_bend;
    if (o.exact_geodesics) out.decompose.protrusion = decompose::ProtrusionSum::Exact;
    out.progress = show_progress;
    return out;
}

/// @throw io::ModelFileError
void write(bake::BakeResult& baked, const LoadedMesh& loaded, const Options& o)
{
    baked.model.made_by = "sqmap " SQMAP_VERSION;
    baked.model.source = std::filesystem::path(o.mesh).filename().string();
    // The report first: where it cannot be written, no model is left behind either.
    if (!o.report.empty()) {
        const std::string text = report_json(baked, loaded).dump(2) + '\n';
        io::replace_file(o.report, std::as_bytes(std::span(text)));
    }
    io::write_model(baked.model, o.model);
}

void print(const bake::BakeResult& baked, const Options& o)
{
    const std::size_t bytes = std::filesystem::file_size(o.model);
    double seconds = 0;
    for (const auto& [stage, s] : baked.report.seconds) seconds += s;
    print_doubt(baked.model.measured);
    if (baked.model.measured.depth_p99 > o.bake.target_error)
        std::printf("W_TARGET: target error of %g %% not reached: the best model found has %.3f %%\n", o.bake.target_error,
                    baked.model.measured.depth_p99);
    std::printf("%s: %zu parts, %.0f kB, baked in %.2f s of CPU time\n", o.model.c_str(), baked.report.parts.size(),
                static_cast<double>(bytes) / 1000, seconds);
    print_measured(baked.model.measured);
}

int run(const Options& o)
{
    try {
        io::refuse_to_replace(o.model, {o.mesh});
        io::refuse_to_replace(o.report, {o.mesh});
        const LoadedMesh loaded = load_mesh(o.mesh, o.load);
        if (loaded.refused() || !loaded.repairs.empty() || !loaded.warnings.empty())
            std::fprintf(loaded.refused() ? stderr : stdout, "%s: %s", o.mesh.c_str(), report(loaded).c_str());
        if (loaded.refused()) return 2;
        bake::BakeOptions options = bake_options(o);
        options.cured = bake::cured(loaded.verdict, loaded.made_up, loaded.deviation);
        bake::BakeResult baked = bake::bake(loaded.mesh, loaded.solid, options);
        write(baked, loaded, o);
        print(baked, o);
        return 0;
    } catch (const mesh::RefusedMesh& e) {
        std::fprintf(stderr, "%s: REFUSED %s\n  cure: %s\n", o.mesh.c_str(), e.what(), e.diagnosis().cure.c_str());
    } catch (const mesh::Error& e) {
        std::fprintf(stderr, "%s: %s\n", o.mesh.c_str(), e.what());
    } catch (const io::ModelFileError& e) {
        std::fprintf(stderr, "%s\n", e.what());
    }
    return 2;
}

/// Of sections 2 and 3 of the paper.
void add_paper_options(Command& command, Options& options)
{
    decompose::DecomposeOptions& d = options.bake.decompose;
    const char* const k_decomposition =
        "Decomposition (section 3 of the paper; lengths in roots of the surface area, areas as shares of it)";
    command.flag("--exact-geodesics", options.exact_geodesics, "Protrusion over every triangle (eq. 4): quadratic cost")
        .group(k_decomposition);
    command.option("--salient-window", d.salient_window, "Geodesic window of a salient feature (eq. 5)")
        .group(k_decomposition)
        .shows_default();
    command
        .option("--boundary-strength", d.boundary_strength,
                "Growth of a locale's radius over distance that makes a cut; a tube on a plane has 0.5 to 1")
        .group(k_decomposition)
        .shows_default();
    command
        .option("--hyperbolic-share", d.hyperbolic_share,
                "k_h: least share of a locale that must be hyperbolic for a cut by curvature")
        .group(k_decomposition)
        .shows_default();
    command
        .option("--hyperbolic-curvature", d.hyperbolic_curvature,
                "t_h: curvature times area between such cuts; 3 is a tube that turns by 86 degrees")
        .group(k_decomposition)
        .shows_default();
    const auto threshold = [&](const char* name, double& value, const char* words) {
        command.option(name, value, words).in_range(1e-3, 1e6).group(k_decomposition).shows_default();
    };
    threshold("--salient-prominence", d.salient_prominence,
              "Least rise of a salient feature over the pass to a higher one, of mean p");
    threshold("--locale-width", d.locale_width, "Geodesic width of a locale");
    threshold("--protrusion-ratio", d.protrusion_ratio,
              "Least height of a salient part over its radius at the cut; a disc has 1");
    threshold("--boundary-concavity", d.boundary_concavity, "Least mean concavity of a salient part's border, at most 1");
    threshold("--curvature-window", d.curvature_window,
              "Window of the Gaussian curvature, of roots of a triangle's area (2: printed)");
    threshold("--fragment-roundness", d.fragment_roundness, "Parts less round than this are joined to a neighbour; a disc has 1");
    command
        .choice<decompose::Cutting>(
            "--cuts", d.cutting, {{"passes", decompose::Cutting::Passes}, {"printed", decompose::Cutting::Printed}},
            "passes: parts, then bends, along creases; printed: both tests locale by locale", "passes|printed")
        .group(k_decomposition);
    command
        .choice<decompose::CurvatureMean>("--mean-curvature", d.curvature_mean,
                                          {{"area", decompose::CurvatureMean::Area}, {"count", decompose::CurvatureMean::Count}},
                                          "Of the printed test: weighted by area, or over the points as printed", "area|count")
        .group(k_decomposition);
    threshold("--printed-strength", d.printed_strength, "Boundary Strength that makes a printed cut; on a plane it is 1");
    threshold("--printed-curvature", d.printed_curvature, "t_h of a printed cut: |mean curvature| times the surface area");
    command.option("--protrusion-sources", d.protrusion_sources, "Sources of the sampled sum of eq. 4")
        .in_range(1, 100000)
        .group(k_decomposition)
        .shows_default();
    command.option("--minimum-part", d.minimum_part_area, "Least area of a part").group(k_decomposition).shows_default();
    command.flag("--no-taper", options.no_taper, "Do not try tapering").group("Superquadrics (section 2 of the paper)");
    command.flag("--no-bend", options.no_bend, "Do not try bending").group("Superquadrics (section 2 of the paper)");
}

/// ROWSxCOLUMNS
bake::GridSize grid_size(const std::string& text)
{
    bake::GridSize grid;
    const char* const end = text.data() + text.size();
    const auto rows = std::from_chars(text.data(), end, grid.rows);
    if (rows.ec == std::errc{} && rows.ptr != end && *rows.ptr == 'x')
        if (const auto columns = std::from_chars(rows.ptr + 1, end, grid.columns);
            columns.ec == std::errc{} && columns.ptr == end)
            if (grid.rows >= 5 && grid.rows <= 4096 && grid.columns >= 8 && grid.columns <= 8192) return grid;
    throw WrongUsage("--grid", "'" + text + "' is not ROWSxCOLUMNS, 5 to 4096 rows and 8 to 8192 columns, as in 100x200");
}

/// Of section 4.1.
void add_map_options(Command& command, bake::NormalMapOptions& map)
{
    const char* const k_maps = "Maps of the normal projection (section 4 of the paper)";
    command
        .text(
            "--grid", [&map](const std::string& text) { map.grid = grid_size(text); },
            "eta_d x omega_d: samples of layer 2 a part, as 100x200")
        .group(k_maps)
        .type_name("ROWSxCOLUMNS")
        .shows_default("by the target error");
    command.option("--subdivisions", map.subdivisions, "A_S: layer 3 halves the spacing of layer 2 this often")
        .in_range(0, 5)
        .group(k_maps)
        .shows_default();
    command.option("--offset-constant", map.offset_constant, "a_N of eq. 12").in_range(0, 100).group(k_maps).shows_default();
    command
        .option("--offset-radius", map.offset_radius,
                "Eq. 12 takes the greatest gradient within so many samples of a minimum; 0: its own, as printed")
        .in_range(0, 8)
        .group(k_maps)
        .shows_default();
    command.option("--smoothing-radius", map.smoothing_radius, "Samples that the smoothed map takes in; 0: none")
        .in_range(0, 8)
        .group(k_maps)
        .shows_default();
    command
        .choice<bake::SmoothingKernel>("--smoothing-kernel", map.smoothing_kernel,
                                       {{"binomial", bake::SmoothingKernel::Binomial},
                                        {"box", bake::SmoothingKernel::Box},
                                        {"gaussian", bake::SmoothingKernel::Gaussian}},
                                       "How they are weighted", "binomial|box|gaussian")
        .group(k_maps);
}

}  // namespace

void add_bake(CommandLine& line)
{
    const auto options = std::make_shared<Options>();
    Command command = line.add("bake", "Bake a mesh into an SQ-Map model");
    command.option("mesh", options->mesh, "OFF, OBJ, STL, PLY, glTF or GLB; with the program assimp also DAE, 3MF, FBX")
        .required()
        .existing_file();
    command.option("-o,--output", options->model, "Model to write (.sqmap)").required();
    command.option("--projection", options->projection, "central, or normal: the paper's own maps")
        .one_of({"central", "normal"})
        .shows_default();
    command
        .option("--target-error", options->bake.target_error, "Layer-3 depth error to reach, 99th percentile, percent of R_max")
        .above_zero()
        .shows_default();
    command.option("--max-parts", options->bake.max_parts, "Most parts that cuts may make; a mesh of more pieces has more")
        .in_range(1, 1000)
        .shows_default();
    command.option("--band", options->bake.band, "How far on either side of the surface distances are exact, percent of R_max")
        .in_range(0, 100)
        .shows_default();
    Option no_exact =
        command.flag("--no-exact", options->no_exact, "Leave the exact layer out: a smaller model, approximate answers");
    command.flag("--exact", options->exact, "Store the exact layer: the default but for the normal projection")
        .excludes(no_exact);
    command.option("--threads", options->bake.threads, "Threads, 0 for one a core; the model does not depend on it")
        .shows_default();
    command.option("--report", options->report, "Write what happened, a part and a stage at a time, as JSON");
    command
        .option("--max-looseness", options->bake.max_looseness,
                "Split a part while its superquadric has more than this times its solid's volume")
        .shows_default();
    command
        .option("--max-q2", options->bake.max_q2_share,
                "Split a part while more than this share of its area is hidden from its projection")
        .shows_default();
    add_load_options(command, options->load);
    add_paper_options(command, *options);
    add_map_options(command, options->bake.normal);
    command.footer(
        "Exit code: 0 written (it says so first where the target error was not reached or layer 3 errs), 2 mesh refused or model "
        "not written, 64 wrong "
        "usage, 70 internal error.");
    command.run([options] { return run(*options); });
}

}  // namespace sqmap::app
