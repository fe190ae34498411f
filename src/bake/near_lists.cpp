#include "near_lists.h"

#include "budget.h"
#include "parallel.h"
#include "query/approach.h"
#include "query/triangle_offsets.h"
#include "sqmap/math/triangle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

namespace sqmap::bake {

namespace {

using model::PlaceKind;

/// A box is judged at the points of a lattice and in the boxes between them, so many along a side.
template <std::size_t k_boxes>
struct Lattice {
    static constexpr std::size_t k_side = k_boxes, k_along = k_side + 1;  ///< points along a side, x fastest
    static constexpr std::size_t k_points = k_along * k_along * k_along;
    static constexpr std::size_t k_room = (k_points + query::k_point_step - 1) / query::k_point_step * query::k_point_step;
    /// From a small box's lowest corner to its corners, in lattice points.
    static constexpr std::size_t k_steps[8] = {
        0, 1, k_along, k_along + 1, k_along* k_along, k_along* k_along + 1, k_along*(k_along + 1), k_along*(k_along + 1) + 1};
};
/// What the coarse one leaves is judged on the fine one, or, where time counts more than a fifth of the bytes, is the list.
using Coarse = Lattice<2>;
using Fine = Lattice<4>;
/// What float and rounding may be off by, in half sides of the box.
constexpr double k_slack = 1e-4;

/// The triangles nearest to some point of the box about centre of half side h, and a few more; those that are nearest most often
/// first. The distance to a triangle is convex. So in a box it is at most the multilinear function of its values at the corners,
/// and at least its tangent plane at any point; where one triangle's plane is above another's values at all corners, it is
/// nowhere the nearest.
class NearTriangles {
public:
    explicit NearTriangles(const mesh::Solid& solid) : solid_(solid) {}

    /// Boxes about centres, all within the box about middle of half side half.
    void begin(Vec3d middle, double half, std::span<const Vec3d> centres)
    {
        within_.clear();
        corners_.clear();
        const double reach = (solid_.closest_boundary(middle).distance + 2 * std::sqrt(3.0) * half) * (1 + 1e-6);
        solid_.bvh().visit_nearest(middle, reach * reach, [&](std::uint32_t t, double radius_sq) {
            if (solid_.boundary()[t] != mesh::Boundary::Buried) within_.push_back(t);
            return radius_sq;
        });
        std::sort(within_.begin(), within_.end());
        put_corners(within_, middle);
        // The last column is the middle itself.
        centres_ = (centres.size() + query::k_point_step) / query::k_point_step * query::k_point_step;
        for (std::size_t k = 0; k < 3; ++k) {
            centre_[k].resize(centres_);
            for (std::size_t i = 0; i < centres_; ++i) {
                const Vec3d p = i < centres.size() ? centres[i] - middle : Vec3d{};
                centre_[k][i] = static_cast<float>(p[static_cast<int>(k)]);
            }
            grow(to_centre_[k], within_.size() * centres_);
        }
        grow(from_centre_, within_.size() * centres_);
        query::triangle_offsets(corners_, {centre_[0].data(), centre_[1].data(), centre_[2].data(), centres_},
                                to_centre_[0].data(), to_centre_[1].data(), to_centre_[2].data(), from_centre_.data());
        all_.resize(within_.size());
        std::iota(all_.begin(), all_.end(), 0u);
        collect(all_, centres_ - 1, middle, half, some_);
    }

    /// Those of the box about the centre of that number.
    const std::vector<std::uint32_t>& operator()(std::size_t number, Vec3d centre, double h, bool fine)
    {
        collect(some_, number, centre, h, chosen_);
        triangles_.clear();
        for (const std::uint32_t i : chosen_) triangles_.push_back(within_[i]);
        judge<Coarse>(centre, h);
        if (fine) {
            triangles_ = near_;
            std::sort(triangles_.begin(), triangles_.end());
            judge<Fine>(centre, h);
        }
        return near_;
    }

private:
    static constexpr std::uint32_t k_none = 0xffffffffu;

    /// All of it is written over: what is there need not be cleared.
    static void grow(std::vector<float>& values, std::size_t count)
    {
        if (values.size() < count) values.resize(count);
    }

