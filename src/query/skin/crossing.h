// The surface that a point crosses on its way and the surface at the end of its way: common to solids and skins.
#pragma once

#include "sqmap/query/swept.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::query {

inline constexpr std::uint32_t k_no_contact = 0xffffffffu;
inline constexpr double k_head_on = 0.25;  ///< cosine between the way and the surface's inward normal

/// Instead of the point's own contact at the end, or behind the others, of which there are `count`.
template <class Crossing>
void keep_crossing(const Crossing& crossing, std::uint32_t own, std::span<Crossing> contacts, std::size_t& count,
                   SweptResult& result) noexcept
{
    ++result.caught;
    if (own != k_no_contact) {
        contacts[own] = crossing;
        return;
    }
    ++result.probe.contacts;
    if (count < contacts.size())
        contacts[count++] = crossing;
    else
        result.probe.status |= k_full;
}

}  // namespace sqmap::query
