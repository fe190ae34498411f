// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, asks the vertices of B of the map of A (section
// 4.2); here both ways.
#include "pair_query.h"

#include "merge.h"
#include "query/layer.h"
#include "query/probe_pointwise.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sqmap::query {

namespace {

/// The sphere about a body's mesh, in the body's own frame.
Sphere local_sphere(const Body& body)
{
    if (body.model == nullptr) return body.probe == nullptr ? Sphere{} : body.probe->sphere();
    const model::Header& h = body.model->header;
    const Sphere map{model::to_mesh_units(h, model::vec3(h.sphere)), static_cast<double>(h.sphere[3]) * h.unit};
    if (body.probe == nullptr || body.probe->size() == 0) return map;
    // Both hold the same vertices, but a probe may have been deformed since.
    const Sphere probe = body.probe->sphere();
    return {map.centre, std::max(map.radius, norm(probe.centre - map.centre) + probe.radius)};
}

/// PairResult::edge_length: one end of an edge is at most half its length from where the edge crosses a surface.
double edge_length(const Body& a, const Body& b, const QueryOptions& options)
{
    double rounding = 0;
    for (const Body* body : {&a, &b}) {
        if (body->model == nullptr || body->probe == nullptr) return 0;
        QueryOptions chosen = options;
        chosen.layer = chosen_layer(*body->model, options);
        if (!is_margin_proven(*body->model, chosen)) return 0;
        rounding += 4e-6 * sphere_of(*body).radius;
    }
    return std::max(2 * (options.margin - rounding), 0.);
}

}  // namespace

Sphere sphere_of(const Body& body) noexcept
{
    const Sphere local = local_sphere(body);
    return {apply(body.pose, local.centre), local.radius};
}

double reach_of(const Body& body, const QueryOptions& options) noexcept
{
    return body.model == nullptr ? 0. : static_cast<double>(offset_reach(*body.model, options)) * body.model->header.unit;
}

void PairQuery::add(const Body& touched, const Body& collider, Side vertex_of) noexcept
{
    const ProbeResult found = query_probe(touched, collider, options.query, workspace.found_);
    result.found += found.contacts;
    result.status |= found.status;
    for (const Contact& c : found.written(workspace.found_)) {
        if (result.contacts == out.size()) {
            result.status |= k_full;
            return;
        }
        const Vec3d surface = found.position(c), vertex = surface - static_cast<double>(c.depth) * cast<double>(c.normal);
        const bool of_b = vertex_of == Side::B;
        out[result.contacts++] = {{of_b ? surface : vertex, of_b ? vertex : surface},
                                  of_b ? c.normal : -c.normal,
                                  c.depth,
                                  c.index,
                                  c.part,
                                  vertex_of,
                                  c.certain,
                                  false,
                                  c.status};
    }
}

void PairQuery::merge(std::size_t split, double spacing) noexcept
{
    // Far below the rounding of positions nothing is the same, and cells could not be counted.
    if (!(options.merge_distance > 1e-6f) || !(spacing > 0)) return;
    const std::size_t lists = std::bit_ceil(std::max<std::size_t>(split, result.contacts - split));
    const MergeRule rule{static_cast<double>(options.merge_distance) * spacing, options.merge_cosine};
    result.contacts =
        merge_mutual(out.first(result.contacts), split, rule, std::span(workspace.head_).first(lists), workspace.next_);
}

void PairQuery::run(const Body& a, const Body& b) noexcept
{
    add(a, b, Side::B);
    if (options.query.first_only && result.found > 0) return;
    const std::size_t split = result.contacts;
    add(b, a, Side::A);
    if (split > 0 && split < result.contacts) merge(split, std::max(a.probe->spacing(), b.probe->spacing()));
}

PairResult query_pair(const Body& a, const Body& b, const PairOptions& options, PairWorkspace& workspace) noexcept
{
    PairQuery query{options, workspace, PairQuery::contacts_of(workspace)};
    query.run(a, b);
    return {query.out.first(query.result.contacts), query.result.found, query.result.status, edge_length(a, b, options.query)};
}

}  // namespace sqmap::query
