// The tool of a touch: points that meet the surface, and the triangles that the page draws of them.
#pragma once

#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/object.h"

#include <string>
#include <vector>

namespace sqmap::viewer {

inline constexpr std::size_t k_max_tool_points = 6000;  ///< a frame of so many takes well under a tick

/// About the tool's centre, m, turned as the settings say.
struct Tool {
    mesh::Mesh mesh;
    std::vector<float> weights;  ///< m^2 of surface a vertex
};

/// object: the mesh, where the settings ask for one; null: the ball instead. Larger meshes are thinned by clustering vertices
/// until they have at most k_max_tool_points: a tool is felt by its vertices, and details between them are not.
[[nodiscard]] Tool make_tool(const Settings& settings, const Object* object);

/// "SQT1", #vertices, #triangles, positions, corners.
[[nodiscard]] std::string tool_bytes(const Tool& tool);

}  // namespace sqmap::viewer
