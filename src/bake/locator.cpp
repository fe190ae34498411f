#include "locator.h"

#include "bake/locator/clip_to_cube.h"
#include "bake/locator/near_triangles.h"
#include "bake/locator/nearby.h"
#include "budget.h"
#include "model/approach.h"
#include "model/locator.h"
#include "sqmap/mesh/error.h"
#include "sqmap/parallel/for_each.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

namespace sqmap::bake {

namespace {

using model::LocatorBrick;
using model::LocatorCell;
using model::LocatorCellKind;
using model::LocatorPlane;
using model::Seed;

constexpr int k_places = static_cast<int>(model::k_brick_cells);
// Cells along the longest side of the object's box, for a target error of half a percent. A plane's error grows with the square
// of the cell.
constexpr double k_cells_along = 40;
constexpr double k_cells_target = 0.5;
constexpr double k_least_cells = 20;
// The maps come first: the locator makes do with larger cells where little of the budget is left, but for this share of it.
constexpr double k_least_share = 0.12;
// Bytes grow with about this power of the cells along a side: by the square but for places that fine cells make flat.
constexpr double k_growth = 1.7;
// Of the bricks near the surface one in so many tells how many bytes all take.
constexpr std::uint32_t k_sampled_brick = 6;
// Of the locator's bytes, what places take before those that are not flat are divided; and what a division takes, about.
constexpr double k_undivided_share = 0.65;
constexpr double k_division_bytes = 250;
// What an update may make of the bytes that the locator had, by dividing places.
constexpr double k_growth_room = 1.1;
// By how much of R_max a sample may miss its nearest surface before it gets a seed of its own, and a plane the surface.
constexpr double k_seed_tolerance = 0.0005;
// By how much of the target error a place's planes may miss the surface at its worst sample; at most points it is a tenth.
constexpr double k_flat_share = 0.4;

/// Where a place is sampled, in its sides from its centre: near its corners and the middles of its faces.
constexpr Vec3d k_samples[] = {{0, 0, 0},        {-.48, -.48, -.48}, {.48, -.48, -.48}, {.48, .48, -.48},  {-.48, .48, -.48},
                               {-.48, .48, .48}, {.48, .48, .48},    {.48, -.48, .48},  {-.48, -.48, .48}, {-.48, 0, 0},
                               {0, -.48, 0},     {.48, 0, 0},        {0, .48, 0},       {0, 0, .48},       {0, 0, -.48}};
/// And where several planes are to be checked: between its centre and its corners, and near the middles of its edges.
constexpr Vec3d k_more_samples[] = {{-.24, -.24, -.24}, {.24, -.24, -.24}, {.24, .24, -.24},  {-.24, .24, -.24}, {-.24, .24, .24},
                                    {.24, .24, .24},    {.24, -.24, .24},  {-.24, -.24, .24}, {-.48, -.48, 0},   {.48, -.48, 0},
                                    {.48, .48, 0},      {-.48, .48, 0},    {-.48, 0, -.48},   {.48, 0, -.48},    {.48, 0, .48},
                                    {-.48, 0, .48},     {0, -.48, -.48},   {0, .48, -.48},    {0, .48, .48},     {0, -.48, .48}};

constexpr double k_sample_reach = 0.832;  ///< how far from the centre a sample is at most, in sides

struct Grid {
    Vec3d origin;
    double cell = 0;
    int n[3] = {};  ///< cells
};

Grid grid_about(const mesh::Mesh& mesh, double cells)
{
    Vec3d lo = mesh.vertices.front(), hi = lo;
    for (const Vec3d& v : mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], v[k]);
            hi[k] = std::max(hi[k], v[k]);
        }
    Grid grid;
    // In float from here on: the runtime must see the very same grid.
    grid.cell = static_cast<float>(std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}) / cells);
    for (int k = 0; k < 3; ++k) {
        const double margin = 0.01 * grid.cell;
        const int bricks = static_cast<int>(std::ceil((hi[k] - lo[k] + 2 * margin) / (model::k_brick * grid.cell)));
        grid.n[k] = model::k_brick * std::max(bricks, 1);
        grid.origin[k] = static_cast<float>(0.5 * (lo[k] + hi[k]) - 0.5 * grid.cell * grid.n[k]);
    }
    return grid;
}

/// A plane as stored, but for its part.
struct PartPlane {
    LocatorPlane plane;
    std::uint32_t part;
};

/// What is known of a place before it is packed.
struct Place {
    LocatorCellKind kind = LocatorCellKind::Free;
    double gap = 0;  ///< Free
    model::PartList parts{model::k_no_part, model::k_no_part, model::k_no_part, model::k_no_part};
    std::vector<PartPlane> planes;  ///< of a flat place
    std::uint8_t rise = model::k_no_rise;
    std::vector<Seed> seeds;          ///< of another
    std::uint32_t choices = 0;        ///< which seed comes first in each octant, three bits each
    std::vector<Place> eighths;       ///< of a place that is divided, x fastest
    std::vector<std::uint32_t> near;  ///< in an update, of one that is baked anew: the triangles near it
};

/// How a part's domain lies to a box about c with half side h, in the chart frame.
struct DomainTest {
    bool touches = false, holds = false;
};

DomainTest test_domain(const model::Part& part, Vec3d c, double h)
{
    const Vec3d d = c - cast<double>(model::vec3(part.chart_centre));
    Vec3d rows[3];
    for (int i = 0; i < 3; ++i) rows[i] = cast<double>(model::vec3(part.chart_rows + 3 * i));
    const Vec3d directions[9] = {rows[0],           rows[1],           rows[2],           rows[0] + rows[1], rows[0] - rows[1],
                                 rows[0] + rows[2], rows[0] - rows[2], rows[1] + rows[2], rows[1] - rows[2]};
    DomainTest test{true, true};
    for (int i = 0; i < 9; ++i) {
        const Vec3d& n = directions[i];
        const double value = dot(n, d), reach = 1.0001 * h * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
        const double lo = part.chart_lo[i], hi = part.chart_hi[i], slack = 1e-5 * (hi - lo);
        if (value + reach < lo - slack || value - reach > hi + slack) test.touches = false;
        if (value - reach < lo + slack || value + reach > hi - slack) test.holds = false;
    }
    return test;
}

