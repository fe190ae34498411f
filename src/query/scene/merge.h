// Contacts that two bodies both see.
#pragma once

#include "sqmap/query/pair.h"

namespace sqmap::query {

struct MergeRule {
    double distance;  ///< world units, > 0
    float cosine;
};

/// contacts[0, split) are of one body's vertices, the rest of the other's. The side with fewer contacts looks, each contact in
/// turn, for the nearest contact of the other side that is within the rule and not taken; of the two the deeper one stays.
/// Returns how many are left, in the same order. head: a power of two; next: at least contacts.size().
/// Cost: linear, while contacts within the rule's distance of each other are few.
std::size_t merge_mutual(std::span<PairContact> contacts, std::size_t split, const MergeRule& rule, std::span<std::uint32_t> head,
                         std::span<std::uint32_t> next) noexcept;

}  // namespace sqmap::query