    Vec3d closest(std::uint32_t triangle, Vec3d p) const
    {
        const mesh::Triangle& t = solid_.mesh().triangles[triangle];
        const auto& v = solid_.mesh().vertices;
        return closest_point_on_triangle(p, v[t[0]], v[t[1]], v[t[2]]);
    }

    void put_corners(std::span<const std::uint32_t> triangles, Vec3d from)
    {
        corners_.clear();
        for (const std::uint32_t t : triangles)
            for (const std::uint32_t v : solid_.mesh().triangles[t])
                corners_.push_back(cast<float>(solid_.mesh().vertices[v] - from));
    }

    /// Whatever is no farther from the centre than the nearest by more than the box's diagonal, and not ruled out by that one.
    /// from, to: places in within_.
    void collect(const std::vector<std::uint32_t>& from, std::size_t number, Vec3d centre, double h,
                 std::vector<std::uint32_t>& to) const
    {
        to.clear();
        std::size_t nearest = within_.size();
        for (const std::uint32_t i : from)
            if ((nearest == within_.size() || from_centre_[i * centres_ + number] < from_centre_[nearest * centres_ + number]) &&
                solid_.boundary()[within_[i]] == mesh::Boundary::Whole)
                nearest = i;
        if (nearest == within_.size()) {
            to = from;
            return;
        }
        const auto corner = [&](int k) { return h * Vec3d{k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.}; };
        double limit[8];
        for (int k = 0; k < 8; ++k)
            limit[k] = norm(centre + corner(k) - closest(within_[nearest], centre + corner(k))) + k_slack * h;
        const auto fh = static_cast<float>(h);
        const float reach = from_centre_[nearest * centres_ + number] + (2 * 1.7321f + static_cast<float>(k_slack)) * fh;
        for (const std::uint32_t i : from) {
            const std::size_t at = i * centres_ + number;
            const float distance = from_centre_[at];
            if (distance > reach) continue;
            bool above = i != nearest && distance > fh * static_cast<float>(k_slack);
            const float scale = above ? -fh / distance : 0;
            for (int k = 0; k < 8 && above; ++k)
                above = static_cast<double>(distance + scale * ((k & 1 ? 1.f : -1.f) * to_centre_[0][at] +
                                                                (k & 2 ? 1.f : -1.f) * to_centre_[1][at] +
                                                                (k & 4 ? 1.f : -1.f) * to_centre_[2][at])) > limit[k];
            if (!above) to.push_back(i);
        }
    }

    /// What of the triangles is the nearest somewhere on a lattice, or not ruled out in all of its small boxes.
    template <class L>
    void judge(Vec3d centre, double h)
    {
        measure<L>(centre, h);
        near_.clear();
        wins_.assign(triangles_.size(), 0);
        for (std::size_t i = 0; i < L::k_points; ++i)
            if (nearest_[i] != k_none) ++wins_[nearest_[i]];
        order_.clear();
        auto& losers = losers_;
        losers.clear();
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) (wins_[t] > 0 ? order_ : losers).push_back(t);
        const float side = static_cast<float>(2 * h / L::k_side), slack = static_cast<float>(k_slack * h);
        const std::size_t out = rule_out<L>(0, losers.size(), 0, L::k_side, side, slack);
        order_.insert(order_.end(), losers.begin() + static_cast<std::ptrdiff_t>(out), losers.end());
        std::sort(order_.begin(), order_.end(), [&](std::uint32_t l, std::uint32_t r) {
            return wins_[l] != wins_[r] ? wins_[l] > wins_[r] : triangles_[l] < triangles_[r];
        });
        for (const std::uint32_t t : order_) near_.push_back(triangles_[t]);
    }