class LocatorBaker {
public:
    LocatorBaker(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, double target_error, double cells,
                 model::ModelData& data)
        : solid_(solid),
          part_of_triangle_(part_of_triangle),
          data_(data),
          grid_(grid_about(solid.mesh(), cells)),
          flat_tolerance_(0.01 * k_flat_share * target_error * data.header.r_max)
    {
        for (int k = 0; k < 3; ++k) {
            data_.locator.origin[k] = static_cast<float>(grid_.origin[k]);
            data_.locator.bricks[k] = static_cast<std::uint32_t>(grid_.n[k] / model::k_brick);
        }
        data_.locator.cell = static_cast<float>(grid_.cell);
        // Nothing is deeper than half the narrowest side; a plane is no farther below a place's centre than a sample, and a cell.
        data_.locator.plane_reach = 0.5f * static_cast<float>(std::min({grid_.n[0], grid_.n[1], grid_.n[2]})) + 3;
        view_ = data_.view();
    }

    /// On the grid that data has, and with what it holds.
    LocatorBaker(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, double target_error,
                 model::ModelData& data)
        : solid_(solid),
          part_of_triangle_(part_of_triangle),
          data_(data),
          flat_tolerance_(0.01 * k_flat_share * target_error * data.header.r_max)
    {
        grid_.cell = static_cast<double>(data.locator.cell);
        for (int k = 0; k < 3; ++k) {
            grid_.origin[k] = static_cast<double>(data.locator.origin[k]);
            grid_.n[k] = model::k_brick * static_cast<int>(data.locator.bricks[k]);
        }
        view_ = data_.view();
        unpack();
        keeps_near_ = true;
    }

    /// In place of run.
    LocatorUpdate update(const Change& change, unsigned threads)
    {
        const std::size_t bytes = packed_bytes();
        LocatorUpdate update;
        enclose(update);
        update.reached.assign(bricks_.size(), 0);
        const auto* n = data_.locator.bricks;
        parallel::for_each(bricks_.size(), threads, [&](std::size_t i) {
            const bool fresh = update.brick_before[i] == LocatorUpdate::k_no_brick;
            update.reached[i] = update_brick(bricks_[i], i % n[0], i / n[0] % n[1], i / (n[0] * n[1]), fresh, change);
        });
        pack();
        const double room = k_growth_room * static_cast<double>(bytes) - static_cast<double>(packed_bytes());
        divide(static_cast<std::size_t>(std::max(0.0, room) / k_division_bytes), threads, update.reached);
        update.near.resize(bricks_.size());
        for (std::size_t i = 0; i < bricks_.size(); ++i)
            for (Place& place : bricks_[i].places)
                if (update.reached[i] != 0) update.near[i].push_back(std::move(place.near));
        return update;
    }

    void run(unsigned threads)
    {
        bake_bricks(1, threads);
        pack();
    }

    /// Bytes that run would take, told from a share of its bricks.
    double estimated_bytes(unsigned threads)
    {
        const double sampled = bake_bricks(k_sampled_brick, threads);
        const auto stored = static_cast<double>(
            std::count_if(bricks_.begin(), bricks_.end(), [](const Brick& brick) { return brick.kind == Brick::Kind::Stored; }));
        for (Brick& brick : bricks_)
            if (brick.places.empty()) brick = {.kind = Brick::Kind::Free, .places = {Place{}}};
        pack();
        return static_cast<double>(packed_bytes()) * stored / std::max(sampled, 1.0);
    }

    std::size_t packed_bytes() const { return model::bytes_of<model::LocatorArrays<model::ArrayData>>(data_); }

    /// After run: the places of one cell that are not flat, in eighths; at most so many, those with the longest chains first.
    /// among: bits of places that are considered, brick by brick; empty for all.
    void divide(std::size_t most, unsigned threads, std::span<const std::uint64_t> among = {})
    {
        const auto* n = data_.locator.bricks;
        std::vector<std::pair<std::size_t, std::size_t>> candidates;  // seeds, and which place
        for (std::size_t i = 0; i < bricks_.size(); ++i) {
            if (bricks_[i].kind != Brick::Kind::Stored) continue;
            for (std::size_t k = 0; k < k_places; ++k) {
                const Place& place = bricks_[i].places[k];
                if (!place.eighths.empty() || (!among.empty() && (among[i] >> k & 1u) == 0)) continue;
                if (!place.seeds.empty()) candidates.emplace_back(place.seeds.size(), i * k_places + k);
            }
        }
        std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
        candidates.resize(std::min(most, candidates.size()));
        std::vector<std::uint8_t> chosen(bricks_.size() * k_places, 0);
        for (const auto& [seeds, which] : candidates) chosen[which] = 1;
        parallel::for_each(bricks_.size(), threads, [&](std::size_t i) {
            if (bricks_[i].kind != Brick::Kind::Stored) return;
            for (int k = 0; k < k_places; ++k) {
                Place& place = bricks_[i].places[static_cast<std::size_t>(k)];
                if (chosen[i * k_places + static_cast<std::size_t>(k)] == 0) continue;
                const Vec3d centre = cell_centre(brick_corner(i % n[0], i / n[0] % n[1], i / (n[0] * n[1])), k);
                mesh::ClosestPoint nearest = solid_.closest_boundary(centre);
                for (std::size_t e = 0; e < 8; ++e) {
                    const Vec3d p = eighth_centre(centre, grid_.cell, e);
                    nearest = closest_from(nearest.point, p);
                    place.eighths.push_back(bake_place(p, 0.5 * grid_.cell, nearest, place.near));
                }
            }
        });
        pack();
    }

private:
    struct Brick {
        enum class Kind { Free, Deep, Stored } kind = Kind::Stored;
        std::vector<Place> places;
    };

