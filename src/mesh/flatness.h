// Recognises a surface that is a sheet: too thin for a fit to find a volume.
#pragma once

#include "surface.h"

#include <string>

namespace sqmap::mesh {

/// Volume over area to the power of 3/2, halved: thinner is a sheet.
inline constexpr double k_flat_thickness = 1e-5;

struct Flatness {
    double area = 0;              ///< of all faces, units of the points squared
    bool is_plane = false;        ///< all faces lie in one plane, as far as a fit can tell
    bool encloses_volume = true;  ///< if closed: some shell is thicker than a sheet
    std::string message;          ///< what is flat about it
    [[nodiscard]] bool is_flat(bool closed) const { return is_plane || (closed && !encloses_volume); }
};

/// points: of the surface, near the origin and about unit size; component: of every face; scale: of a printed length.
[[nodiscard]] Flatness flatness_of(const Surface& surface, std::span<const Vec3d> points,
                                   std::span<const std::uint32_t> component, double scale);

/// A length as a user reads it.
[[nodiscard]] std::string length_text(double length);

}  // namespace sqmap::mesh
