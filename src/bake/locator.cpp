#include "locator.h"

#include "parallel.h"
#include "query/approach.h"

#include <algorithm>
#include <array>
#include <compare>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

namespace sqmap::bake {

namespace {

using model::PlaceKind;

constexpr int k_places = model::k_brick * model::k_brick * model::k_brick;
// Cells along the longest side of the object's box.
const double k_cells_along = getenv("CELLS")?atof(getenv("CELLS")):48;

// By how much of R_max a sample may miss its nearest surface before it gets one of its own.
constexpr double k_seed_tolerance = 0.0005;

/// Where a cell is sampled, in cells from its centre: its corners, the middles of its sides and edges.
std::vector<Vec3d> sample_offsets()
{
    std::vector<Vec3d> offsets;
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) offsets.push_back(0.45 * Vec3d{double(i), double(j), double(k)});
    return offsets;
}

struct Grid {
    Vec3d origin;
    double cell = 0;
    int n[3] = {};  ///< cells

    Vec3d centre(int i, int j, int k) const { return origin + cell * Vec3d{i + 0.5, j + 0.5, k + 0.5}; }
};

Grid grid_about(const mesh::Mesh& mesh)
{
    Vec3d lo = mesh.vertices.front(), hi = lo;
    for (const Vec3d& v : mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], v[k]);
            hi[k] = std::max(hi[k], v[k]);
        }
    Grid grid;
    // In float from here on: the runtime must see the very same grid.
    grid.cell = static_cast<float>(std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}) / k_cells_along);
    for (int k = 0; k < 3; ++k) {
        const double margin = 0.01 * grid.cell;
        const int bricks = static_cast<int>(std::ceil((hi[k] - lo[k] + 2 * margin) / (model::k_brick * grid.cell)));
        grid.n[k] = model::k_brick * std::max(bricks, 1);
        grid.origin[k] = static_cast<float>(0.5 * (lo[k] + hi[k]) - 0.5 * grid.cell * grid.n[k]);
    }
    return grid;
}

struct Seed {
    std::uint32_t code;
    std::uint8_t reach;
    auto operator<=>(const Seed&) const = default;
};

/// What is known of a cell before it is packed.
struct Place {
    PlaceKind kind = PlaceKind::Free;
    double gap = 0;  ///< Free
    std::array<std::uint8_t, model::k_list_length> parts{model::k_no_part, model::k_no_part, model::k_no_part, model::k_no_part};
    std::vector<Seed> seeds;
    std::uint32_t choices = 0;  ///< which seed comes first in each octant, three bits each
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
        const double value = dot(n, d), reach = 1.00001 * h * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
        const double lo = part.chart_lo[i], hi = part.chart_hi[i], slack = 1e-5 * (hi - lo);
        if (value + reach < lo - slack || value - reach > hi + slack) test.touches = false;
        if (value - reach < lo + slack || value + reach > hi - slack) test.holds = false;
    }
    return test;
}

class LocatorBaker {
public:
    LocatorBaker(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, model::ModelData& data)
        : solid_(solid), part_of_triangle_(part_of_triangle), data_(data), view_(data.view()), grid_(grid_about(solid.mesh()))
    {
    }

    void run(unsigned threads)
    {
        const int bx = grid_.n[0] / model::k_brick, by = grid_.n[1] / model::k_brick, bz = grid_.n[2] / model::k_brick;
        for (int k = 0; k < 3; ++k) {
            data_.locator.origin[k] = static_cast<float>(grid_.origin[k]);
            data_.locator.bricks[k] = static_cast<std::uint32_t>(grid_.n[k] / model::k_brick);
        }
        data_.locator.cell = static_cast<float>(grid_.cell);
        view_ = data_.view();
        bricks_.resize(static_cast<std::size_t>(bx * by * bz));
        parallel_for(bricks_.size(), threads, [&](std::size_t i) {
            const int b = static_cast<int>(i);
            bake_brick(bricks_[i], b % bx, b / bx % by, b / (bx * by));
        });
        pack();
    }

private:
    struct Brick {
        bool free = false;
        double gap = 0;
        std::array<Place, k_places> places;
    };

