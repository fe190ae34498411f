// See query/skin.h. The solid's surroundings are cut into cells, weights are spread from the surface to their corners and fitted
// so that the surface is carried to where skinning takes it.
#include "sqmap/bake/skin_lattice.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace sqmap::bake {

namespace {

using query::SkinLattice;

constexpr std::uint32_t k_none = SkinLattice::k_none;
constexpr double k_least_weight = 1e-3;  ///< less moves nothing
constexpr double k_stay = 0.002;         ///< pull of a corner towards its guess, against the samples' one each
constexpr int k_steps = 30;              ///< of conjugate gradients
constexpr double k_negligible = 2e-4;    ///< of a bone's share in a corner

/// A bone's share of a position: the weighted position, and the weight.
struct Share {
    Vec3d position{};
    double weight = 0;
};
Share operator+(const Share& a, const Share& b) { return {a.position + b.position, a.weight + b.weight}; }
Share operator-(const Share& a, const Share& b) { return {a.position - b.position, a.weight - b.weight}; }
Share operator*(double s, const Share& a) { return {s * a.position, s * a.weight}; }
double dot(const Share& a, const Share& b) { return sqmap::dot(a.position, b.position) + a.weight * b.weight; }

using Weights = std::map<std::uint32_t, double>;  // of bones

/// A position of the surface: the corners of its tetrahedron, and what skinning makes of it.
struct Sample {
    std::array<std::uint32_t, 4> corner{};
    std::array<double, 4> share{};
    std::map<std::uint32_t, Share> target;
};

class Builder {
public:
    Builder(const mesh::Mesh& mesh, const mesh::Influences& influences, double cell) : mesh_(mesh), bvh_(mesh)
    {
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
            Weights& weights = of_vertex_.emplace_back();
            double sum = 0;
            for (std::size_t k = 0; k < 4; ++k)
                if (influences.weights[v][k] >= k_least_weight) {
                    weights[influences.joints[v][k]] += influences.weights[v][k];
                    sum += influences.weights[v][k];
                    out_.bones = std::max<std::uint32_t>(out_.bones, influences.joints[v][k] + 1u);
                }
            if (!(sum > 0)) throw mesh::InvalidInput("a vertex that no joint moves");
            for (auto& [bone, weight] : weights) weight /= sum;
        }
        for (const auto& joints : influences.joints)
            for (const std::uint16_t j : joints) out_.bones = std::max<std::uint32_t>(out_.bones, j + 1u);
        const auto [lo, hi] = box_of(mesh.vertices);
        out_.cell = cell;
        out_.origin = lo - cell * Vec3d{1, 1, 1};
        for (int k = 0; k < 3; ++k)
            out_.size[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(std::ceil((hi[k] - lo[k]) / cell)) + 2;
    }

    SkinLattice make()
    {
        find_cells();
        guess();
        sort_cells();
        fit();
        store();
        return std::move(out_);
    }

private:
    std::size_t cell_count() const { return std::size_t{out_.size[0]} * out_.size[1] * out_.size[2]; }
    std::array<std::uint32_t, 3> at(std::size_t cell) const
    {
        return {static_cast<std::uint32_t>(cell % out_.size[0]), static_cast<std::uint32_t>(cell / out_.size[0] % out_.size[1]),
                static_cast<std::uint32_t>(cell / (std::size_t{out_.size[0]} * out_.size[1]))};
    }
    Vec3d low_of(std::size_t cell) const
    {
        const auto [x, y, z] = at(cell);
        return out_.origin + out_.cell * Vec3d{double(x), double(y), double(z)};
    }
    /// Grid of corners: one more along each axis.
    std::uint32_t corner_of(std::size_t cell, std::uint32_t k) const
    {
        const auto [x, y, z] = at(cell);
        return ((z + (k >> 2 & 1)) * (out_.size[1] + 1) + y + (k >> 1 & 1)) * (out_.size[0] + 1) + x + (k & 1);
    }
    Vec3d position_of(std::uint32_t corner) const
    {
        const std::uint32_t nx = out_.size[0] + 1, ny = out_.size[1] + 1;
        return out_.origin + out_.cell * Vec3d{double(corner % nx), double(corner / nx % ny), double(corner / (nx * ny))};
    }

