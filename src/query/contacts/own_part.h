// Parts of a body's own model, by triangles and vertices of its probe.
#pragma once

#include "query/probe/triangle_tree.h"
#include "sqmap/query/body.h"
#include "sqmap/query/distance.h"

namespace sqmap::query {

/// The part of a triangle of the probe, or of a vertex alone: that of the model's triangle of the same number where they are one,
/// else of the nearest one.
class OwnPart {
public:
    explicit OwnPart(const Body& body) : tree_(body.probe->triangles()), model_(body.model) {}

    [[nodiscard]] std::int16_t of_triangle(std::uint32_t t) const
    {
        if (!has_parts()) return -1;
        const ProbeTriangle& v = tree_.triangle(t);
        if (is_corner(v[0], 3 * t) && is_corner(v[1], 3 * t + 1) && is_corner(v[2], 3 * t + 2)) return part(t);
        return near((tree_.point(v[0]) + tree_.point(v[1]) + tree_.point(v[2])) / 3.0);
    }
    [[nodiscard]] std::int16_t of_vertex(std::uint32_t v) const
    {
        if (!has_parts() || v >= tree_.points()) return -1;
        const std::uint32_t h = tree_.half_edge_from(v);
        return h != TriangleTree::k_no_half_edge && is_corner(v, h) ? part(h / 3) : near(tree_.point(v));
    }

private:
    [[nodiscard]] bool has_parts() const { return model_ != nullptr && !model_->triangle_part.empty(); }
    /// A point stands where the model's half-edge begins.
    [[nodiscard]] bool is_corner(std::uint32_t point, std::uint32_t h) const
    {
        if (h / 3 >= model_->triangle_part.size()) return false;
        const float* corner = &model_->vertices[3 * std::size_t{model::triangle_vertex(*model_, h / 3, h % 3)}];
        return model::to_model_space(model_->header, tree_.point(point)) == model::vec3(corner);
    }
    [[nodiscard]] std::int16_t part(std::uint32_t t) const
    {
        return static_cast<std::int16_t>(model::part_of_triangle(*model_, t));
    }
    [[nodiscard]] std::int16_t near(Vec3d p) const { return static_cast<std::int16_t>(distance(*model_, p).part); }

    const TriangleTree& tree_;
    const model::ModelView* model_;
};

}  // namespace sqmap::query