    /// Distances from the lattice, relative to the centre so that float is enough, and the nearest of each of its points. A
    /// triangle that is cut may not be boundary where it is nearest, and rules out nothing.
    template <class L>
    void measure(Vec3d centre, double h)
    {
        put_corners(triangles_, centre);
        for (std::size_t i = 0; i < L::k_room; ++i) {
            const std::size_t p = std::min(i, L::k_points - 1);
            const auto place = [&](std::size_t k) {
                return static_cast<float>(h * (2.0 / L::k_side * static_cast<double>(k % L::k_along) - 1));
            };
            point_[0][i] = place(p);
            point_[1][i] = place(p / L::k_along);
            point_[2][i] = place(p / (L::k_along * L::k_along));
        }
        for (auto* values : {&offset_[0], &offset_[1], &offset_[2], &distance_}) grow(*values, triangles_.size() * L::k_room);
        query::triangle_offsets(corners_, {point_[0].data(), point_[1].data(), point_[2].data(), L::k_room}, offset_[0].data(),
                                offset_[1].data(), offset_[2].data(), distance_.data());
        nearest_.fill(k_none);
        least_.fill(INFINITY);
        std::uint32_t* __restrict nearest = nearest_.data();
        float* __restrict least = least_.data();
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            if (solid_.boundary()[triangles_[t]] != mesh::Boundary::Whole) continue;
            const float* __restrict d = &distance_[t * L::k_room];
            for (std::size_t i = 0; i < L::k_room; ++i) {
                const std::uint32_t nearer = d[i] < least[i] ? 0xffffffffu : 0u;
                nearest[i] = (nearest[i] & ~nearer) | (t & nearer);
                least[i] = std::min(d[i], least[i]);
            }
        }
    }

    /// Of so many losers puts those first that are nowhere nearest in the box of so many small ones a side whose lowest
    /// corner is lattice point low; returns how many.
    template <class L>
    std::size_t rule_out(std::size_t first, std::size_t count, std::size_t low, std::size_t boxes, float small_side, float slack)
    {
        const float side = small_side * static_cast<float>(boxes);
        auto& losers = losers_;
        Rulers rulers;
        std::size_t corners[8];
        for (std::size_t k = 0; k < 8; ++k) corners[k] = low + L::k_steps[k] * boxes;
        for (const std::size_t at : corners) {
            const std::uint32_t r = nearest_[at];
            if (r == k_none || std::find(rulers.triangle, rulers.triangle + rulers.count, r) != rulers.triangle + rulers.count)
                continue;
            for (std::size_t k = 0; k < 8; ++k) rulers.value[rulers.count][k] = distance_[r * L::k_room + corners[k]];
            rulers.triangle[rulers.count++] = r;
        }
        std::size_t out = first;
        for (std::size_t i = first; i < first + count; ++i) {
            const std::uint32_t t = losers[i];
            // Distances change no faster than places.
            if (distance_[t * L::k_room + low] - least_[low] > 2 * 1.7321f * side + slack ||
                is_above<L>(t, corners, rulers, boxes == 1, side, slack))
                std::swap(losers[out++], losers[i]);
        }
        if (boxes == 1) return out - first;
        // The others have to lose in every small box.
        std::size_t still = first + count - out;
        for (std::size_t k = 0; k < 8 && still > 0; ++k)
            still = rule_out<L>(out, still, low + L::k_steps[k] * (boxes / 2), boxes / 2, small_side, slack);
        return out - first + still;
    }

    /// Triangles that are nearest at some corner of a box, with their distances from all of them.
    struct Rulers {
        std::uint32_t triangle[8];
        float value[8][8];
        std::size_t count = 0;
    };

    /// By the planes at the corners; all of them, or the most promising one.
    template <class L>
    bool is_above(std::uint32_t t, const std::size_t* corners, const Rulers& rulers, bool all, float side, float slack) const
    {
        // The plane that touches where it matters most is the best as a rule; in the end all are tried.
        float mine[8];
        std::size_t most = 0;
        float least_margin = INFINITY;
        for (std::size_t k = 0; k < 8; ++k) {
            mine[k] = distance_[t * L::k_room + corners[k]];
            const float margin = mine[k] - least_[corners[k]];
            most = margin < least_margin ? k : most;
            least_margin = std::min(margin, least_margin);
        }
        if (!(least_margin > slack)) return false;
        for (std::size_t tried = 0; tried < (all ? 8u : 1u); ++tried) {
            const std::size_t j = most ^ tried;
            const std::size_t value = t * L::k_room + corners[j];
            // Away from the triangle distance grows.
            const float scale = -side / mine[j];
            const float g[3] = {scale * offset_[0][value], scale * offset_[1][value], scale * offset_[2][value]};
            float plane[8];
            plane[0] = mine[j] - slack - ((j & 1) != 0 ? g[0] : 0) - ((j & 2) != 0 ? g[1] : 0) - ((j & 4) != 0 ? g[2] : 0);
            plane[1] = plane[0] + g[0];
            for (std::size_t k = 2; k < 4; ++k) plane[k] = plane[k - 2] + g[1];
            for (std::size_t k = 4; k < 8; ++k) plane[k] = plane[k - 4] + g[2];
            for (std::size_t r = 0; r < rulers.count; ++r) {
                float least = INFINITY;
                for (std::size_t k = 0; k < 8; ++k) least = std::min(least, plane[k] - rulers.value[r][k]);
                if (least > 0) return true;
            }
        }
        return false;
    }

