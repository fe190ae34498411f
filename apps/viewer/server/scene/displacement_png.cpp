#include "viewer/server/scene/displacement.h"

#include <png.h>

#include <stdexcept>

namespace sqmap::viewer {
namespace {

void append(png_structp png, png_bytep bytes, std::size_t count)
{
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

}  // namespace

std::string displacement_png(const Displacement& map)
{
    const std::vector<png_byte> texels = displacement_texels(map);
    std::string out;
    // Errors end in an exception of ours instead of a jump over what is to be destroyed.
    png_structp png = png_create_write_struct(
        PNG_LIBPNG_VER_STRING, nullptr, [](png_structp, png_const_charp why) { throw std::runtime_error(why); }, nullptr);
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr) throw std::runtime_error("libpng has no memory");
    try {
        png_set_write_fn(png, &out, append, [](png_structp) {});
        png_set_IHDR(png, info, static_cast<png_uint_32>(map.width), static_cast<png_uint_32>(map.height), 16,
                     PNG_COLOR_TYPE_GRAY_ALPHA, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_write_info(png, info);
        for (int row = 0; row < map.height; ++row) png_write_row(png, &texels[static_cast<std::size_t>(4 * row * map.width)]);
        png_write_end(png, info);
    } catch (...) {
        png_destroy_write_struct(&png, &info);
        throw;
    }
    png_destroy_write_struct(&png, &info);
    return out;
}

}  // namespace sqmap::viewer
