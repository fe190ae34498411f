#include "sqmap/sim/garment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace sqmap::sim {

namespace {

void need(bool holds, const char* what)
{
    if (!holds) throw std::invalid_argument(what);
}

bool positive(double v) { return std::isfinite(v) && v > 0; }

/// A panel on a square grid: cells that are kept, split along alternate diagonals so that no direction is stiffer.
struct Grid {
    int columns = 0, rows = 0;  ///< of cells
    double pitch_x = 0, pitch_y = 0;
    std::vector<std::int64_t> vertex;  ///< (columns + 1) x (rows + 1): its number, -1 if none is kept

    std::int64_t& at(int i, int j)
    {
        return vertex[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns + 1) + static_cast<std::size_t>(i)];
    }
};

/// A cell's two triangles, split from its first corner or from its second.
void add_cell(Garment& garment, const std::array<std::uint32_t, 4>& v, bool from_first)
{
    garment.triangles.push_back({v[0], v[1], from_first ? v[2] : v[3]});
    garment.triangles.push_back({from_first ? v[0] : v[1], v[2], v[3]});
}

/// keep(i, j): true if a cell is cloth; start(i, j): the initial position of a corner.
template <class Keep, class Start>
Grid add_panel(Garment& garment, Grid grid, Keep&& keep, Start&& start)
{
    const int columns = grid.columns, rows = grid.rows;
    grid.vertex.assign(static_cast<std::size_t>(columns + 1) * static_cast<std::size_t>(rows + 1), -1);
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            if (!keep(i, j)) continue;
            for (const auto [di, dj] : {std::array{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
                std::int64_t& v = grid.at(i + di, j + dj);
                if (v >= 0) continue;
                v = static_cast<std::int64_t>(garment.flat.size());
                garment.flat.push_back({(i + di) * grid.pitch_x, (j + dj) * grid.pitch_y, 0});
                garment.start.push_back(start(i + di, j + dj));
            }
            const auto a = static_cast<std::uint32_t>(grid.at(i, j)), b = static_cast<std::uint32_t>(grid.at(i + 1, j)),
                       c = static_cast<std::uint32_t>(grid.at(i + 1, j + 1)), d = static_cast<std::uint32_t>(grid.at(i, j + 1));
            add_cell(garment, {a, b, c, d}, (i + j) % 2 == 0);
        }
    need(!garment.triangles.empty(), "the pattern leaves no cloth");
    return grid;
}

}  // namespace

Fabric fabric(std::string_view name)
{
    // Damping is the drag of still air on a sheet that moves face on at 1 m/s: half the air's density over the sheet's. Bending
    // is what hangs a disc as cloth hangs (sqmap_measure drape): the yarns' friction, which holds real folds too, is part of it.
    //                                density stretch shear bend damping friction thickness
    if (name == "cotton") return Fabric{0.15, 1.0, 50, 33e-6, 4.0, 0.40, 0.002};
    if (name == "silk") return Fabric{0.06, 1.0, 20, 3e-6, 10.0, 0.20, 0.0015};
    if (name == "denim") return Fabric{0.40, 1.0, 150, 120e-6, 1.5, 0.50, 0.003};
    if (name == "wool") return Fabric{0.30, 0.9, 40, 36e-6, 2.0, 0.60, 0.004};
    if (name == "leather") return Fabric{0.80, 1.0, 5000, 140e-6, 0.75, 0.60, 0.004};
    throw std::invalid_argument("no fabric '" + std::string(name) + "': there are cotton, silk, denim, wool, leather");
}

Garment sheet(const SheetPattern& p)
{
    need(positive(p.width) && positive(p.depth) && p.hole_x >= 0 && p.hole_z >= 0, "a sheet's sizes must be positive");
    need(p.vertices >= 9, "a sheet needs at least 9 vertices");
    const double pitch = std::sqrt(p.width * p.depth / p.vertices);
    const int columns = std::max(2, static_cast<int>(std::lround(p.width / pitch))),
              rows = std::max(2, static_cast<int>(std::lround(p.depth / pitch)));
    const double px = p.width / columns, pz = p.depth / rows;
    Garment out;
    add_panel(
        out, {columns, rows, px, pz, {}},
        [&](int i, int j) {
            if (p.hole_x <= 0 || p.hole_z <= 0) return true;
            const double x = ((i + 0.5) * px - 0.5 * p.width) / p.hole_x, z = ((j + 0.5) * pz - 0.5 * p.depth) / p.hole_z;
            return x * x + z * z > 1;
        },
        [&](int i, int j) {
            return p.centre + Vec3d{i * px - 0.5 * p.width, 0, j * pz - 0.5 * p.depth};
        });
    return out;
}