    const mesh::Solid& solid_;
    std::vector<std::uint32_t> triangles_, near_, order_, wins_, losers_;
    std::vector<Vec3f> corners_;
    // What can be nearest somewhere in the boxes, and how it lies to their centres.
    std::vector<std::uint32_t> within_, all_, some_, chosen_;
    std::size_t centres_ = 0;
    std::vector<float> centre_[3], to_centre_[3], from_centre_;
    std::array<float, Fine::k_room> point_[3];
    std::vector<float> offset_[3], distance_;          // triangle after triangle, the lattice's values each
    std::array<std::uint32_t, Fine::k_room> nearest_;  // on the lattice
    std::array<float, Fine::k_room> least_;
};

/// How far the solid rises above the lowest of a place's planes within the place, as stored. A linear function is greatest at a
/// corner of the solid's part of the place: at one of the place's own corners, or where the surface is in it.
class Rise {
public:
    explicit Rise(const mesh::Solid& solid) : solid_(solid) {}

    std::uint8_t operator()(const model::ModelData& data, std::uint32_t place, Vec3d centre, double h,
                            const std::vector<std::uint32_t>& near)
    {
        const double cell = static_cast<double>(data.locator.cell);
        planes_.clear();
        for (std::uint32_t k = 0; k < model::place_planes(place); ++k) {
            const std::uint32_t plane = data.planes[model::place_first(place) + k];
            planes_.push_back({cast<double>(query::plane_normal(plane)),
                               cell * static_cast<double>(model::plane_distance(plane, data.locator.plane_reach)),
                               (plane & model::k_joined) != 0, 0});
        }
        const auto offer = [&](Vec3d p) {
            for (Plane& plane : planes_) plane.highest = std::max(plane.highest, dot(plane.normal, p) - plane.distance);
        };
        for (const std::uint32_t t : near) {
            polygon_.clear();
            for (const std::uint32_t v : solid_.mesh().triangles[t]) polygon_.push_back(solid_.mesh().vertices[v] - centre);
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {-1., 1.}) clip(axis, sign, h);
            for (const Vec3d& p : polygon_) offer(p);
        }
        for (int k = 0; k < 8; ++k) {
            const Vec3d corner = h * Vec3d{k & 1 ? 1. : -1., k & 2 ? 1. : -1., k & 4 ? 1. : -1.};
            const bool above = std::any_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
                return dot(plane.normal, corner) - plane.distance > plane.highest;
            });
            if (above && solid_.inside(centre + corner)) offer(corner);
        }
        // Nothing is above a group that is not above all of it.
        double highest = 0, least = 0;
        for (const Plane& plane : planes_) {
            if (!plane.joined) highest = std::max(highest, least);
            least = plane.joined ? std::min(least, plane.highest) : plane.highest;
        }
        highest = std::max(highest, least);
        const double steps = std::ceil((highest / cell + 1e-3) / static_cast<double>(model::k_rise_step));
        return steps < model::k_no_rise ? static_cast<std::uint8_t>(steps) : model::k_no_rise;
    }

private:
    struct Plane {
        Vec3d normal;
        double distance;
        bool joined;
        double highest;  ///< height of the solid above it
    };

    /// Keeps what is not beyond h along sign times an axis.
    void clip(int axis, double sign, double h)
    {
        kept_.clear();
        for (std::size_t i = 0; i < polygon_.size(); ++i) {
            const Vec3d &a = polygon_[i], &b = polygon_[(i + 1) % polygon_.size()];
            const double u = h - sign * a[axis], v = h - sign * b[axis];
            if (u >= 0) kept_.push_back(a);
            if ((u >= 0) != (v >= 0)) kept_.push_back(a + (u / (u - v)) * (b - a));
        }
        polygon_.swap(kept_);
    }

    const mesh::Solid& solid_;
    std::vector<Plane> planes_;
    std::vector<Vec3d> polygon_, kept_;
};