    /// Cells that the surface may pass through, and those inside.
    void find_cells()
    {
        used_.assign(cell_count(), 0);
        const double reach = 0.5 * std::sqrt(3.0) * out_.cell * 1.001;
        for (std::size_t c = 0; c < used_.size(); ++c) {
            const Vec3d middle = low_of(c) + 0.5 * out_.cell * Vec3d{1, 1, 1};
            const bool crossed = bvh_.closest_point(middle, reach).distance < reach;
            used_[c] = crossed || bvh_.winding_number(middle) > 0 ? 1 : 0;
        }
    }

    Weights weights_at(const mesh::ClosestPoint& closest) const
    {
        const mesh::Triangle& t = mesh_.triangles[closest.triangle];
        const Vec3d a = mesh_.vertices[t[0]], b = mesh_.vertices[t[1]], c = mesh_.vertices[t[2]];
        const Vec3d across = cross(b - a, c - a);
        const double area = norm_sq(across);
        double u = sqmap::dot(cross(c - b, closest.point - b), across) / area,
               v = sqmap::dot(cross(a - c, closest.point - c), across) / area;
        if (!(area > 0)) u = 1, v = 0;
        const double share[3] = {u, v, 1 - u - v};
        Weights weights;
        for (std::size_t k = 0; k < 3; ++k)
            for (const auto& [bone, weight] : of_vertex_[t[k]]) weights[bone] += share[k] * weight;
        std::erase_if(weights, [](const auto& w) { return w.second < k_least_weight; });
        double sum = 0;
        for (const auto& [bone, weight] : weights) sum += weight;
        for (auto& [bone, weight] : weights) weight /= sum;
        return weights;
    }

    /// Corners have the weights of the surface nearest to them. Which cells one bone moves: bone_, of others k_none.
    void guess()
    {
        bone_.assign(used_.size(), k_none);
        const auto bone_of = [](const Weights& w) { return w.size() == 1 ? w.begin()->first : k_none; };
        for (std::size_t c = 0; c < used_.size(); ++c) {
            if (used_[c] == 0) continue;
            for (std::uint32_t k = 0; k < 8; ++k) {
                const std::uint32_t corner = corner_of(c, k);
                const auto [it, fresh] = weights_.try_emplace(corner);
                if (fresh) it->second = weights_at(bvh_.closest_point(position_of(corner)));
                const std::uint32_t bone = bone_of(it->second);
                bone_[c] = k == 0 || bone_[c] == bone ? bone : k_none;
                if (bone_[c] == k_none) break;
            }
            for (std::uint32_t k = 0; k < 8; ++k) weights_.try_emplace(corner_of(c, k));
        }
        for (auto& [corner, weights] : weights_)
            if (weights.empty()) weights = weights_at(bvh_.closest_point(position_of(corner)));
        // Also by the surface within.
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            each_sample(t, [&](Vec3d p, const std::array<double, 3>& share) {
                const std::size_t c = cell_at(p);
                if (used_[c] == 0) return;
                for (std::size_t k = 0; k < 3; ++k)
                    if (share[k] > 0 && bone_of(of_vertex_[mesh_.triangles[t][k]]) != bone_[c]) bone_[c] = k_none;
            });
    }

    std::size_t cell_at(Vec3d p) const
    {
        std::size_t index = 0, stride = 1;
        for (int k = 0; k < 3; ++k) {
            index += stride * static_cast<std::size_t>((p[k] - out_.origin[k]) / out_.cell);
            stride *= out_.size[static_cast<std::size_t>(k)];
        }
        return index;
    }

