// What bake and rebake pack models with.
#pragma once

#include "bake/parts/part_work.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/model_data.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// Behind what is there; returns where it begins.
template <class T>
std::uint32_t append(std::vector<T>& all, const std::vector<T>& some)
{
    const auto first = static_cast<std::uint32_t>(all.size());
    all.insert(all.end(), some.begin(), some.end());
    return first;
}

/// A small sphere about points: centre, radius.
void bounding_sphere(std::span<const Vec3d> points, float sphere[4]);

/// The part as stored; its map's arrays are appended to the model's.
[[nodiscard]] model::Part make_part(const mesh::Mesh& mesh, const PartWork& work, model::ModelData& data);

/// The mesh in a frame of its own: vertices turned and sorted there, every triangle at its old place but starting at its
/// least vertex. What is computed from it depends on the mesh's frame through rounding only.
[[nodiscard]] mesh::Mesh canonical_view(const mesh::Mesh& mesh, const Mat3d& frame);

[[nodiscard]] std::uint16_t surface_flag(mesh::Boundary boundary);

// Tighter targets start here too: cells that are finer than the surface asks for crowd out those that it does.
inline constexpr double k_first_target = 0.5;
/// Cell tolerances that meet a target as a rule; measured and corrected after.
[[nodiscard]] CentralOptions central_options(double target_error);
/// The same, where the first guess was multiplied by a factor.
void scale(CentralOptions& central, double factor);

/// The exact layer's vertices, triangles and pieces. flags: surface_flag of each triangle.
void append_exact(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, std::span<const std::uint16_t> flags,
                  model::ModelData& data);

}  // namespace sqmap::bake
