// PNG (RFC 2083) around a zlib stream: compressed, or without zlib of stored blocks (RFC 1950, RFC 1951).
#include "common/render/png.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string_view>

#if SQMAP_WITH_ZLIB
#include <zlib.h>
#endif

namespace sqmap::app {
namespace {

void put_number(std::string& out, std::uint32_t value)
{
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 255);
}

std::uint32_t crc_of(std::string_view bytes)
{
    std::uint32_t crc = ~0u;
    for (const char byte : bytes) {
        crc ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
    }
    return ~crc;
}

void put_chunk(std::string& out, const std::string& kind, const std::string& content)
{
    put_number(out, static_cast<std::uint32_t>(content.size()));
    out += kind + content;
    put_number(out, crc_of(kind + content));
}

#if SQMAP_WITH_ZLIB

std::string zlib_stream(const std::string& bytes)
{
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string out(size, '\0');
    if (compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                 static_cast<uLong>(bytes.size())) != Z_OK)
        throw ImageError("a picture cannot be written: zlib has no memory");
    out.resize(size);
    return out;
}

#else

std::uint32_t adler_of(std::string_view bytes)
{
    std::uint32_t a = 1, b = 0;
    for (const char byte : bytes) {
        a = (a + static_cast<unsigned char>(byte)) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

std::string zlib_stream(std::string_view bytes)
{
    constexpr std::size_t k_block = 65535;
    std::string out("\x78\x01", 2);
    for (std::size_t at = 0; at < bytes.size(); at += k_block) {
        const std::size_t size = std::min(k_block, bytes.size() - at);
        const auto low = static_cast<char>(size & 255), high = static_cast<char>(size >> 8);
        out += at + size == bytes.size() ? '\1' : '\0';
        out += {low, high, static_cast<char>(~low), static_cast<char>(~high)};
        out += bytes.substr(at, size);
    }
    put_number(out, adler_of(bytes));
    return out;
}

#endif

/// A row behind the number of its filter: as it is, less the pixel to the left, or less the row above, whichever leaves the least
/// sum of magnitudes, which as a rule compresses best.
std::string filtered(std::span<const unsigned char> row, std::span<const unsigned char> above, std::size_t pixel)
{
    std::string best;
    long least = 0;
    for (char filter = 0; filter < (above.empty() ? 2 : 3); ++filter) {
        std::string line(1, filter);
        long sum = 0;
        for (std::size_t i = 0; i < row.size(); ++i) {
            const int less = filter == 0 ? 0 : filter == 2 ? above[i] : i < pixel ? 0 : row[i - pixel];
            const auto left = static_cast<signed char>(row[i] - less);
            line += static_cast<char>(left);
            sum += std::abs(left);
        }
        if (!best.empty() && sum >= least) continue;
        best = std::move(line);
        least = sum;
    }
    return best;
}

}  // namespace

std::string png_bytes(const Pixels& pixels)
{
    if (pixels.width == 0 || pixels.height == 0) throw ImageError("a picture cannot be written: it has no pixels");
    const bool is_grey = pixels.format == PngFormat::GreyAlpha16;
    const std::size_t pixel = is_grey ? 4 : 3, row = pixel * pixels.width;
    std::string rows;
    for (std::size_t y = 0; y < pixels.height; ++y)
        rows += filtered(pixels.bytes.subspan(y * row, row),
                         y > 0 ? pixels.bytes.subspan((y - 1) * row, row) : decltype(pixels.bytes){}, pixel);
    std::string head;
    put_number(head, pixels.width);
    put_number(head, pixels.height);
    head += is_grey ? std::string{16, 4} : std::string{8, 2};  // bits of a channel, channels
    head += {0, 0, 0};                                         // deflate, adaptive filters, not interlaced
    std::string out("\x89PNG\r\n\x1a\n", 8);
    put_chunk(out, "IHDR", head);
    if (!is_grey) put_chunk(out, "sRGB", {'\0'});  // perceptual
    put_chunk(out, "IDAT", zlib_stream(rows));
    put_chunk(out, "IEND", "");
    return out;
}

}  // namespace sqmap::app
