// Garments from patterns: flat panels, the seams that join them, and their fabric. Functions may be called by any thread; they
// allocate.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::sim {

/// Material of cloth. SI units.
struct Fabric {
    double density = 0.15;     ///< kg / m^2
    double stretch = 1;        ///< share of a thread's strain that a solution removes, (0, 1]
    double shear = 50;         ///< N / m, above zero: modulus of shear
    double bend = 33e-6;       ///< N m: stiffness of bending, of a strip a metre wide
    double damping = 4.0;      ///< 1 / s: how fast motion against still air dies away
    double friction = 0.4;     ///< Coulomb's coefficient against the body
    double thickness = 0.002;  ///< m: nodes stay this far from the body
};

/// cotton, silk, denim, wool or leather.
/// @throw std::invalid_argument for another name, listing these
[[nodiscard]] Fabric fabric(std::string_view name);

/// Pairs of vertices that are sewn together.
struct Seam {
    std::string name;
    std::vector<std::array<std::uint32_t, 2>> pairs;
    bool sewn = true;
};

/// A garment before the fitting: the positions of its vertices at the start and in the flat pattern.
struct Garment {
    std::vector<Vec3d> start;  ///< world, m
    std::vector<Vec3d> flat;   ///< in the pattern, m; z is zero
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Seam> seams{};
    std::vector<std::uint32_t> waist{};  ///< vertices that a waistband holds
};

/// A rectangle, width along x and depth along z, with an elliptic hole of the given half axes in the middle (none: 0); level, at
/// height y of centre. With a hole it is a poncho, without one a blanket. About `vertices` vertices.
/// @throw std::invalid_argument for sizes that are not positive or a hole that leaves nothing; so do all below
struct SheetPattern {
    Vec3d centre{0, 1.5, 0};
    double width = 1.2, depth = 1.2, hole_x = 0, hole_z = 0;
    std::uint32_t vertices = 2500;
};
/// Deterministic.
[[nodiscard]] Garment sheet(const SheetPattern& pattern);

/// A circle skirt: a ring, level, at the waist; its inner edge is the waistband.
struct SkirtPattern {
    Vec3d centre{0, 1, 0};
    double waist_radius = 0.15, length = 0.5;
    std::uint32_t vertices = 2500;
};
/// Deterministic.
[[nodiscard]] Garment skirt(const SkirtPattern& pattern);

/// A T-shirt of two panels, upright, in front of and behind the body (+z and -z), sewn along shoulders and sleeves' tops, and
/// along sides and sleeves' bottoms. Arms stretched along x.
struct ShirtPattern {
    Vec3d collar{0, 1.45, 0};       ///< middle of the neck, at the height of the shoulder seam
    double chest = 0.5;             ///< width of the body
    double length = 0.6;            ///< from the shoulder seam down
    double span = 1.1;              ///< from one sleeve's end to the other's
    double sleeve = 0.22;           ///< width of a sleeve laid flat
    double neck = 0.22;             ///< width of the opening
    double gap = 0.16;              ///< from the middle plane to each panel
    std::uint32_t vertices = 4000;  ///< of both panels
};
/// Deterministic.
[[nodiscard]] Garment shirt(const ShirtPattern& pattern);

}  // namespace sqmap::sim
