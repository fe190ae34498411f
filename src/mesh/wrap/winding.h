// The generalized winding number of triangles that need not close.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// Sum of the solid angles of oriented triangles about a point, over 4 pi. Immutable once made.
class WindingNumber {
public:
    explicit WindingNumber(const Mesh& soup);

    /// Triangles near p singly, those far off in groups by their moments up to the second: within about 1e-3.
    [[nodiscard]] double at(Vec3d p) const;
    /// All triangles singly.
    [[nodiscard]] double direct(Vec3d p) const;

private:
    using Corners = std::array<Vec3d, 3>;

    /// Moments of a group about its centre, as the derivatives of the dipole's potential need them.
    struct Node {
        Vec3d centre;
        double reach_sq = 0;               ///< beyond this squared distance the moments serve
        Vec3d area;                        ///< sum of the vector areas
        double trace = 0;                  ///< of the first moment
        double first[6] = {};              ///< first moment, symmetric part: xx yy zz xy xz yz
        Vec3d contracted;                  ///< of the second moment
        double second[10] = {};            ///< second moment, symmetric part: xxx yyy zzz xxy xxz yyx yyz zzx zzy xyz
        std::uint32_t begin = 0, end = 0;  ///< triangles
        std::uint32_t skip = 0;            ///< the node after all that lie below this one
        bool leaf = false;
    };

    void build(std::uint32_t begin, std::uint32_t end, std::span<std::uint32_t> order, std::span<const Corners> pieces);
    void sum_moments(Node& node) const;

    std::vector<Node> nodes_;         ///< depth first
    std::vector<Corners> triangles_;  ///< or pieces of long ones, in the order of the leaves
};

}  // namespace sqmap::mesh
