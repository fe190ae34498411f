// Words of the central map: samples, cells, splits, layered records, certified deviations. Each is written and read here.
#pragma once

#include "model/chart.h"
#include "sqmap/model/model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace sqmap::model {

inline constexpr int k_block = 2;                    ///< base cells along the side of a block of the pyramid
inline constexpr int k_max_split_depth = 4;          ///< a base cell is halved at most this often
inline constexpr int k_max_sheets = 7;               ///< surfaces along one ray that a layered cell tells apart
inline constexpr std::size_t k_max_payload = 16384;  ///< splits, and specials, of a part

inline constexpr std::uint16_t k_no_surface = 0xffff;  ///< a base sample whose ray meets no surface
inline constexpr Block k_empty_block{0xffff, 0};

/// How w is stored in 16 bits: v means w_min + w_step v.
struct SampleRange {
    float w_min = 0, w_step = 1;

    /// A little more than from lo to hi: samples beyond the chart's domain are kept for interpolation.
    static SampleRange around(double lo, double hi)
    {
        return {static_cast<float>(0.9 * lo), static_cast<float>((1.1 * hi - 0.9 * lo) / 65000.0)};
    }
    /// True where all of lo to hi can be stored.
    bool holds(double lo, double hi) const
    {
        const auto least = static_cast<double>(w_min);
        return 0.95 * lo >= least && 1.05 * hi <= least + 65000.0 * static_cast<double>(w_step);
    }

    float decode(std::uint16_t v) const { return w_min + w_step * static_cast<float>(v); }
    std::uint16_t encode(double w) const { return clamped(std::nearbyint(steps(w))); }
    /// Not above w, whatever rounding does.
    std::uint16_t encode_down(double w) const { return clamped(std::floor(steps(w) - 0.01)); }
    std::uint16_t encode_up(double w) const { return clamped(std::ceil(steps(w) + 0.01)); }

    /// The code of a slope. gain: by which a plane's w grows over half a cell.
    std::uint16_t encode_slope(double gain) const
    {
        const double v = std::clamp(std::nearbyint(gain / static_cast<double>(w_step)), -32767.0, 32767.0);
        return static_cast<std::uint16_t>(static_cast<std::int16_t>(v));
    }

private:
    double steps(double w) const { return (w - static_cast<double>(w_min)) / static_cast<double>(w_step); }
    static std::uint16_t clamped(double v) { return static_cast<std::uint16_t>(std::clamp(v, 0.0, 65534.0)); }
};
/// In steps of w; see SampleRange::encode_slope.
constexpr float decode_slope(std::uint16_t stored) { return static_cast<float>(static_cast<std::int16_t>(stored)); }

/// Steps of the terms beside the samples, for the largest value that occurs.
inline float offset_step(double largest) { return static_cast<float>(largest / 255 * (1 + 1e-6)); }
inline float smoothing_step(double largest) { return static_cast<float>(largest / 127 * (1 + 1e-6)); }
/// Rounded up.
inline std::uint8_t encode_offset(double value, float step)
{
    return step > 0 ? static_cast<std::uint8_t>(std::min(std::ceil(value / static_cast<double>(step)), 255.0)) : std::uint8_t{0};
}
inline std::int8_t encode_smoothing(double value, float step)
{
    return step > 0 ? static_cast<std::int8_t>(std::lround(std::clamp(value / static_cast<double>(step), -127.0, 127.0)))
                    : std::int8_t{0};
}

/// How a stored cell is read: two bits of kind, fourteen of payload.
enum class CellKind : std::uint32_t {
    Uniform = 0,  ///< no surface; the payload is the verdict
    Single = 1,   ///< one surface over the four corner samples; the payload holds the code of its certified deviation
    Split = 2,    ///< the payload is an index of splits
    Layered = 3,  ///< the payload is an index of specials, which points at a layered record in the pool
};

/// A stored cell. foreign: no surface over the cell is the part's own; it serves verdicts, while depth and normal are the
/// business of the part that owns the surface.
struct CentralCell {
    std::uint16_t word = 0;

    constexpr CellKind kind() const { return static_cast<CellKind>(word >> k_payload_bits); }
    constexpr std::uint32_t payload() const { return word & ((1u << k_payload_bits) - 1u); }
    constexpr bool inside() const { return (payload() & 1u) != 0; }               ///< Uniform
    constexpr std::uint32_t deviation_code() const { return payload() & 0xffu; }  ///< Single
    constexpr bool foreign() const { return (payload() & k_foreign) != 0; }       ///< Single
    /// False of a Uniform or Single cell with bits that mean nothing.
    constexpr bool has_valid_bits() const
    {
        return kind() == CellKind::Uniform ? payload() <= 1 : kind() != CellKind::Single || payload() < 2 * k_foreign;
    }

    static constexpr CentralCell of(CellKind kind, std::size_t payload)
    {
        return {
            static_cast<std::uint16_t>(static_cast<std::uint32_t>(kind) << k_payload_bits | static_cast<std::uint32_t>(payload))};
    }
    static constexpr CentralCell uniform(bool inside) { return of(CellKind::Uniform, inside ? 1 : 0); }
    static constexpr CentralCell single(std::uint32_t deviation_code, bool foreign)
    {
        return of(CellKind::Single, deviation_code | (foreign ? k_foreign : 0u));
    }

