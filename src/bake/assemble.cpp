#include "assemble.h"

#include "math/small_sphere.h"
#include "model/flags.h"
#include "sqmap/shape/superquadric.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::bake {

namespace {

/// A small sphere about points: centre, radius.
void bounding_sphere(std::span<const Vec3d> points, float sphere[4])
{
    const auto at = [&](std::size_t i) { return points[i]; };
    const Sphere small = small_sphere<double>(points.size(), at, {.steps = 100, .pull = 0.1, .shrink = 0.96});
    for (int k = 0; k < 3; ++k) sphere[k] = static_cast<float>(small.centre[k]);
    double radius = 0;
    for (const Vec3d& p : points) radius = std::max(radius, norm(p - Vec3d{sphere[0], sphere[1], sphere[2]}));
    sphere[3] = static_cast<float>(radius * (1 + 1e-5) + 1e-7);
}

/// The superquadric and its chart as stored.
model::Part stored_shape(const fit::FitReport& fit, const CentralMapData& map)
{
    const shape::Superquadricd& sq = fit.superquadric;
    model::Part p{};
    const shape::EulerAngles<double> euler = shape::euler_angles_of(sq.rotation);
    p.euler[0] = static_cast<float>(euler.phi);
    p.euler[1] = static_cast<float>(euler.theta);
    p.euler[2] = static_cast<float>(euler.chi);
    for (int i = 0; i < 3; ++i) {
        p.a[i] = static_cast<float>(sq.a[i]);
        p.translation[i] = static_cast<float>(sq.translation[i]);
        for (int j = 0; j < 3; ++j) p.rotation[3 * i + j] = static_cast<float>(sq.rotation.row[i][j]);
        p.chart_centre[i] = map.centre[i];
    }
    std::copy(std::begin(map.domain.lo), std::end(map.domain.lo), p.chart_lo);
    std::copy(std::begin(map.domain.hi), std::end(map.domain.hi), p.chart_hi);
    p.eps[0] = static_cast<float>(sq.eps1);
    p.eps[1] = static_cast<float>(sq.eps2);
    p.taper[0] = static_cast<float>(sq.taper_x);
    p.taper[1] = static_cast<float>(sq.taper_y);
    p.bend = static_cast<float>(sq.bend);
    p.bend_angle = static_cast<float>(sq.bend_angle);
    p.largest_f = static_cast<float>(fit.certificate.largest_f);
    p.tolerance = static_cast<float>(fit.certificate.tolerance);
    std::copy(std::begin(map.chart_rows), std::end(map.chart_rows), p.chart_rows);
    p.offset_step = map.offset_step;
    p.smoothing_step = map.smoothing_step;
    p.w_min = map.range.w_min;
    p.w_step = map.range.w_step;
    p.base = map.base;
    p.flags = (map.centre_winding > 0 ? model::k_centre_inside : 0u) | (fit.fallback ? model::k_fit_fallback : 0u);
    p.centre_winding = map.centre_winding;
    return p;
}

/// Counts the triangles and vertices of a part's own surface, and measures its area and bounding sphere.
void count_surface(const mesh::Mesh& mesh, const Patch& patch, model::Part& p)
{
    p.triangle_count = static_cast<std::uint32_t>(patch.triangles.size());
    std::vector<std::uint32_t> vertices;
    double area = 0;
    for (const std::uint32_t t : patch.triangles) {
        vertices.insert(vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
        area += mesh::triangle_area(mesh, t);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    p.vertex_count = static_cast<std::uint32_t>(vertices.size());
    p.area = static_cast<float>(area);
    std::vector<Vec3d> points;
    for (const std::uint32_t v : vertices) points.push_back(mesh.vertices[v]);
    for (const CapTriangle& t : patch.caps) points.insert(points.end(), t.begin(), t.end());
    bounding_sphere(points, p.sphere);
}

/// Puts a part's arrays behind those of the parts so far, and says in the part where they are.
template <template <class> class Array>
void append_map(const model::CentralArrays<Array>& own, model::ModelData& data, model::Part& p)
{
    const auto behind = [](model::Slice& slice, std::size_t values, const auto& some, auto& all) {
        slice = {static_cast<std::uint32_t>(all.size() / values), static_cast<std::uint32_t>(some.size() / values)};
        all.insert(all.end(), some.begin(), some.end());
    };
    model::CentralArrays<Array>::each_slice(behind, p, own, data);
}

/// Puts a part's polytope behind those of the parts so far.
void append_polytope(std::span<const HalfSpacef> sides, model::ModelData& data)
{
    data.polytope_sides.insert(data.polytope_sides.end(), sides.begin(), sides.end());
    data.polytope_ends.push_back(static_cast<std::uint32_t>(data.polytope_sides.size()));
}

/// The exact layer's vertices, triangles and pieces.
void append_exact(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, model::ModelData& data)
{
    const mesh::Mesh& mesh = solid.mesh();
    for (const Vec3d& v : mesh.vertices)
        for (int k = 0; k < 3; ++k) data.vertices.push_back(static_cast<float>(v[k]));
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const std::uint32_t v : mesh.triangles[t]) {
            if (mesh.vertices.size() <= 0x10000)
                data.triangles16.push_back(static_cast<std::uint16_t>(v));
            else
                data.triangles32.push_back(v);
        }
        data.triangle_part.push_back(static_cast<std::uint16_t>(part_of_triangle[t] | surface_flag(solid.boundary()[t])));
        for (const auto& piece : solid.visible(t)) {
            data.piece_triangle.push_back(t);
            for (const Vec3d& corner : piece)
                for (int k = 0; k < 3; ++k) data.pieces.push_back(static_cast<float>(corner[k]));
        }
    }
}

}  // namespace

