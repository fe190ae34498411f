// How far the polynomials of power-inl.h are from their functions in double.
#pragma once

namespace sqmap::query {

/// x^e of x in [0, 1] and e in [1, 20], as it enters eq. 1: absolute.
inline constexpr double k_power_error = 1.5e-7;
/// x^e of x in [1, 2] and e in [-1, -0.05]: relative.
inline constexpr double k_root_error = 1.5e-7;
/// Sines, cosines and angles: absolute.
inline constexpr double k_angle_error = 4e-7;
/// Bounds the error of F^(1/2) of eq. 1 on the surface. The query enlarges the inside by it, so that no point that the
/// certificate holds is outside.
inline constexpr float k_gauge_error = 1e-6f;

}  // namespace sqmap::query