    static constexpr int k_payload_bits = 14;
    static constexpr std::uint32_t k_foreign = 0x100;
};

/// First word of a layered record. Bilinear: five words a sheet follow, four corner samples and the code of the certified
/// deviation. Mixed: the certified least and greatest w follow, and three words a sheet: w at the cell's middle and its slopes. A
/// mixed cell may be divided by a silhouette: the word after the band names the line, and the second side's sheets come last.
struct LayeredHead {
    std::uint16_t word = 0;

    constexpr int sheets() const { return word & 7; }
    constexpr bool bilinear() const { return (word & k_bilinear) != 0; }
    constexpr bool divided() const { return (word & k_divided) != 0; }
    constexpr bool foreign() const { return (word & CentralCell::k_foreign) != 0; }
    constexpr int second_sheets() const { return (word >> k_second_shift) & 7; }  ///< divided: right of the line
    /// Words before a mixed record's first sheet.
    constexpr std::uint32_t head_size() const { return divided() ? 4 : 3; }
    /// Words of the whole record.
    constexpr std::uint32_t record_size() const
    {
        if (bilinear()) return 1 + k_bilinear_size * static_cast<std::uint32_t>(sheets());
        return head_size() + k_plane_size * static_cast<std::uint32_t>(sheets() + (divided() ? second_sheets() : 0));
    }

    static constexpr LayeredHead of_bilinear(int sheets, bool foreign) { return {bits(sheets, foreign, k_bilinear)}; }
    static constexpr LayeredHead of_mixed(int sheets, bool foreign) { return {bits(sheets, foreign, 0)}; }
    static constexpr LayeredHead of_divided(int sheets, int second, bool foreign)
    {
        return {bits(sheets, foreign, k_divided | static_cast<std::uint32_t>(second) << k_second_shift)};
    }

    static constexpr std::uint32_t k_bilinear = 0x8, k_divided = 0x10;
    static constexpr int k_second_shift = 5;
    static constexpr std::uint32_t k_bilinear_size = 5, k_plane_size = 3;

private:
    static constexpr std::uint16_t bits(int sheets, bool foreign, std::uint32_t rest)
    {
        return static_cast<std::uint16_t>(static_cast<std::uint32_t>(sheets) | rest | (foreign ? CentralCell::k_foreign : 0u));
    }
};

/// The j-th sheet of a bilinear record whose first word is passed.
constexpr const std::uint16_t* bilinear_sheet(const std::uint16_t* sheets, int j)
{
    return sheets + LayeredHead::k_bilinear_size * static_cast<std::uint32_t>(j);
}

/// A position on the border of a cell: 64 steps a side, from the corner of least s and t towards greater s and around.
struct BorderPoint {
    float u, v;  ///< in the cell, from 0 to 1
};
constexpr BorderPoint border_point(std::uint32_t code)
{
    const float f = static_cast<float>(code & 63u) / 64.f;
    switch ((code >> 6) & 3u) {
        case 0:
            return {f, 0.f};
        case 1:
            return {1.f, f};
        case 2:
            return {1.f - f, 1.f};
        default:
            return {0.f, 1.f - f};
    }
}
/// The line of a divided cell: left of the direction from its first border point to its second the first sheets hold.
struct BorderLine {
    BorderPoint from, to;
};
constexpr BorderLine border_line(std::uint16_t word) { return {border_point(word >> 8), border_point(word & 0xffu)}; }
constexpr std::uint16_t border_line_word(std::uint32_t from, std::uint32_t to)
{
    return static_cast<std::uint16_t>(from << 8 | to);
}

/// A split cell's record: of three by three samples the five that are not the cell's own corners, row by row, and the four cells
/// between them.
inline constexpr std::uint32_t k_split_cells = 5;
static_assert(k_split_size == k_split_cells + 4);
inline constexpr std::array<int, k_split_cells> k_split_samples{1, 3, 4, 5, 7};

/// Certified deviation of a bilinear surface, in w. Codes grow with it, by an eighth of an octave or less.
template <class Real>
inline Real deviation_of_code(std::uint32_t code, Real w_step)
{
    return std::ldexp((Real(8) + static_cast<Real>(code & 7u)) * Real(0.03125) * w_step, static_cast<int>(code >> 3));
}
/// The values of all codes; finds the code of a value.
class DeviationCodes {
public:
    explicit DeviationCodes(float w_step)
    {
        for (std::uint32_t code = 0; code < values_.size(); ++code)
            values_[code] = deviation_of_code(code, static_cast<double>(w_step));
    }
    double operator[](std::uint32_t code) const { return values_[code]; }
    /// The least code of at least value; none where it is too large.
    std::optional<std::uint16_t> at_least(double value) const
    {
        const auto found = std::lower_bound(values_.begin(), values_.end(), value);
        if (found == values_.end()) return std::nullopt;
        return static_cast<std::uint16_t>(found - values_.begin());
    }

private:
    std::array<double, 256> values_{};
};

}  // namespace sqmap::model