    void bake_brick(Brick& brick, int bx, int by, int bz)
    {
        constexpr int n = model::k_brick;
        const Vec3d middle = grid_.origin + grid_.cell * Vec3d{n * (bx + 0.5), n * (by + 0.5), n * (bz + 0.5)};
        const double brick_reach = 0.5 * std::sqrt(3.0) * n * grid_.cell;
        const double distance = solid_.closest_boundary(middle).distance;
        if (distance > brick_reach * 1.00001 && !solid_.inside(middle)) {
            brick.free = true;
            brick.gap = distance;
            return;
        }
        for (int i = 0; i < k_places; ++i)
            brick.places[static_cast<std::size_t>(i)] = bake_place(grid_.centre(n * bx + i % n, n * by + i / n % n, n * bz + i / (n * n)));
    }

    Place bake_place(Vec3d centre) const
    {
        Place place;
        const mesh::ClosestPoint nearest = solid_.closest_boundary(centre);
        const double reach = 0.5 * std::sqrt(3.0) * grid_.cell;
        const bool crossed = nearest.distance <= reach * 1.00001;
        if (!crossed && !solid_.inside(centre)) {
            place.gap = nearest.distance;
            return place;
        }
        place.kind = crossed ? PlaceKind::Mixed : PlaceKind::Inside;
        const std::uint32_t owner = part_of_triangle_[nearest.triangle];
        choose_seeds(place, centre, nearest);
        if (crossed) list_parts(place, centre, owner);
        return place;
    }