    /// One in so many of the bricks that are stored, and what all others are. Returns how many are stored in full.
    double bake_bricks(std::uint32_t one_in, unsigned threads)
    {
        const auto* n = data_.locator.bricks;
        bricks_.assign(static_cast<std::size_t>(n[0]) * n[1] * n[2], {});
        parallel::for_each(bricks_.size(), threads, [&](std::size_t i) {
            // A multiplicative hash (Knuth): neither rows nor columns are left out.
            const bool chosen = (static_cast<std::uint32_t>(i) * 2654435761u >> 16) % one_in == 0;
            bake_brick(bricks_[i], i % n[0], i / n[0] % n[1], i / (n[0] * n[1]), chosen);
        });
        return static_cast<double>(std::count_if(bricks_.begin(), bricks_.end(), [](const Brick& brick) {
            return brick.kind == Brick::Kind::Stored && !brick.places.empty();
        }));
    }

    void bake_brick(Brick& brick, std::size_t bx, std::size_t by, std::size_t bz, bool in_full) const
    {
        constexpr int n = model::k_brick;
        const Vec3d corner = brick_corner(bx, by, bz);
        const Place whole = bake_place(corner + 0.5 * n * grid_.cell * Vec3d{1, 1, 1}, n * grid_.cell);
        // One that planes do not answer for as a whole is stored in full, deep as it is: searching there would take ten times as
        // long.
        if (whole.kind == LocatorCellKind::Free || !whole.planes.empty()) {
            brick.kind = whole.kind == LocatorCellKind::Free ? Brick::Kind::Free : Brick::Kind::Deep;
            brick.places = {whole};
            return;
        }
        for (int i = 0; i < k_places && in_full; ++i) brick.places.push_back(bake_place(cell_centre(corner, i), grid_.cell));
    }

    Vec3d brick_corner(std::size_t bx, std::size_t by, std::size_t bz) const
    {
        return grid_.origin + model::k_brick * grid_.cell * Vec3d{double(bx), double(by), double(bz)};
    }
    Vec3d cell_centre(Vec3d brick_corner, int i) const
    {
        constexpr int n = model::k_brick;
        return brick_corner + grid_.cell * Vec3d{i % n + 0.5, i / n % n + 0.5, i / (n * n) + 0.5};
    }

    void unpack()
    {
        for (const std::uint32_t word : data_.bricks) {
            const LocatorBrick brick{word};
            Brick& to = bricks_.emplace_back();
            if (brick.is_free()) {
                to.kind = Brick::Kind::Free;
                to.places.emplace_back().gap = gap_of(brick.gap());
                continue;
            }
            to.kind = brick.is_deep() ? Brick::Kind::Deep : Brick::Kind::Stored;
            for (std::uint32_t k = 0; k < brick.cell_count(); ++k) to.places.push_back(unpacked(brick.first() + k));
        }
    }

    Place unpacked(std::size_t index) const
    {
        const LocatorCell cell{data_.places[index]};
        Place place;
        place.kind = cell.kind();
        if (cell.is_free()) {
            place.gap = gap_of(cell.gap());
            return place;
        }
        if (cell.is_divided()) {
            for (std::uint32_t e = 0; e < 8; ++e) place.eighths.push_back(unpacked(cell.first() + e));
            return place;
        }
        place.parts = model::decode_list(data_.part_lists[cell.list()]);
        if (!data_.rises.empty()) place.rise = data_.rises[index];
        for (std::uint32_t k = 0; k < cell.planes(); ++k) {
            const LocatorPlane plane{data_.planes[cell.first() + k]};
            place.planes.push_back({plane.with_slot(0), place.parts[plane.slot()]});
        }
        if (!place.planes.empty()) return place;
        std::uint32_t at = cell.first();
        do place.seeds.push_back(model::as_not_last(data_.seeds[at]));
        while (!model::is_last_seed(data_.seeds[at++]));
        if (place.seeds.size() > 1) place.choices = data_.seeds[cell.first() - 1].direction;
        return place;
    }

    /// As it was, to within a step: packed again it is the same.
    double gap_of(std::uint32_t code) const { return (code + 0.5) * static_cast<double>(model::k_gap_step) * grid_.cell; }

