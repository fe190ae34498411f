// Two bodies against each other: each one's map against the other's vertices, contacts seen from both sides reported once.
#pragma once

#include "sqmap/query/body.h"
#include "sqmap/query/probe.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

/// One of the two bodies of a pair.
enum class Side : std::uint8_t { A, B };

/// The witness points of a contact, a vertex of one body and the nearest surface point of the other.
struct WitnessPair {
    Vec3d on_a{}, on_b{};  ///< on_b = on_a - depth normal
};

/// A vertex of one body in the other. The frame and units of the bodies' poses.
struct PairContact {
    WitnessPair witness{};
    Vec3f normal{};           ///< unit, the direction in which b leaves a; zero with k_no_surface
    float depth = 0;          ///< >= 0
    std::uint32_t index = 0;  ///< of the vertex in its body's probe
    std::int16_t part = -1;   ///< of the other body's model
    Side vertex_of = Side::B;
    bool certain = false;  ///< the verdict is proven
    bool mutual = false;   ///< seen from both sides; the other one was no deeper and is left out
    std::uint8_t status = k_ok;
};

/// How a pair is queried, and when two contacts of it are one.
struct PairOptions {
    QueryOptions query{};  ///< in both directions
    /// When contacts of a vertex of a and of one of b are the same: both ends nearer than this times the vertex spacing of the
    /// coarser body (Probe::spacing), normals with at least this cosine. Distance 0: none is.
    float merge_distance = 0.5f;
    float merge_cosine = 0.7f;
};

/// The workspace of a pair query, made outside the tick: one for each thread that queries.
class PairWorkspace {
public:
    /// contacts: the most that are found in one direction; what is beyond it is counted, not kept. Allocates.
    explicit PairWorkspace(std::size_t contacts);

private:
    friend struct PairQuery;
    std::vector<Contact> found_;
    std::vector<std::uint32_t> head_, next_;  ///< lists of near contacts, by a hash of their position
    std::vector<PairContact> contacts_;       ///< of the last query_pair
};

/// Contacts of a pair.
struct PairResult {
    std::span<const PairContact> contacts{};  ///< after merging; in the workspace, valid until its next query
    std::size_t found = 0;                    ///< in both directions, before merging, kept or not
    std::uint8_t status = k_ok;               ///< bits of Status
    /// Edges no longer than this that cross the other surface have an end among the contacts: twice the margin, less what
    /// rounding takes. Poses' units; 0 without a margin, with offset, on layer One and of models without triangles.
    double edge_length = 0;
};

/// Contacts of two bodies: vertices of b in a in the order of b's probe, then vertices of a in b; of each contact seen from both
/// sides only the deeper one. Swapping the bodies swaps the witness points and turns the normals round. With first_only the first
/// contact of either direction ends it. Total, noexcept, no allocation. Several threads may query the same bodies, each with its
/// workspace.
/// @pre a.model, b.model came from model::parse (not checked)
/// Cost: two query_probe, and merging linear in what they find.
[[nodiscard]] PairResult query_pair(const Body& a, const Body& b, const PairOptions& options, PairWorkspace& workspace) noexcept;

}  // namespace sqmap::query
