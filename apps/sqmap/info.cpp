#include "commands.h"
#include "common/reports.h"
#include "sqmap/model/named_parts.h"
#include "sqmap/model/parse.h"
#include "sqmap/paper/model.h"
#include "sqmap/paper/model_file.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

namespace sqmap::app {
namespace {

struct InfoArguments {
    std::string model;
    bool json = false;
};

/// Grids of the paper maps, a line for each run of parts that have the same.
void print_maps(const model::ModelView& m)
{
    std::string before;
    for (std::uint32_t i = 0, first = 0; i <= m.parts.size(); ++i) {
        char text[120] = "";
        if (i < m.parts.size()) {
            const paper::MapView map = paper::map_of(m, i);
            std::snprintf(text, sizeof text, "layer 2 %u x %u samples, layer 3 %u x %u (A_S %u), %s smoothed map",
                          ((map.eta_count - 1) >> map.subdivisions) + 1, map.omega_count >> map.subdivisions, map.eta_count,
                          map.omega_count, map.subdivisions, map.smoothed.empty() ? "no" : "a");
        }
        if (before == text) continue;
        if (i > first) std::printf("  maps of parts %u to %u: %s\n", first, i - 1, before.c_str());
        before = text;
        first = i;
    }
}

/// Counts of what the paper's projection shows of each part (section 5): Q2, vertices that are hidden from their feet, rays of
/// the map.
void print_lemma(const model::ModelView& m)
{
    const paper::ModelView& view = paper::Reading::of(m).model();
    std::printf("  part  Q2 %%  hidden vertices    rays, %%: hits  caps  misses\n");
    for (std::uint32_t i = 0; i < m.parts.size(); ++i) {
        const paper::MapView map = paper::map_of(view, i);
        const paper::MapCounts counts = paper::counts_of(map);
        const double percent = 100. / static_cast<double>(map.distance.size());
        std::printf("  %4u %5.2f %6u of %-6u %18.1f %5.1f %7.1f\n", i, 100 * static_cast<double>(map.q2_share),
                    map.occluded_vertices, map.vertex_count, percent * counts.hits, percent * counts.caps,
                    percent * counts.misses);
    }
}

/// Volumes over the solid's, support excess in mesh units and percent of R_max: a line for each part, and one for the whole.
void print_bounds(const model::ModelView& m)
{
    if (m.bound_figures.empty()) return;
    std::printf("  bounds: superquadric, polytope, both; volume over the solid's, support excess in mesh units (%% of R_max)\n");
    for (std::size_t i = 0; i < m.bound_figures.size(); ++i) {
        const model::BoundFigures& f = m.bound_figures[i];
        const bool is_whole = i == m.parts.size();
        if (is_whole)
            std::printf(" whole");
        else
            std::printf("  %4zu", i);
        for (const float volume : f.volume) {
            if (f.solid_volume > 0)
                std::printf(" %6.3f", static_cast<double>(volume / f.solid_volume));
            else
                std::printf("      -");
        }
        for (const float excess : f.excess)
            std::printf("  %9.4g (%5.2f)", static_cast<double>(excess) * m.header.unit,
                        100 * static_cast<double>(excess) / m.header.r_max);
        if (is_whole)
            std::printf("  union; volumes within %.1f %% (standard error)\n",
                        100 * static_cast<double>(f.standard_error / f.volume[static_cast<std::size_t>(model::Bound::Both)]));
        else
            std::printf("  %zu sides\n", model::polytope_of(m, i).size());
    }
}

/// Names the parts whose superquadrics bound them badly, and by how much their polytopes make up for it.
void print_loose_parts(const model::ModelView& m)
{
    constexpr float k_loose = 2.5F;  // a part that its superquadric serves well has 1.2 to 2
    std::string parts;
    float greatest = 0;
    for (std::size_t i = 0; i < std::min(m.parts.size(), m.bound_figures.size()); ++i) {
        const model::BoundFigures& f = m.bound_figures[i];
        const auto over_solid = [&](model::Bound b) { return f.volume[static_cast<std::size_t>(b)] / f.solid_volume; };
        if (!(f.solid_volume > 0) || !(over_solid(model::Bound::Superquadric) > k_loose)) continue;
        char text[60];
        std::snprintf(text, sizeof text, "%s%zu (%.2f)", parts.empty() ? "" : ", ", i,
                      static_cast<double>(over_solid(model::Bound::Superquadric)));
        parts += text;
        greatest = std::max(greatest, over_solid(model::Bound::Both));
    }
    if (parts.empty()) return;
    std::printf(
        "  superquadrics that hold more than %.1f times their part's solid: %s; with their polytopes at most %.2f times\n",
        static_cast<double>(k_loose), parts.c_str(), static_cast<double>(greatest));
}

void print(const std::string& name, const model::ModelView& m, const io::SectionBytes& bytes)
{
    const bool central = !paper::is_paper(m);
    print_doubt(m);
    const std::string source = m.source.empty() ? "" : " from " + std::string(m.source);  // models of libraries name none
    std::printf("%s: %zu parts with %u names, %s projection, %u triangles, made by %s%s%s\n", name.c_str(), m.parts.size(),
                model::group_count(m), central ? "central" : "normal", m.header.triangle_count, std::string(m.made_by).c_str(),
                source.c_str(), rung_suffix(m.cure));
    print_cure(m.cure);
    std::printf("  baked with %s\n", m.options.empty() ? "the default options" : std::string(m.options).c_str());
    std::printf(
        "  %zu bytes: superquadrics %zu, polytopes %zu, %smap %zu, locator %zu, exact layer %zu + %zu, distances %zu, input "
        "%zu\n",
        bytes.total, bytes.superquadrics, bytes.polytopes, central ? "" : "paper ",
        central ? bytes.map : model::bytes_of(paper::Reading::of(m).model().maps), bytes.locator, bytes.exact, bytes.mesh,
        bytes.distance, bytes.input);
    std::printf("  R_max %.6g; 16-bit storage moves a radius by at most %.5f %% of it\n", m.header.r_max * m.header.unit,
                100 * m.header.quantisation / m.header.r_max);
    print_measured(m.measured);
    if (model::has_distance(m))
        std::printf("  signed distances %s within %.6g of the surface\n", model::has_exact(m) ? "exact" : "approximate",
                    static_cast<double>(m.distance.header.band) * m.header.unit);
    else
        std::printf("  no signed distances: bake it with --exact\n");
    if (!central) print_maps(m);
    std::printf("  part name      a1       a2       a3    eps1  eps2  triangles  largest F\n");
    for (std::size_t i = 0; i < m.parts.size(); ++i) {
        const model::Part& p = m.parts[i];
        std::printf("  %4zu %4u %8.4f %8.4f %8.4f  %5.2f %5.2f  %9u  %.6f%s%s%s\n", i, model::group_of_part(m, i), p.a[0], p.a[1],
                    p.a[2], p.eps[0], p.eps[1], p.triangle_count, p.largest_f,
                    p.taper[0] != 0 || p.taper[1] != 0 ? " tapered" : "", p.bend != 0 ? " bent" : "",
                    model::is_fallback(p) ? " fallback" : "");
    }
    if (!central) print_lemma(m);
    print_bounds(m);
    print_loose_parts(m);
}

int run(const InfoArguments& o)
{
    const paper::MappedModel file(o.model);
    const model::ModelView& m = file.view();
    if (o.json)
        std::printf("%s\n", paper::model_json(m, file.size(), paper::notes_of(file.bytes())).c_str());
    else
        print(o.model, m, io::section_bytes(m, file.size()));
    return 0;
}

}  // namespace

void add_info(CommandLine& line)
{
    const auto options = std::make_shared<InfoArguments>();
    Command command = line.add("info", "Say what is in a model: parts, certificates, bytes, measured error");
    command.option("model", options->model, "Model (.sqmap)").required().existing_file();
    command.flag("--json", options->json, "Answer as JSON");
    command.footer("Exit code: 0 printed, 2 not a valid model, 64 wrong usage, 70 internal error.");
    command.run<io::ModelFileError>([options] { return run(*options); });
}

}  // namespace sqmap::app
