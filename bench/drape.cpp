// The drape coefficient: a disc of cloth hangs over a smaller level one, and the ring that its shadow covers is a share of the
// ring that is free. Cusick (1968), The measurement of fabric drape, Journal of the Textile Institute 59(6); ISO 9073-9.
#include "measure.h"
#include "sqmap/sim/cloth.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::bench {
namespace {

constexpr double k_disc = 0.15, k_support = 0.09;  ///< m: radii
constexpr double k_moved = 0.3;                    ///< times the pitch: how near the circle a node is moved onto it
constexpr double k_rate = 240, k_max_seconds = 8, k_slow = 0.02;  ///< steps a second; s; m / s, at rest
constexpr int k_pixels = 1200;                                    ///< of the shadow, along each side

/// Coefficients of real cloth, percent.
struct Published {
    const char *fabric, *source;
    double low, high;
};
constexpr Published k_published[] = {
    {"silk", "woven silks, Matsudaira & Yang 2003", 20, 40},
    {"cotton", "plain cotton, Gan, Ly & Steven 1991", 68.4, 68.4},
    {"wool", "tropical wool, Matsudaira et al. 2015", 49.8, 49.8},
    {"leather", "four garment leathers of sheep, Memon et al. 2021", 47.35, 69.9},
};

/// A disc of square cells in the middle of the world. Nodes near the circle that holds it lie on it, so that the free ring is as
/// wide in every mesh.
sim::Garment disc(double pitch)
{
    sim::Garment out;
    std::map<std::pair<int, int>, std::uint32_t> number;
    const auto flat = [&](int i, int j) {
        const Vec3d at{(i + 0.37) * pitch, (j + 0.21) * pitch, 0};
        const double r = norm(at);
        return std::abs(r - k_support) < k_moved * pitch ? (k_support / r) * at : at;
    };
    const int n = static_cast<int>(std::ceil(k_disc / pitch)) + 1;
    for (int j = -n; j < n; ++j)
        for (int i = -n; i < n; ++i) {
            std::array<std::pair<int, int>, 4> corner{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
            if ((i + j) % 2 != 0) std::rotate(corner.begin(), corner.begin() + 1, corner.end());
            for (const auto& t : {std::array{0u, 1u, 2u}, {0u, 2u, 3u}}) {
                std::array<std::uint32_t, 3> triangle{};
                if (std::any_of(t.begin(), t.end(),
                                [&](auto k) { return norm(flat(corner[k].first, corner[k].second)) > k_disc; }))
                    continue;
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto [x, y] = corner[t[k]];
                    const auto [found, fresh] = number.try_emplace({x, y}, static_cast<std::uint32_t>(out.flat.size()));
                    triangle[k] = found->second;
                    if (!fresh) continue;
                    out.flat.push_back(flat(x, y));
                    out.start.push_back({out.flat.back().x, 0, out.flat.back().y});
                }
                out.triangles.push_back(triangle);
            }
        }
    return out;
}

/// m^2: what the triangles cover, seen from above.
double shadow(std::span<const Vec3d> at, std::span<const std::array<std::uint32_t, 3>> triangles)
{
    const double pixel = 2.2 * k_disc / k_pixels;
    std::vector<std::uint8_t> dark(static_cast<std::size_t>(k_pixels) * k_pixels);
    for (const auto& t : triangles) {
        std::array<double, 3> x, z;
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = at[t[k]].x / pixel + 0.5 * k_pixels;
            z[k] = at[t[k]].z / pixel + 0.5 * k_pixels;
        }
        const double area = (x[1] - x[0]) * (z[2] - z[0]) - (z[1] - z[0]) * (x[2] - x[0]);
        if (!(std::abs(area) > 1e-12)) continue;
        const auto [left, right] = std::minmax({x[0], x[1], x[2]});
        const auto [bottom, top] = std::minmax({z[0], z[1], z[2]});
        for (int j = std::max(0, static_cast<int>(bottom)); j < std::min<double>(k_pixels, top + 1); ++j)
            for (int i = std::max(0, static_cast<int>(left)); i < std::min<double>(k_pixels, right + 1); ++i) {
                const double px = i + 0.5 - x[0], pz = j + 0.5 - z[0];
                const double u = (px * (z[2] - z[0]) - pz * (x[2] - x[0])) / area,
                             v = ((x[1] - x[0]) * pz - (z[1] - z[0]) * px) / area;
                if (u >= 0 && v >= 0 && u + v <= 1)
                    dark[static_cast<std::size_t>(j) * k_pixels + static_cast<std::size_t>(i)] = 1;
            }
    }
    return pixel * pixel * static_cast<double>(std::count(dark.begin(), dark.end(), 1));
}

void hang(const sim::Fabric& fabric, double pitch, const Published& p)
{
    const sim::Garment garment = disc(pitch);
    sim::Cloth cloth(garment, fabric);
    std::vector<std::uint32_t> held;
    for (std::uint32_t i = 0; i < garment.flat.size(); ++i)
        if (norm(garment.flat[i]) <= k_support * (1 + 1e-9)) held.push_back(i);
    cloth.pin(held, sim::Cloth::k_world, {});
    const double support = std::numbers::pi * k_support * k_support,
                 free = shadow(cloth.positions(), cloth.triangles()) - support;
    sim::Drape drape(k_slow);
    sim::StepReport report;
    int step = 0;
    while (step < k_max_seconds * k_rate && !drape.report().at_rest)
        drape.add(report = cloth.step(1 / k_rate, {}), ++step / k_rate);
    const double percent = 100 * (shadow(cloth.positions(), cloth.triangles()) - support) / free;
    std::printf("%-8s %4.1f mm %5zu vertices: %5.1f %%, %s, %.1f s, fastest vertex %.3f m/s; measured on %s: %g to %g %%\n",
                p.fabric, 1e3 * pitch, cloth.size(), percent, drape.report().at_rest ? "at rest" : "not at rest", step / k_rate,
                report.fastest, p.source, p.low, p.high);
    std::fflush(stdout);
}

}  // namespace

int measure_drape(int argc, char** argv)
{
    std::vector<double> pitches{0.010, 0.007, 0.005};
    std::optional<double> bend;
    std::string only;
    for (int a = 1; a + 1 < argc; a += 2) {
        const std::string_view word = argv[a];
        if (word == "--fabric")
            only = argv[a + 1];
        else if (word == "--bend")
            bend = std::atof(argv[a + 1]);
        else if (word == "--pitch")
            pitches = {std::atof(argv[a + 1])};
        else
            return k_wrong_usage;
    }
    if (argc % 2 == 0 || !(pitches.front() >= 0.002 && pitches.front() <= 0.03)) return k_wrong_usage;
    for (const Published& p : k_published) {
        if (!only.empty() && only != p.fabric) continue;
        sim::Fabric fabric = sim::fabric(p.fabric);
        fabric.bend = bend.value_or(fabric.bend);
        for (const double pitch : pitches) hang(fabric, pitch, p);
    }
    return 0;
}

}  // namespace sqmap::bench
