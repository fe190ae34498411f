// Haptic texture (eq. 34): a fixed, band-limited relief carved into a surface, made once, looked up at contacts.
#pragma once

#include "sqmap/math/vec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// How a table lies on a surface.
enum class TextureMap : std::uint8_t {
    Solid,   ///< n^3 values that repeat through space: no seams
    Planar,  ///< n^2 values, projected along the three axes and blended by the normal: for images
};

/// A relief over the mesh frame: values on a lattice that repeats, joined by quadratic B-splines, so that the slope is
/// continuous and nothing is finer than two steps of the lattice. Drawn once, never in a tick (errata 12). The relief is carved
/// inwards from the surface: heights are at most zero, so that points outside the surface stay free.
struct Texture {
    TextureMap map = TextureMap::Solid;
    std::uint32_t n = 0;              ///< values along a side; 0: no texture
    double step = 0;                  ///< m between values
    std::span<const float> values{};  ///< m, <= 0; x fastest. Caller-owned
};

/// A texture at a point.
struct Relief {
    double height = 0;  ///< m, <= 0
    Vec3d gradient{};   ///< of the height in space
};

/// p: mesh frame, m; normal: unit, of the surface at p; only planar tables read it. Flat where p is not finite or the table is
/// too short. No allocation. Any thread.
[[nodiscard]] Relief relief_at(const Texture& texture, Vec3d p, Vec3d normal) noexcept;

/// A contact in the carved surface.
struct Carved {
    double depth = 0;
    Vec3d normal{};
};
/// Depth and unit normal of a contact in the carved surface: eq. 34 with the sign that makes n_g a distance further in, and
/// the normal tilted by the relief's slope along the surface. Never deeper than without. m, any one frame. Any thread.
[[nodiscard]] Carved carved(const Relief& relief, double depth, Vec3d normal) noexcept;

// Tables: made outside the loop. They allocate, are deterministic and may be called by any thread.

/// A relief of noise.
struct NoiseOptions {
    std::uint64_t seed = 1;
    double amplitude = 0.0002;  ///< m, standard deviation of the relief
    double wavelength = 0.002;  ///< m, the shortest one kept
    std::uint32_t n = 32;       ///< values along a side; the relief repeats after n wavelength / 2
};
/// Gaussian noise (section 6.3), solid. values is filled with the table, n^3, and has to outlive the texture.
[[nodiscard]] Texture gaussian_texture(const NoiseOptions& options, std::vector<float>& values);

/// From an image of n by n grey values (0 deep, 255 the surface), row by row, each pixel step metres wide. Planar.
/// An image whose edges do not match has a seam there.
struct ImageOptions {
    double depth = 0.0005;  ///< m, of black
    double step = 0.001;    ///< m a pixel
};
/// No texture (n 0) where the image is not square.
[[nodiscard]] Texture image_texture(std::span<const std::uint8_t> grey, const ImageOptions& options, std::vector<float>& values);

/// Procedural: height(x, y, z), m, over the unit cube, periodic in each. Sampled once, solid; positive and non-finite heights
/// become zero.
[[nodiscard]] Texture procedural_texture(double (*height)(double, double, double), std::uint32_t n, double step,
                                         std::vector<float>& values);

}  // namespace sqmap::haptic
