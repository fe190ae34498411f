#include "grid.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <cmath>

namespace sqmap::mesh {

std::size_t KeyTable::slot_of(LatticePoint p) const
{
    std::uint64_t h = 0;
    for (const std::int32_t c : p) h = (h ^ static_cast<std::uint32_t>(c)) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
    std::size_t slot = h & (slots_.size() - 1);
    while (slots_[slot] != k_absent && points_[slots_[slot]] != p) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
}

void KeyTable::grow()
{
    slots_.assign(slots_.empty() ? 1024 : 2 * slots_.size(), k_absent);
    for (std::uint32_t i = 0; i < points_.size(); ++i) slots_[slot_of(points_[i])] = i;
}

std::uint32_t KeyTable::insert(LatticePoint p)
{
    if (2 * points_.size() >= slots_.size()) grow();
    std::uint32_t& slot = slots_[slot_of(p)];
    if (slot == k_absent) {
        slot = size();
        points_.push_back(p);
    }
    return slot;
}

std::uint32_t KeyTable::find(LatticePoint p) const { return slots_.empty() ? k_absent : slots_[slot_of(p)]; }

namespace {

constexpr double k_margin = 1e-6;  ///< cells are larger by that, so that a triangle on a side is in both

struct Pair {
    LatticePoint cell;
    std::uint32_t triangle;
    friend bool operator<(const Pair& a, const Pair& b) { return a.cell != b.cell ? a.cell < b.cell : a.triangle < b.triangle; }
};

Vec3d corner_of(LatticePoint p) { return {double(p[0]), double(p[1]), double(p[2])}; }

/// Adds the cells of [lo, hi) that the triangle touches.
void collect(const std::array<Vec3d, 3>& triangle, std::uint32_t index, LatticePoint lo, LatticePoint hi, std::vector<Pair>& out)
{
    constexpr Vec3d k_rim{k_margin, k_margin, k_margin};
    if (!touches(triangle, corner_of(lo) - k_rim, corner_of(hi) + k_rim)) return;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (hi[k] - lo[k] > hi[axis] - lo[axis]) axis = k;
    if (hi[axis] - lo[axis] == 1) {
        out.push_back({lo, index});
        return;
    }
    LatticePoint low_end = hi, high_begin = lo;
    low_end[axis] = high_begin[axis] = lo[axis] + (hi[axis] - lo[axis]) / 2;
    collect(triangle, index, lo, low_end, out);
    collect(triangle, index, high_begin, hi, out);
}

}  // namespace

bool touches(const std::array<Vec3d, 3>& triangle, Vec3d lo, Vec3d hi)
{
    const Vec3d middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    const Vec3d v[3] = {triangle[0] - middle, triangle[1] - middle, triangle[2] - middle};
    for (int k = 0; k < 3; ++k) {
        const auto [least, greatest] = std::minmax({v[0][k], v[1][k], v[2][k]});
        if (least > half[k] || greatest < -half[k]) return false;
    }
    const auto separates = [&](Vec3d n) {
        const auto [least, greatest] = std::minmax({dot(n, v[0]), dot(n, v[1]), dot(n, v[2])});
        const double reach = std::abs(n.x) * half.x + std::abs(n.y) * half.y + std::abs(n.z) * half.z;
        return least > reach || greatest < -reach;
    };
    const Vec3d edges[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
    if (separates(cross(edges[0], edges[1]))) return false;
    for (const Vec3d& e : edges)
        if (separates({0, -e.z, e.y}) || separates({e.z, 0, -e.x}) || separates({-e.y, e.x, 0})) return false;
    return true;
}

double estimated_pairs(const Mesh& soup, double side)
{
    double pairs = 0;
    for (const Triangle& t : soup.triangles) {
        const Vec3d a = soup.vertices[t[0]], b = soup.vertices[t[1]], c = soup.vertices[t[2]];
        const double area = 0.5 * norm(cross(b - a, c - a)), around = norm(b - a) + norm(c - b) + norm(a - c);
        pairs += 1 + around / side + 1.7 * area / (side * side);
    }
    return pairs;
}

std::uint32_t Grid::add_cell(LatticePoint p)
{
    const std::uint32_t cell = cells.insert(p);
    if (cell < cell_corners.size()) return cell;
    auto& numbers = cell_corners.emplace_back();
    for (int k = 0; k < 8; ++k) numbers[k] = corners.insert({p[0] + (k & 1), p[1] + (k >> 1 & 1), p[2] + (k >> 2)});
    return cell;
}

Grid make_grid(const Mesh& soup)
{
    std::vector<Pair> pairs;
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
        std::array<Vec3d, 3> corners;
        for (int k = 0; k < 3; ++k) corners[k] = soup.vertices[soup.triangles[t][k]];
        const Box box = box_of(corners);
        LatticePoint lo{}, hi{};
        for (int k = 0; k < 3; ++k) {
            lo[k] = static_cast<std::int32_t>(std::floor(box.lo[k] - k_margin));
            hi[k] = static_cast<std::int32_t>(std::floor(box.hi[k] + k_margin)) + 1;
        }
        collect(corners, t, lo, hi, pairs);
    }
    std::sort(pairs.begin(), pairs.end());
    Grid grid;
    grid.triangles.reserve(pairs.size());
    for (const Pair& pair : pairs) {
        if (grid.add_cell(pair.cell) == grid.first.size())
            grid.first.push_back(static_cast<std::uint32_t>(grid.triangles.size()));
        grid.triangles.push_back(pair.triangle);
    }
    grid.first.push_back(static_cast<std::uint32_t>(grid.triangles.size()));
    return grid;
}

}  // namespace sqmap::mesh
