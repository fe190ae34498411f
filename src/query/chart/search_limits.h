// Limits of the search for the nearest surface in a chart, which bake repeats when it chooses seeds.
#pragma once

namespace sqmap::query {

inline constexpr int k_approach_steps = 5;
/// Squared distance to the surface point found over that to its tangent plane: within this ratio the plane's foot is the nearest
/// point, with an error of second order.
inline constexpr float k_approach_near = 1.01f;

}  // namespace sqmap::query
