#include "assemble.h"

#include "sqmap/shape/euler.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace sqmap::bake {

// From the box's centre, moved towards what sticks out (Ritter 1990, repeated).
void bounding_sphere(std::span<const Vec3d> points, float sphere[4])
{
    Vec3d lo = points.front(), hi = lo;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    Vec3d centre = 0.5 * (lo + hi), best_centre = centre;
    double best = 0;
    for (const Vec3d& p : points) best = std::max(best, norm(p - centre));
    double pull = 0.1;
    for (int step = 0; step < 100; ++step, pull *= 0.96) {
        Vec3d farthest = points.front();
        double radius_sq = 0;
        for (const Vec3d& p : points)
            if (const double d_sq = norm_sq(p - centre); d_sq > radius_sq) {
                radius_sq = d_sq;
                farthest = p;
            }
        const double radius = std::sqrt(radius_sq);
        if (radius < best) {
            best = radius;
            best_centre = centre;
        }
        centre += pull * (farthest - centre);
    }
    for (int k = 0; k < 3; ++k) sphere[k] = static_cast<float>(best_centre[k]);
    double radius = 0;
    for (const Vec3d& p : points) radius = std::max(radius, norm(p - Vec3d{sphere[0], sphere[1], sphere[2]}));
    sphere[3] = static_cast<float>(radius * (1 + 1e-5) + 1e-7);
}

model::Part make_part(const mesh::Mesh& mesh, const PartWork& work, model::ModelData& data)
{
    const shape::Superquadricd& sq = work.fit.superquadric;
    model::Part p{};
    const shape::EulerAngles<double> euler = shape::euler_angles_of(sq.rotation);
    p.euler[0] = static_cast<float>(euler.phi);
    p.euler[1] = static_cast<float>(euler.theta);
    p.euler[2] = static_cast<float>(euler.chi);
    for (int i = 0; i < 3; ++i) {
        p.a[i] = static_cast<float>(sq.a[i]);
        p.translation[i] = static_cast<float>(sq.translation[i]);
        for (int j = 0; j < 3; ++j) p.rotation[3 * i + j] = static_cast<float>(sq.rotation.row[i][j]);
        p.chart_centre[i] = work.map.centre[i];
    }
    std::copy(std::begin(work.map.domain.lo), std::end(work.map.domain.lo), p.chart_lo);
    std::copy(std::begin(work.map.domain.hi), std::end(work.map.domain.hi), p.chart_hi);
    p.eps[0] = static_cast<float>(sq.eps1);
    p.eps[1] = static_cast<float>(sq.eps2);
    p.taper[0] = static_cast<float>(sq.taper_x);
    p.taper[1] = static_cast<float>(sq.taper_y);
    p.bend = static_cast<float>(sq.bend);
    p.bend_angle = static_cast<float>(sq.bend_angle);
    p.largest_f = static_cast<float>(work.fit.certificate.largest_f);
    p.tolerance = static_cast<float>(work.fit.certificate.tolerance);
    std::copy(std::begin(work.map.chart_rows), std::end(work.map.chart_rows), p.chart_rows);
    p.offset_step = work.map.offset_step;
    p.smoothing_step = work.map.smoothing_step;
    p.w_min = work.map.w_min;
    p.w_step = work.map.w_step;
    p.base = work.map.base;
    p.flags = (work.map.centre_winding > 0 ? model::k_centre_inside : 0u) | (work.fit.fallback ? model::k_fit_fallback : 0u);
    p.centre_winding = work.map.centre_winding;
    p.triangle_count = static_cast<std::uint32_t>(work.triangles.size());
    std::vector<std::uint32_t> vertices;
    double area = 0;
    for (const std::uint32_t t : work.triangles) {
        vertices.insert(vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
        area += mesh::triangle_area(mesh, t);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    p.vertex_count = static_cast<std::uint32_t>(vertices.size());
    p.area = static_cast<float>(area);
    std::vector<Vec3d> points;
    for (const std::uint32_t v : vertices) points.push_back(mesh.vertices[v]);
    for (const CapTriangle& t : work.caps) points.insert(points.end(), t.begin(), t.end());
    bounding_sphere(points, p.sphere);

    const CentralMapData& m = work.map;
    p.sample_count = static_cast<std::uint32_t>(m.samples.size());
    p.cell_count = static_cast<std::uint32_t>(m.cells.size());
    p.block_count = static_cast<std::uint32_t>(m.blocks.size());
    p.split_count = static_cast<std::uint32_t>(m.splits.size() / model::k_split_size);
    p.special_count = static_cast<std::uint32_t>(m.specials.size());
    p.pool_count = static_cast<std::uint32_t>(m.pool.size());
    p.first_sample = append(data.samples, m.samples);
    append(data.offsets, m.offsets);
    append(data.smoothing, m.smoothing);
    p.first_cell = append(data.cells, m.cells);
    p.first_block = append(data.blocks, m.blocks);
    p.first_split = append(data.splits, m.splits) / model::k_split_size;
    p.first_special = append(data.specials, m.specials);
    p.first_pool = append(data.pool, m.pool);
    return p;
}

mesh::Mesh canonical_view(const mesh::Mesh& mesh, const Mat3d& frame)
{
    std::vector<std::uint32_t> order(mesh.vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Vec3d> turned;
    for (const Vec3d& v : mesh.vertices) turned.push_back(frame * v);
    std::sort(order.begin(), order.end(), [&](std::uint32_t l, std::uint32_t r) {
        return std::tuple(turned[l].x, turned[l].y, turned[l].z, l) < std::tuple(turned[r].x, turned[r].y, turned[r].z, r);
    });
    mesh::Mesh view;
    std::vector<std::uint32_t> rank(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        rank[order[i]] = i;
        view.vertices.push_back(turned[order[i]]);
    }
    for (const mesh::Triangle& t : mesh.triangles) {
        mesh::Triangle r{rank[t[0]], rank[t[1]], rank[t[2]]};
        std::rotate(r.begin(), std::min_element(r.begin(), r.end()), r.end());
        view.triangles.push_back(r);
    }
    return view;
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

CentralOptions central_options(double target_error)
{
    CentralOptions central;
    central.tolerance = 0.0016 * target_error;
    central.foreign_tolerance = 0.003 * target_error;
    central.finest = 0.02 * target_error;
    central.silhouette = 0.022 * target_error;
    central.division = 0.003 * target_error;
    return central;
}

void scale(CentralOptions& central, double factor)
{
    for (double* size : {&central.finest, &central.tolerance, &central.foreign_tolerance, &central.silhouette, &central.division})
        *size *= factor;
}

void append_exact(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, std::span<const std::uint16_t> flags,
                  model::ModelData& data)
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
        data.triangle_part.push_back(static_cast<std::uint16_t>(part_of_triangle[t] | flags[t]));
        for (const auto& piece : solid.visible(t)) {
            data.piece_triangle.push_back(t);
            for (const Vec3d& corner : piece)
                for (int k = 0; k < 3; ++k) data.pieces.push_back(static_cast<float>(corner[k]));
        }
    }
}

}  // namespace sqmap::bake
