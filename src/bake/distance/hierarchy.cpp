// Groups of near triangles by the surface area heuristic: J. Goldsmith, J. Salmon, "Automatic creation of object hierarchies for
// ray tracing", IEEE CG&A 7(5), 1987. Only cuts that leave full groups on one side are tried, so that no index has to be stored.
#include "bake/distance/hierarchy.h"

#include "model/flags.h"
#include "model/hierarchy.h"

#include <algorithm>
#include <numeric>

namespace sqmap::bake {

namespace {

using model::HierarchyBox;
using model::k_hierarchy_leaf;
using model::k_hierarchy_width;

void add(HierarchyBox& box, const HierarchyBox& other)
{
    for (int k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], other.lo[k]);
        box.hi[k] = std::max(box.hi[k], other.hi[k]);
    }
}

constexpr HierarchyBox k_empty{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

double area(const HierarchyBox& box)
{
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = static_cast<double>(box.hi[k]) - static_cast<double>(box.lo[k]);
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

class Grouping {
public:
    explicit Grouping(std::span<const HierarchyBox> boxes) : boxes_(boxes), order_(boxes.size()), area_after_(boxes.size())
    {
        std::iota(order_.begin(), order_.end(), 0u);
        std::size_t unit = k_hierarchy_leaf;
        while (unit < order_.size()) unit *= k_hierarchy_width;
        divide(0, order_.size(), unit);
    }
    const std::vector<std::uint32_t>& order() const { return order_; }

private:
    /// Into groups of unit entries, and those further.
    void divide(std::size_t first, std::size_t last, std::size_t unit)
    {
        while (last - first <= unit) {
            if (unit == k_hierarchy_leaf) return;
            unit /= k_hierarchy_width;
        }
        double least = INFINITY;
        std::size_t cut = first + unit;
        int axis = 0;
        for (int k = 0; k < 3; ++k) {
            sort(first, last, k);
            HierarchyBox box = k_empty;
            for (std::size_t i = last; i-- > first;) {
                add(box, boxes_[order_[i]]);
                area_after_[i] = area(box);
            }
            box = k_empty;
            for (std::size_t i = first; i < last; ++i) {
                if (i > first && (i - first) % unit == 0) {
                    const double cost =
                        area(box) * static_cast<double>(i - first) + area_after_[i] * static_cast<double>(last - i);
                    if (cost < least) {
                        least = cost;
                        cut = i;
                        axis = k;
                    }
                }
                add(box, boxes_[order_[i]]);
            }
        }
        sort(first, last, axis);
        divide(first, cut, unit);
        divide(cut, last, unit);
    }

    void sort(std::size_t first, std::size_t last, int axis)
    {
        const auto key = [&](std::uint32_t i) { return boxes_[i].lo[axis] + boxes_[i].hi[axis]; };
        std::sort(order_.begin() + static_cast<std::ptrdiff_t>(first), order_.begin() + static_cast<std::ptrdiff_t>(last),
                  [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    }

    std::span<const HierarchyBox> boxes_;
    std::vector<std::uint32_t> order_;
    std::vector<double> area_after_;
};

void grow(HierarchyBox& box, const float* corner)
{
    for (int k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], corner[k]);
        box.hi[k] = std::max(box.hi[k], corner[k]);
    }
}

/// A leaf's triangles, three corners each.
using Corners = std::vector<Vec3d>;

/// A cylinder about a leaf's triangles, before it is stored.
struct Cylinder {
    Vec3d centre;
    std::uint8_t axis[2];
};

/// About the mean normal, midway between the corners' extremes.
Cylinder cylinder_about(const Corners& corners)
{
    Vec3d normal{};
    for (std::size_t i = 0; i < corners.size(); i += 3) normal += cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]);
    Cylinder cylinder;
    model::encode_axis(normal, cylinder.axis[0], cylinder.axis[1]);
    const Vec3d n = cast<double>(model::decode_axis(cylinder.axis[0], cylinder.axis[1]));
    const Vec3d u = normalized(cross(n, std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})), v = cross(n, u);
    const Vec3d axes[3] = {n, u, v};
    for (const Vec3d& axis : axes) {
        double lo = INFINITY, hi = -INFINITY;
        for (const Vec3d& p : corners) {
            lo = std::min(lo, dot(axis, p));
            hi = std::max(hi, dot(axis, p));
        }
        cylinder.centre += 0.5 * (lo + hi) * axis;
    }
    return cylinder;
}

/// Half height and radius that hold the corners.
std::pair<double, double> extent_of(const Corners& corners, Vec3d centre, Vec3d axis)
{
    double height = 0, radius = 0;
    for (const Vec3d& p : corners) {
        const double along = dot(axis, p - centre);
        height = std::max(height, std::abs(along));
        radius = std::max(radius, norm(p - centre - along * axis));
    }
    return {height, radius};
}

