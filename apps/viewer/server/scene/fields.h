// Fields over the surface as bytes for the page: "SQF1", #values, a float each.
#pragma once

#include "viewer/server/scene/object.h"

namespace sqmap::viewer {

enum class Field : std::uint8_t { ErrorOfTwo, Error, Protrusion, Curvature, Locales, Strength, Regions, MadeUp };
/// A float a triangle. Error: of layer 3's depth just below the surface, percent of R_max; below 0: missed (-1), not known (-2).
/// ErrorOfTwo: the same of layer 2. Protrusion: over its mean. Curvature: Gaussian, times R_max squared.
/// Locales: twice the number of the nearest salient feature, and 1 in every second locale about it; -2 where none is reached.
/// Strength: Boundary Strength of the triangle's locale, -20 where none is. Regions: section 5's of a paper model: 0 convex, 1
/// Q1, 2 Q2; -2 of others. MadeUp: 1 or 0.
[[nodiscard]] std::string field_bytes(const Object& object, Field field);
/// A float a triangle: by how much layer 3's depths of two models of one mesh differ 1 % of R_max below the surface, percent of
/// R_max; -1 where only one finds contact, -2 where neither does. @pre are_of_one_mesh
[[nodiscard]] std::string difference_bytes(const Object& object, const Object& other);
/// A float a triangle: 1 where other surface hides it from its part's projection (Q2 of section 5), 0 where it is seen, -2 not
/// known. The parts are the model's own.
[[nodiscard]] std::string hidden_bytes(const Object& object);
/// A float a vertex: how far the stored offset (eq. 12) moves the surface out, m.
[[nodiscard]] std::string offset_bytes(const Object& object);

}  // namespace sqmap::viewer
