#include "bake_options.h"

#include "common/program_words.h"

#include <charconv>
#include <cstdio>
#include <string>

namespace sqmap::app {
namespace {

constexpr const char* k_no_locator = "--no-locator";
constexpr const char* k_grid = "--grid";
constexpr const char* k_kinds_of_smoothing[] = {"--smoothing", "--smoothing-kernel"};

}  // namespace

void add_decompose_options(Command& command, DecomposeSettings& settings)
{
    decompose::DecomposeOptions& d = settings.options;
    const decompose::DecomposeOptions printed = decompose::printed_cuts();
    d.printed_strength = printed.printed_strength;  // no other cuts read these two
    d.printed_curvature = printed.printed_curvature;
    Command cuts =
        command.titled("Decomposition (section 3 of the paper; lengths in roots of the surface area, areas as shares of it)");
    cuts.flag("--exact-geodesics", settings.exact_geodesics, "Protrusion over every triangle (eq. 4): quadratic cost");
    const auto threshold = [&](const char* name, std::string words) {
        const NumberOption<decompose::DecomposeOptions>& t = option_named(decompose::k_thresholds, name);
        if (t.value(printed) != t.value(d)) {
            char other[40];
            std::snprintf(other, sizeof other, "; with --cuts printed %g", t.value(printed));
            words += other;
        }
        cuts.number(t, d, words);
    };
    threshold("salient_window", "Geodesic window of a salient feature (eq. 5)");
    threshold("boundary_strength", "Growth of a locale's radius over distance that makes a cut; a tube on a plane has 0.5 to 1");
    threshold("hyperbolic_share", "k_h: least share of a locale that must be hyperbolic for a cut by curvature");
    threshold("hyperbolic_curvature", "t_h: curvature times area between such cuts; 3 is a tube that turns by 86 degrees");
    threshold("salient_prominence", "Least rise of a salient feature over the pass to a higher one, of mean p");
    threshold("locale_width", "Geodesic width of a locale");
    threshold("protrusion_ratio", "Least height of a salient part over its radius at the cut; a disc has 1");
    threshold("boundary_concavity", "Least mean concavity of a salient part's border");
    threshold("curvature_window", "Window of the Gaussian curvature, of roots of a triangle's area (2: printed)");
    threshold("curvature_floor", "Least triangle that this window counts with: detail below it is noise");
    threshold("fragment_roundness", "Parts less round than this are joined to a neighbour; a disc has 1");
    threshold("minimum_part", "Least area of a part");
    threshold("protrusion_sources", "Sources of the sampled sum of eq. 4");
    cuts.choice<decompose::Cutting>(
        "--cuts", d.cutting, {{"passes", decompose::Cutting::Passes}, {"printed", decompose::Cutting::Printed}},
        "passes: parts, then bends, along creases; printed: both tests locale by locale", "passes|printed");
    cuts.choice<decompose::CurvatureMean>("--mean-curvature", d.curvature_mean,
                                          {{"area", decompose::CurvatureMean::Area}, {"count", decompose::CurvatureMean::Count}},
                                          "Of --cuts printed: weighted by area, or over the points as printed", "area|count");
    threshold("printed_strength",
              "Of --cuts printed: rise of Boundary Strength that makes a cut; where a tube meets a plane it is 1");
    threshold("printed_curvature", "Of --cuts printed: t_h, |mean curvature| times the surface area");
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
            columns.ec == std::errc{} && columns.ptr == end && out_of_range(paper::k_grid_numbers, grid).empty())
            return grid;
    const auto range = [](const char* side) { return words(option_named(paper::k_grid_numbers, side).range) + ' ' + side; };
    throw WrongUsage(k_grid,
                     "'" + text + "' is not ROWSxCOLUMNS, " + range("rows") + " and " + range("columns") + ", as in 100x200");
}

/// Adds the options of section 4.1 of the paper.
void add_map_options(Command maps, paper::MapOptions& map)
{
    const auto number = [&](const char* name, const char* words) {
        maps.number(option_named(paper::k_map_numbers, name), map, words);
    };
    maps.text(
            k_grid, [&map](const std::string& text) { map.grid = grid_size(text); },
            "eta_d x omega_d: samples of layer 2 a part, as 100x200")
        .type_name("ROWSxCOLUMNS")
        .shows_default("by the target error");
    number("subdivisions", "A_S: layer 3 halves the spacing of layer 2 this often");
    number("offset_constant", "a_N of eq. 12");
    number("offset_radius", "Eq. 12 takes the greatest gradient within so many samples of a minimum; 0: its own, as printed");
    maps.choice<paper::Smoothing>(k_kinds_of_smoothing[0], map.smoothing,
                                  {{"surface", paper::Smoothing::Surface}, {"distances", paper::Smoothing::Distances}},
                                  "What the smoothed map shows: the smoothed mesh, or as section 6 has it the map's own "
                                  "distances, smoothed",
                                  "surface|distances");
    number("smoothing_length", "Of surface: as a share of R_max");
    number("smoothing_radius", "Of distances: samples of the kernel; 0: no smoothed map of either");
    maps.choice<paper::SmoothingKernel>(k_kinds_of_smoothing[1], map.smoothing_kernel,
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
    const auto is_of_maps = [&](const std::string& option) {
        if (!is_paper && settings.given(option)) throw WrongUsage(option, "is of the maps of --projection normal: give that too");
    };
    is_of_maps(k_grid);
    for (const NumberOption<paper::MapOptions>& number : paper::k_map_numbers) is_of_maps(as_option(number.name));
    for (const char* const option : k_kinds_of_smoothing) is_of_maps(option);
    if (const auto idle = paper::idle_smoothing(settings.maps)) throw WrongUsage(option_of(*idle), reason_of(*idle));
    if (!paper::is_storable(settings.maps))
        throw WrongUsage(k_grid, "with --subdivisions " + std::to_string(settings.maps.subdivisions) +
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
    for (const NumberOption<decompose::DecomposeOptions>& threshold : decompose::k_thresholds)
        if (!settings.given(as_option(threshold.name))) threshold.set(options, threshold.value(printed));
    if (settings.exact_geodesics) options.protrusion = decompose::ProtrusionSum::Exact;
    return options;
}

void add_bake_options(Command& command, BakeSettings& settings)
{
    const auto number = [&](const char* name, const char* words) {
        command.number(option_named(bake::k_bake_numbers, name), settings.bake, words);
    };
    command.option("--projection", settings.projection, "central, or normal: the paper's own maps").one_of({"central", "normal"});
    number("target_error", "Layer-3 depth error to reach, 99th percentile, percent of R_max");
    number("max_parts", "Most parts that cuts may make; a mesh of more pieces has more");
    number("band", "How far on either side of the surface distances are exact, percent of R_max");
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
    number("max_looseness", "Split a part while its superquadric has more than this times its solid's volume");
    number("max_q2", "Split a part while more than this share of its area is hidden from its projection");
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
