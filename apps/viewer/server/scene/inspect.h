// One point looked at closely: what each layer says of it, and a section through the object there.
#pragma once

#include "viewer/server/scene/object.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>

namespace sqmap::viewer {

/// Layers 1, 2, 3 and exact of one point of the world, m: verdict, depth, normal, part, whether proven, and what the status says.
[[nodiscard]] nlohmann::ordered_json answers_json(const Object& object, Vec3d point);

/// How each projector finds the foot of a point of the world, m, on a part of a paper model: steps as [x, y on the map's
/// picture, point of the superquadric (world, m), distance (m), I_S, stride, whether it was the best so far], and what the map
/// says there. "held": the part's superquadric holds the point. @pre the model is normal and the part exists
[[nodiscard]] nlohmann::ordered_json search_json(const Object& object, std::uint32_t part, Vec3d point);

/// Through a point of the world, across an axis (0 to 2) of a part's superquadric.
struct SectionPlane {
    std::uint32_t part = 0;
    int axis = 0;
    Vec3d through{};
};
/// "SQC1", side, #cuts; of the square that is shown a corner and its two edges (world, m); F of the part (eqs. 1 and 2) on side
/// by side points, rows along the second edge; the least F of the other parts likewise; then the cuts through triangles: part,
/// and x, y of both ends as shares of the edges. @pre the part exists
[[nodiscard]] std::string section_bytes(const Object& object, const Parts& parts, const SectionPlane& plane);

/// "SLC1", side; of a square of the world across an axis (0 to 2) through a point, a fifth larger than the object's box, a corner
/// and its two edges (m); then side by side signed distances, m, negative inside, rows along the second edge: exact within 10 cm.
[[nodiscard]] std::string slice_bytes(const Object& object, int axis, Vec3d through);

}  // namespace sqmap::viewer
