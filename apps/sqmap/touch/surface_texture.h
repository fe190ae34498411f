// --texture: words to a relief (eq. 34).
#pragma once

#include "sqmap/haptic/texture.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::app {

struct TextureOptions {
    std::string kind = "none";  ///< none, gaussian, image:FILE, or the name of a procedural one
    double depth = 0.0004;      ///< m: of black, of a procedure's deepest; Gaussian noise: twice the standard deviation
    double wavelength = 0.003;  ///< m: shortest of the noise, period of a procedure; of an image: a pixel
    std::uint64_t seed = 1;
};

/// A texture that owns its table. n of the texture is 0 for none.
struct SurfaceTexture {
    std::vector<float> values;
    haptic::Texture texture;
    std::uint64_t hash = 0;  ///< of the table; 0: none
};

/// @throw BadTouch for kinds that are not there and images that cannot be read. beside: see TouchSetup.
[[nodiscard]] SurfaceTexture make_texture(const TextureOptions& options, const std::filesystem::path& beside);

}  // namespace sqmap::app
