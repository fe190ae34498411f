// Reflective symmetry by closest points, as in P. J. Besl, N. D. McKay, "A method for registration of 3-D shapes", IEEE PAMI
// 14(2), 1992: the reflection that fits pairs of points best takes the place of the rotation.
#include "mirror.h"

#include "math/triangle.h"
#include "sqmap/mesh/bvh.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace sqmap::decompose {

namespace {

constexpr std::size_t k_samples = 400;

Eigen::Vector3d eigen(Vec3d v) { return {v.x, v.y, v.z}; }
Vec3d vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

struct Plane {
    Vec3d normal;
    double offset;
    [[nodiscard]] Vec3d mirrored(Vec3d p) const { return p - 2 * (dot(normal, p) - offset) * normal; }
    [[nodiscard]] Vec3d turned(Vec3d v) const { return v - 2 * dot(normal, v) * normal; }
};

/// Finds the plane of one mesh.
class MirrorFinder {
public:
    explicit MirrorFinder(const mesh::Mesh& mesh) : mesh_(mesh), tree_(mesh), r_max_(mesh::largest_vertex_distance(mesh))
    {
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const mesh::Triangle& tri = mesh.triangles[t];
            const Vec3d a = mesh.vertices[tri[0]];
            const Vec3d twice = cross(mesh.vertices[tri[1]] - a, mesh.vertices[tri[2]] - a);
            area_.push_back(0.5 * norm(twice));
            normal_.push_back(sqmap::normalized(twice));
            centre_.push_back(mesh::triangle_centroid(mesh, t));
            total_ += area_.back();
            mean_ += area_.back() * centre_.back();
        }
        mean_ = mean_ / total_;
        sample();
    }

    [[nodiscard]] bool has_area() const { return !samples_.empty(); }

    [[nodiscard]] std::array<Plane, 3> candidates() const
    {
        Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
        for (std::size_t t = 0; t < area_.size(); ++t) {
            const Eigen::Vector3d c = eigen(centre_[t] - mean_);
            second += area_[t] * c * c.transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(second);
        std::array<Plane, 3> planes{};
        // The longest axis first; an axis that may turn freely comes last.
        const Eigen::Vector3d& extent = solver.eigenvalues();
        const auto is_free = [&](int k) {
            constexpr double k_distinct = 0.98;
            return (k < 2 && extent[k] > k_distinct * extent[k + 1]) || (k > 0 && extent[k - 1] > k_distinct * extent[k]);
        };
        std::array<int, 3> order{2, 1, 0};
        std::stable_sort(order.begin(), order.end(), [&](int l, int r) { return is_free(l) < is_free(r); });
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3d n = vec(solver.eigenvectors().col(order[i]));
            planes[i] = {n, dot(n, mean_)};
        }
        return planes;
    }

    /// The plane that fits the pairs of a sample and the surface's point nearest to its mirror image, again and again.
    [[nodiscard]] Plane refined(Plane plane) const
    {
        constexpr std::array<double, 8> k_reach{0.2, 0.1, 0.05, 0.05, 0.03, 0.03, 0.02, 0.02};  // of R_max
        for (const double reach : k_reach) {
            std::vector<std::pair<Vec3d, Vec3d>> pairs;
            Vec3d mean_p{}, mean_q{};
            for (const std::uint32_t t : samples_) {
                const Vec3d p = centre_[t], image = plane.mirrored(p);
                const mesh::ClosestPoint q = tree_.closest_point(image, reach * r_max_);
                if (!(q.distance < reach * r_max_)) continue;
                pairs.emplace_back(p, q.point);
                mean_p += p;
                mean_q += q.point;
            }
            if (pairs.size() < samples_.size() / 4) return plane;
            mean_p = mean_p / static_cast<double>(pairs.size());
            mean_q = mean_q / static_cast<double>(pairs.size());
            Eigen::Matrix3d both = Eigen::Matrix3d::Zero();
            for (const auto& [p, q] : pairs) {
                const Eigen::Matrix3d one = eigen(p - mean_p) * eigen(q - mean_q).transpose();
                both += one + one.transpose();
            }
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(both);
            plane.normal = vec(solver.eigenvectors().col(0));
            plane.offset = 0.5 * dot(plane.normal, mean_p + mean_q);
        }
        return plane;
    }

    /// The triangle at a mirror image.
    [[nodiscard]] std::uint32_t image_of(std::uint32_t t, const Plane& plane) const
    {
        const Vec3d at = plane.mirrored(centre_[t]), facing = plane.turned(normal_[t]);
        const double reach = k_symmetric_distance * r_max_;
        double least = reach * reach;
        std::uint32_t best = mesh::k_no_triangle;
        tree_.visit_nearest(at, least, [&](std::uint32_t o, double) {
            if (dot(normal_[o], facing) > 0) {
                const mesh::Triangle& tri = mesh_.triangles[o];
                const std::vector<Vec3d>& v = mesh_.vertices;
                const double d = norm_sq(closest_point_on_triangle(at, v[tri[0]], v[tri[1]], v[tri[2]]) - at);
                if (d < least) {
                    least = d;
                    best = o;
                }
            }
            return least;
        });
        return best;
    }

    [[nodiscard]] double share(const Plane& plane) const
    {
        double near = 0, all = 0;
        for (const std::uint32_t t : samples_) {
            all += 1;
            if (image_of(t, plane) != mesh::k_no_triangle) near += 1;
        }
        return near / all;
    }

    [[nodiscard]] Mirror mirror(const Plane& plane) const
    {
        Mirror out{plane.normal, plane.offset, {}};
        for (std::uint32_t t = 0; t < area_.size(); ++t) out.of_triangle.push_back(image_of(t, plane));
        return out;
    }

private:
    /// Triangles that share the area evenly, in order of their distance from the centroid: no frame and no order of the file
    /// has a say.
    void sample()
    {
        if (!(total_ > 0)) return;
        std::vector<std::pair<double, std::uint32_t>> order;
        for (std::uint32_t t = 0; t < area_.size(); ++t) order.emplace_back(norm_sq(centre_[t] - mean_), t);
        std::sort(order.begin(), order.end());
        double below = 0;
        for (const auto& [distance, t] : order) {
            below += area_[t];
            if (below < total_ * (static_cast<double>(samples_.size()) + 0.5) / k_samples) continue;
            samples_.push_back(t);
            while (below >= total_ * (static_cast<double>(samples_.size()) + 0.5) / k_samples) samples_.push_back(t);
        }
    }

    const mesh::Mesh& mesh_;
    mesh::Bvh tree_;
    double r_max_;
    std::vector<double> area_;
    std::vector<Vec3d> normal_, centre_;
    std::vector<std::uint32_t> samples_;
    double total_ = 0;
    Vec3d mean_{};
};

}  // namespace

std::optional<Mirror> find_mirror(const mesh::Mesh& mesh)
{
    const MirrorFinder finder(mesh);
    if (!finder.has_area()) return std::nullopt;
    Plane best{};
    double best_share = 0;
    for (const Plane& candidate : finder.candidates()) {
        const Plane plane = finder.refined(candidate);
        const double share = finder.share(plane);
        if (share > best_share + 0.01) {
            best = plane;
            best_share = share;
        }
    }
    if (best_share < k_symmetric_share) return std::nullopt;
    return finder.mirror(best);
}

}  // namespace sqmap::decompose
