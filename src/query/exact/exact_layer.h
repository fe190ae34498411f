// The exact layer: the mesh's own triangles, for one point and for a probe.
#pragma once

#include "query/model_contact.h"
#include "query/probe/probe_job.h"
#include "sqmap/model/model.h"

namespace sqmap::query {

/// Float does not prove the side of a point nearer to the surface than this times the radius of the object's sphere. Corners and
/// points are rounded by 2e-7 of it, and the kernels' squared distances by 4e-12 of its square.
inline constexpr float k_unproven = 4e-6f;

/// Layer Exact for a finite point: 10 to 50 triangles where the model has a locator, else all of them. Behind a surface that
/// bounds no solid, only what some part holds is in contact. Certain beyond k_unproven. @pre model::has_exact(model)
[[nodiscard]] ModelContact query_exact(const model::ModelView& model, Vec3f point) noexcept;

/// The same where the point's cell, which is not Free, is known; inside: all of it is in the solid.
[[nodiscard]] ModelContact query_exact_in(const model::ModelView& model, Vec3f point, std::size_t brick, std::uint32_t cell,
                                          bool inside) noexcept;

/// As nearest_surface, model space. @pre model::has_exact(model)
[[nodiscard]] ModelContact nearest_in_model(const model::ModelView& model, Vec3f point, const ModelContact& from) noexcept;

/// The probe query by the mesh's own triangles, one entry for every instruction set. job.unproven: set to 1 for points within
/// k_unproven of the surface. @pre the model has a locator and the exact
/// layer
ProbeResult run_probe_exact(const ProbeJob& job) noexcept;

}  // namespace sqmap::query
