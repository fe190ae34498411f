// Contacts of the tool on the maps of what it touches: where on a part's map each is looked up.
#pragma once

#include "viewer/server/touch/forces.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace sqmap::viewer {

/// A contact's foot: of a paper model the point of the superquadric whose normal leads through the contact (P_M of section
/// 4.2), of a central one the point on the ray from the chart's centre.
struct Foot {
    std::uint32_t part = 0;
    float x = 0, y = 0;  ///< on the picture of the part's map, shares of width and height from the upper left
    float depth = 0;     ///< m
};

inline constexpr std::size_t k_max_feet = 256;  ///< of more contacts every n-th has one

/// Feet of the tool at a pose on one object, as a layer answers. Cost: a probe query, and a search a contact. Any thread.
/// @pre object < #objects
[[nodiscard]] std::vector<Foot> feet_of(const Forces& forces, const sqmap::Pose& pose, std::size_t object, query::Layer layer);

/// The foot of one point of the world that a part's superquadric holds or nearly holds; nothing at a chart's centre.
[[nodiscard]] std::optional<Foot> foot_of(const Object& object, std::uint32_t part, Vec3d point);

}  // namespace sqmap::viewer
