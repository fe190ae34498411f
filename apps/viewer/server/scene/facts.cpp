#include "viewer/server/scene/facts.h"

#include "common/hash_text.h"
#include "sqmap/io/model_file.h"
#include "viewer/server/scene/edits.h"
#include "viewer/server/scene/page_words.h"

#include <cmath>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

ordered_json vector_json(Vec3d v) { return {v.x, v.y, v.z}; }

}  // namespace

ordered_json facts_json(const Object& object, const Parts& parts, bool edited)
{
    const model::ModelView& m = object.view;
    const model::Header& h = m.header;
    const io::SectionBytes bytes = io::section_bytes(m, object.file->size());
    ordered_json out;
    out["name"] = object.name;
    out["hash"] = app::hash_text(paper::content_hash(m));
    out["edited"] = edited;
    out["solid"] = h.solid != 0;
    out["triangles"] = h.triangle_count;
    out["vertices"] = h.vertex_count;
    out["hasTriangles"] = !object.mesh.triangles.empty();
    out["bytes"] = {{"total", bytes.total},
                    {"superquadrics", bytes.superquadrics},
                    {"polytopes", bytes.polytopes},
                    {"map", bytes.map},
                    {"locator", bytes.locator},
                    {"exact", bytes.exact},
                    {"mesh", bytes.mesh}};
    out["rMax"] = h.r_max * h.unit * object.metres_per_unit;
    out["metresPerUnit"] = object.metres_per_unit;
    out["central"] = !paper::is_paper(m);
    out["exact"] = model::has_exact(m);
    out["position"] = vector_json(object.position);
    out["half"] = vector_json(object.half);
    out["centre"] = vector_json(object.centre);
    out["up"] = name_of(object.up);
    const model::Measured& e = m.measured;
    out["measured"] = {{"points", e.points},        {"missed", e.missed},
                       {"false", e.false_contacts}, {"eq35Mean", e.eq35_mean},
                       {"eq35P99", e.eq35_p99},     {"depthMedian", e.depth_median},
                       {"depthP95", e.depth_p95},   {"depthP99", e.depth_p99},
                       {"depthMax", e.depth_max},   {"normalMedian", e.normal_median},
                       {"q2", e.q2_share}};
    std::vector<double> area(parts.partition.part_count);
    std::vector<std::uint32_t> count(parts.partition.part_count);
    double whole = 0;
    for (std::uint32_t t = 0; t < parts.partition.part_of_triangle.size(); ++t) {
        const double a = mesh::triangle_area(object.mesh, t);
        area[parts.partition.part_of_triangle[t]] += a;
        ++count[parts.partition.part_of_triangle[t]];
        whole += a;
    }
    const double metres = object.metres_per_model_unit();
    const auto sphere_json = [&](Vec3d centre, double radius) {
        const Vec3f c = object.world(centre);
        return ordered_json{c.x, c.y, c.z, metres * radius};
    };
    out["sphere"] = sphere_json(cast<double>(model::vec3(h.sphere)), static_cast<double>(h.sphere[3]));
    const std::vector<std::vector<std::uint32_t>> neighbours = neighbours_of(object, parts.partition);
    out["parts"] = ordered_json::array();
    for (std::uint32_t p = 0; p < parts.partition.part_count; ++p) {
        const shape::Superquadricd& s = parts.superquadrics[p];
        out["parts"].push_back(
            {{"name", parts.names[p]},
             {"sphere", sphere_json(parts.spheres[p].centre, parts.spheres[p].radius)},
             {"neighbours", neighbours[p]},
             {"triangles", count[p]},
             {"area", whole > 0 ? 100 * area[p] / whole : 0},
             {"certified", parts.largest_f[p] <= 1},
             {"largestF", std::isfinite(parts.largest_f[p]) ? ordered_json(parts.largest_f[p]) : ordered_json()},
             {"a", vector_json(metres * s.a)},
             {"eps", {s.eps1, s.eps2}},
             {"taper", {s.taper_x, s.taper_y}},
             {"bend", s.bend},
             {"bounds", edited ? ordered_json() : ordered_json::parse(io::bounds_json(m, p))}});
    }
    out["bounds"] = edited ? ordered_json() : ordered_json::parse(io::bounds_json(m, m.parts.size()));
    out["cure"] = ordered_json::parse(io::cure_json(m.cure));
    out["verdict"] = object.admission ? mesh::name_of(*object.admission) : "";
    out["notes"] = words(object.notes, k_page_settings);
    return out;
}

}  // namespace sqmap::viewer
