// Who is dressed: solids that stand still or ride bones.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/query/frame.h"
#include "sqmap/sim/walker.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace sqmap::app {

/// A solid of the avatar: its model and the mesh it was made from, in the same frame, m.
struct AvatarPart {
    std::string name;
    std::vector<std::byte> bytes;
    model::ModelView model;  ///< over the bytes
    mesh::Mesh mesh;
};

struct Avatar {
    std::vector<AvatarPart> parts;
    std::function<void(double time, std::span<query::Pose>)> pose;  ///< of each part
    double height = 0;                                              ///< m, as it stands
};

/// One solid that stands still, in the model's own mesh units.
/// @throw io::ModelFileError for a file that is no model, or one without its exact layer (there is nothing to show then)
[[nodiscard]] Avatar still_avatar(const std::filesystem::path& model);

/// The capsule human, each bone baked on the spot. spacing: of its meshes, m; target_error: percent of each bone's R_max.
/// progress: called before each bone, with how many are done of how many; what it throws ends it.
[[nodiscard]] Avatar walking_avatar(double height, const sim::Gait& gait, double spacing, double target_error,
                                    const std::function<void(std::size_t done, std::size_t of)>& progress = {});

}  // namespace sqmap::app