    /// visit(position, barycentric) for a grid of positions of a triangle, a third of a cell apart or less.
    template <class Visit>
    void each_sample(std::uint32_t triangle, Visit&& visit) const
    {
        const mesh::Triangle& t = mesh_.triangles[triangle];
        const Vec3d p[3] = {mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]};
        const double longest = std::max({norm(p[1] - p[0]), norm(p[2] - p[1]), norm(p[0] - p[2])});
        const int n = std::max(1, static_cast<int>(std::ceil(3 * longest / out_.cell)));
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j) {
                const std::array<double, 3> share{double(i) / n, double(j) / n, double(n - i - j) / n};
                visit(share[0] * p[0] + share[1] * p[1] + share[2] * p[2], share);
            }
    }

    /// Numbers of the cells in use, so that those of a node of the tree stand together, and the tree.
    void sort_cells()
    {
        std::vector<std::uint32_t> cells;
        for (std::size_t c = 0; c < used_.size(); ++c)
            if (used_[c] != 0) cells.push_back(static_cast<std::uint32_t>(c));
        out_.leaf_of.assign(used_.size(), k_none);
        if (!cells.empty()) add_node(cells, 0);
    }

    void add_node(std::span<std::uint32_t> cells, std::uint32_t parent)
    {
        const auto number = static_cast<std::uint32_t>(out_.nodes.size());
        SkinLattice::Node node;
        node.parent = parent;
        node.lo = low_of(cells.front());
        node.hi = node.lo;
        for (const std::uint32_t c : cells)
            for (int k = 0; k < 3; ++k) {
                node.lo[k] = std::min(node.lo[k], low_of(c)[k]);
                node.hi[k] = std::max(node.hi[k], low_of(c)[k] + out_.cell);
            }
        const std::uint32_t bone = bone_[cells.front()];
        const bool rigid =
            bone != k_none && std::all_of(cells.begin(), cells.end(), [&](std::uint32_t c) { return bone_[c] == bone; });
        if (rigid) node.bone = bone;
        if (!rigid && cells.size() == 1) {
            node.blend = static_cast<std::uint32_t>(out_.corners.size());
            std::array<std::uint32_t, 8>& corners = out_.corners.emplace_back();
            for (std::uint32_t k = 0; k < 8; ++k) {
                const auto [it, fresh] =
                    number_of_.try_emplace(corner_of(cells.front(), k), static_cast<std::uint32_t>(number_of_.size()));
                if (fresh) grid_of_.push_back(it->first);
                corners[k] = it->second;
            }
        }
        out_.nodes.push_back(node);
        if (rigid || cells.size() == 1) {
            for (const std::uint32_t c : cells) out_.leaf_of[c] = number;
        } else {
            const Vec3d side = node.hi - node.lo;
            const std::size_t axis = side.x >= side.y && side.x >= side.z ? 0 : (side.y >= side.z ? 1 : 2);
            const auto half = static_cast<std::ptrdiff_t>(cells.size() / 2);
            std::nth_element(cells.begin(), cells.begin() + half, cells.end(), [&](std::uint32_t a, std::uint32_t b) {
                return at(a)[axis] != at(b)[axis] ? at(a)[axis] < at(b)[axis] : a < b;
            });
            add_node(cells.first(static_cast<std::size_t>(half)), number);
            add_node(cells.subspan(static_cast<std::size_t>(half)), number);
        }
        out_.nodes[number].next = static_cast<std::uint32_t>(out_.nodes.size());
    }

    void fit()
    {
        shares_.resize(grid_of_.size());
        std::vector<std::uint8_t> fixed(grid_of_.size(), 0);
        for (std::size_t i = 0; i < grid_of_.size(); ++i)
            for (const auto& [bone, weight] : weights_.at(grid_of_[i]))
                shares_[i][bone] = {weight * position_of(grid_of_[i]), weight};
        // Corners of cells that one bone moves stay with it.
        for (std::size_t c = 0; c < used_.size(); ++c) {
            if (used_[c] == 0 || bone_[c] == k_none) continue;
            for (std::uint32_t k = 0; k < 8; ++k)
                if (const auto it = number_of_.find(corner_of(c, k)); it != number_of_.end()) fixed[it->second] = 1;
        }
        std::vector<Sample> samples;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            each_sample(t, [&](Vec3d p, const std::array<double, 3>& share) {
                const std::uint32_t leaf = out_.leaf_of[cell_at(p)];
                if (leaf == k_none || out_.nodes[leaf].blend == k_none) return;
                Sample& s = samples.emplace_back();
                set_corners(p, out_.nodes[leaf], s);
                for (std::size_t k = 0; k < 3; ++k)
                    for (const auto& [bone, weight] : of_vertex_[mesh_.triangles[t][k]]) {
                        Share& target = s.target[bone];
                        target = target + share[k] * weight * Share{mesh_.vertices[mesh_.triangles[t][k]], 1};
                    }
            });
        for (std::uint32_t bone = 0; bone < out_.bones; ++bone) fit_bone(bone, samples, fixed);
    }

    /// Shares within the tetrahedron.
    void set_corners(Vec3d p, const SkinLattice::Node& node, Sample& s) const
    {
        const Vec3d u = (p - node.lo) / out_.cell;
        std::array<int, 3> axis{0, 1, 2};
        std::sort(axis.begin(), axis.end(), [&](int a, int b) { return u[a] != u[b] ? u[a] > u[b] : a < b; });
        const std::array<std::uint32_t, 8>& corners = out_.corners[node.blend];
        const std::uint32_t one = 1u << axis[0], two = one | 1u << axis[1];
        s.corner = {corners[0], corners[one], corners[two], corners[7]};
        s.share = {1 - u[axis[0]], u[axis[0]] - u[axis[1]], u[axis[1]] - u[axis[2]], u[axis[2]]};
    }

    /// Least squares for what one bone adds: conjugate gradients on the normal equations.
    void fit_bone(std::uint32_t bone, const std::vector<Sample>& samples, const std::vector<std::uint8_t>& fixed)
    {
        const std::size_t n = shares_.size();
        std::vector<std::uint8_t> moved(n, 0);
        for (std::size_t i = 0; i < n; ++i) moved[i] = shares_[i].contains(bone) ? 1 : 0;
        for (const Sample& s : samples)
            if (s.target.contains(bone))
                for (const std::uint32_t c : s.corner) moved[c] = 1;
        for (std::size_t i = 0; i < n; ++i)
            if (fixed[i] != 0) moved[i] = 0;
        std::vector<const Sample*> active;
        for (const Sample& s : samples)
            if (std::any_of(s.corner.begin(), s.corner.end(), [&](std::uint32_t c) { return moved[c] != 0; }))
                active.push_back(&s);
        if (active.empty()) return;
        std::vector<Share> move(n), residual(n), direction(n), product(n);
        const auto add_transposed = [&](const Sample& s, const Share& value, std::vector<Share>& out) {
            for (std::size_t k = 0; k < 4; ++k)
                if (moved[s.corner[k]] != 0) out[s.corner[k]] = out[s.corner[k]] + s.share[k] * value;
        };
        for (const Sample* s : active) {
            const auto target = s->target.find(bone);
            Share miss = target != s->target.end() ? target->second : Share{};
            for (std::size_t k = 0; k < 4; ++k)
                if (const auto it = shares_[s->corner[k]].find(bone); it != shares_[s->corner[k]].end())
                    miss = miss - s->share[k] * it->second;
            add_transposed(*s, miss, residual);
        }
        direction = residual;
        const auto sum = [&](const std::vector<Share>& a, const std::vector<Share>& b) {
            double s = 0;
            for (std::size_t i = 0; i < n; ++i) s += dot(a[i], b[i]);
            return s;
        };
        double size = sum(residual, residual);
        for (int step = 0; step < k_steps && size > 1e-30; ++step) {
            for (std::size_t i = 0; i < n; ++i) product[i] = k_stay * direction[i];
            for (const Sample* s : active) {
                Share value;
                for (std::size_t k = 0; k < 4; ++k) value = value + s->share[k] * direction[s->corner[k]];
                add_transposed(*s, value, product);
            }
            const double length = size / sum(direction, product);
            for (std::size_t i = 0; i < n; ++i) {
                move[i] = move[i] + length * direction[i];
                residual[i] = residual[i] - length * product[i];
            }
            const double next = sum(residual, residual);
            for (std::size_t i = 0; i < n; ++i) direction[i] = residual[i] + next / size * direction[i];
            size = next;
        }
        for (std::size_t i = 0; i < n; ++i)
            if (moved[i] != 0) shares_[i][bone] = shares_[i][bone] + move[i];
    }

    /// Adds small weights to that of the heaviest bone, so that a common motion of all bones stays exact.
    void store()
    {
        const Vec3d size = out_.cell * Vec3d{double(out_.size[0]), double(out_.size[1]), double(out_.size[2])};
        out_.first_pull.push_back(0);
        for (std::size_t c = 0; c < shares_.size(); ++c) {
            const Vec3d position = position_of(grid_of_[c]);
            Share left{position, 1};
            const std::size_t first = out_.pulls.size();
            for (const auto& [bone, share] : shares_[c]) {
                const double off = norm(share.position - share.weight * position);
                if (std::abs(share.weight) <= k_negligible && off <= k_negligible * norm(size)) continue;
                out_.pulls.push_back({share.position, share.weight, bone});
                left = left - share;
            }
            const auto heaviest = std::max_element(out_.pulls.begin() + static_cast<std::ptrdiff_t>(first), out_.pulls.end(),
                                                   [](const auto& a, const auto& b) { return a.weight < b.weight; });
            heaviest->position += left.position;
            heaviest->weight += left.weight;
            out_.first_pull.push_back(static_cast<std::uint32_t>(out_.pulls.size()));
        }
    }

    const mesh::Mesh& mesh_;
    mesh::Bvh bvh_;
    SkinLattice out_;
    std::vector<Weights> of_vertex_;
    std::vector<std::uint8_t> used_;
    std::vector<std::uint32_t> bone_;
    std::map<std::uint32_t, Weights> weights_;            // of grid corners
    std::map<std::uint32_t, std::uint32_t> number_of_;    // grid corner -> corner in use
    std::vector<std::uint32_t> grid_of_;                  // and back
    std::vector<std::map<std::uint32_t, Share>> shares_;  // of corners in use
};

}  // namespace

