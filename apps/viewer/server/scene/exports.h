// An object as files of other programs: what `sqmap export` writes, of the parts as they are shown.
#pragma once

#include "viewer/server/scene/object.h"

namespace sqmap::viewer {

/// The superquadrics as collider::Format::Json has them, in the frame and units of the mesh.
/// @throw mesh::InvalidInput for a model without its triangles. Cost: some 50 ms for twenty parts
[[nodiscard]] std::string json_text(const Object& object, const Parts& parts);

/// A mesh a part and a mesh a superquadric, in metres. A superquadric has as extras what json_text says of it, texture
/// coordinates, and in its material's extras a displacement texture: grey times `scale` (below 0: inwards) metres along the
/// normal lead to the part's surface where alpha is not zero. @throw as json_text
[[nodiscard]] std::string glb_bytes(const Object& object, const Parts& parts);

}  // namespace sqmap::viewer
