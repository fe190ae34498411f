// Body of the kernel. Everything here has internal linkage: each including file is compiled with other flags.
#include "dense_simd_kernel.h"

#include <cstring>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace sqmap::bench {
namespace {

// GCC's vectors: sixteen lanes whatever the machine has.
typedef float Floats __attribute__((vector_size(64)));
typedef std::int32_t Ints __attribute__((vector_size(64)));

inline Floats load(const float* p)
{
    Floats v;
    std::memcpy(&v, p, sizeof v);
    return v;
}
inline Floats all(float value) { return Floats{} + value; }
inline Floats floats(Ints v) { return __builtin_convertvector(v, Floats); }
inline Ints ints(Floats v) { return __builtin_convertvector(v, Ints); }
inline Floats bits(Ints v)
{
    Floats f;
    std::memcpy(&f, &v, sizeof f);
    return f;
}
inline Ints bits(Floats v)
{
    Ints i;
    std::memcpy(&i, &v, sizeof i);
    return i;
}

inline Floats clamp(Floats v, float hi)
{
#if defined(__AVX512F__)
    return (Floats)_mm512_min_ps(_mm512_max_ps((__m512)v, _mm512_setzero_ps()), _mm512_set1_ps(hi));
#else
    const Floats low = bits(bits(v) & (v > 0.0f));
    const Ints above = low > hi;
    return bits((bits(all(hi)) & above) | (bits(low) & ~above));
#endif
}

/// Bit i: lane i of a comparison's result.
inline std::uint32_t mask_of(Ints comparison)
{
#if defined(__AVX512F__)
    return _mm512_movepi32_mask((__m512i)comparison);
#elif defined(__AVX2__)
    __m256 half[2];
    std::memcpy(half, &comparison, sizeof half);
    return static_cast<std::uint32_t>(_mm256_movemask_ps(half[0])) | static_cast<std::uint32_t>(_mm256_movemask_ps(half[1])) << 8;
#else
    std::uint32_t mask = 0;
    for (std::uint32_t i = 0; i < k_lanes; ++i) mask |= (comparison[i] != 0 ? 1u : 0u) << i;
    return mask;
#endif
}

/// values[index] in the low half of a lane, values[index + 1] in the high half.
inline Ints gather_pairs(const std::int16_t* values, Ints index)
{
#if defined(__AVX512F__)
    return (Ints)_mm512_i32gather_epi32((__m512i)index, values, 2);
#elif defined(__AVX2__)
    __m256i half[2];
    std::memcpy(half, &index, sizeof half);
    half[0] = _mm256_i32gather_epi32(reinterpret_cast<const int*>(values), half[0], 2);
    half[1] = _mm256_i32gather_epi32(reinterpret_cast<const int*>(values), half[1], 2);
    Ints out;
    std::memcpy(&out, half, sizeof out);
    return out;
#else
    Ints out;
    for (std::uint32_t i = 0; i < k_lanes; ++i) {
        std::int32_t pair;
        std::memcpy(&pair, values + index[i], sizeof pair);
        out[i] = pair;
    }
    return out;
#endif
}

struct Cells {
    Floats x, y, z;
};

inline Cells to_cells(const CellPose& pose, Floats x, Floats y, Floats z)
{
    const auto row = [&](const float* m) { return x * m[0] + (y * m[1] + (z * m[2] + m[3])); };
    return {row(pose.m[0]), row(pose.m[1]), row(pose.m[2])};
}

/// Differences along the axes, cell by cell.
struct Gradient {
    Floats x, y, z;
};

/// Trilinear value in units of FieldView::step. @pre p is clamped to the grid.
template <bool with_gradient = false>
inline Floats look_up(const Samples& samples, Cells p, Gradient* gradient = nullptr)
{
    const std::int32_t dy = samples.count, dz = dy * dy;
    const Ints cx = ints(p.x), cy = ints(p.y), cz = ints(p.z);
    const Floats fx = p.x - floats(cx), fy = p.y - floats(cy), fz = p.z - floats(cz);
    const Ints index = cx + dy * cy + dz * cz;
    struct Row {
        Floats value, rise;
    };
    const auto row = [&](std::int32_t shift) -> Row {
        const Ints pair = gather_pairs(samples.values + shift, index);
        const Floats low = floats((pair << 16) >> 16), rise = floats(pair >> 16) - low;
        return {low + fx * rise, rise};
    };
    const Row r00 = row(0), r10 = row(dy), r01 = row(dz), r11 = row(dz + dy);
    const Floats near_rise = r10.value - r00.value, far_rise = r11.value - r01.value;
    const Floats near = r00.value + fy * near_rise, rise = r01.value + fy * far_rise - near;
    if constexpr (with_gradient) {
        const Floats near_x = r00.rise + fy * (r10.rise - r00.rise), far_x = r01.rise + fy * (r11.rise - r01.rise);
        *gradient = {near_x + fz * (far_x - near_x), near_rise + fz * (far_rise - near_rise), rise};
    }
    return near + fz * rise;
}

/// Bit i: sphere i may hold a point of negative distance.
inline std::uint32_t near_spheres(const FieldView& field, const CellPose& pose, const SphereBlock& block, float last)
{
    const Cells p = to_cells(pose, load(block.x), load(block.y), load(block.z));
    const Floats radius = load(block.radius);
    const Cells q{clamp(p.x, last), clamp(p.y, last), clamp(p.z, last)};
    const Floats ex = (p.x - q.x) * field.spacing[0], ey = (p.y - q.y) * field.spacing[1], ez = (p.z - q.z) * field.spacing[2];
    // If a sphere's centre is outside the box, its part inside is also within its radius of the clamped centre.
    const Floats outside_sq = ex * ex + ey * ey + ez * ez;
    const float scale = field.per_stride;
    const Floats distance = look_up(field.coarse, {q.x * scale, q.y * scale, q.z * scale}) * field.step;
    const Ints near = (outside_sq <= radius * radius) & (distance <= load(block.reach)) & (radius >= 0.0f);
    return mask_of(near);
}

/// Appends the numbers from first on whose bit of mask is set; writes up to a block beyond.
inline std::uint32_t append(std::uint32_t* list, std::uint32_t count, std::uint32_t mask, std::uint32_t first)
{
#if defined(__AVX512F__)
    const __m512i numbers = _mm512_add_epi32(_mm512_set1_epi32(static_cast<int>(first)),
                                             _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    _mm512_storeu_si512(list + count, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), numbers));
    return count + static_cast<std::uint32_t>(__builtin_popcount(mask));
#else
    for (; mask != 0; mask &= mask - 1) list[count++] = first + static_cast<std::uint32_t>(__builtin_ctz(mask));
    return count;
#endif
}