    /// Adds bricks where the mesh is beyond the grid.
    void enclose(LocatorUpdate& update)
    {
        Vec3d lo = solid_.mesh().vertices.front(), hi = lo;
        for (const Vec3d& v : solid_.mesh().vertices)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], v[k]);
                hi[k] = std::max(hi[k], v[k]);
            }
        const double side = model::k_brick * grid_.cell, margin = 0.01 * grid_.cell;
        std::array<std::uint32_t, 3> before{}, below{}, now{};
        for (int k = 0; k < 3; ++k) {
            const auto i = static_cast<std::size_t>(k);
            const auto missing = [&](double length) {
                return static_cast<std::uint32_t>(std::ceil(std::max(length, 0.0) / side));
            };
            before[i] = data_.locator.bricks[i];
            below[i] = missing(grid_.origin[k] + margin - lo[k]);
            now[i] = before[i] + below[i] + missing(hi[k] + margin - grid_.origin[k] - grid_.cell * grid_.n[k]);
            grid_.origin[k] = static_cast<double>(static_cast<float>(grid_.origin[k] - side * below[i]));
            grid_.n[k] = model::k_brick * static_cast<int>(now[i]);
            data_.locator.origin[i] = static_cast<float>(grid_.origin[k]);
            data_.locator.bricks[i] = now[i];
        }
        std::vector<Brick> bricks(std::size_t{now[0]} * now[1] * now[2]);
        update.brick_before.assign(bricks.size(), LocatorUpdate::k_no_brick);
        for (std::uint32_t z = 0; z < before[2]; ++z)
            for (std::uint32_t y = 0; y < before[1]; ++y)
                for (std::uint32_t x = 0; x < before[0]; ++x) {
                    const std::size_t from = (std::size_t{z} * before[1] + y) * before[0] + x;
                    const std::size_t to = (std::size_t{z + below[2]} * now[1] + y + below[1]) * now[0] + x + below[0];
                    bricks[to] = std::move(bricks_[from]);
                    update.brick_before[to] = static_cast<std::uint32_t>(from);
                }
        bricks_ = std::move(bricks);
        view_ = data_.view();
    }

    /// Which of its places have another nearest surface.
    std::uint64_t update_brick(Brick& brick, std::size_t bx, std::size_t by, std::size_t bz, bool fresh,
                               const Change& change) const
    {
        constexpr std::uint64_t k_all = ~std::uint64_t{0};
        const double side = model::k_brick * grid_.cell;
        const Vec3d corner = brick_corner(bx, by, bz), centre = corner + 0.5 * side * Vec3d{1, 1, 1};
        const auto anew = [&] {
            brick = {};
            bake_brick(brick, bx, by, bz, true);
            return k_all;
        };
        if (fresh) return anew();
        if (brick.kind == Brick::Kind::Free) return reaches_free(brick.places.front(), centre, change) ? anew() : 0;
        const mesh::ClosestPoint nearest = solid_.closest_boundary(centre);
        const bool reached = change.reaches_box(centre, 0.5 * side, nearest.distance);
        if (brick.kind == Brick::Kind::Deep) {
            if (reached) return anew();
            return update_parts(brick.places.front(), centre, side, change) ? 1 : 0;
        }
        std::uint64_t bits = 0;
        Vec3d close = nearest.point;
        for (int k = 0; k < k_places; ++k) {
            Place& place = brick.places[static_cast<std::size_t>(k)];
            const bool here = reached ? update_place(place, cell_centre(corner, k), grid_.cell, change, close)
                                      : update_parts(place, cell_centre(corner, k), grid_.cell, change);
            if (here) bits |= std::uint64_t{1} << k;
        }
        return bits;
    }

    bool reaches_free(const Place& place, Vec3d centre, const Change& change) const
    {
        return change.reaches(centre, place.gap + static_cast<double>(model::k_gap_step) * grid_.cell);
    }

    /// Whether the nearest surface of some point of a box may be another; told from its eighths, so many levels down.
    bool is_reached(Vec3d centre, double half, const Change& change, int levels) const
    {
        if (!change.reaches_box(centre, half, solid_.closest_boundary(centre).distance)) return false;
        for (std::size_t e = 0; e < 8 && levels > 0; ++e)
            if (is_reached(eighth_centre(centre, 2 * half, e), 0.5 * half, change, levels - 1)) return true;
        return levels == 0;
    }

    /// Whether the nearest surface may be another. close: some point of the boundary; the nearest one, where that was looked for.
    bool update_place(Place& place, Vec3d centre, double side, const Change& change, Vec3d& close,
                      std::span<const std::uint32_t> near = {}) const
    {
        if (place.kind == LocatorCellKind::Free) {
            if (!reaches_free(place, centre, change)) return false;
            place = bake_place(centre, side, solid_.closest_boundary(centre), near);
            return true;
        }
        const double half = 0.5 * side;
        if (!change.reaches_box(centre, half, norm(close - centre))) return update_parts(place, centre, side, change);
        const mesh::ClosestPoint nearest = closest_from(close, centre);
        close = nearest.point;
        if (!change.reaches_box(centre, half, nearest.distance)) return update_parts(place, centre, side, change);
        if (place.eighths.empty()) {
            place = bake_place(centre, side, nearest, near);
        } else {
            place.near = near_triangles(centre, side, nearest.distance);
            for (std::size_t e = 0; e < 8; ++e)
                (void)update_place(place.eighths[e], eighth_centre(centre, side, e), half, change, close, place.near);
        }
        return true;
    }

    /// What a place says of parts. True where its planes are others.
    bool update_parts(Place& place, Vec3d centre, double side, const Change& change) const
    {
        if (place.kind == LocatorCellKind::Free) return false;
        if (!place.eighths.empty()) {
            bool other = false;
            for (std::size_t e = 0; e < 8; ++e)
                other = update_parts(place.eighths[e], eighth_centre(centre, side, e), 0.5 * side, change) || other;
            return other;
        }
        if (std::any_of(place.seeds.begin(), place.seeds.end(),
                        [&](const Seed& seed) { return change.remade(model::seed_part(seed)); })) {
            place = bake_place(centre, side);
            return true;
        }
        if (place.kind == LocatorCellKind::Inside) return false;
        for (std::uint32_t i = 0; i < view_.parts.size(); ++i) {
            if (!change.remade(i)) continue;
            const DomainTest was = test_domain(change.before(i), centre, 0.5 * side),
                             is = test_domain(view_.parts[i], centre, 0.5 * side);
            if (was.touches == is.touches && was.holds == is.holds) continue;
            place.kind = LocatorCellKind::Mixed;
            place.parts.fill(model::k_no_part);
            list_parts(place, centre, side, part_of_triangle_[solid_.closest_boundary(centre).triangle]);
            break;
        }
        return false;
    }

    /// Of the boundary, to p; with another point of it known, so that no more than a ball is searched.
    mesh::ClosestPoint closest_from(Vec3d known, Vec3d p) const
    {
        return solid_.closest_boundary(p, 1.000001 * norm(known - p) + 1e-12);
    }

    Vec3d eighth_centre(Vec3d centre, double side, std::size_t e) const
    {
        return centre + 0.25 * side * Vec3d{e & 1 ? 1. : -1., e & 2 ? 1. : -1., e & 4 ? 1. : -1.};
    }

    Place bake_place(Vec3d centre, double side) const { return bake_place(centre, side, solid_.closest_boundary(centre)); }

    /// All that are nearest to some point of a place.
    const std::vector<std::uint32_t>& near_triangles(Vec3d centre, double side, double distance) const
    {
        thread_local NearTriangles search;  // keeps its room
        const double half = 0.5 * k_near_slack * side;
        search.begin(solid_, centre, half, {&centre, 1}, distance);
        return search(0, centre, half, /*fine=*/false);
    }

    /// nearest: of the boundary, to the centre. near: of a place that this is an eighth of, or nothing.
    Place bake_place(Vec3d centre, double side, const mesh::ClosestPoint& nearest, std::span<const std::uint32_t> near = {}) const
    {
        Place place;
        const bool crossed = nearest.distance <= 0.5 * std::sqrt(3.0) * side * 1.0001;
        const bool inside = is_inside(centre, nearest);
        if (!crossed && !inside) {
            place.gap = nearest.distance;
            return place;
        }
        place.kind = crossed ? LocatorCellKind::Mixed : LocatorCellKind::Inside;
        if (crossed && side > 1.5 * grid_.cell) return place;  // a brick that is divided
        if (keeps_near_ && near.empty()) {
            place.near = near_triangles(centre, side, nearest.distance);
            near = place.near;
        }
        choose_planes(place, centre, side, nearest, inside, near);
        if (crossed) list_parts(place, centre, side, part_of_triangle_[nearest.triangle]);
        return place;
    }

    struct Sample {
        Vec3d point;
        mesh::ClosestPoint truth;
        bool inside;
        double best;  ///< distance that some seed finds
    };

    /// Planes that are the surface; where none suffice, seeds.
    void choose_planes(Place& place, Vec3d centre, double side, const mesh::ClosestPoint& nearest, bool inside,
                       std::span<const std::uint32_t> near) const
    {
        std::vector<Sample> samples;
        Nearby nearby = near.empty() ? Nearby(solid_, centre, (nearest.distance + 2 * k_sample_reach * side) * (1 + 1e-6))
                                     : Nearby(solid_, centre, near);
        sample(place, centre, side, k_samples, nearby, samples);
        const std::size_t within = samples.size();
        if (place.kind == LocatorCellKind::Mixed) add_surface(samples, centre, side);
        std::optional<double> least;
        if (const auto plane = plane_at(centre, centre, nearest, inside)) {
            place.planes = {*plane};
            least = add_planes(place.planes, centre, samples);
        }
        if (least && place.planes.size() > 1 && place.kind == LocatorCellKind::Mixed) {
            // Planes that are right at all of these may still meet in the wrong place between them.
            sample(place, centre, side, k_more_samples, nearby, samples);
            least = add_planes(place.planes, centre, samples);
        }
        if (least) {
            // A surface that bends towards the point is met in the middle.
            if (*least < -flat_tolerance_)
                for (PartPlane& p : place.planes) p.plane = raised(p.plane, -*least - flat_tolerance_);
            return;
        }
        place.planes.clear();
        samples.resize(within);
        place.seeds = {seed_at(centre, centre, part_of_triangle_[nearest.triangle], nearest, inside)};
        add_seeds(place.seeds, centre, samples);
        if (place.seeds.size() > 1) rank_seeds(place, centre, samples);
    }

    void sample(const Place& place, Vec3d centre, double side, std::span<const Vec3d> offsets, Nearby& nearby,
                std::vector<Sample>& samples) const
    {
        Vec3d points[Nearby::k_points];
        for (std::size_t i = 0; i < offsets.size(); ++i) points[i] = centre + side * offsets[i];
        std::vector<mesh::ClosestPoint> found;
        nearby.closest({points, offsets.size()}, found);
        for (std::size_t i = 0; i < found.size(); ++i) {
            const bool inside = place.kind == LocatorCellKind::Inside || is_inside(points[i], found[i], samples);
            samples.push_back({points[i], found[i], inside, 0});
        }
    }

    /// The surface within the place: corners and middles of the triangles' pieces. Where planes are near all of it, a point
    /// farther from them is on the side of a corner of the place, which is a sample: so their side is right but for a band.
    void add_surface(std::vector<Sample>& samples, Vec3d centre, double side) const
    {
        const double half = 0.5 * side, radius_sq = 3.0003 * half * half;
        solid_.bvh().visit_nearest(centre, radius_sq, [&](std::uint32_t triangle, double) {
            const mesh::Triangle& t = solid_.mesh().triangles[triangle];
            const auto& v = solid_.mesh().vertices;
            const ClippedTriangle piece = clip_to_cube({v[t[0]] - centre, v[t[1]] - centre, v[t[2]] - centre}, half);
            Vec3d middle{};
            for (int i = 0; i < piece.count; ++i) middle += piece.corners[i] / double(piece.count);
            for (int i = 0; i <= piece.count && piece.count > 0; ++i) {
                const Vec3d p = centre + (i < piece.count ? piece.corners[i] : middle);
                samples.push_back({p, {p, triangle, 0}, true, 0});
            }
            return radius_sq;
        });
    }

    /// By the side of the nearest triangle where the point is right above its face, which tells; else by another sample that no
    /// surface can be between, for it is nearer; else by the winding number.
    bool is_inside(Vec3d p, const mesh::ClosestPoint& nearest, std::span<const Sample> samples = {}) const
    {
        const mesh::Triangle& t = solid_.mesh().triangles[nearest.triangle];
        const auto& v = solid_.mesh().vertices;
        const Vec3d n = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]), d = p - nearest.point;
        const double height = dot(n, d), sideways = norm(cross(n, d));
        const double u = dot(cross(v[t[1]] - nearest.point, v[t[2]] - nearest.point), n),
                     w = dot(cross(v[t[2]] - nearest.point, v[t[0]] - nearest.point), n),
                     x = dot(cross(v[t[0]] - nearest.point, v[t[1]] - nearest.point), n);
        const double corner = 1e-6 * norm_sq(n);
        if (!solid_.self_intersecting() && sideways < 1e-6 * std::abs(height) && u > corner && w > corner && x > corner)
            return height < 0;
        for (const Sample& other : samples) {
            const double clear = 0.999 * std::max(nearest.distance, other.truth.distance);
            if (other.truth.distance > 0 && norm_sq(p - other.point) < clear * clear) return other.inside;
        }
        return solid_.inside(p);
    }

    /// Planes in groups, those of a group marked but for its first: a point is as deep as the lowest of the groups' highest. A
    /// surface that bends away is met by groups, one that bends towards the point by the planes of a group.
    /// The least that an inside sample's depth is above the planes' (negative), or nothing where planes do not suffice.
    std::optional<double> add_planes(std::vector<PartPlane>& planes, Vec3d centre, const std::vector<Sample>& samples) const
    {
        const double tolerance = flat_tolerance_;
        std::vector<std::uint32_t> words;
        for (;;) {
            const Sample* worst = nullptr;
            double worst_miss = 1, least = 0;
            std::size_t worst_group = 0;
            words.clear();
            for (const PartPlane& p : planes) words.push_back(p.plane.word);
            for (const Sample& sample : samples) {
                const model::FlatGap lowest = model::flat_gap(view_.locator, words, cast<float>(sample.point - centre));
                const double gap = static_cast<double>(lowest.gap);
                // Outside only the side counts.
                const double excess = gap - (sample.inside ? sample.truth.distance : 0);
                if (sample.inside) least = std::min(least, excess);
                double miss = excess > 0 ? excess / tolerance : (sample.inside ? -excess / (2 * tolerance) : 0);
                // On the wrong side, and not because it is so near.
                if (excess > 0 && !sample.inside && sample.truth.distance > tolerance) miss += 1;
                if (miss > worst_miss) {
                    worst_miss = miss;
                    worst = &sample;
                    worst_group = excess > 0 ? 0 : lowest.group_end;
                }
            }
            if (worst == nullptr) return least;
            if (planes.size() == model::k_max_planes) return std::nullopt;
            std::optional<PartPlane> next = plane_at(centre, worst->point, worst->truth, worst->inside);
            if (!next) return std::nullopt;
            if (worst_group > 0) next->plane = next->plane.joined();
            planes.insert(worst_group > 0 ? planes.begin() + static_cast<std::ptrdiff_t>(worst_group) : planes.end(), *next);
        }
    }

    /// Enough seeds that every sample of the place finds its nearest surface from one of them: outside too, for the side is
    /// told by the surface found.
    void add_seeds(std::vector<Seed>& seeds, Vec3d centre, std::vector<Sample>& samples) const
    {
        const double tolerance = k_seed_tolerance * view_.header.r_max;
        for (Sample& sample : samples) {
            sample.best = INFINITY;
            for (const Seed& seed : seeds) sample.best = std::min(sample.best, reach_from(centre, seed, sample.point));
            if (sample.best <= sample.truth.distance + tolerance || seeds.size() == model::k_max_seeds) continue;
            const auto [seed, reached] = best_seed(centre, sample.point, sample.truth, tolerance);
            if (!(reached < sample.best - tolerance)) continue;
            seeds.push_back(seed);
            sample.best = reached;
        }
    }

    /// Which seed comes first in which octant, and how near a surface found from it must be to end the search.
    void rank_seeds(Place& place, Vec3d centre, std::vector<Sample>& samples) const
    {
        const double tolerance = k_seed_tolerance * view_.header.r_max;
        std::vector<std::vector<double>> found(place.seeds.size());
        for (Sample& sample : samples) {
            sample.best = INFINITY;
            for (std::size_t k = 0; k < place.seeds.size(); ++k) {
                found[k].push_back(reach_from(centre, place.seeds[k], sample.point));
                sample.best = std::min(sample.best, found[k].back());
            }
        }
        double miss[8][model::k_max_seeds] = {};
        for (std::size_t k = 0; k < place.seeds.size(); ++k) {
            double reach = INFINITY;
            std::size_t i = 0;
            for (const Sample& sample : samples) {
                const double d_found = found[k][i++];
                if (d_found > sample.best + tolerance) reach = std::min(reach, d_found);
                const Vec3d d = sample.point - centre;
                for (int octant = 0; octant < 8; ++octant) {
                    bool here = true;
                    for (int axis = 0; axis < 3; ++axis) {
                        const double v = (octant >> axis & 1) != 0 ? d[axis] : -d[axis];
                        here = here && v > -1e-9;
                    }
                    if (here) miss[octant][k] += std::min(d_found, 1e3) - std::min(sample.best, 1e3);
                }
            }
            // Between samples it may come half a sample's spacing earlier.
            place.seeds[k] = model::with_reach(place.seeds[k], reach / grid_.cell - 0.25);
        }
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const double* m = miss[octant];
            const auto best = static_cast<std::uint32_t>(std::min_element(m, m + place.seeds.size()) - m);
            place.choices = model::with_seed_choice(place.choices, octant, best);
        }
    }

    struct SeedReach {
        Seed seed;
        double distance;
    };
    /// The owner's chart as a rule; another's where that one does not see the surface.
    SeedReach best_seed(Vec3d centre, Vec3d p, const mesh::ClosestPoint& truth, double tolerance) const
    {
        const std::uint32_t owner = part_of_triangle_[truth.triangle];
        const auto seed_of = [&](std::uint32_t part) { return seed_at(centre, p, part, truth, true); };
        SeedReach best{seed_of(owner), 0};
        best.distance = reach_from(centre, best.seed, p);
        for (std::uint32_t i = 0; i < view_.parts.size() && best.distance > truth.distance + tolerance; ++i) {
            if (i == owner || !test_domain(view_.parts[i], truth.point, 0).holds) continue;
            const Seed other = seed_of(i);
            if (const double d = reach_from(centre, other, p); d < best.distance) best = {other, d};
        }
        return best;
    }

    /// Distance that the runtime finds from a seed of the place about centre.
    double reach_from(Vec3d centre, Seed seed, Vec3d p) const
    {
        const model::Part& part = view_.parts[model::seed_part(seed)];
        const model::CentralMap map(view_, part);
        const Vec3f point = cast<float>(p), n = model::seed_normal(seed);
        const float gap = model::seed_gap(view_.locator, seed, cast<float>(p - centre));
        return std::sqrt(model::approach(map, part, map.to_chart_frame(point), map.to_chart_frame(point + gap * n)).distance_sq);
    }

    /// Outward normal of the surface at the point nearest to p.
    Vec3d normal_at(Vec3d p, const mesh::ClosestPoint& nearest, bool inside) const
    {
        Vec3d n = inside ? nearest.point - p : p - nearest.point;
        if (norm(n) < 1e-4 * grid_.cell) {
            const mesh::Triangle& t = solid_.mesh().triangles[nearest.triangle];
            const auto& v = solid_.mesh().vertices;
            n = cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
        }
        return n;
    }

    /// The plane that touches the surface at the point nearest to p, told from the place's centre; nothing where it is farther
    /// than planes can be stored.
    std::optional<PartPlane> plane_at(Vec3d centre, Vec3d p, const mesh::ClosestPoint& nearest, bool inside) const
    {
        const LocatorPlane plane = LocatorPlane::towards(normal_at(p, nearest, inside));
        // With the direction as stored.
        const double distance = dot(cast<double>(plane.normal()), nearest.point - centre) / grid_.cell;
        const float reach = view_.locator.plane_reach;
        if (!LocatorPlane::holds_distance(distance, reach)) return std::nullopt;
        return PartPlane{plane.with_distance(distance, reach), part_of_triangle_[nearest.triangle]};
    }

    /// A plane moved outwards by so much.
    LocatorPlane raised(LocatorPlane plane, double by) const
    {
        const float reach = view_.locator.plane_reach;
        return plane.with_distance(static_cast<double>(plane.distance(reach)) + by / grid_.cell, reach);
    }

    /// The plane that touches the surface at the point nearest to p, told from the place's centre.
    Seed seed_at(Vec3d centre, Vec3d p, std::uint32_t part, const mesh::ClosestPoint& nearest, bool inside) const
    {
        const Seed seed = model::make_seed(part, normal_at(p, nearest, inside));
        // With the direction as stored.
        return model::with_distance(seed, dot(cast<double>(model::seed_normal(seed)), nearest.point - centre), grid_.cell);
    }

    /// The parts that answer in a cell, best first: one that holds the whole cell suffices.
    void list_parts(Place& place, Vec3d centre, double side, std::uint32_t owner) const
    {
        std::vector<std::uint32_t> touching;
        std::int64_t holder = -1;
        double best = -1;
        for (std::uint32_t i = 0; i < view_.parts.size(); ++i) {
            const DomainTest test = test_domain(view_.parts[i], centre, 0.5 * side);
            if (!test.touches) continue;
            touching.push_back(i);
            if (!test.holds) continue;
            // One that sees a single surface there rather than layers, and the owner of the surface rather than another.
            const double score = fitness(i, centre) + (i == owner ? 0.5 : 0);
            if (score > best) {
                best = score;
                holder = i;
            }
        }
        if (holder >= 0) touching = {static_cast<std::uint32_t>(holder)};
        if (touching.size() > model::k_list_length || touching.empty()) {
            place.kind = LocatorCellKind::Ambiguous;  // held by none: free by the cover, but let the query say so
            return;
        }
        std::stable_partition(touching.begin(), touching.end(), [&](std::uint32_t i) { return i == owner; });
        for (std::size_t i = 0; i < touching.size(); ++i) place.parts[i] = static_cast<std::uint8_t>(touching[i]);
    }

    double fitness(std::uint32_t part, Vec3d p) const
    {
        const model::CentralMap map(view_, view_.parts[part]);
        const model::ChartPoint q = model::to_chart(map.to_chart_frame(cast<float>(p)));
        const model::Leaf leaf = map.leaf_at(q.face, q.s, q.t);
        return leaf.kind == model::CellKind::Layered ? (leaf.bilinear ? 1 : 0) : 2;
    }

    void pack()
    {
        data_.bricks.clear();
        data_.places.clear();
        data_.part_lists.clear();
        data_.planes.clear();
        data_.seeds.clear();
        data_.rises.clear();
        lists_.clear();
        Place any;
        any.parts[0] = 0;
        (void)list_index(any);  // so that there is one
        for (const Brick& brick : bricks_) {
            const auto first = static_cast<std::uint32_t>(data_.places.size());
            if (brick.kind == Brick::Kind::Free) {
                data_.bricks.push_back(LocatorBrick::free(model::encode_gap(brick.places.front().gap, grid_.cell)).word);
                continue;
            }
            data_.bricks.push_back(
                (brick.kind == Brick::Kind::Deep ? LocatorBrick::deep(first) : LocatorBrick::stored(first)).word);
            for (const Place& place : brick.places) pack_place(place);
        }
        // The eighths of divided places, behind everything else.
        std::size_t at = 0;
        for (const Brick& brick : bricks_) {
            if (brick.kind == Brick::Kind::Free) continue;
            for (const Place& place : brick.places) pack_eighths(at++, place);
        }
        data_.rises.resize(model::padded_rises(data_.places.size()), model::k_no_rise);
    }

    void pack_eighths(std::size_t at, const Place& place)
    {
        if (place.eighths.empty()) return;
        const std::size_t first = data_.places.size();
        if (first > model::k_max_first)
            throw mesh::InvalidInput("the locator needs more places than it can name: ask for a larger target error");
        data_.places[at] = LocatorCell::divided(static_cast<std::uint32_t>(first)).word;
        for (const Place& eighth : place.eighths) pack_place(eighth);
    }

    void pack_place(const Place& place)
    {
        data_.places.push_back(place_word(place));
        data_.rises.push_back(place.rise);
    }

    std::uint32_t place_word(const Place& place)
    {
        if (place.kind == LocatorCellKind::Free) return LocatorCell::free(model::encode_gap(place.gap, grid_.cell)).word;
        if (!place.eighths.empty()) return 0;  // see divide
        const std::optional<std::uint32_t> list = list_index(place);
        const auto planes = static_cast<std::uint32_t>(place.planes.size());
        const auto first = static_cast<std::uint32_t>(planes > 0 ? data_.planes.size() : pack_chain(place));
        if (first > model::k_max_first)
            throw mesh::InvalidInput("the locator needs more planes than a place can name: ask for a larger target error");
        // Too many lists for one more: all parts are asked, and a plane's part may be another.
        const std::uint32_t index = list.value_or(0);
        for (const PartPlane& p : place.planes) {
            std::uint32_t slot = model::k_list_length;
            for (std::uint32_t k = model::k_list_length; k-- > 0;)
                if (model::part_in_list(data_.part_lists[index], k) == p.part) slot = k;
            data_.planes.push_back(p.plane.with_slot(slot < model::k_list_length ? slot : 0u).word);
        }
        return LocatorCell::flat(list ? place.kind : LocatorCellKind::Ambiguous, index, planes, first).word;
    }

    /// Of the place's parts, and behind them its planes', which decide nothing.
    std::optional<std::uint32_t> list_index(const Place& place)
    {
        auto parts = place.parts;
        for (const PartPlane& p : place.planes) {
            const auto part = static_cast<std::uint8_t>(p.part);
            const auto at = std::find_if(parts.begin(), parts.end(), [&](auto q) { return q == part || q == model::k_no_part; });
            if (at != parts.end()) *at = part;
        }
        const std::uint32_t list = model::encode_list(parts);
        if (const auto found = lists_.find(list); found != lists_.end()) return found->second;
        if (lists_.size() == model::k_max_lists) return std::nullopt;
        const auto index = static_cast<std::uint32_t>(lists_.size());
        lists_.emplace(list, index);
        data_.part_lists.push_back(list);
        return index;
    }

    /// Returns the index of its first seed.
    std::size_t pack_chain(const Place& place)
    {
        auto& seeds = data_.seeds;
        if (place.seeds.size() > 1) seeds.push_back({place.choices, 0});
        const std::size_t first = seeds.size();
        seeds.insert(seeds.end(), place.seeds.begin(), place.seeds.end());
        seeds.back() = model::as_last(seeds.back());
        return first;
    }

    const mesh::Solid& solid_;
    std::span<const std::uint32_t> part_of_triangle_;
    model::ModelData& data_;
    model::ModelView view_;
    Grid grid_;
    double flat_tolerance_;
    std::vector<Brick> bricks_;
    bool keeps_near_ = false;  ///< in an update
    std::map<std::uint32_t, std::uint32_t> lists_;
};

}  // namespace

