#include "bake_options.h"

#include <charconv>

namespace sqmap::app {
namespace {

/// Of sections 2 and 3 of the paper.
void add_paper_options(Command& command, BakeSettings& options)
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

void add_bake_options(Command& command, BakeSettings& settings)
{
    command.option("--projection", settings.projection, "central, or normal: the paper's own maps")
        .one_of({"central", "normal"})
        .shows_default();
    command
        .option("--target-error", settings.bake.target_error, "Layer-3 depth error to reach, 99th percentile, percent of R_max")
        .above_zero()
        .shows_default();
    command.option("--max-parts", settings.bake.max_parts, "Most parts that cuts may make; a mesh of more pieces has more")
        .in_range(1, 1000)
        .shows_default();
    command.option("--band", settings.bake.band, "How far on either side of the surface distances are exact, percent of R_max")
        .in_range(0, 100)
        .shows_default();
    Option no_exact =
        command.flag("--no-exact", settings.no_exact, "Leave the exact layer out: a smaller model, approximate answers");
    command.flag("--exact", settings.exact, "Store the exact layer: the default but for the normal projection")
        .excludes(no_exact);
    command
        .option("--max-looseness", settings.bake.max_looseness,
                "Split a part while its superquadric has more than this times its solid's volume")
        .shows_default();
    command
        .option("--max-q2", settings.bake.max_q2_share,
                "Split a part while more than this share of its area is hidden from its projection")
        .shows_default();
    add_paper_options(command, settings);
    add_map_options(command, settings.bake.normal);
}

bake::BakeOptions bake_options(const BakeSettings& settings)
{
    bake::BakeOptions out = settings.bake;
    out.projection = settings.projection == "normal" ? model::Projection::Normal : model::Projection::Central;
    // A normal model is the paper's maps; triangles are beside them.
    out.exact = settings.exact || (!settings.no_exact && out.projection == model::Projection::Central);
    out.fit.allow_taper = !settings.no_taper;
    out.fit.allow_bend = !settings.no_bend;
    if (settings.exact_geodesics) out.decompose.protrusion = decompose::ProtrusionSum::Exact;
    return out;
}

}  // namespace sqmap::app