/// Of a place, or of the eighths that it is divided in.
void set_rises(Rise& rise, model::ModelData& data, std::uint32_t index, Vec3d centre, double h,
               const std::vector<std::uint32_t>& near)
{
    const std::uint32_t place = data.places[index];
    if (model::is_divided(place)) {
        for (std::uint32_t i = 0; i < 8; ++i) {
            const Vec3d offset = 0.5 * h * Vec3d{(i & 1) != 0 ? 1. : -1., (i & 2) != 0 ? 1. : -1., (i & 4) != 0 ? 1. : -1.};
            set_rises(rise, data, model::place_first(place) + i, centre + offset, 0.5 * h, near);
        }
    } else if (model::place_kind(place) == PlaceKind::Mixed && model::place_planes(place) > 0) {
        data.rises[index] = rise(data, place, centre, h, near);
    }
}

}  // namespace

namespace {

constexpr double k_least_near_share = 0.4;

/// What is left for the lists.
double near_budget(const model::ModelData& data, double target_error)
{
    const model::ModelView v = data.view();
    const std::size_t others = v.parts.size_bytes() + v.samples.size_bytes() + v.offsets.size_bytes() + v.smoothing.size_bytes() +
                               v.cells.size_bytes() + v.blocks.size_bytes() + v.splits.size_bytes() + v.specials.size_bytes() +
                               v.pool.size_bytes() + v.vertices.size_bytes() + v.triangles16.size_bytes() +
                               v.triangles32.size_bytes() + v.triangle_part.size_bytes() + v.piece_triangle.size_bytes() +
                               v.pieces.size_bytes() + v.bricks.size_bytes() + v.places.size_bytes() + v.part_lists.size_bytes() +
                               v.planes.size_bytes() + v.seeds.size_bytes() + v.rises.size_bytes() + 4 * v.bricks.size();
    const double all = model_byte_budget(v.triangle_part.size(), target_error);
    // A large map must not take them all.
    return std::max(all - static_cast<double>(others), k_least_near_share * all);
}

/// A brick's record before it is packed: see model::NearRecord.
struct Record {
    std::uint64_t occupied = 0;
    std::vector<std::uint32_t> starts{0}, triangles, refs;
    std::span<const std::uint16_t> packed{};  ///< or as it was before an update

