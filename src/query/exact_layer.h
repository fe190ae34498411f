// The exact layer: signed crossings of the ray from the chart's centre with the mesh's own triangles.
#pragma once

#include "central_map.h"

namespace sqmap::query {

/// One part's triangle lists.
class ExactLayer {
public:
    ExactLayer(const model::ModelView& view, const model::Part& part)
        : view_(view),
          base_(static_cast<int>(part.base)),
          rows_(view.rows.data() + part.first_row),
          starts_(view.starts.data() + part.first_start),
          refs_(view.refs.data() + part.first_ref),
          locals_(view.locals.data() + part.first_local)
    {
    }

    struct List {
        const std::uint16_t* begin;
        const std::uint16_t* end;
    };

    List base_list(int face, int column, int row) const
    {
        const std::uint32_t r = static_cast<std::uint32_t>(face * base_ + row);
        const std::uint16_t* start = starts_ + r * static_cast<std::uint32_t>(base_ + 1);
        return {refs_ + rows_[r] + start[column], refs_ + rows_[r] + start[column + 1]};
    }

    /// Triangles whose central projection touches the cell around (s, t).
    List list_at(int face, float s, float t) const
    {
        const float size0 = 2.f / static_cast<float>(base_);
        const int column = std::clamp(static_cast<int>((s + 1.f) * 0.5f * static_cast<float>(base_)), 0, base_ - 1);
        const int row = std::clamp(static_cast<int>((t + 1.f) * 0.5f * static_cast<float>(base_)), 0, base_ - 1);
        List list = base_list(face, column, row);
        float s0 = -1.f + size0 * static_cast<float>(column), t0 = -1.f + size0 * static_cast<float>(row), size = size0;
        while (list.begin != list.end && *list.begin == model::k_split_list) {
            size *= 0.5f;
            const int right = s >= s0 + size ? 1 : 0, up = t >= t0 + size ? 1 : 0;
            s0 += size * static_cast<float>(right);
            t0 += size * static_cast<float>(up);
            list = quadrant(list, right + 2 * up);
        }
        return list;
    }

    static List quadrant(List list, int q)
    {
        const std::uint16_t* base = list.begin + 6;
        return {base + list.begin[1 + q], base + list.begin[2 + q]};
    }

    /// Calls visit(triangle) for every triangle of a base cell, some of them more than once.
    template <class Visit>
    void each_triangle(List list, Visit&& visit) const
    {
        if (list.begin == list.end) return;
        if (*list.begin == model::k_split_list) {
            for (int q = 0; q < 4; ++q) each_triangle(quadrant(list, q), visit);
            return;
        }
        for (const std::uint16_t* r = list.begin; r != list.end; ++r) visit(locals_[*r]);
    }

    Vec3d vertex(std::uint32_t v) const
    {
        const float* p = view_.vertices.data() + 3 * static_cast<std::size_t>(v);
        return {p[0], p[1], p[2]};
    }

    enum class Side { Outside, Inside, Degenerate };

    /// Exact verdict: winding number above zero. centre_winding: of the chart's centre.
    Side side(List list, Vec3d centre, Vec3d point, int centre_winding) const
    {
        const Vec3d d = point - centre;
        const double d_size = norm(d);
        int winding = centre_winding;
        for (const std::uint16_t* r = list.begin; r != list.end; ++r) {
            const std::uint32_t t = locals_[*r];
            const std::uint32_t tri[3] = {triangle_vertex(view_, t, 0), triangle_vertex(view_, t, 1),
                                          triangle_vertex(view_, t, 2)};
            const Vec3d a = vertex(tri[0]) - centre, b = vertex(tri[1]) - centre, c = vertex(tri[2]) - centre;
            // Both triangles of an edge see the same number, since it is computed from its lower vertex to its upper.
            const double u = edge(tri[1], tri[2], b, c, d), v = edge(tri[2], tri[0], c, a, d), w = edge(tri[0], tri[1], a, b, d);
            const double size = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z), std::abs(b.x), std::abs(b.y),
                                          std::abs(b.z), std::abs(c.x), std::abs(c.y), std::abs(c.z)});
            const double tiny = 1e-14 * size * size * d_size;
            if ((u > tiny || v > tiny || w > tiny) && (u < -tiny || v < -tiny || w < -tiny)) continue;
            const double volume = dot(a, cross(b, c)), along = u + v + w;  // the ray meets the plane at volume / along
            if (std::abs(u) <= tiny || std::abs(v) <= tiny || std::abs(w) <= tiny) {
                if (along * volume >= 0 && std::abs(volume) <= std::abs(along) * (1 + 1e-9)) return Side::Degenerate;
                continue;
            }
            if ((along > 0) == (volume > 0) && std::abs(volume) < std::abs(along)) winding -= along > 0 ? 1 : -1;
        }
        return winding > 0 ? Side::Inside : Side::Outside;
    }

private:
    static double edge(std::uint32_t i, std::uint32_t j, Vec3d p, Vec3d q, Vec3d d)
    {
        return i < j ? dot(cross(p, q), d) : -dot(cross(q, p), d);
    }

    const model::ModelView& view_;
    int base_;
    const std::uint32_t* rows_;
    const std::uint16_t* starts_;
    const std::uint16_t* refs_;
    const std::uint32_t* locals_;
};

}  // namespace sqmap::query
