// Queries of points in a deformed body, answered in its material space: A. McAdams et al., Efficient elasticity for character
// skinning with contact and collisions, ACM TOG 30(4), 2011, section 6. The tetrahedra are H. W. Kuhn's (1960).
#include "sqmap/query/skin.h"

#include "skin_kernels.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace sqmap::query {

namespace {

constexpr std::uint32_t k_none = SkinLattice::k_none;
/// Margin of a tetrahedron's side: a point that far outside belongs to both neighbours, so that rounding opens no gap. A position
/// found twice counts once.
constexpr double k_border = 1e-7, k_same = 1e-4;
constexpr std::size_t k_at_once = 64;  ///< positions that one point is answered with at most
constexpr double k_collapsed = 1e-9;   ///< times a cell: a tetrahedron of less volume holds nothing

/// Columns.
Mat3d of_columns(Vec3d a, Vec3d b, Vec3d c) { return {{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}}; }

/// Rows of the inverse times the determinant, of a matrix of columns.
Mat3d adjugate(Vec3d a, Vec3d b, Vec3d c) { return {{cross(b, c), cross(c, a), cross(a, b)}}; }

Mat3d adjugate(const Mat3d& m)
{
    const Mat3d t = transpose(m);
    return adjugate(t.row[0], t.row[1], t.row[2]);
}

/// Four corners of a tetrahedron along its path, posed, as edges.
struct Path {
    Vec3d start, edge[3];
};
Path path_of(const KuhnOrder& order, const std::array<std::uint32_t, 8>& corners, std::span<const Vec3d> positions)
{
    const std::uint32_t one = 1u << order.axis[0], two = one | 1u << order.axis[1];
    const Vec3d p0 = positions[corners[0]], p1 = positions[corners[one]], p2 = positions[corners[two]],
                p3 = positions[corners[7]];
    return {p0, {p1 - p0, p2 - p1, p3 - p2}};
}

/// The map from positions of the bound cell to the path's tetrahedron.
Affine local_of(const KuhnOrder& order, const Path& path, Vec3d lo, double cell)
{
    Vec3d column[3];
    for (int k = 0; k < 3; ++k) column[order.axis[k]] = path.edge[k] / cell;
    const Mat3d linear = of_columns(column[0], column[1], column[2]);
    return {linear, path.start - linear * lo};
}

double least(double a, double b) { return a < b ? a : b; }
double greatest(double a, double b) { return a > b ? a : b; }

inline void merge(Vec3d& lo, Vec3d& hi, const Vec3d& p, const Vec3d& q)
{
    lo = {least(lo.x, p.x), least(lo.y, p.y), least(lo.z, p.z)};
    hi = {greatest(hi.x, q.x), greatest(hi.y, q.y), greatest(hi.z, q.z)};
}

void add(const SkinPosition& at, double cell, std::span<SkinPosition> found, std::size_t& count)
{
    for (std::size_t i = 0; i < std::min(count, found.size()); ++i)
        if (found[i].sign == at.sign && norm_sq(found[i].bound - at.bound) < k_same * k_same * cell * cell) return;
    if (count < found.size()) found[count] = at;
    ++count;
}

}  // namespace

