// The figure that is dressed: solids that stand still or ride bones, or one whose bones blend.
#pragma once

#include "common/dress/person.h"
#include "sim/walker.h"
#include "sqmap/io/read_skin.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/skin.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/query/probe.h"
#include "sqmap/query/skin.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace sqmap::app {

/// A solid of the avatar: its model and the mesh it was made from, in the same frame, m.
struct AvatarPart {
    std::string name;
    std::vector<std::byte> bytes;
    paper::AnyModel opened;  ///< over the bytes
    model::ModelView model;  ///< of opened
    mesh::Mesh mesh;
};

/// A skinned file's surface, with what carries cloth's points back to the pose that it was bound in.
struct SkinnedBody {
    io::SkinnedSoup file;
    mesh::Mesh bound;          ///< as its part's mesh: what cloth touches
    std::vector<Vec3d> drawn;  ///< #vertices of it: where they are seen, on it or a little below
    mesh::Influences influences;
    query::SkinLattice lattice;
    std::unique_ptr<query::MovingSkin> moving;
    std::vector<Affine> maps;  ///< of the pose that it is in

    /// The vertices in that pose, as they are seen.
    [[nodiscard]] std::vector<Vec3d> posed() const { return mesh::skinned(drawn, influences, maps); }
};

struct Avatar {
    std::vector<AvatarPart> parts;
    std::vector<std::string> joints;  ///< of a skin: what garments may be pinned to; after the parts among the poses
    std::function<void(double time, std::span<sqmap::Pose>)> pose;  ///< of each part and joint; moves the skin
    std::unique_ptr<SkinnedBody> skin;                              ///< of the only part
    double height = 0;                                              ///< m, as it stands
};

/// An avatar file that cannot be dressed; what() names it and the cure.
class AvatarError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// One solid that stands still, in the model's own mesh units.
/// @throw io::ModelFileError for a file that is no model, or one without its exact layer (there is nothing to show then)
[[nodiscard]] Avatar still_avatar(const std::filesystem::path& model);

constexpr double k_figure_spacing = 0.022, k_figure_error = 0.3;  ///< of the figure in walking_avatar's arguments: m, percent

/// The person of person.h, baked on the spot. spacing: of its mesh, m; target_error: percent of R_max.
/// progress: called before each stage and often while it bakes, with how many stages are done; what it throws ends it.
[[nodiscard]] Avatar walking_avatar(double height, const sim::Gait& gait, double spacing, double target_error,
                                    const std::function<void(std::size_t done, std::size_t of)>& progress = {});

/// The first skinned mesh of a glTF or GLB file, m, y up. It stands as the file has its joints at rest, or for walk: from 1 s to
/// 2 s it goes over to the animation (its name; empty: the first), which is played from then on, again and again where it ends as
/// it begins. target_error: percent of R_max.
/// @throw AvatarError where the file has no skin, its mesh is not closed as it is, or there is no such animation
[[nodiscard]] Avatar skinned_avatar(const std::filesystem::path& file, bool walk, const std::string& animation,
                                    double target_error);

}  // namespace sqmap::app
