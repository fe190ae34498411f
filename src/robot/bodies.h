// The shapes of a link as triangles in a tree, and how far two such trees are apart.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/math/pose.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/robot/description.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sqmap::robot {

/// A triangle, grown: the shape has every point within `grown` of it, and none of its points is farther from all triangles than
/// their `reach`. A ball is a triangle of one point.
struct GrownTriangle {
    Vec3d corner[3];
    double grown = 0, reach = 0;
};
/// A branch of the tree: its box in the link's frame, and a ball around it; both hold the triangles with their reach.
struct Branch {
    Vec3d centre{}, half{};
    double radius = 0;
    std::uint32_t first = 0;  ///< leaf: its first triangle; else its first child, the second one follows
    std::uint32_t count = 0;  ///< triangles of a leaf; 0 of others
};

/// The space that a link occupies.
class LinkShape {
public:
    /// Reads the link's collision elements. Problems are kept, not thrown.
    LinkShape(const Link& link, const std::filesystem::path& robot_file, const Packages& packages, const MeshOptions& options);

    [[nodiscard]] bool empty() const { return triangles_.empty(); }
    [[nodiscard]] std::span<const GrownTriangle> triangles() const { return triangles_; }
    [[nodiscard]] std::span<const Branch> branches() const { return branches_; }
    /// A point of each piece of the surface.
    [[nodiscard]] std::span<const Vec3d> samples() const { return samples_; }
    /// True for a point within a solid of the link; balls have none, their triangles say it.
    [[nodiscard]] bool inside(Vec3d p) const;
    std::string verdict{};
    mesh::Words problem{};

private:
    struct Filled {
        std::unique_ptr<mesh::Mesh> mesh;
        std::unique_ptr<mesh::Solid> solid{};
    };
    void add_mesh(const CollisionMesh& mesh, const std::filesystem::path& path, const MeshOptions& options);
    void add_solid(const CollisionSolid& solid);
    void add_triangles(const mesh::Mesh& mesh, double reach);
    void add_filled(mesh::Mesh mesh, std::span<const std::uint8_t> crossed);
    void add_problem(const mesh::Words& words);
    void split(std::uint32_t branch, std::uint32_t first, std::uint32_t count);

    std::vector<GrownTriangle> triangles_;
    std::vector<Branch> branches_;
    std::vector<Vec3d> samples_;
    std::vector<Filled> filled_;
};

/// Distance of two triangles, 0 where they meet; within rounding of their coordinates.
[[nodiscard]] double distance_of(const Vec3d (&a)[3], const Vec3d (&b)[3]) noexcept;

/// Two links, one posed in the frame of the other.
class Placement {
public:
    Placement(const LinkShape& a, const LinkShape& b, const Pose& b_in_a);

    /// A lower bound of the distance of two branches.
    [[nodiscard]] double lower_bound(const Branch& a, const Branch& b) const noexcept;
    /// Bounds of the distance of the shapes at two triangles. They differ where a cylinder is more than its prism.
    struct Gap {
        double lower = 0, upper = 0;
    };
    [[nodiscard]] Gap gap(std::uint32_t a, std::uint32_t b) const noexcept;
    /// Two triangles: a's, b's.
    struct TrianglePair {
        std::uint32_t a = 0, b = 0;
    };
    /// The distance of the shapes' surfaces, if it is less than `within`; else `within`. nearest: a guess comes in, the nearest
    /// triangles go out, so that the next query for a pose nearby is quick.
    [[nodiscard]] double distance(double within, TrianglePair& nearest) const;
    /// A piece of one has a point within the other's solid.
    [[nodiscard]] bool contained() const;
    /// The centre of a branch of b, in a's frame.
    [[nodiscard]] Vec3d centre_in_a(const Branch& of_b) const noexcept { return apply(pose_, of_b.centre); }

    const LinkShape& a;
    const LinkShape& b;

private:
    Pose pose_;
    Mat3d size_;  ///< entries of the rotation without signs
};

}  // namespace sqmap::robot
