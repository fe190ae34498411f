// PNG without libpng, which emscripten does not bring: the texels are stored, not compressed (RFC 1950, RFC 1951, RFC 2083).
#include "common/render/png.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

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

std::uint32_t adler_of(std::string_view bytes)
{
    std::uint32_t a = 1, b = 0;
    for (const char byte : bytes) {
        a = (a + static_cast<unsigned char>(byte)) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

void put_chunk(std::string& out, const std::string& kind, const std::string& content)
{
    put_number(out, static_cast<std::uint32_t>(content.size()));
    out += kind + content;
    put_number(out, crc_of(kind + content));
}

/// A zlib stream of stored blocks.
std::string stored(std::string_view bytes)
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

}  // namespace

std::string png_bytes(const Pixels& pixels)
{
    const bool is_grey = pixels.format == PngFormat::GreyAlpha16;
    const std::size_t row = (is_grey ? 4 : 3) * static_cast<std::size_t>(pixels.width);
    std::string rows;
    for (std::size_t at = 0; at < pixels.bytes.size(); at += row) {
        rows += '\0';  // no filter
        rows.append(reinterpret_cast<const char*>(&pixels.bytes[at]), row);
    }
    std::string head;
    put_number(head, pixels.width);
    put_number(head, pixels.height);
    head += is_grey ? std::string{16, 4} : std::string{8, 2};  // bits of a channel, channels
    head += {0, 0, 0};                                         // deflate, adaptive filters, not interlaced
    std::string out("\x89PNG\r\n\x1a\n", 8);
    put_chunk(out, "IHDR", head);
    put_chunk(out, "IDAT", stored(rows));
    put_chunk(out, "IEND", "");
    return out;
}

}  // namespace sqmap::app
