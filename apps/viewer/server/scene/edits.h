// Edits of an object's parts: cuts, joins and fits, and the bake of what they made.
#pragma once

#include "sqmap/bake/bake_types.h"
#include "viewer/server/scene/object.h"

#include <optional>

namespace sqmap::viewer {

/// Superquadrics and names of a partition. keep: parts whose superquadrics are taken over where a part has the same triangles.
[[nodiscard]] Parts fitted(const Object& object, decompose::Partition partition, const Parts* keep, const Words& words);
/// The parts with one superquadric fitted anew; the others stay.
[[nodiscard]] Parts refitted(const Object& object, const Parts& parts, std::uint32_t part);
/// The cut between two parts moved into `other` by a distance along the surface, m, one row of triangles at least. Nothing where
/// they do not touch or too little of `other` would be left. Pieces that the cut separates from the rest of `other` go with it.
[[nodiscard]] std::optional<decompose::Partition> moved_cut(const Object& object, const decompose::Partition& partition,
                                                            std::uint32_t part, std::uint32_t other, double distance);
/// #parts: the parts that each shares an edge with, ascending.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> neighbours_of(const Object& object, const decompose::Partition& partition);

/// The same object with other parts, baked with the options' projection; triangles that the cure of its mesh made up stay so.
/// An object that was baked in this program is baked with the same BakeOptions again (Object::baked_with); of options.bake only
/// the progress is used then.
/// @throw mesh::Error
[[nodiscard]] std::shared_ptr<Object> rebaked(const Object& object, const Parts& parts, BakeMeshOptions options,
                                              const Words& words);

}  // namespace sqmap::viewer
