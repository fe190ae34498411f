// Pixels as a PNG file, compressed where there is zlib; in WebAssembly there is none.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace sqmap::app {

enum class PngFormat : std::uint8_t {
    Rgb8,         ///< sRGB, a byte a channel
    GreyAlpha16,  ///< two bytes a channel, the higher one first
};

struct Pixels {
    std::uint32_t width = 0, height = 0;
    PngFormat format = PngFormat::Rgb8;
    std::span<const unsigned char> bytes{};  ///< row-major from the top left, without padding
};

class ImageError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// @throw ImageError for a picture without pixels
[[nodiscard]] std::string png_bytes(const Pixels& pixels);

}  // namespace sqmap::app