SkinLattice skin_lattice(const mesh::Mesh& mesh, const mesh::Influences& influences, const SkinLatticeOptions& options)
{
    if (!(options.cell >= 1.0 / 512 && options.cell <= 0.25)) throw mesh::InvalidInput("a lattice's cell lies in [1/512, 1/4]");
    if (mesh.triangles.empty()) throw mesh::InvalidInput("a lattice needs a mesh");
    if (influences.joints.size() != mesh.vertices.size() || influences.weights.size() != mesh.vertices.size())
        throw mesh::InvalidInput("influences are not of this mesh");
    return Builder(mesh, influences, options.cell * mesh::largest_vertex_distance(mesh)).make();
}

double skin_deviation(const query::SkinLattice& lattice, const mesh::Mesh& mesh, const mesh::Influences& influences,
                      std::span<const Affine> maps)
{
    query::PosedSkin posed(lattice);
    if (!posed.pose(maps)) throw mesh::InvalidInput("maps are not of this lattice");
    const std::vector<Vec3d> positions = mesh::skinned(mesh.vertices, influences, maps);
    double largest = 0;
    for (const mesh::Triangle& t : mesh.triangles)
        for (const std::array<double, 3>& w :
             {std::array{1., 0., 0.}, {0.5, 0.5, 0.}, {0., 0.5, 0.5}, {0.5, 0., 0.5}, {1. / 3, 1. / 3, 1. / 3}}) {
            const auto mean = [&](const std::vector<Vec3d>& p) { return w[0] * p[t[0]] + w[1] * p[t[1]] + w[2] * p[t[2]]; };
            Affine local;
            if (posed.carry_forward(mean(mesh.vertices), local))
                largest = std::max(largest, norm(apply(local, mean(mesh.vertices)) - mean(positions)));
        }
    return largest;
}

}  // namespace sqmap::bake