void bake_locator(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, double target_error,
                  unsigned threads, model::ModelData& data)
{
    if (data.parts.size() >= model::k_no_part) return;
    for (const model::Part& part : data.parts)
        if (part.base == 0) return;
    const auto maps = static_cast<double>(model::bytes_of<model::CentralArrays<model::ArrayData>>(data));
    const double all = byte_budget(solid.mesh().triangles.size(), target_error);
    const double budget = std::max(all - maps, k_least_share * all);
    const double undivided = k_undivided_share * budget;
    double cells = std::clamp(k_cells_along * std::sqrt(k_cells_target / target_error), k_least_cells, 160.0);
    const auto fewer = [&](double bytes) {
        cells = std::clamp(std::floor(cells * std::pow(undivided / bytes, 1 / k_growth)), k_least_cells, cells);
    };
    fewer(LocatorBaker(solid, part_of_triangle, target_error, cells, data).estimated_bytes(threads));
    for (;;) {
        LocatorBaker baker(solid, part_of_triangle, target_error, cells, data);
        baker.run(threads);
        const auto bytes = static_cast<double>(baker.packed_bytes());
        if (bytes <= budget || cells <= k_least_cells) {
            baker.divide(static_cast<std::size_t>(std::max(0.0, budget - bytes) / k_division_bytes), threads);
            return;
        }
        fewer(bytes);
    }
}

LocatorUpdate update_locator(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, double target_error,
                             const Change& change, unsigned threads, model::ModelData& data)
{
    return LocatorBaker(solid, part_of_triangle, target_error, data).update(change, threads);
}

}  // namespace sqmap::bake