bool PosedSkin::pose(std::span<const Affine> maps) noexcept
{
    if (maps.size() != maps_.size()) return false;
    for (const Affine& m : maps)
        if (!is_finite(m.shift) || !is_finite(m.linear.row[0]) || !is_finite(m.linear.row[1]) || !is_finite(m.linear.row[2]))
            return false;
    std::copy(maps.begin(), maps.end(), maps_.begin());
    for (std::size_t b = 0; b < maps.size(); ++b) {
        const Mat3d& m = maps[b].linear;
        const double det = dot(m.row[0], cross(m.row[1], m.row[2]));
        sign_[b] = std::abs(det) > k_collapsed && std::isfinite(1 / det) ? (det > 0 ? 1 : -1) : 0;
        if (sign_[b] == 0) continue;
        Mat3d inverse = adjugate(m);
        for (Vec3d& row : inverse.row) row = row / det;
        back_[b] = {inverse, -(inverse * maps[b].shift)};
    }
    for (std::size_t c = 0; c < corners_.size(); ++c) {
        Vec3d at{};
        for (std::uint32_t i = lattice_->first_pull[c]; i < lattice_->first_pull[c + 1]; ++i) {
            const SkinLattice::Pull& pull = lattice_->pulls[i];
            at += maps_[pull.bone].linear * pull.position + pull.weight * maps_[pull.bone].shift;
        }
        corners_[c] = at;
    }
    for (Box& box : boxes_) box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    // Parents stand before what is below them.
    for (std::size_t i = boxes_.size(); i-- > 0;) {
        const SkinLattice::Node& node = lattice_->nodes[i];
        Box& box = boxes_[i];
        if (node.blend != k_none) {
            const std::array<std::uint32_t, 8>& corners = lattice_->corners[node.blend];
            Vec3d lo = corners_[corners[0]], hi = lo;
            for (std::size_t k = 1; k < 8; ++k) merge(lo, hi, corners_[corners[k]], corners_[corners[k]]);
            box = {lo, hi};
        } else if (node.bone != k_none && sign_[node.bone] != 0) {
            const Vec3d centre = apply(maps_[node.bone], 0.5 * (node.lo + node.hi)), half = 0.5 * (node.hi - node.lo);
            for (int k = 0; k < 3; ++k) {
                const Vec3d row = maps_[node.bone].linear.row[k];
                const double reach = std::abs(row.x) * half.x + std::abs(row.y) * half.y + std::abs(row.z) * half.z;
                box.lo[k] = centre[k] - reach;
                box.hi[k] = centre[k] + reach;
            }
        }
        if (i > 0) merge(boxes_[node.parent].lo, boxes_[node.parent].hi, box.lo, box.hi);
    }
    return true;
}

std::uint32_t PosedSkin::leaf_at(Vec3d bound) const noexcept
{
    std::size_t index = 0, stride = 1;
    for (int k = 0; k < 3; ++k) {
        const double at = (bound[k] - lattice_->origin[k]) / lattice_->cell;
        const std::uint32_t size = lattice_->size[static_cast<std::size_t>(k)];
        if (!(at >= 0 && at < size)) return k_none;
        index += stride * static_cast<std::size_t>(at);
        stride *= size;
    }
    return lattice_->leaf_of[index];
}

void PosedSkin::add_rigid(std::uint32_t leaf, Vec3d posed, std::span<SkinPosition> found, std::size_t& count) const noexcept
{
    const std::uint32_t bone = lattice_->nodes[leaf].bone;
    if (sign_[bone] == 0) return;
    const Vec3d bound = apply(back_[bone], posed);
    if (leaf_at(bound) == leaf) add({bound, leaf, 0, static_cast<std::int8_t>(sign_[bone])}, lattice_->cell, found, count);
}

void PosedSkin::add_blended(std::uint32_t leaf, const CellHit& hit, std::span<SkinPosition> found,
                            std::size_t& count) const noexcept
{
    const KuhnOrder& order = k_kuhn_orders[hit.order];
    SkinPosition at{lattice_->nodes[leaf].lo, leaf, hit.order,
                    static_cast<std::int8_t>(hit.positive ? order.parity : -order.parity)};
    for (int k = 0; k < 3; ++k) at.bound[order.axis[k]] += lattice_->cell * hit.along[k];
    add(at, lattice_->cell, found, count);
}

Affine PosedSkin::local_at(const SkinPosition& position) const noexcept
{
    const SkinLattice::Node& node = lattice_->nodes[position.leaf];
    if (node.blend == k_none) return maps_[node.bone];
    const KuhnOrder& order = k_kuhn_orders[position.order];
    return local_of(order, path_of(order, lattice_->corners[node.blend], corners_), node.lo, lattice_->cell);
}

void PosedSkin::carry_back(const SkinCluster& cluster, std::span<SkinPosition> found, std::size_t max_count,
                           std::span<std::size_t, SkinCluster::k_points> counts) const noexcept
{
    constexpr std::size_t k_leaves = 256;
    const double cell = lattice_->cell, slack = 1e-6 * cell, least_volume = k_collapsed * cell * cell * cell;
    std::fill(counts.begin(), counts.end(), std::size_t{0});
    SkinLeaf leaves[k_leaves];
    CellHit hits[k_max_cell_hits];
    for (std::uint32_t from = 0; from < boxes_.size();) {
        std::size_t near = 0;
        from = leaves_about(lattice_->nodes, boxes_, slack, cluster, from, leaves, near);
        for (const SkinLeaf& at : std::span(leaves).first(near)) {
            const SkinLattice::Node& node = lattice_->nodes[at.leaf];
            if (node.bone != k_none)
                for (std::uint32_t points = at.points; points != 0; points &= points - 1) {
                    const auto p = static_cast<std::size_t>(std::countr_zero(points));
                    add_rigid(at.leaf, {cluster.x[p], cluster.y[p], cluster.z[p]}, found.subspan(p * max_count, max_count),
                              counts[p]);
                }
            if (node.blend == k_none) continue;
            std::array<Vec3d, 8> corners;
            for (std::size_t k = 0; k < 8; ++k) corners[k] = corners_[lattice_->corners[node.blend][k]];
            const std::size_t count = cell_hits(corners, least_volume, k_border, cluster, at.points, hits);
            for (const CellHit& hit : std::span(hits).first(count))
                add_blended(at.leaf, hit, found.subspan(hit.point * max_count, max_count), counts[hit.point]);
        }
    }
}

