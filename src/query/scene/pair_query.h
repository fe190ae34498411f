// One pair of bodies, its contacts written where the caller has space.
#pragma once

#include "sqmap/query/pair.h"

namespace sqmap::query {

struct PairQuery {
    const PairOptions& options;
    PairWorkspace& workspace;
    std::span<PairContact> out;

    struct Result {
        std::size_t contacts = 0;    ///< written, after merging
        std::size_t found = 0;       ///< in both directions, before merging, written or not
        std::uint8_t status = k_ok;  ///< bits of Status
    };
    Result result{};

    /// The workspace's own space.
    static std::span<PairContact> contacts_of(PairWorkspace& workspace) noexcept { return workspace.contacts_; }

    void run(const Body& a, const Body& b) noexcept;

private:
    /// Vertices of the collider in the touched body.
    void add(const Body& touched, const Body& collider, Side vertex_of) noexcept;
    /// Keeps the deeper of two contacts that both directions report. split: the index at which the second direction begins.
    void merge(std::size_t split, double spacing) noexcept;
};

}  // namespace sqmap::query
