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

/// Trilinear value in units of FieldView::step. @pre p is clamped to the grid.
inline Floats look_up(const Samples& samples, Cells p)
{
    const std::int32_t dy = samples.count, dz = dy * dy;
    const Ints cx = ints(p.x), cy = ints(p.y), cz = ints(p.z);
    const Floats fx = p.x - floats(cx), fy = p.y - floats(cy), fz = p.z - floats(cz);
    const Ints index = cx + dy * cy + dz * cz;
    const auto row = [&](std::int32_t shift) {
        const Ints pair = gather_pairs(samples.values + shift, index);
        const Floats low = floats((pair << 16) >> 16), high = floats(pair >> 16);
        return low + fx * (high - low);
    };
    const Floats r00 = row(0), r10 = row(dy), r01 = row(dz), r11 = row(dz + dy);
    const Floats near = r00 + fy * (r10 - r00), far = r01 + fy * (r11 - r01);
    return near + fz * (far - near);
}

/// Bit i: sphere i may hold a point of negative distance.
inline std::uint32_t near_spheres(const FieldView& field, const CellPose& pose, const SphereBlock& block, float last)
{
    const Cells p = to_cells(pose, load(block.x), load(block.y), load(block.z));
    const Floats radius = load(block.radius);
    const Cells q{clamp(p.x, last), clamp(p.y, last), clamp(p.z, last)};
    const Floats ex = (p.x - q.x) * field.spacing[0], ey = (p.y - q.y) * field.spacing[1], ez = (p.z - q.z) * field.spacing[2];
    // Of a sphere whose centre is outside the box, what lies inside is within its radius of the clamped centre, too.
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

/// Three sweeps, each over a list that the one before has packed: no branch waits for a look-up, so that the look-ups of
/// many blocks are under way at once.
inline std::uint32_t run(const FieldView& field, const ProbeView& probe, const CellPose& pose, const ContactRoom& room)
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
        const Floats distance = look_up(field.fine, q) * field.step;
        std::uint32_t inside = mask_of((distance < 0.0f) & (p.x == q.x) & (p.y == q.y) & (p.z == q.z));
        inside &= c == probe.last_block ? (1u << probe.last_lanes) - 1 : 0xffffu;
#if defined(__AVX512F__)
        const auto lanes = static_cast<__mmask16>(inside);
        _mm512_storeu_si512(room.vertex + count, _mm512_maskz_compress_epi32(lanes, _mm512_load_si512(block.vertex)));
        _mm512_storeu_ps(room.depth + count, _mm512_maskz_compress_ps(lanes, (__m512)-distance));
        count += static_cast<std::uint32_t>(__builtin_popcount(inside));
#else
        for (; inside != 0; inside &= inside - 1) {
            const auto lane = static_cast<std::uint32_t>(__builtin_ctz(inside));
            room.vertex[count] = block.vertex[lane];
            room.depth[count++] = -distance[lane];
        }
#endif
    }
    return count;
}

}  // namespace
}  // namespace sqmap::bench