std::size_t PosedSkin::carry_back(Vec3d posed, std::span<PreImage> found) const noexcept
{
    SkinCluster cluster;
    for (std::size_t i = 0; i < SkinCluster::k_points; ++i) cluster.x[i] = cluster.y[i] = cluster.z[i] = NAN;
    cluster.x[0] = posed.x;
    cluster.y[0] = posed.y;
    cluster.z[0] = posed.z;
    SkinPosition positions[k_at_once];
    std::size_t counts[SkinCluster::k_points];
    // The other points find nothing, and have no workspace.
    carry_back(cluster, positions, std::min(found.size(), k_at_once), counts);
    for (std::size_t i = 0; i < std::min({counts[0], found.size(), k_at_once}); ++i)
        found[i] = {positions[i].bound, local_at(positions[i]), positions[i].sign};
    return counts[0];
}

bool PosedSkin::carry_forward(Vec3d bound, Affine& local) const noexcept
{
    const std::uint32_t leaf = leaf_at(bound);
    if (leaf == k_none) return false;
    const SkinLattice::Node& node = lattice_->nodes[leaf];
    if (node.blend == k_none) {
        local = maps_[node.bone];
        return true;
    }
    const Vec3d within = bound - node.lo;
    for (const KuhnOrder& order : k_kuhn_orders) {
        const double a = within[order.axis[0]], b = within[order.axis[1]], c = within[order.axis[2]];
        if (!(a >= b && b >= c)) continue;
        local = local_of(order, path_of(order, lattice_->corners[node.blend], corners_), node.lo, lattice_->cell);
        return true;
    }
    return false;
}

double PosedSkin::farthest_from(const PosedSkin& other) const noexcept
{
    SQMAP_ASSERT(corners_.size() == other.corners_.size() && maps_.size() == other.maps_.size());
    double far_sq = 0;
    for (std::size_t c = 0; c < corners_.size(); ++c) far_sq = std::max(far_sq, norm_sq(corners_[c] - other.corners_[c]));
    double far = std::sqrt(far_sq);
    for (const SkinLattice::Node& node : lattice_->nodes) {
        if (node.bone == k_none) continue;
        const Affine &a = maps_[node.bone], &b = other.maps_[node.bone];
        const Vec3d centre = 0.5 * (node.lo + node.hi);
        double turn_sq = 0;  // Frobenius norm, no less than the spectral
        for (int k = 0; k < 3; ++k) turn_sq += norm_sq(a.linear.row[k] - b.linear.row[k]);
        far = std::max(far, norm(apply(a, centre) - apply(b, centre)) + std::sqrt(turn_sq) * 0.5 * norm(node.hi - node.lo));
    }
    return far;
}

bool MovingSkin::step(std::span<const Affine> maps) noexcept
{
    // The pose before last makes workspace: nothing is copied, nothing allocated.
    std::swap(from_, to_);
    const bool good = to_.pose(maps);
    if (!good) (void)to_.pose(from_.maps());
    motion_ = good ? to_.farthest_from(from_) : 0;
    return good;
}

Vec3d carried_normal(const Affine& local, Vec3d normal) noexcept
{
    return normalized(transpose_mul(adjugate(local.linear), normal));
}

struct SkinQuery {
    const SkinnedQuery& query;
    const QueryOptions& options;
    SkinWorkspace& workspace;
    std::span<SkinContact> contacts;
    const PosedSkin& skin = *query.skin;
    const std::span<const Vec3d> points = query.points;

