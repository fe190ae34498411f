// An object as a file of binary glTF.
#pragma once

#include "viewer/server/scene/object.h"

namespace sqmap::viewer {

/// A mesh a part and a mesh a superquadric, in metres. A superquadric has its parameters as extras, texture coordinates, and in
/// its material's extras a displacement texture: grey times `scale` (below 0: inwards) metres along the normal lead to the
/// part's surface where alpha is not zero.
[[nodiscard]] std::string glb_bytes(const Object& object, const Parts& parts);

}  // namespace sqmap::viewer
