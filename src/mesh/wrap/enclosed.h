// Triangles that a surface keeps inside: does a triangle come near one, does a moving one pass over one.
#pragma once

#include "sqmap/math/box.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// Triangles with or without area. Immutable once made.
class Enclosed {
public:
    using Corners = std::array<Vec3d, 3>;

    /// margin: nearer triangles meet; far above the rounding of the coordinates.
    Enclosed(const Mesh& soup, double margin);

    /// Appends the triangles whose boxes come near a box.
    void collect(const Box& box, std::vector<std::uint32_t>& out) const;
    /// True if a plane keeps the triangle of the soup and the other one, whose box is given, apart by the margin: they share no
    /// point.
    [[nodiscard]] bool are_apart(std::uint32_t soup_triangle, const Corners& other, const Box& box) const;
    /// A triangle of the soup that is not kept apart from the other one.
    [[nodiscard]] std::optional<std::uint32_t> met_by(const Corners& other) const;
    /// True if the first corner of the triangle lies in the tetrahedron, or within rounding of it.
    [[nodiscard]] bool is_swept(std::uint32_t soup_triangle, const std::array<Vec3d, 4>& tetrahedron) const;

private:
    struct Node {
        Box box;
        std::uint32_t first = 0, count = 0;  ///< leaf: entries of order_
        std::uint32_t skip = 0;              ///< the node after all that lie below this one
    };

    void build(std::uint32_t first, std::uint32_t last, std::span<const Vec3d> middles);
    template <class Visit>
    void visit(const Box& box, Visit&& visit) const;

    double margin_;
    std::vector<Corners> corners_;  ///< #triangles
    std::vector<std::uint32_t> order_;
    std::vector<Box> boxes_;   ///< #triangles, larger by the margin
    std::vector<Node> nodes_;  ///< depth first
};

}  // namespace sqmap::mesh