    void add(const std::vector<std::uint32_t>& near)
    {
        // Where a brick's lists are too long, the rest of its places tries all of the brick's triangles.
        const bool room = refs.size() + near.size() <= 0xffff;
        for (const std::uint32_t t : near) {
            const auto at = std::find(triangles.begin(), triangles.end(), t);
            if (room) refs.push_back(static_cast<std::uint32_t>(at - triangles.begin()));
            if (at == triangles.end()) triangles.push_back(t);
        }
        starts.push_back(static_cast<std::uint32_t>(refs.size()));
    }
    bool narrow() const { return triangles.size() <= 256; }
    std::size_t values(bool wide) const
    {
        if (!packed.empty()) return packed.size();
        return model::k_near_head + starts.size() + triangles.size() * (wide ? 2 : 1) +
               (narrow() ? (refs.size() + 1) / 2 : refs.size());
    }
    /// Each place tries all of the brick's triangles.
    void drop_lists(bool wide)
    {
        if (!packed.empty()) {
            const model::NearRecord r = model::near_record(packed.data(), wide);
            const model::NearList all{r.table, nullptr, 0, r.triangles, wide, false};
            for (std::uint32_t i = 0; i < all.count; ++i) triangles.push_back(all[i]);
            starts.resize(static_cast<std::size_t>(std::popcount(occupied)) + 1);
        }
        packed = {};
        refs.clear();
        std::fill(starts.begin(), starts.end(), 0u);
    }
    /// Each place tries all triangles of the mesh.
    void drop_triangles(bool wide)
    {
        drop_lists(wide);
        triangles.clear();
    }
    void pack(bool wide, std::vector<std::uint16_t>& out) const
    {
        if (!packed.empty()) {
            out.insert(out.end(), packed.begin(), packed.end());
            return;
        }
        for (int k = 0; k < 4; ++k) out.push_back(static_cast<std::uint16_t>(occupied >> 16 * k));
        out.push_back(static_cast<std::uint16_t>(triangles.size()));
        for (const std::uint32_t s : starts) out.push_back(static_cast<std::uint16_t>(s));
        for (const std::uint32_t t : triangles) {
            out.push_back(static_cast<std::uint16_t>(t));
            if (wide) out.push_back(static_cast<std::uint16_t>(t >> 16));
        }
        for (std::size_t i = 0; i < refs.size(); i += narrow() ? 2 : 1)
            out.push_back(static_cast<std::uint16_t>(refs[i] | (narrow() && i + 1 < refs.size() ? refs[i + 1] << 8 : 0)));
    }
};

/// A brick's record as it is in the model.
std::span<const std::uint16_t> packed_record(const model::ModelView& view, std::size_t brick)
{
    const bool wide = model::near_is_wide(view);
    const std::uint16_t* first = view.near.data() + view.near_bricks[brick];
    const model::NearRecord r = model::near_record(first, wide);
    const std::size_t refs = r.starts[std::popcount(r.occupied)];
    return {first, static_cast<std::size_t>(r.refs - first) + (r.triangles <= 256 ? (refs + 1) / 2 : refs)};
}

/// Where they take more bytes, the longest bricks' lists go, and then, if that does not do, their triangles.
void keep_within(double budget, bool wide, std::vector<Record>& records)
{
    for (Record& record : records)
        if (record.triangles.size() > 0xffff) record.drop_triangles(wide);
    for (const bool lists : {true, false}) {
        const auto bytes_of = [&](const Record& r) { return 2.0 * static_cast<double>(r.values(wide)); };
        double bytes = 0;
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < records.size(); ++i) {
            if (records[i].occupied == 0) continue;
            bytes += bytes_of(records[i]);
            order.push_back(i);
        }
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return bytes_of(records[a]) > bytes_of(records[b]); });
        for (std::size_t k = 0; k < order.size() && bytes > budget; ++k) {
            Record& record = records[order[k]];
            bytes -= bytes_of(record);
            if (lists)
                record.drop_lists(wide);
            else
                record.drop_triangles(wide);
            bytes += bytes_of(record);
        }
    }
}

