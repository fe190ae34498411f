#include "common/render/png.h"

#include <png.h>

namespace sqmap::app {
namespace {

void append(png_structp png, png_bytep bytes, std::size_t count)
{
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

}  // namespace

std::string png_bytes(const Pixels& pixels)
{
    const bool is_grey = pixels.format == PngFormat::GreyAlpha16;
    std::string out;
    // Errors end in an exception of ours instead of a jump over what is to be destroyed.
    const auto fail = [](png_structp, png_const_charp why) {
        throw ImageError(std::string("a picture cannot be written: ") + why);
    };
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, [](png_structp, png_const_charp) {});
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr) throw ImageError("libpng has no memory");
    try {
        png_set_write_fn(png, &out, append, [](png_structp) {});
        png_set_IHDR(png, info, pixels.width, pixels.height, is_grey ? 16 : 8,
                     is_grey ? PNG_COLOR_TYPE_GRAY_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                     PNG_FILTER_TYPE_DEFAULT);
        if (!is_grey) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
        png_write_info(png, info);
        const std::size_t row = png_get_rowbytes(png, info);
        for (std::size_t y = 0; y < pixels.height; ++y) png_write_row(png, &pixels.bytes[y * row]);
        png_write_end(png, info);
    } catch (...) {
        png_destroy_write_struct(&png, &info);
        throw;
    }
    png_destroy_write_struct(&png, &info);
    return out;
}

}  // namespace sqmap::app
