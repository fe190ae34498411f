// Constructors of probes, which allocate: they run outside the frame.
#include "halves.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/math/assert.h"
#include "sqmap/math/box.h"
#include "sqmap/query/probe.h"

#include <algorithm>
#include <numeric>

namespace sqmap::query {

Probe::Probe(std::span<const Vec3d> points) : size_(points.size())
{
    if (points.empty()) return;
    origin_ = centre(box_of(points));
    std::vector<std::uint32_t> order(size_);
    std::iota(order.begin(), order.end(), 0u);
    order_by_halves(order, points, k_cluster);

    const std::size_t clusters = (size_ + k_cluster - 1) / k_cluster, groups = (clusters + k_cluster - 1) / k_cluster;
    for (auto* v : {&x_, &y_, &z_}) v->resize(clusters * k_cluster);
    point_.resize(clusters * k_cluster);
    slot_of_point_.resize(size_);
    for (std::size_t slot = 0; slot < point_.size(); ++slot) {
        point_[slot] = order[std::min(slot, size_ - 1)];
        if (slot < size_) slot_of_point_[point_[slot]] = static_cast<std::uint32_t>(slot);
    }
    for (auto* v : {&centre_x_, &centre_y_, &centre_z_, &radius_}) v->resize(clusters + k_cluster);  // read by whole vectors
    for (auto* v : {&group_x_, &group_y_, &group_z_, &group_radius_}) v->resize(groups);
    move(points);
    refit();
}

Probe::Probe(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles) : Probe(points)
{
    SQMAP_ASSERT(find_fault(points, triangles).kind == TriangleFault::Kind::None);
    triangles_.get() = TriangleTree(points, triangles);
}

Probe::OwnTree::OwnTree() : tree_(std::make_unique<TriangleTree>()) {}
Probe::OwnTree::OwnTree(const OwnTree& other) : tree_(std::make_unique<TriangleTree>(other.get())) {}
Probe::OwnTree& Probe::OwnTree::operator=(const OwnTree& other)
{
    tree_ = std::make_unique<TriangleTree>(other.get());
    return *this;
}
Probe::OwnTree::OwnTree(OwnTree&& other) noexcept = default;
Probe::OwnTree& Probe::OwnTree::operator=(OwnTree&& other) noexcept = default;
Probe::OwnTree::~OwnTree() = default;

}  // namespace sqmap::query