model::HierarchyGroup make_group(std::span<const Corners> leaves)
{
    model::HierarchyGroup group{};
    std::vector<Cylinder> cylinders;
    for (const Corners& leaf : leaves) cylinders.push_back(cylinder_about(leaf));
    double extent = 0;
    for (int k = 0; k < 3; ++k) {
        double lo = INFINITY, hi = -INFINITY;
        for (const Cylinder& c : cylinders) {
            lo = std::min(lo, c.centre[k]);
            hi = std::max(hi, c.centre[k]);
        }
        group.origin[k] = static_cast<float>(lo);
        extent = std::max(extent, hi - lo);
    }
    group.step = std::max(static_cast<float>(extent / 255), 1e-30f);
    std::vector<std::pair<double, double>> extents;
    double height = 0, radius = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        Vec3d centre;
        for (int k = 0; k < 3; ++k) {
            const double steps =
                (cylinders[i].centre[k] - static_cast<double>(group.origin[k])) / static_cast<double>(group.step);
            group.centre[k][i] = static_cast<std::uint8_t>(std::clamp(std::round(steps), 0.0, 255.0));
            centre[k] = static_cast<double>(group.origin[k]) + static_cast<double>(group.step) * group.centre[k][i];
        }
        for (int k = 0; k < 2; ++k) group.axis[k][i] = cylinders[i].axis[k];
        extents.push_back(extent_of(leaves[i], centre, cast<double>(model::decode_axis(group.axis[0][i], group.axis[1][i]))));
        height = std::max(height, extents.back().first);
        radius = std::max(radius, extents.back().second);
    }
    // Room for what rounding takes.
    group.height_step = std::max(static_cast<float>(height / 254.9), 1e-30f);
    group.radius_step = std::max(static_cast<float>(radius / 254.9), 1e-30f);
    const auto code = [](double value, float step) {
        return static_cast<std::uint8_t>(std::clamp(std::ceil(value / static_cast<double>(step) + 1e-3), 0.0, 255.0));
    };
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        group.height[i] = code(extents[i].first, group.height_step);
        group.radius[i] = code(extents[i].second, group.radius_step);
    }
    return group;
}

}  // namespace

void bake_hierarchy(model::ModelData& data)
{
    const model::ModelView view = data.view();
    std::vector<model::HierarchyNode>& nodes = data.distance.nodes;
    std::vector<model::HierarchyGroup>& groups = data.distance.groups;
    std::vector<std::uint32_t> entries;
    const auto triangles = static_cast<std::uint32_t>(view.triangle_part.size());
    std::vector<std::uint32_t> primitives;
    std::vector<const float*> corners;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        if ((view.triangle_part[t] & (model::k_buried | model::k_crossed)) != 0) continue;
        primitives.push_back(t);
        for (std::uint32_t k = 0; k < 3; ++k)
            corners.push_back(view.vertices.data() + 3 * std::size_t{model::triangle_vertex(view, t, k)});
    }
    for (std::uint32_t i = 0; i < view.piece_triangle.size(); ++i) {
        primitives.push_back(triangles + i);
        for (std::uint32_t k = 0; k < 3; ++k) corners.push_back(view.pieces.data() + 9 * std::size_t{i} + 3 * k);
    }
    if (primitives.empty() || primitives.size() > model::k_max_hierarchy_entries) return;
    std::vector<HierarchyBox> boxes(primitives.size(), k_empty);
    for (std::size_t i = 0; i < corners.size(); ++i) grow(boxes[i / 3], corners[i]);
    const Grouping grouping(boxes);
    const std::vector<std::uint32_t>& order = grouping.order();
    for (const std::uint32_t i : order) entries.push_back(primitives[i]);
    const auto count = static_cast<std::uint32_t>(entries.size());
    std::vector<Corners> leaves(model::leaf_count(count));
    std::vector<HierarchyBox> below(model::group_count(count), k_empty);
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            leaves[i / k_hierarchy_leaf].push_back(cast<double>(model::vec3(corners[3 * std::size_t{order[i]} + k])));
        add(below[i / k_hierarchy_leaf / k_hierarchy_width], boxes[order[i]]);
    }
    for (std::size_t first = 0; first < leaves.size(); first += k_hierarchy_width)
        groups.push_back(
            make_group(std::span(leaves).subspan(first, std::min<std::size_t>(k_hierarchy_width, leaves.size() - first))));
    entries.resize(std::size_t{model::leaf_count(count)} * k_hierarchy_leaf, entries.back());
    const model::HierarchyLevels levels = model::hierarchy_levels(count);
    nodes.resize(levels.first[levels.count]);
    for (std::uint32_t level = levels.count; level-- > 0;) {
        std::vector<HierarchyBox> here(levels.first[level + 1] - levels.first[level], k_empty);
        for (std::uint32_t i = 0; i < below.size(); ++i) add(here[i / k_hierarchy_width], below[i]);
        for (std::uint32_t n = 0; n < here.size(); ++n) {
            const std::uint32_t first = n * k_hierarchy_width,
                                end =
                                    std::min<std::uint32_t>(first + k_hierarchy_width, static_cast<std::uint32_t>(below.size()));
            nodes[levels.first[level] + n] = model::encode_node(below.data() + first, end - first);
        }
        below = std::move(here);
    }
    data.distance.header.entries = count;
    if (triangles + view.piece_triangle.size() <= 0x10000)
        data.distance.entries16.assign(entries.begin(), entries.end());
    else
        data.distance.entries32 = std::move(entries);
}

}  // namespace sqmap::bake