    ProbeResult run() const noexcept
    {
        ProbeResult result;
        if (points.size() != workspace.size_) return result;
        std::size_t max_count = 0, positions = 0;
        std::fill(workspace.count_.begin(), workspace.count_.end(), std::uint8_t{0});
        std::fill(workspace.covered_.begin(), workspace.covered_.end(), 0);
        const std::span<const std::uint32_t> order = workspace.probe_.point_;
        for (std::size_t slot = 0; slot < points.size(); slot += SkinCluster::k_points) {
            const std::size_t size = std::min(SkinCluster::k_points, points.size() - slot);
            for (std::size_t k = slot + 2 * SkinCluster::k_points; k < std::min(slot + 3 * SkinCluster::k_points, points.size());
                 ++k)
                __builtin_prefetch(&points[order[k]]);
            SkinCluster cluster;
            bool any = false;
            for (std::size_t k = 0; k < SkinCluster::k_points; ++k) {
                const std::uint32_t i = order[slot + std::min(k, size - 1)];
                const bool active =
                    k < size && (query.active.size() != points.size() || query.active[i] != 0) && is_finite(points[i]);
                const Vec3d p = active ? points[i] : Vec3d{NAN, NAN, NAN};
                cluster.x[k] = p.x;
                cluster.y[k] = p.y;
                cluster.z[k] = p.z;
                any = any || active;
            }
            if (!any) continue;
            std::size_t counts[SkinCluster::k_points];
            skin.carry_back(cluster, workspace.found_positions_, SkinWorkspace::k_max, counts);
            for (std::size_t k = 0; k < size; ++k) {
                if (counts[k] == 0) continue;
                const std::uint32_t i = order[slot + k];
                const std::size_t count = std::min(counts[k], SkinWorkspace::k_max);
                if (counts[k] > count) result.status |= k_crowded;
                workspace.count_[i] = static_cast<std::uint8_t>(count);
                workspace.first_[i] = static_cast<std::uint32_t>(positions);
                workspace.best_[i].part = -1;
                for (std::size_t n = 0; n < count; ++n)
                    workspace.positions_[positions++] = workspace.found_positions_[k * SkinWorkspace::k_max + n];
                max_count = std::max(max_count, count);
            }
        }
        QueryOptions all = options;
        all.first_only = false;
        for (std::size_t round = 0; round < max_count; ++round) {
            for (std::size_t i = 0; i < points.size(); ++i) {
                workspace.active_[i] = workspace.count_[i] > round ? 1 : 0;
                if (workspace.active_[i] != 0) workspace.active_positions_[i] = position(i, round).bound;
            }
            workspace.probe_.move(workspace.active_positions_, workspace.active_);
            const ProbeResult found =
                query_probe({query.bound, nullptr, {}}, {nullptr, &workspace.probe_, {}}, all, workspace.found_);
            result.status |= found.status;
            result.unseen += found.unseen;
            for (const Contact& c : found.written(workspace.found_))
                if (workspace.active_[c.index] != 0) take(c, found.position(c), position(c.index, round));
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (workspace.covered_[i] <= 0) continue;
            if (result.contacts < contacts.size())
                contacts[result.contacts] = workspace.best_[i];
            else
                result.status |= k_full;
            ++result.contacts;
            if (options.first_only) break;
        }
        return result;
    }

    const SkinPosition& position(std::size_t point, std::size_t round) const
    {
        return workspace.positions_[workspace.first_[point] + round];
    }

    void take(const Contact& c, Vec3d surface, const SkinPosition& at) const noexcept
    {
        workspace.covered_[c.index] += at.sign;
        if (at.sign < 0) return;
        Affine there;
        if (!skin.carry_forward(surface, there)) there = skin.local_at(at);
        const Vec3d point = points[c.index];
        SkinContact contact;
        contact.bound_witness = surface;
        contact.bound_normal = cast<double>(c.normal);
        contact.normal = carried_normal(there, contact.bound_normal);
        contact.depth = std::max(0.0, dot(apply(there, surface) - point, contact.normal));
        contact.witness = point + contact.depth * contact.normal;
        contact.index = c.index;
        contact.part = c.part;
        contact.status = c.status;
        SkinContact& best = workspace.best_[c.index];
        if (best.part < 0 || contact.depth > best.depth) best = contact;
    }
};

ProbeResult query_skin(const SkinnedQuery& query, const QueryOptions& options, SkinWorkspace& workspace,
                       std::span<SkinContact> contacts) noexcept
{
    SQMAP_ASSERT(query.skin != nullptr && !options.offset && !(options.margin > 0));
    if (query.bound == nullptr) return {};
    return SkinQuery{query, options, workspace, contacts}.run();
}

}  // namespace sqmap::query
