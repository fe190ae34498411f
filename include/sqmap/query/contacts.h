// Complete contacts of two closed meshes: vertices, edges and faces, none missed.
#pragma once

#include "sqmap/query/pair.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

/// The element of a mesh that takes part in a contact.
enum class Feature : std::uint8_t { Vertex, Edge, Face };

inline constexpr std::uint32_t k_unnamed = 0xffffffffu;

/// A contact of two bodies. The frame and units of the bodies' poses.
struct SurfaceContact {
    WitnessPair witness{};
    Vec3f normal{};   ///< unit, the direction in which b leaves a; zero with k_no_surface
    float depth = 0;  ///< >= 0: of a vertex its distance to the other surface, or to the face that bears it; else the least
                      ///< translation along the normal that separates the two features
    Feature feature_a = Feature::Face, feature_b = Feature::Face;
    /// A vertex and a face by their numbers in the body's probe, an edge as 3 t + k: from corner k of triangle t to the next one.
    /// k_unnamed: the face that a vertex is below, which the exact layer does not report.
    std::uint32_t index_a = k_unnamed, index_b = k_unnamed;
    std::uint32_t region = k_unnamed;       ///< contacts of one region touch together; k_unnamed: see ContactOptions::per_region
    std::int16_t part_a = -1, part_b = -1;  ///< of the bodies' models, by the triangle, or the one nearest to it; -1: no model
    bool certain = false;                   ///< the verdict is proven
    std::uint8_t status = k_ok;
};

/// Options of complete contacts.
struct ContactOptions {
    bool first_only = false;  ///< one contact, the first that is found: a yes or no
    /// Contacts of a region that are kept: the deepest, then those that span the largest area. 0: all, and vertices that no face
    /// bears have no region.
    std::uint32_t per_region = 0;
    bool supports = true;  ///< corners of what flat faces share; false for whoever tests the vertices otherwise
};

/// The workspace of complete contacts, made outside the tick: one for each thread that queries.
class ContactWorkspace {
public:
    /// contacts: how many are kept of vertices in a direction, of edges, and of pairs of triangles that meet; what is beyond it
    /// is counted, not kept. Allocates.
    explicit ContactWorkspace(std::size_t contacts);

private:
    friend class ContactQuery;
    static constexpr std::size_t k_least_slots = 1024;  ///< of the table
    struct Entry {
        std::uint64_t key;
        std::uint32_t value, round;
    };
    struct Meeting {
        std::uint32_t a, b;      ///< triangles
        std::uint32_t contacts;  ///< of the region, where it is the root of one
        double depth;            ///< along the normals of its triangles
    };
    std::vector<Contact> found_;
    std::vector<SurfaceContact> contacts_;
    std::vector<SurfaceContact> kept_;
    std::vector<Meeting> meetings_;
    std::vector<std::uint32_t> parents_;  ///< of kept contacts, then of meetings: what belongs to one region
    std::vector<Entry> table_;
    std::uint32_t round_ = 0;
};

/// Bits of results about two solids, beside those of Status, which a byte holds. C refuses such a probe and has no bit for it.
enum ContactStatus : std::uint16_t {
    k_no_triangles = 256,  ///< a probe has no triangles: only vertices were tested; give them to Probe
};

/// Contacts of two bodies.
struct ContactResult {
    std::span<const SurfaceContact> contacts{};  ///< in the workspace, valid until its next query
    std::size_t found = 0;                       ///< kept or not
    std::size_t meetings = 0;                    ///< pairs of triangles that have a point in common
    std::size_t regions = 0;                     ///< of such pairs, each one connected; every one has a contact
    std::uint16_t status = k_ok;                 ///< bits of Status and ContactStatus
};

/// The map by which complete contacts move the points of b's probe to the mesh frame of a: x -> linear x + shift, in double, as
/// apply() evaluates it. Points of a stay as they are. An oracle that is given these numbers gives the same verdicts.
[[nodiscard]] Affine b_in_a(const Body& a, const Body& b) noexcept;

/// Contacts of two closed meshes, with no false negative: if a triangle of a's probe and one of b's have a point in common, to
/// the last bit of b_in_a's positions, then the region of such pairs around them has a contact. In this order:
/// - vertices of b in a's model, then of a in b's, as the exact layer finds them: depth is the distance to the surface;
/// - edges of a against edges of b, where the edges support each other: both pairs of faces fall off from them;
/// - corners of what flat faces that lie on each other share, along the normal of one: vertices over a face, and sides that
/// cross;
/// - of each region that has none of the last two, the two triangles that are deepest in each other.
/// A body without a model has no vertices in it; one whose probe has no triangles meets with vertices alone: k_no_triangles. A
/// pose that is not finite has no contacts: k_not_finite. Contacts beyond the workspace's are counted: k_full. Total, noexcept,
/// no allocation, the same bits on every instruction set. Several threads may query the same bodies, each with its workspace.
/// @pre a.model, b.model came from model::parse
/// Cost: that of query_pair's exact layer, and linear in the triangles near the other surface.
[[nodiscard]] ContactResult query_contacts(const Body& a, const Body& b, const ContactOptions& options,
                                           ContactWorkspace& workspace) noexcept;

}  // namespace sqmap::query