void store_input(std::span<const Vec3d> vertices, const SourceNumbers& source, model::ModelData& data)
{
    model::InputArrays<model::ArrayData>& out = data.input;
    out = {};
    const auto is_float = [](const Vec3d& v) { return v == cast<double>(cast<float>(v)); };
    const bool all_floats = std::all_of(vertices.begin(), vertices.end(), is_float);
    for (const Vec3d& v : vertices)
        for (int k = 0; k < 3; ++k) {
            if (all_floats)
                out.coordinates32.push_back(static_cast<float>(v[k]));
            else
                out.coordinates64.push_back(v[k]);
        }
    out.source_triangle.assign(source.triangle.begin(), source.triangle.end());
    out.source_vertex.assign(source.vertex.begin(), source.vertex.end());
    const auto own = [](std::vector<std::uint32_t>& numbers, std::size_t count) {
        if (!numbers.empty()) return;
        numbers.resize(count);
        std::iota(numbers.begin(), numbers.end(), 0u);
    };
    own(out.source_triangle, data.triangle_part.size());
    own(out.source_vertex, vertices.size());
}

std::uint16_t surface_flag(mesh::Boundary boundary)
{
    switch (boundary) {
        case mesh::Boundary::Buried:
            return model::k_buried;
        case mesh::Boundary::Partly:
            return model::k_crossed;
        case mesh::Boundary::Whole:
            break;
    }
    return 0;
}

model::ModelData assemble(const model::Header& header, const Assembly& assembly)
{
    const mesh::Mesh& mesh = assembly.solid.mesh();
    model::ModelData data;
    data.header = header;
    data.header.r_max = mesh::largest_vertex_distance(mesh);
    bounding_sphere(mesh.vertices, data.header.sphere);
    data.header.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    data.header.vertex_count = static_cast<std::uint32_t>(mesh.vertices.size());
    data.header.self_intersecting = assembly.solid.self_intersecting() ? 1 : 0;
    const model::ModelView before = assembly.before != nullptr ? assembly.before->view() : model::ModelView{};
    for (const PartSource& source : assembly.parts) {
        if (source.fitted == nullptr) {
            append_map(model::arrays_of(*assembly.before, *source.before), data, data.parts.emplace_back(*source.before));
            append_polytope(model::polytope_of(before, static_cast<std::size_t>(source.before - assembly.before->parts.data())),
                            data);
            continue;
        }
        model::Part& part = data.parts.emplace_back(stored_shape(source.fitted->fit, *source.map));
        count_surface(mesh, source.fitted->patch, part);
        append_map(*source.map, data, part);
        append_polytope(source.fitted->polytope, data);
        data.header.quantisation = std::max(data.header.quantisation, source.map->quantisation);
    }
    if (data.polytope_sides.empty()) data.polytope_ends.clear();
    if (assembly.exact) append_exact(assembly.solid, assembly.part_of_triangle, data);
    return data;
}

}  // namespace sqmap::bake