inline Floats reciprocal_root(Floats v)
{
#if defined(__AVX512F__)
    // Fourteen bits and one step of Newton's.
    const Floats guess = (Floats)_mm512_rsqrt14_ps((__m512)v);
    return guess * (1.5f - 0.5f * v * guess * guess);
#else
    Floats out;
    for (std::uint32_t i = 0; i < k_lanes; ++i) out[i] = 1 / __builtin_sqrtf(v[i]);
    return out;
#endif
}

/// The lanes of mask, packed; writes up to a block beyond.
inline void pack(float* out, Floats values, std::uint32_t mask)
{
#if defined(__AVX512F__)
    _mm512_storeu_ps(out, _mm512_maskz_compress_ps(static_cast<__mmask16>(mask), (__m512)values));
#else
    for (; mask != 0; mask &= mask - 1) *out++ = values[__builtin_ctz(mask)];
#endif
}

/// Three sweeps, each over a list that the one before has packed: no branch waits for a look-up, so that the look-ups of
/// many blocks are under way at once.
template <bool with_normal>
inline std::uint32_t sweep(const FieldView& field, const ProbeView& probe, const CellPose& pose,
                           const ContactWorkspace& workspace)
{
    // The largest coordinate that still lies in the last cell.
    const float last = static_cast<float>(field.fine.count - 1) * (1 - 1e-6f);
    std::uint32_t group_count = 0, cluster_count = 0, count = 0;
    for (std::uint32_t b = 0; b < probe.group_blocks; ++b)
        group_count = append(probe.group_list, group_count, near_spheres(field, pose, probe.groups[b], last), k_lanes * b);
    for (std::uint32_t i = 0; i < group_count; ++i) {
        const std::uint32_t g = probe.group_list[i];
        cluster_count =
            append(probe.cluster_list, cluster_count, near_spheres(field, pose, probe.clusters[g], last), k_lanes * g);
    }
    for (std::uint32_t i = 0; i < cluster_count; ++i) {
        const std::uint32_t c = probe.cluster_list[i];
        const VertexBlock& block = probe.vertices[c];
        const Cells p = to_cells(pose, load(block.x), load(block.y), load(block.z));
        const Cells q{clamp(p.x, last), clamp(p.y, last), clamp(p.z, last)};
        Gradient gradient;
        const Floats distance = look_up<with_normal>(field.fine, q, &gradient) * field.step;
        std::uint32_t inside = mask_of((distance < 0.0f) & (p.x == q.x) & (p.y == q.y) & (p.z == q.z));
        inside &= c == probe.last_block ? (1u << probe.last_lanes) - 1 : 0xffffu;
        Floats vertex;
        std::memcpy(&vertex, block.vertex, sizeof vertex);
        pack(reinterpret_cast<float*>(workspace.vertex + count), vertex, inside);
        pack(workspace.depth + count, -distance, inside);
        if constexpr (with_normal) {
            if (inside == 0) continue;
            const Floats x = gradient.x / field.spacing[0], y = gradient.y / field.spacing[1], z = gradient.z / field.spacing[2];
            const Floats scale = reciprocal_root(x * x + y * y + z * z + 1e-30f);
            pack(workspace.normal[0] + count, x * scale, inside);
            pack(workspace.normal[1] + count, y * scale, inside);
            pack(workspace.normal[2] + count, z * scale, inside);
        }
        count += static_cast<std::uint32_t>(__builtin_popcount(inside));
    }
    return count;
}

inline std::uint32_t run(const FieldView& field, const ProbeView& probe, const CellPose& pose, const ContactWorkspace& workspace)
{
    return workspace.normal[0] != nullptr ? sweep<true>(field, probe, pose, workspace)
                                          : sweep<false>(field, probe, pose, workspace);
}

}  // namespace
}  // namespace sqmap::bench
