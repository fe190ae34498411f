// Distances differ by at most a step between neighbours, which bounds every search by the answer beside it, and a sign
// can only change where two neighbouring distances together are no longer than the step: winding numbers are counted
// there and nowhere else.
#include "distance_grid.h"

#include "clock.h"
#include "io/replace_file.h"
#include "method.h"
#include "parallel/for_each.h"
#include "sqmap/io/model_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>

namespace sqmap::bench {
namespace {

constexpr std::uint64_t k_version = 1;  // of the cached files: count up when values or layout change

void fill_slab(const mesh::Solid& solid, DistanceGrid& grid, std::uint32_t k)
{
    const std::uint32_t n = grid.samples;
    const auto point = [&](std::uint32_t i, std::uint32_t j) {
        return Vec3d{grid.lo.x + i * grid.spacing.x, grid.lo.y + j * grid.spacing.y, grid.lo.z + k * grid.spacing.z};
    };
    double row_start = std::numeric_limits<double>::infinity();  // unsigned distance at (0, j - 1)
    bool row_inside = false;
    for (std::uint32_t j = 0; j < n; ++j) {
        double last = row_start, step = grid.spacing.y;
        bool inside = row_inside;
        for (std::uint32_t i = 0; i < n; ++i) {
            const Vec3d p = point(i, j);
            // A bounded search finds nothing at exactly the bound.
            const double distance = solid.closest_boundary(p, (last + step) * (1 + 1e-9) + 1e-12).distance;
            if (!(distance + last > step * (1 + 1e-9)) || (i == 0 && j == 0)) inside = solid.inside(p);
            grid.values[grid.index(i, j, k)] = static_cast<float>(inside ? -distance : distance);
            if (i == 0) {
                row_start = distance;
                row_inside = inside;
                step = grid.spacing.x;
            }
            last = distance;
        }
    }
}

std::filesystem::path cache_file(const Setting& setting, std::uint32_t samples)
{
    if (setting.cache.empty()) return {};
    Hash hash;
    hash.add(k_version);
    hash.add(samples);
    for (const Vec3d& v : setting.object.vertices)
        for (int k = 0; k < 3; ++k) hash.add(std::bit_cast<std::uint64_t>(v[k]));
    for (const mesh::Triangle& t : setting.object.triangles)
        for (const std::uint32_t v : t) hash.add(v);
    char name[64];
    std::snprintf(name, sizeof name, "distances-%u-%016llx.bin", samples, static_cast<unsigned long long>(hash.value()));
    return setting.cache / name;
}

/// build_s, the values, and a hash of both: a file cut short or overwritten is made again.
std::uint64_t content_hash(const DistanceGrid& grid)
{
    Hash hash;
    hash.add(std::bit_cast<std::uint64_t>(grid.build_s));
    for (std::size_t i = 0; i + 1 < grid.values.size(); i += 2) {
        std::uint64_t word;
        std::memcpy(&word, &grid.values[i], sizeof word);
        hash.add(word);
    }
    return hash.value();
}

bool read_cache(const std::filesystem::path& path, DistanceGrid& grid)
{
    std::ifstream in(path, std::ios::binary);
    std::uint64_t hash = 0;
    const auto size = static_cast<std::streamsize>(grid.values.size() * sizeof(float));
    return in.read(reinterpret_cast<char*>(&hash), sizeof hash) &&
           in.read(reinterpret_cast<char*>(&grid.build_s), sizeof grid.build_s) &&
           in.read(reinterpret_cast<char*>(grid.values.data()), size) && in.peek() == std::ifstream::traits_type::eof() &&
           hash == content_hash(grid);
}

/// Keeps the grid for the next run; keeps nothing if the file cannot be written.
void write_cache(const std::filesystem::path& path, const DistanceGrid& grid)
try {
    std::filesystem::create_directories(path.parent_path());
    const std::uint64_t hash = content_hash(grid);
    const std::size_t size = grid.values.size() * sizeof(float);
    std::vector<std::byte> bytes(sizeof hash + sizeof grid.build_s + size);
    std::memcpy(bytes.data(), &hash, sizeof hash);
    std::memcpy(bytes.data() + sizeof hash, &grid.build_s, sizeof grid.build_s);
    std::memcpy(bytes.data() + sizeof hash + sizeof grid.build_s, grid.values.data(), size);
    io::replace_file(path, bytes);
} catch (const std::filesystem::filesystem_error&) {
} catch (const io::ModelFileError&) {
}

}  // namespace

double signed_distance(const mesh::Solid& solid, Vec3d p)
{
    const double distance = solid.closest_boundary(p).distance;
    return solid.inside(p) ? -distance : distance;
}

DistanceGrid distance_grid(const Setting& setting, std::uint32_t samples)
{
    DistanceGrid grid;
    grid.samples = samples;
    grid.values.resize(std::size_t{samples} * samples * samples);
    Vec3d lo = setting.object.vertices.front(), hi = lo;
    for (const Vec3d& v : setting.object.vertices)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], v[k]);
            hi[k] = std::max(hi[k], v[k]);
        }
    constexpr double k_margin_cells = 1.5;
    grid.spacing = (hi - lo) / (samples - 1 - 2 * k_margin_cells);
    grid.lo = lo - k_margin_cells * grid.spacing;
    const std::filesystem::path cached = cache_file(setting, samples);
    if (!cached.empty() && read_cache(cached, grid)) return grid;

    const double start = process_seconds();
    parallel::for_each(samples, setting.threads,
                       [&](std::size_t k) { fill_slab(setting.solid, grid, static_cast<std::uint32_t>(k)); });
    grid.build_s = process_seconds() - start;
    if (!cached.empty()) write_cache(cached, grid);
    return grid;
}

bool interpolate(const DistanceGrid& grid, Vec3d p, double& value)
{
    std::uint32_t cell[3];
    double f[3];
    for (int k = 0; k < 3; ++k) {
        const double g = (p[k] - grid.lo[k]) / grid.spacing[k];
        if (!(g >= 0 && g <= grid.samples - 1)) return false;
        cell[k] = std::min(static_cast<std::uint32_t>(g), grid.samples - 2);
        f[k] = g - cell[k];
    }
    const float* v = &grid.values[grid.index(cell[0], cell[1], cell[2])];
    const std::size_t dy = grid.samples, dz = dy * dy;
    const auto row = [&](const float* r) { return r[0] + f[0] * (r[1] - r[0]); };
    const auto face = [&](const float* r) { return row(r) + f[1] * (row(r + dy) - row(r)); };
    value = face(v) + f[2] * (face(v + dz) - face(v));
    return true;
}

}  // namespace sqmap::bench
