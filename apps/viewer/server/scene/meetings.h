// Complete contacts of each pair of objects of the scene, as they stand.
#pragma once

#include "sqmap/query/probe.h"
#include "viewer/server/scene/object.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <span>

namespace sqmap::viewer {

/// The object's vertices and triangles in the frame of its pose; nothing where they bound no solid.
[[nodiscard]] std::optional<query::Probe> solid_of(const Object& object);

/// "pairs": of each pair of objects that touch "a" and "b", their numbers, "meetings" (pairs of triangles with a point in
/// common), "found" (contacts, shown or not) and "contacts" as [kind (0 a vertex in the other object, 1 edge across edge, 2
/// faces), region of the pair (-1: none), witness on a (world, m), witness on b, depth (m)]; "open": numbers of objects that take
/// no part, because their triangles bound no solid. Of a region at most 4096 contacts are shown. objects: null where one is
/// hidden.
[[nodiscard]] nlohmann::ordered_json meetings_json(std::span<const ObjectPtr> objects);

}  // namespace sqmap::viewer
