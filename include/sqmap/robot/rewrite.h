// A robot file whose collision meshes are replaced by shapes that are certified to hold them.
// Any number of threads, on files of their own.
#pragma once

#include "sqmap/bake_mesh.h"
#include "sqmap/collider/export.h"
#include "sqmap/robot/description.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::robot {

/// Options of rewriting a robot's collision elements.
struct RewriteOptions {
    collider::ShapeChoice shape{};
    std::uint32_t max_parts = 1;  ///< into which a mesh is cut: a shape for each
    Packages packages{};
    MeshOptions mesh{};
    unsigned threads = 0;  ///< 0: one a core; the files do not depend on it
};

/// A collision mesh, and what stands for it now.
struct RewrittenMesh {
    std::string link, filename;
    std::size_t line = 0;
    std::size_t triangles = 0;
    std::string verdict;  ///< of admission: "ACCEPT", "WRAPPED"; of a mesh that bounds no solid its code, "E_OPEN"
    std::size_t shapes = 0;
    collider::Figures figures{};  ///< metres, beside the mesh in the link's frame
    mesh::Words problem{};        ///< not empty: the collision element was left as it was, and why
};

/// A robot file made anew.
struct Rewritten {
    std::vector<collider::ExportFile> files;  ///< meshes to which the robot file refers, then that file
    std::vector<RewrittenMesh> meshes;        ///< in the file's order
};

/// Replaces each collision element that names a mesh by elements with shapes that hold it, each with its figures in a comment.
/// All else in the file stays: comments, white space, elements that URDF does not know, what the replaced element held beside its
/// origin and geometry. Shapes are made in the link's frame, the mesh scaled and turned as the file says, so they hold, as
/// written, every triangle of the file, of a solid or not. A mesh that cannot be read, or gets no shape, is a problem of its own:
/// its element stays. DAE files whose up axis is z are taken as robots take them, with z up.
/// text: of the file at `robot_file`, from whose folder meshes are found; output: the file to be written, whose folder gets
/// meshes.
/// @throw DescriptionError as read_description; mesh::InvalidInput for a shape that URDF cannot hold
/// Cost: reading and admitting each mesh, a decomposition where max_parts is above 1, and the shapes.
[[nodiscard]] Rewritten rewrite(std::string_view text, const std::filesystem::path& robot_file,
                                const std::filesystem::path& output, const RewriteOptions& options = {});

/// A link's mesh in the link's frame.
struct LinkMesh {
    mesh::Mesh soup;        ///< as read, its polygons cut into triangles
    AdmittedMesh admitted;  ///< the solid that it bounds, or the reason why it bounds none
};
/// Reads a mesh, scales and turns it, and admits it. The unit of the options is the mesh file's; the link's frame is in metres.
/// @throw mesh::RefusedMesh where the file cannot be read, names corners that are not there or not finite, or has no faces
[[nodiscard]] LinkMesh load_mesh(const std::filesystem::path& path, const CollisionMesh& as, const MeshOptions& options);

}  // namespace sqmap::robot
