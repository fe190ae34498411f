#include "commands.h"
#include "common/reports.h"
#include "sqmap/io/model_file.h"
#include "sqmap/model/parse.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <memory>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

ordered_json array_of(const float* values, int count)
{
    ordered_json out = ordered_json::array();
    for (int i = 0; i < count; ++i) out.push_back(values[i]);
    return out;
}

ordered_json part_json(const model::Part& p, std::size_t index, const model::Header& h)
{
    ordered_json out;
    out["part"] = index;
    out["a1"] = p.a[0];
    out["a2"] = p.a[1];
    out["a3"] = p.a[2];
    out["eps1"] = p.eps[0];
    out["eps2"] = p.eps[1];
    out["phi"] = p.euler[0];
    out["theta"] = p.euler[1];
    out["chi"] = p.euler[2];
    out["tx"] = p.translation[0];
    out["ty"] = p.translation[1];
    out["tz"] = p.translation[2];
    out["Kx"] = p.taper[0];
    out["Ky"] = p.taper[1];
    out["k"] = p.bend;
    out["alpha"] = p.bend_angle;
    out["rotation"] = {array_of(p.rotation, 3), array_of(p.rotation + 3, 3), array_of(p.rotation + 6, 3)};
    // The same in the mesh's own units, for readers that hold the mesh.
    out["mesh_units"] = {{"a", {p.a[0] * h.unit, p.a[1] * h.unit, p.a[2] * h.unit}},
                         {"translation",
                          {p.translation[0] * h.unit + h.origin[0], p.translation[1] * h.unit + h.origin[1],
                           p.translation[2] * h.unit + h.origin[2]}},
                         {"k", p.bend / h.unit},
                         {"projection_centre",
                          {p.chart_centre[0] * h.unit + h.origin[0], p.chart_centre[1] * h.unit + h.origin[1],
                           p.chart_centre[2] * h.unit + h.origin[2]}}};
    out["projection_centre"] = array_of(p.chart_centre, 3);
    out["bounding_sphere"] = array_of(p.sphere, 4);
    out["certificate"] = {{"largest_f", p.largest_f}, {"tolerance", p.tolerance}, {"bounding", p.largest_f <= 1.f}};
    out["fit_fallback"] = model::is_fallback(p);
    out["triangles"] = p.triangle_count;
    out["vertices"] = p.vertex_count;
    out["area"] = p.area;
    out["base_cells"] = p.cell_count;
    return out;
}

struct Options {
    std::string model;
    bool json = false;
};

bool is_central(const model::ModelView& m)
{
    return m.header.projection == static_cast<std::uint32_t>(model::Projection::Central);
}

ordered_json model_json(const model::ModelView& m, const io::SectionBytes& bytes)
{
    const bool central = is_central(m);
    ordered_json out;
    out["format_version"] = model::k_format_version;
    char hash[20];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(model::content_hash(m)));
    out["content_hash"] = hash;
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(m.mesh_hash));
    out["mesh_hash"] = m.mesh_hash == 0 ? ordered_json(nullptr) : ordered_json(hash);
    out["made_by"] = m.made_by;
    out["source"] = m.source;
    out["projection"] = central ? "central" : "normal";
    out["solid"] = m.header.solid != 0;
    // Every part's certificate covers the caps that close it, and closed parts tile the solid.
    const bool contained = std::all_of(m.parts.begin(), m.parts.end(), [](const model::Part& p) { return p.largest_f <= 1.f; });
    out["certified"] = {{"triangles_contained", contained}, {"solid_covered", contained && m.header.solid != 0}};
    out["self_intersecting"] = m.header.self_intersecting != 0;
    out["origin"] = {m.header.origin[0], m.header.origin[1], m.header.origin[2]};
    out["unit"] = m.header.unit;
    out["r_max"] = m.header.r_max * m.header.unit;
    out["quantisation_percent"] = 100 * m.header.quantisation / m.header.r_max;
    out["triangles"] = m.header.triangle_count;
    out["vertices"] = m.header.vertex_count;
    out["bytes"] = {{"total", bytes.total},
                    {"superquadrics", bytes.superquadrics},
                    {"map", bytes.map},
                    {"normal_map", bytes.normal_map},
                    {"locator", bytes.locator},
                    {"exact_lists", bytes.exact},
                    {"exact_mesh", bytes.mesh},
                    {"distance", bytes.distance},
                    {"without_exact", bytes.total - bytes.exact - bytes.mesh - (central ? 0 : bytes.map)}};
    out["band"] = static_cast<double>(m.distance.header.band) * m.header.unit;
    out["cure"] = cure_json(m.cure);
    out["measured"] = measured_json(m.measured);
    out["parts"] = ordered_json::array();
    for (std::size_t i = 0; i < m.parts.size(); ++i) out["parts"].push_back(part_json(m.parts[i], i, m.header));
    return out;
}

void print(const std::string& name, const model::ModelView& m, const io::SectionBytes& bytes)
{
    const bool central = is_central(m);
    print_doubt(m.measured);
    std::printf("%s: %zu parts, %s projection, %u triangles, made by %s from %s%s\n", name.c_str(), m.parts.size(),
                central ? "central" : "normal", m.header.triangle_count, std::string(m.made_by).c_str(),
                std::string(m.source).c_str(), rung_suffix(m.cure));
    print_cure(m.cure);
    std::printf("  %zu bytes: superquadrics %zu, %smap %zu, locator %zu, exact layer %zu + %zu, distances %zu\n", bytes.total,
                bytes.superquadrics, central ? "" : "normal ", central ? bytes.map : bytes.normal_map, bytes.locator,
                bytes.exact + (central ? 0 : bytes.map), bytes.mesh, bytes.distance);
    std::printf("  R_max %.6g; 16-bit storage moves a radius by at most %.5f %% of it\n", m.header.r_max * m.header.unit,
                100 * m.header.quantisation / m.header.r_max);
    print_measured(m.measured);
    std::printf("  signed distances exact within %.6g of the surface\n",
                static_cast<double>(m.distance.header.band) * m.header.unit);
    std::printf("  part      a1       a2       a3    eps1  eps2  triangles  largest F\n");
    for (std::size_t i = 0; i < m.parts.size(); ++i) {
        const model::Part& p = m.parts[i];
        std::printf("  %4zu %8.4f %8.4f %8.4f  %5.2f %5.2f  %9u  %.6f%s%s%s\n", i, p.a[0], p.a[1], p.a[2], p.eps[0], p.eps[1],
                    p.triangle_count, p.largest_f, p.taper[0] != 0 || p.taper[1] != 0 ? " tapered" : "",
                    p.bend != 0 ? " bent" : "", model::is_fallback(p) ? " fallback" : "");
    }
}

int run(const Options& o)
{
    try {
        const io::MappedModel file(o.model);
        const model::ModelView& m = file.view();
        const io::SectionBytes bytes = io::section_bytes(m, file.size());
        if (o.json)
            std::printf("%s\n", model_json(m, bytes).dump(2).c_str());
        else
            print(o.model, m, bytes);
        return 0;
    } catch (const io::ModelFileError& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 2;
    }
}

}  // namespace

void add_info(CommandLine& line)
{
    const auto options = std::make_shared<Options>();
    Command command = line.add("info", "Say what is in a model: parts, certificates, bytes, measured error");
    command.option("model", options->model, "Model (.sqmap)").required().existing_file();
    command.flag("--json", options->json, "Answer as JSON");
    command.footer("Exit code: 0 printed, 2 not a valid model, 64 wrong usage, 70 internal error.");
    command.run([options] { return run(*options); });
}

}  // namespace sqmap::app