Garment skirt(const SkirtPattern& p)
{
    need(positive(p.waist_radius) && positive(p.length) && p.vertices >= 12, "a skirt's sizes must be positive");
    // Rings whose pitch along the middle circle is that between them.
    const double middle = 2 * std::numbers::pi * (p.waist_radius + 0.5 * p.length);
    const double pitch = std::sqrt(middle * p.length / p.vertices);
    const int around = std::max(8, static_cast<int>(std::lround(middle / pitch))),
              rings = std::max(2, static_cast<int>(std::lround(p.length / pitch)));
    Garment out;
    const auto number = [&](int i, int j) { return static_cast<std::uint32_t>(j * around + i % around); };
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i < around; ++i) {
            const double r = p.waist_radius + p.length * j / rings, angle = 2 * std::numbers::pi * i / around;
            const Vec3d at{r * std::cos(angle), r * std::sin(angle), 0};
            out.flat.push_back(at);
            out.start.push_back(p.centre + Vec3d{at.x, 0, at.y});
            if (j == 0) out.waist.push_back(number(i, j));
            if (j == rings) continue;
            const std::uint32_t a = number(i, j), b = number(i + 1, j), c = number(i + 1, j + 1), d = number(i, j + 1);
            add_cell(out, {a, b, c, d}, (i + j) % 2 == 0);
        }
    return out;
}

Garment shirt(const ShirtPattern& p)
{
    need(positive(p.chest) && positive(p.length) && positive(p.sleeve) && positive(p.gap) && p.neck >= 0,
         "a shirt's sizes must be positive");
    need(p.span >= p.chest && p.sleeve < p.length && p.neck < p.chest,
         "a shirt is wider than its body, longer than its sleeves are wide, and its neck fits in");
    const double area = p.chest * p.length + (p.span - p.chest) * p.sleeve,
                 pitch = std::sqrt(2 * area / std::max(p.vertices, 16u));
    const int columns = std::max(4, static_cast<int>(std::lround(p.span / pitch))),
              rows = std::max(3, static_cast<int>(std::lround(p.length / pitch)));
    const double px = p.span / columns, py = p.length / rows;
    const auto from_middle = [&](double i) { return std::abs(i * px - 0.5 * p.span); };
    const auto kept = [&](int i, int j) {
        if (i < 0 || j < 0 || i >= columns || j >= rows) return false;
        return from_middle(i + 0.5) < 0.5 * p.chest || (j + 0.5) * py < p.sleeve;  // rows run down from the shoulder
    };
    Garment out;
    const auto panel = [&](double z) {
        return add_panel(out, {columns, rows, px, py, {}}, kept, [&](int i, int j) {
            return p.collar + Vec3d{i * px - 0.5 * p.span, -j * py, z};
        });
    };
    Grid front = panel(p.gap);
    const std::size_t front_triangles = out.triangles.size();
    Grid back = panel(-p.gap);
    // Both panels show their outside: rows run down, so the front's triangles are turned.
    for (std::size_t t = 0; t < front_triangles; ++t) std::swap(out.triangles[t][1], out.triangles[t][2]);
    Seam top{"shoulders", {}, true}, sides{"sides", {}, true};
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const std::int64_t v = front.at(i, j);
            if (v < 0) continue;
            const std::array pair{static_cast<std::uint32_t>(v), static_cast<std::uint32_t>(back.at(i, j))};
            if (j == 0) {
                if (from_middle(i) >= 0.5 * p.neck) top.pairs.push_back(pair);
                continue;
            }
            // On the outline, but neither on the hem nor on a sleeve's end.
            const bool inside = kept(i - 1, j - 1) && kept(i, j - 1) && kept(i - 1, j) && kept(i, j);
            const bool hem = j == rows && from_middle(i) < 0.5 * p.chest - 0.5 * px;
            const bool cuff = (i == 0 || i == columns) && kept(i == 0 ? 0 : columns - 1, j);
            if (!inside && !hem && !cuff) sides.pairs.push_back(pair);
        }
    out.seams = {top, sides};
    return out;
}

}  // namespace sqmap::sim