    /// Enough seeds that every sample of the cell that lies in the solid finds its nearest surface from one of them.
    void choose_seeds(Place& place, Vec3d centre, const mesh::ClosestPoint& nearest) const
    {
        place.seeds = {{seed_at(centre, part_of_triangle_[nearest.triangle], nearest.point), 255}};
        const double tolerance = k_seed_tolerance * view_.header.r_max;
        struct Sample {
            Vec3d point;
            double best;  ///< distance that some seed finds
        };
        std::vector<Sample> samples;
        mesh::ClosestPoint truth = nearest;
        for (const Vec3d& offset : sample_offsets()) {
            const Vec3d p = centre + grid_.cell * offset;
            truth = solid_.closest_boundary(p, 1.000001 * norm(p - truth.point) + 1e-12);  // no farther than the last one's
            if (place.kind == PlaceKind::Mixed && !solid_.inside(p)) continue;
            double found = INFINITY;
            for (const Seed& seed : place.seeds) found = std::min(found, reach_from(centre, seed.code, p));
            if (found > truth.distance + tolerance && place.seeds.size() < model::k_most_seeds) {
                const auto [seed, reached] = best_seed(centre, p, truth, tolerance);
                if (reached < found - tolerance) {
                    place.seeds.push_back({seed, 255});
                    found = reached;
                }
            }
            samples.push_back({p, found});
        }
        if (place.seeds.size() == 1) return;
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            std::size_t best = 0;
            double least = INFINITY;
            for (std::size_t k = 0; k < place.seeds.size(); ++k) {
                double sum = 0;
                for (const Sample& sample : samples) {
                    const Vec3d d = sample.point - centre;
                    const double slack = -1e-9;
                    const bool here = (d.x > slack || (octant & 1) == 0) && (d.x < -slack || (octant & 1) != 0) && (d.y > slack || (octant & 2) == 0) &&
                                      (d.y < -slack || (octant & 2) != 0) && (d.z > slack || (octant & 4) == 0) && (d.z < -slack || (octant & 4) != 0);
                    if (here) sum += std::min(reach_from(centre, place.seeds[k].code, sample.point), 100.0) - sample.best;
                }
                if (sum < least) {
                    least = sum;
                    best = k;
                }
            }
            place.choices |= static_cast<std::uint32_t>(best) << 3 * octant;
        }
        // From which distance on a surface found from a seed may be bettered by another.
        for (Seed& seed : place.seeds) {
            double reach = INFINITY;
            for (const Sample& sample : samples)
                if (const double d = reach_from(centre, seed.code, sample.point); d > sample.best + tolerance) reach = std::min(reach, d);
            // Between samples it may come half a sample's spacing earlier.
            const double steps = std::floor((reach / grid_.cell - 0.25) / model::k_seed_reach_step);
            seed.reach = static_cast<std::uint8_t>(std::clamp(steps, 0.0, 255.0));
        }
    }

    struct SeedReach {
        std::uint32_t code;
        double distance;
    };
    /// The owner's chart as a rule; another's where that one does not see the surface.
    SeedReach best_seed(Vec3d centre, Vec3d p, const mesh::ClosestPoint& truth, double tolerance) const
    {
        const std::uint32_t owner = part_of_triangle_[truth.triangle];
        SeedReach best{seed_at(centre, owner, truth.point), 0};
        best.distance = reach_from(centre, best.code, p);
        for (std::uint32_t i = 0; i < view_.parts.size() && best.distance > truth.distance + tolerance; ++i) {
            if (i == owner || !test_domain(view_.parts[i], truth.point, 0).holds) continue;
            const std::uint32_t other = seed_at(centre, i, truth.point);
            if (const double d = reach_from(centre, other, p); d < best.distance) best = {other, d};
        }
        return best;
    }

    /// Distance that the runtime finds from a seed of the place about centre.
    double reach_from(Vec3d centre, std::uint32_t seed, Vec3d p) const
    {
        const model::Part& part = view_.parts[model::seed_part(seed)];
        const query::CentralMap map(view_, part);
        const Vec3f point = cast<float>(p), c = cast<float>(centre), n = query::seed_direction(seed);
        const Vec3f start = point + (query::seed_length(view_.locator, seed) - dot(n, point - c)) * n;
        return std::sqrt(query::approach(map, part, map.to_chart_frame(point), map.to_chart_frame(start)).distance_sq);
    }

    /// A seed whose plane passes through a surface point, across the line to it.
    std::uint32_t seed_at(Vec3d centre, std::uint32_t part, Vec3d surface_point) const
    {
        const Vec3d d = surface_point - centre;
        const double length = norm(d);
        const double steps = std::round(length / (model::k_seed_distance_step * grid_.cell));
        constexpr int cells = 1 << model::k_seed_normal_bits;
        const Vec3d n = length > 0 ? d / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z)) : Vec3d{0, 0, 1};
        const double fold_x = n.z < 0 ? (1 - std::abs(n.y)) * (n.x < 0 ? -1 : 1) : n.x;
        const double fold_y = n.z < 0 ? (1 - std::abs(n.x)) * (n.y < 0 ? -1 : 1) : n.y;
        const auto code = [](double v) { return static_cast<std::uint32_t>(std::clamp(static_cast<int>((v + 1) * 0.5 * cells), 0, cells - 1)); };
        return part | code(fold_x) << 8 | code(fold_y) << (8 + model::k_seed_normal_bits) |
               static_cast<std::uint32_t>(std::min<double>(steps, model::k_max_seed_distance)) << 22;
    }

    /// The parts that answer in a cell, best first: one that holds the whole cell suffices.
    void list_parts(Place& place, Vec3d centre, std::uint32_t owner) const
    {
        std::vector<std::uint32_t> touching;
        std::int64_t holder = -1;
        double best = -1;
        for (std::uint32_t i = 0; i < view_.parts.size(); ++i) {
            const DomainTest test = test_domain(view_.parts[i], centre, 0.5 * grid_.cell);
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
        if (touching.size() > model::k_list_length) {
            place.kind = PlaceKind::Ask;
            return;
        }
        std::stable_partition(touching.begin(), touching.end(), [&](std::uint32_t i) { return i == owner; });
        for (std::size_t i = 0; i < touching.size(); ++i) place.parts[i] = static_cast<std::uint8_t>(touching[i]);
        if (touching.empty()) place.kind = PlaceKind::Ask;  // free by the cover, but let the query say so
    }

    double fitness(std::uint32_t part, Vec3d p) const
    {
        const query::CentralMap map(view_, view_.parts[part]);
        const query::ChartPoint q = query::to_chart(map.to_chart_frame(cast<float>(p)));
        const query::Leaf leaf = map.leaf_at(q.face, q.s, q.t);
        return leaf.kind == model::CellKind::Layered ? (leaf.bilinear ? 1 : 0) : 2;
    }

    std::uint32_t gap_code(double gap) const
    {
        // Rounded down, with room for the runtime's own rounding.
        const double steps = std::floor(gap * (1 - 1e-5) / (grid_.cell * model::k_gap_step));
        return static_cast<std::uint32_t>(std::clamp(steps, 0.0, 1048575.0));
    }

    void pack()
    {
        std::map<std::uint32_t, std::uint32_t> lists;
        std::map<std::pair<std::uint32_t, std::vector<Seed>>, std::uint32_t> chains;
        for (const Brick& brick : bricks_) {
            if (brick.free) {
                data_.bricks.push_back(model::k_free_brick | gap_code(brick.gap));
                continue;
            }
            data_.bricks.push_back(static_cast<std::uint32_t>(data_.places.size()));
            for (const Place& place : brick.places) {
                if (place.kind == PlaceKind::Free) {
                    data_.places.push_back(gap_code(place.gap) << 2);
                    continue;
                }
                PlaceKind kind = place.kind;
                std::uint32_t list = 0;
                for (std::uint32_t k = 0; k < model::k_list_length; ++k) list |= static_cast<std::uint32_t>(place.parts[k]) << 8 * k;
                auto [at, is_new] = lists.try_emplace(list, static_cast<std::uint32_t>(lists.size()));
                if (is_new && at->second > 0xfff) lists.erase(at);
                else if (is_new) data_.part_lists.push_back(list);
                std::uint32_t list_index = 0;
                if (const auto found = lists.find(list); found != lists.end())
                    list_index = found->second;
                else
                    kind = PlaceKind::Ask;
                const auto [chain, new_chain] = chains.try_emplace({place.choices, place.seeds}, static_cast<std::uint32_t>(data_.locator_seeds.size()) + (place.seeds.size() > 1 ? 1u : 0u));
                if (new_chain) {
                    if (place.seeds.size() > 1) {
                        data_.locator_seeds.push_back(place.choices);
                        data_.seed_reaches.push_back(0);
                    }
                    for (const Seed& seed : place.seeds) {
                        data_.locator_seeds.push_back(seed.code);
                        data_.seed_reaches.push_back(seed.reach);
                    }
                    data_.locator_seeds.back() |= model::k_last_seed;
                }
                data_.places.push_back(static_cast<std::uint32_t>(kind) | list_index << 2 | chain->second << 14);
            }
        }
    }

    const mesh::Solid& solid_;
    std::span<const std::uint32_t> part_of_triangle_;
    model::ModelData& data_;
    model::ModelView view_;
    Grid grid_;
    std::vector<Brick> bricks_;
};

}  // namespace

void bake_locator(const mesh::Solid& solid, std::span<const std::uint32_t> part_of_triangle, unsigned threads,
                  model::ModelData& data)
{
    if (data.parts.size() >= model::k_no_part) return;
    for (const model::Part& part : data.parts)
        if (part.base == 0) return;
    LocatorBaker(solid, part_of_triangle, data).run(threads);
}

}  // namespace sqmap::bake
