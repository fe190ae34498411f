// Probe queries one tick after another: what the last ticks proved to be far from the solid is not looked at again.
#pragma once

#include "sqmap/query/probe.h"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::query {

struct KeptProbe;

/// How much a query had to look at.
struct ProbeReuse {
    bool kept = false;         ///< it used and renewed what the workspace keeps; false: it ran as a query without one
    std::size_t clusters = 0;  ///< where kept: clusters of the probe that were looked at
};

/// A caller keeps it of one probe between ticks: space for contacts and, on layer Exact, how far each cluster and point of the
/// probe may move before it can be in the solid. Until then a query passes over it. Its contacts are those of a query
/// without a workspace, in the same order, with the same bits; it takes less time where the probe is near the model and moves
/// little against it (docs/algorithms/probe-queries.md has figures), and at most 2 % more elsewhere.
///
/// Nothing has to be reset: another model, points that moved (Probe::move), or a step of more than 6 % of the side of the
/// locator's cell (0.3 mm on an object of 0.3 m) make it start anew after four smaller steps; other layers, offset, margin,
/// first_only and models of other libraries are answered as without. A query with another probe than the one that it was made for
/// is right, but keeps nothing unless both have as many clusters. The one thing that it cannot see is another model of the same
/// mesh, with arrays of the same sizes, written over the last one in memory: call forget().
///
/// Memory: 36 bytes a contact, 4 a point, 8 a cluster of 16. Allocates when it is made, never in a query.
/// Thread safety: one thread at a time; threads that query the same probe have a workspace each.
class ProbeWorkspace {
public:
    /// contacts: the most that a query writes; the rest is counted (k_full).
    ProbeWorkspace(const Probe& probe, std::size_t contacts);
    ProbeWorkspace(ProbeWorkspace&& other) noexcept;
    ProbeWorkspace& operator=(ProbeWorkspace&& other) noexcept;
    ~ProbeWorkspace();

    /// Space that queries fill; ProbeResult::written takes it.
    [[nodiscard]] std::span<const Contact> contacts() const noexcept { return contacts_; }
    /// Starts anew at the next query.
    void forget() noexcept;
    /// About the last query.
    [[nodiscard]] ProbeReuse reuse() const noexcept;

private:
    friend struct KeptProbe;
    std::vector<Contact> contacts_;
    std::unique_ptr<KeptProbe> kept_;
};

/// query_probe into the workspace's contacts, sooner where little moved since its last query. Total, noexcept, no allocation.
/// @pre as query_probe
[[nodiscard]] ProbeResult query_probe(const Body& touched, const Body& collider, const QueryOptions& options,
                                      ProbeWorkspace& workspace) noexcept;

}  // namespace sqmap::query