/// before, update: null, or what was there, of which places that are not reached keep their lists.
void bake_lists(const mesh::Solid& solid, const model::ModelView* before, const LocatorUpdate* update, double target_error,
                unsigned threads, model::ModelData& data)
{
    data.near_bricks.clear();
    data.near.clear();
    if (data.bricks.empty() || data.triangle_part.empty()) {
        data.rises.clear();
        return;
    }
    const model::Locator& l = data.locator;
    const bool wide = data.triangle_part.size() > 0x10000;
    std::vector<Record> records(data.bricks.size());
    parallel_for(data.bricks.size(), threads, [&](std::size_t b) {
        const std::uint32_t brick = data.bricks[b];
        if ((brick & model::k_free_brick) != 0) return;
        NearTriangles near_triangles(solid);
        Rise rise(solid);
        constexpr int n = model::k_brick;
        const double cell = static_cast<double>(l.cell);
        const Vec3d origin = cast<double>(model::vec3(l.origin));
        const Vec3d lowest = origin + n * cell *
                                          Vec3d{double(b % l.bricks[0]), double(b / l.bricks[0] % l.bricks[1]),
                                                double(b / (std::size_t{l.bricks[0]} * l.bricks[1]))};
        const bool deep = (brick & model::k_deep_brick) != 0;
        // What is asked there may lie beside it by rounding.
        const double slack = 1.0005;
        Record& record = records[b];
        std::vector<Vec3d> centres, group_centres;
        std::vector<std::uint32_t> places, numbers, kept;
        std::vector<std::size_t> group;
        std::vector<std::vector<std::uint32_t>> lists;
        const std::uint32_t was = update != nullptr ? update->brick_before[b] : LocatorUpdate::k_no_brick;
        const std::uint64_t reached = was == LocatorUpdate::k_no_brick ? ~std::uint64_t{0} : update->reached[b];
        if (reached == 0) {
            record.occupied = model::near_record(before->near.data() + before->near_bricks[was], wide).occupied;
            record.packed = packed_record(*before, was);
            return;
        }
        const double half = deep ? 0.5 * n * cell : 0.5 * cell;
        const Vec3d middle = lowest + 0.5 * n * cell * Vec3d{1, 1, 1};
        for (int k = 0; k < (deep ? 1 : n * n * n); ++k) {
            const std::uint32_t place = (brick & ~model::k_deep_brick) + static_cast<std::uint32_t>(k);
            if (model::place_kind(data.places[place]) == PlaceKind::Free) continue;
            record.occupied |= std::uint64_t{1} << k;
            places.push_back(place);
            numbers.push_back(static_cast<std::uint32_t>(k));
            if ((reached >> k & 1u) == 0) continue;
            centres.push_back(deep ? middle : lowest + cell * Vec3d{k % n + 0.5, k / n % n + 0.5, k / (n * n) + 0.5});
        }
        // Eight places at a time: what can be nearest somewhere in the whole brick is four times as many.
        lists.resize(centres.size());
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            group.clear();
            group_centres.clear();
            Vec3d lo{INFINITY, INFINITY, INFINITY}, hi = -lo;
            for (std::size_t i = 0; i < centres.size(); ++i) {
                const Vec3d d = centres[i] - middle;
                if (!deep && ((d.x > 0 ? 1u : 0u) | (d.y > 0 ? 2u : 0u) | (d.z > 0 ? 4u : 0u)) != octant) continue;
                if (deep && octant > 0) continue;
                group.push_back(i);
                group_centres.push_back(centres[i]);
                for (int k = 0; k < 3; ++k) {
                    lo[k] = std::min(lo[k], centres[i][k]);
                    hi[k] = std::max(hi[k], centres[i][k]);
                }
            }
            if (group.empty()) continue;
            const double side = std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z});
            near_triangles.begin(0.5 * (lo + hi), slack * (0.5 * side + half), group_centres);
            for (std::size_t i = 0; i < group.size(); ++i)
                lists[group[i]] = near_triangles(i, group_centres[i], slack * half, update == nullptr);
        }
        // A brick whose lists were too long to keep has none to take over, and gets none.
        bool no_lists = false, no_triangles = false;
        if (was != LocatorUpdate::k_no_brick && before->near_bricks[was] != model::k_no_near && reached != ~std::uint64_t{0}) {
            const model::NearRecord r = model::near_record(before->near.data() + before->near_bricks[was], wide);
            no_lists = r.starts[std::popcount(r.occupied)] == 0;
            no_triangles = r.triangles == 0;
        }
        for (std::size_t i = 0, fresh = 0; i < places.size(); ++i) {
            if ((reached >> numbers[i] & 1u) == 0) {
                const model::NearList list = model::near_list(*before, was, numbers[i]);
                kept.clear();
                for (std::uint32_t j = 0; j < list.count; ++j) kept.push_back(list[j]);
                record.add(kept);
                continue;
            }
            const std::vector<std::uint32_t>& near = lists[fresh];
            set_rises(rise, data, places[i], centres[fresh], slack * half, near);
            record.add(near);
            ++fresh;
        }
        if (no_lists) record.drop_lists(wide);
        if (no_triangles) record.drop_triangles(wide);
    });
    keep_within(near_budget(data, target_error), wide, records);
    for (std::size_t b = 0; b < records.size(); ++b) {
        const bool free = (data.bricks[b] & model::k_free_brick) != 0;
        data.near_bricks.push_back(free ? model::k_no_near : static_cast<std::uint32_t>(data.near.size()));
        if (!free) records[b].pack(wide, data.near);
    }
}

}  // namespace

void bake_near_lists(const mesh::Solid& solid, double target_error, unsigned threads, model::ModelData& data)
{
    bake_lists(solid, nullptr, nullptr, target_error, threads, data);
}

void update_near_lists(const mesh::Solid& solid, const model::ModelView& before, const LocatorUpdate& update, double target_error,
                       unsigned threads, model::ModelData& data)
{
    bake_lists(solid, &before, &update, target_error, threads, data);
}

}  // namespace sqmap::bake
