
#include "sqmap/io/model_file.h"
#include "sqmap/model/named_parts.h"
#include "sqmap/model/parse.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <string_view>

namespace sqmap::io {
namespace {

using nlohmann::ordered_json;

ordered_json array_of(const float* values, int count)
{
    ordered_json out = ordered_json::array();
    for (int i = 0; i < count; ++i) out.push_back(values[i]);
    return out;
}

ordered_json part_json(const model::ModelView& m, std::size_t index)
{
    const model::Part& p = m.parts[index];
    const model::Header& h = m.header;
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
    out["base_cells"] = p.cells.count;
    out["group"] = model::group_of_part(m, index);
    return out;
}

ordered_json json_of(const model::Measured& m)
{
    return {{"points", m.points},
            {"missed", m.missed},
            {"false_contacts", m.false_contacts},
            {"eq35_percent", {{"mean", m.eq35_mean}, {"p99", m.eq35_p99}, {"max", m.eq35_max}}},
            {"depth_percent", {{"median", m.depth_median}, {"p95", m.depth_p95}, {"p99", m.depth_p99}, {"max", m.depth_max}}},
            {"normal_degrees_median", m.normal_median},
            {"q2_percent", m.q2_share}};
}

ordered_json bounds_of(const model::ModelView& m, std::size_t part)
{
    if (m.bound_figures.empty()) return nullptr;
    const model::BoundFigures& f = m.bound_figures[part];
    const double unit = m.header.unit, cube = unit * unit * unit, solid = static_cast<double>(f.solid_volume);
    const auto figures = [&](model::Bound bound) {
        const auto k = static_cast<std::size_t>(bound);
        const double volume = static_cast<double>(f.volume[k]), excess = static_cast<double>(f.excess[k]);
        return ordered_json{{"volume", volume * cube},
                            {"volume_ratio", solid > 0 ? ordered_json(volume / solid) : ordered_json()},
                            {"support_excess", excess * unit},
                            {"support_excess_percent", 100 * excess / m.header.r_max}};
    };
    return {{"solid_volume", solid * cube},
            {"superquadric", figures(model::Bound::Superquadric)},
            {"polytope", figures(model::Bound::Polytope)},
            {"both", figures(model::Bound::Both)},
            {"standard_error", static_cast<double>(f.standard_error) * cube}};
}

/// Outward normal and offset of each side, mesh units.
ordered_json polytope_json(const model::ModelView& m, std::size_t part)
{
    ordered_json sides = ordered_json::array();
    const Vec3d origin{m.header.origin[0], m.header.origin[1], m.header.origin[2]};
    for (const HalfSpacef& side : model::polytope_of(m, part)) {
        const Vec3d n = cast<double>(side.normal);
        sides.push_back({n.x, n.y, n.z, static_cast<double>(side.offset) * m.header.unit + dot(n, origin)});
    }
    return sides;
}

/// Null for a mesh that was taken unchanged, or repaired.
ordered_json json_of(const model::Cure& c)
{
    if (c.rung == model::Rung::AsItIs) return nullptr;
    return {{"rung", c.rung == model::Rung::Closed ? "CLOSED" : "WRAPPED"},
            {"input_to_result", {{"mean", c.from_mean}, {"p99", c.from_p99}, {"max", c.from_max}}},
            {"result_to_input", {{"mean", c.to_mean}, {"p99", c.to_p99}, {"max", c.to_max}}},
            {"made_up_share", c.made_up_share}};
}

ordered_json distances_json(const double* values) { return {{"mean", values[0]}, {"p99", values[1]}, {"max", values[2]}}; }

ordered_json json_of(const model::NoteRecord& n)
{
    switch (n.kind) {
        case model::NoteKind::Repaired:
            return {{"kind", "repaired"}, {"name", n.name}, {"count", n.counts[0]}};
        case model::NoteKind::Moved:
            return {{"kind", "moved"},
                    {"input_to_result", distances_json(n.values)},
                    {"result_to_input", distances_json(n.values + 3)},
                    {"r_max", n.values[6]}};
        case model::NoteKind::MovedBoundary:
            return {{"kind", "moved_boundary"}, {"input_to_result", distances_json(n.values)}, {"r_max", n.values[6]}};
        case model::NoteKind::MadeUp:
            return {{"kind", "made_up"}, {"share", n.values[0]}};
        case model::NoteKind::Warning: {
            ordered_json out{{"kind", "warning"}, {"name", n.name}, {"count", n.counts[0]}, {"at_least", n.flag != 0}};
            if (std::string_view(n.name) == "W_DROPPED") out.update({{"area", n.values[0]}, {"distance", n.values[1]}});
            if (std::string_view(n.name) == "W_TOLERANCE")
                out.update({{"triangles", n.counts[1]},
                            {"wanted_triangles", n.counts[2]},
                            {"share", n.values[0]},
                            {"wanted_share", n.values[1]}});
            return out;
        }
        case model::NoteKind::OffTarget:
            return {{"kind", "off_target"}, {"wanted_percent", n.values[0]}, {"reached_percent", n.values[1]}};
        case model::NoteKind::Doubt:
            return {{"kind", "doubt"},
                    {"wrong", n.counts[0]},
                    {"points", n.counts[1]},
                    {"depth_p99_percent", n.values[0]},
                    {"has_exact", n.flag != 0}};
    }
    return nullptr;
}

}  // namespace

std::string model_json(const model::ModelView& m, std::size_t total, std::span<const model::NoteRecord> notes)
{
    const SectionBytes bytes = section_bytes(m, total);
    ordered_json out;
    out["format_version"] = model::k_format_version;
    char hash[20];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(model::content_hash(m)));
    out["content_hash"] = hash;
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(m.mesh_hash));
    out["mesh_hash"] = m.mesh_hash == 0 ? ordered_json(nullptr) : ordered_json(hash);
    out["made_by"] = m.made_by;
    out["source"] = m.source;
    out["options"] = m.options;
    out["projection"] = "central";
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
                    {"polytopes", bytes.polytopes},
                    {"map", bytes.map},
                    {"normal_map", 0},
                    {"locator", bytes.locator},
                    {"exact_lists", bytes.exact},
                    {"exact_mesh", bytes.mesh},
                    {"distance", bytes.distance},
                    {"input", bytes.input},
                    {"without_exact", bytes.total - bytes.exact - bytes.mesh - bytes.input}};
    out["band"] = static_cast<double>(m.distance.header.band) * m.header.unit;
    out["cure"] = json_of(m.cure);
    out["notes"] = ordered_json::array();
    for (const model::NoteRecord& note : notes) out["notes"].push_back(json_of(note));
    out["measured"] = json_of(m.measured);
    out["groups"] = model::group_count(m);
    out["parts"] = ordered_json::array();
    for (std::uint32_t i = 0; i < m.parts.size(); ++i) {
        ordered_json& part = out["parts"].emplace_back(part_json(m, i));
        if (m.polytope_ends.empty()) continue;
        part["bounds"] = bounds_of(m, i);
        part["polytope"] = polytope_json(m, i);
    }
    if (!m.polytope_ends.empty()) out["bounds"] = bounds_of(m, m.parts.size());
    return out.dump(2);
}

std::string measured_json(const model::Measured& measured) { return json_of(measured).dump(2); }

std::string bounds_json(const model::ModelView& view, std::size_t part) { return bounds_of(view, part).dump(2); }

std::string cure_json(const model::Cure& cure) { return json_of(cure).dump(2); }

}  // namespace sqmap::io
