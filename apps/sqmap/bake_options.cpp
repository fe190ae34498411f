#include "bake_options.h"

#include "common/program_words.h"

#include <charconv>
#include <cstdio>
#include <string>

namespace sqmap::app {
namespace {

constexpr const char* k_no_locator = "--no-locator";
constexpr const char* k_of_paper_maps[] = {"--grid",          "--subdivisions",     "--offset-constant",
                                           "--offset-radius", "--smoothing-radius", "--smoothing-kernel",
                                           "--smoothing",     "--smoothing-length"};

/// Thresholds that have another value where cuts are as printed.
struct PrintedValue {
    const char* option;
    double decompose::DecomposeOptions::*value;
};
constexpr PrintedValue k_printed_values[] = {{"--locale-width", &decompose::DecomposeOptions::locale_width},
                                             {"--minimum-part", &decompose::DecomposeOptions::minimum_part_area},
                                             {"--curvature-floor", &decompose::DecomposeOptions::curvature_floor}};

}  // namespace

void add_decompose_options(Command& command, DecomposeSettings& settings)
{
    decompose::DecomposeOptions& d = settings.options;
    const decompose::DecomposeOptions printed = decompose::printed_cuts();
    d.printed_strength = printed.printed_strength;  // no other cuts read these two
    d.printed_curvature = printed.printed_curvature;
    const auto or_printed = [](const char* words, double value) {
        char text[40];
        std::snprintf(text, sizeof text, "; with --cuts printed %g", value);
        return words + std::string(text);
    };
    Command cuts =
        command.titled("Decomposition (section 3 of the paper; lengths in roots of the surface area, areas as shares of it)");
    cuts.flag("--exact-geodesics", settings.exact_geodesics, "Protrusion over every triangle (eq. 4): quadratic cost");
    const auto limited = [&](const char* name, double& value, const std::string& words, double least, double max) {
        cuts.option(name, value, words).in_range(least, max);
    };
    const auto threshold = [&](const char* name, double& value, const std::string& words) {
        limited(name, value, words, 1e-3, 1e6);
    };
    const auto share = [&](const char* name, double& value, const std::string& words) { limited(name, value, words, 0, 1); };
    threshold("--salient-window", d.salient_window, "Geodesic window of a salient feature (eq. 5)");
    threshold("--boundary-strength", d.boundary_strength,
              "Growth of a locale's radius over distance that makes a cut; a tube on a plane has 0.5 to 1");
    share("--hyperbolic-share", d.hyperbolic_share,
          "k_h: least share of a locale that must be hyperbolic for a cut by curvature");
    threshold("--hyperbolic-curvature", d.hyperbolic_curvature,
              "t_h: curvature times area between such cuts; 3 is a tube that turns by 86 degrees");
    threshold("--salient-prominence", d.salient_prominence,
              "Least rise of a salient feature over the pass to a higher one, of mean p");
    threshold("--locale-width", d.locale_width, or_printed("Geodesic width of a locale", printed.locale_width));
    threshold("--protrusion-ratio", d.protrusion_ratio,
              "Least height of a salient part over its radius at the cut; a disc has 1");
    share("--boundary-concavity", d.boundary_concavity, "Least mean concavity of a salient part's border");
    threshold("--curvature-window", d.curvature_window,
              "Window of the Gaussian curvature, of roots of a triangle's area (2: printed)");
    share("--curvature-floor", d.curvature_floor,
          or_printed("Least triangle that this window counts with: detail below it is noise", printed.curvature_floor));
    share("--fragment-roundness", d.fragment_roundness, "Parts less round than this are joined to a neighbour; a disc has 1");
    share("--minimum-part", d.minimum_part_area, or_printed("Least area of a part", printed.minimum_part_area));
    cuts.option("--protrusion-sources", d.protrusion_sources, "Sources of the sampled sum of eq. 4").in_range(1, 100000);
    cuts.choice<decompose::Cutting>(
        "--cuts", d.cutting, {{"passes", decompose::Cutting::Passes}, {"printed", decompose::Cutting::Printed}},
        "passes: parts, then bends, along creases; printed: both tests locale by locale", "passes|printed");
    cuts.choice<decompose::CurvatureMean>("--mean-curvature", d.curvature_mean,
                                          {{"area", decompose::CurvatureMean::Area}, {"count", decompose::CurvatureMean::Count}},
                                          "Of --cuts printed: weighted by area, or over the points as printed", "area|count");
    threshold("--printed-strength", d.printed_strength,
              "Of --cuts printed: rise of Boundary Strength that makes a cut; where a tube meets a plane it is 1");
    threshold("--printed-curvature", d.printed_curvature, "Of --cuts printed: t_h, |mean curvature| times the surface area");
    settings.defaults = d;
    settings.given = [command](const std::string& option) { return command.given(option); };
}

namespace {

/// Adds the options of sections 2 and 3 of the paper.
void add_paper_options(Command& command, BakeSettings& options)
{
    add_decompose_options(command, options.cuts);
    Command superquadrics = command.titled("Superquadrics (section 2 of the paper)");
    superquadrics.flag("--no-taper", options.no_taper, "Do not try tapering");
    superquadrics.flag("--no-bend", options.no_bend, "Do not try bending");
}

/// ROWSxCOLUMNS
paper::GridSize grid_size(const std::string& text)
{
    paper::GridSize grid;
    const char* const end = text.data() + text.size();
    const auto rows = std::from_chars(text.data(), end, grid.rows);
    if (rows.ec == std::errc{} && rows.ptr != end && *rows.ptr == 'x')
        if (const auto columns = std::from_chars(rows.ptr + 1, end, grid.columns);
            columns.ec == std::errc{} && columns.ptr == end)
            if (grid.rows >= 5 && grid.rows <= 4097 && grid.columns >= 8 && grid.columns <= 8192) return grid;
    throw WrongUsage("--grid", "'" + text + "' is not ROWSxCOLUMNS, 5 to 4097 rows and 8 to 8192 columns, as in 100x200");
}

/// Adds the options of section 4.1 of the paper.
void add_map_options(Command maps, paper::MapOptions& map)
{
    maps.text(
            k_of_paper_maps[0], [&map](const std::string& text) { map.grid = grid_size(text); },
            "eta_d x omega_d: samples of layer 2 a part, as 100x200")
        .type_name("ROWSxCOLUMNS")
        .shows_default("by the target error");
    maps.option(k_of_paper_maps[1], map.subdivisions, "A_S: layer 3 halves the spacing of layer 2 this often").in_range(0, 5);
    maps.option(k_of_paper_maps[2], map.offset_constant, "a_N of eq. 12").in_range(0, 100);
    maps.option(k_of_paper_maps[3], map.offset_radius,
                "Eq. 12 takes the greatest gradient within so many samples of a minimum; 0: its own, as printed")
        .in_range(0, 8);
    maps.choice<paper::Smoothing>(k_of_paper_maps[6], map.smoothing,
                                  {{"surface", paper::Smoothing::Surface}, {"distances", paper::Smoothing::Distances}},
                                  "What the smoothed map shows: the smoothed mesh, or as section 6 has it the map's own "
                                  "distances, smoothed",
                                  "surface|distances");
    maps.option(k_of_paper_maps[7], map.smoothing_length, "Of surface: as a share of R_max").in_range(1e-3, 0.1);
    maps.option(k_of_paper_maps[4], map.smoothing_radius, "Of distances: samples of the kernel; 0: no smoothed map of either")
        .in_range(0, 8);
    maps.choice<paper::SmoothingKernel>(k_of_paper_maps[5], map.smoothing_kernel,
                                        {{"binomial", paper::SmoothingKernel::Binomial},
                                         {"box", paper::SmoothingKernel::Box},
                                         {"gaussian", paper::SmoothingKernel::Gaussian}},
                                        "How distances are weighted", "binomial|box|gaussian");
}

/// @throw WrongUsage where an option would change nothing, or the grid is too fine
void check_together(const BakeSettings& settings)
{
    const bool is_paper = settings.projection == "normal";
    if (is_paper && settings.given(k_no_locator)) throw WrongUsage(k_no_locator, "a model of --projection normal has none");
    for (const char* const option : k_of_paper_maps)
        if (!is_paper && settings.given(option)) throw WrongUsage(option, "is of the maps of --projection normal: give that too");
    if (const auto idle = paper::idle_smoothing(settings.maps)) throw WrongUsage(option_of(*idle), reason_of(*idle));
    if (!paper::is_storable(settings.maps))
        throw WrongUsage(k_of_paper_maps[0], "with --subdivisions " + std::to_string(settings.maps.subdivisions) +
                                                 " is finer than a map can be: at most " + std::to_string(paper::k_max_map_rows) +
                                                 " rows and " + std::to_string(paper::k_max_map_columns) + " columns at layer 3");
    if (const int max = paper::greatest_smoothing_radius(settings.maps); settings.maps.smoothing_radius > max)
        throw WrongUsage("--smoothing-radius", "is at most " + std::to_string(max) + " for " +
                                                   std::to_string(settings.maps.grid.rows) + " rows (--grid)");
}

}  // namespace

decompose::DecomposeOptions decompose_options(const DecomposeSettings& settings)
{
    decompose::DecomposeOptions options = settings.options;
    if (settings.exact_geodesics) options.protrusion = decompose::ProtrusionSum::Exact;
    if (const auto idle = decompose::idle_threshold(options)) throw WrongUsage(option_of(*idle), reason_of(*idle));
    return options.cutting == decompose::Cutting::Printed ? field_options(settings) : options;
}

decompose::DecomposeOptions field_options(const DecomposeSettings& settings)
{
    decompose::DecomposeOptions options = settings.options;
    const decompose::DecomposeOptions printed = decompose::printed_cuts();
    options.cutting = decompose::Cutting::Printed;
    for (const PrintedValue& v : k_printed_values)
        if (!settings.given(v.option)) options.*v.value = printed.*v.value;
    if (settings.exact_geodesics) options.protrusion = decompose::ProtrusionSum::Exact;
    return options;
}

void add_bake_options(Command& command, BakeSettings& settings)
{
    constexpr bake::BakeRanges k_ranges;
    command.option("--projection", settings.projection, "central, or normal: the paper's own maps").one_of({"central", "normal"});
    command
        .option("--target-error", settings.bake.target_error, "Layer-3 depth error to reach, 99th percentile, percent of R_max")
        .in_range(k_ranges.target_error.least, k_ranges.target_error.max);
    command.option("--max-parts", settings.bake.max_parts, "Most parts that cuts may make; a mesh of more pieces has more")
        .in_range(k_ranges.max_parts.least, k_ranges.max_parts.max);
    command.option("--band", settings.bake.band, "How far on either side of the surface distances are exact, percent of R_max")
        .in_range(k_ranges.band.least, k_ranges.band.max);
    Option no_exact =
        command.flag("--no-exact", settings.no_exact, "Leave the exact layer out: a smaller model, approximate answers");
    Option exact =
        command.flag("--exact", settings.exact, "Store the exact layer: the default but for paper models").excludes(no_exact);
    command.flag("--no-input", settings.no_input,
                 "Leave out the mesh's own coordinates and numbers: a smaller model, whose exact distances are in float");
    command
        .flag(k_no_locator, settings.no_locator,
              "Leave the locator and the exact layer out: superquadrics and central maps alone answer")
        .excludes(exact);
    command
        .option("--max-looseness", settings.bake.max_looseness,
                "Split a part while its superquadric has more than this times its solid's volume")
        .in_range(k_ranges.max_looseness.least, k_ranges.max_looseness.max);
    command
        .option("--max-q2", settings.bake.max_q2_share,
                "Split a part while more than this share of its area is hidden from its projection")
        .in_range(k_ranges.max_q2_share.least, k_ranges.max_q2_share.max);
    add_paper_options(command, settings);
    add_map_options(command.titled("Maps of --projection normal (section 4 of the paper)"), settings.maps);
    settings.given = [command](const std::string& option) { return command.given(option); };
}

BakeMeshOptions bake_options(const BakeSettings& settings)
{
    check_together(settings);
    BakeMeshOptions options{.bake = settings.bake};
    if (settings.projection == "normal") options.paper_maps = settings.maps;
    bake::BakeOptions& out = options.bake;
    out.locator = !settings.no_locator;
    // A paper model is its maps; triangles are beside them.
    out.exact = settings.exact || (!settings.no_exact && out.locator && !options.paper_maps);
    out.keep_input = !settings.no_input;
    out.fit.allow_taper = !settings.no_taper;
    out.fit.allow_bend = !settings.no_bend;
    out.decompose = decompose_options(settings.cuts);
    return options;
}

}  // namespace sqmap::app
