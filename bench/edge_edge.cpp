// How many contacts of triangle meshes have no vertex in them: bodies that just touch, at random poses, by FCL's pairs of
// triangles and by query_pair with and without the offset of eq. 12.
#include "error.h"
#include "measure.h"
#include "setting.h"

#include "sqmap/bake/bake.h"
#include "sqmap/math/random.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/query/pair.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

namespace sqmap::bench {
namespace {

using FclModel = fcl::BVHModel<fcl::OBBRSS<double>>;

struct Item {
    explicit Item(mesh::Mesh m)
        : mesh(std::move(m)), bake(bake::bake(mesh, true, {})), view(bake.model.view()), probe(mesh.vertices)
    {
        std::vector<fcl::Vector3d> points;
        for (const Vec3d& v : mesh.vertices) points.emplace_back(v.x, v.y, v.z);
        std::vector<fcl::Triangle> triangles;
        for (const mesh::Triangle& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
        fcl.beginModel(static_cast<int>(triangles.size()), static_cast<int>(points.size()));
        fcl.addSubModel(points, triangles);
        fcl.endModel();
    }
    mesh::Mesh mesh;
    bake::BakeResult bake;
    model::ModelView view;
    query::Probe probe;
    FclModel fcl;
};

constexpr double k_margin = 0.002;  ///< of a's R_max

struct Pair {
    std::uint32_t a, b;
};

fcl::Transform3d transform_of(const sqmap::Pose& pose)
{
    fcl::Transform3d t = fcl::Transform3d::Identity();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) t.linear()(i, j) = pose.rotation.row[i][j];
        t.translation()[i] = pose.translation[i];
    }
    return t;
}

/// Pairs of triangles that cut each other, b posed.
std::vector<Pair> cutting(const Item& a, const Item& b, const sqmap::Pose& pose, std::size_t largest)
{
    fcl::CollisionResultd result;
    fcl::collide(&a.fcl, fcl::Transform3d::Identity(), &b.fcl, transform_of(pose), fcl::CollisionRequestd(largest, false),
                 result);
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < result.numContacts(); ++i)
        pairs.push_back(
            {static_cast<std::uint32_t>(result.getContact(i).b1), static_cast<std::uint32_t>(result.getContact(i).b2)});
    return pairs;
}

/// Triangles of both meshes joined by the pairs that cut: a set is one closed curve of contact.
class Curves {
public:
    Curves(std::size_t a, std::size_t b, const std::vector<Pair>& pairs) : parent_(a + b), offset_(static_cast<std::uint32_t>(a))
    {
        std::iota(parent_.begin(), parent_.end(), 0u);
        for (const Pair& p : pairs) parent_[root(p.a)] = root(p.b + offset_);
    }
    std::uint32_t of_a(std::uint32_t t) { return root(t); }

private:
    std::uint32_t root(std::uint32_t t)
    {
        while (parent_[t] != t) t = parent_[t] = parent_[parent_[t]];
        return t;
    }
    std::vector<std::uint32_t> parent_;
    std::uint32_t offset_;
};

Mat3d random_rotation(SplitMix64& random)
{
    double q[4], n = 0;
    do {
        n = 0;
        for (double& v : q) {
            v = random.between(-1, 1);
            n += v * v;
        }
    } while (n > 1 || n < 0.01);
    for (double& v : q) v /= std::sqrt(n);
    const auto [w, x, y, z] = q;
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

/// Counts of queries in one direction.
struct Count {
    std::size_t poses = 0, curves = 0;  ///< missed
};

struct Totals {
    std::size_t poses = 0, curves = 0;
    Count exact, layer3, offset, margin;
    std::size_t apart = 0, offset_false = 0, margin_false = 0;  ///< poses a little off each other, and those reported
    std::vector<double> sagitta;  ///< of curves no vertex is in: nearest vertex to the other surface, over its spacing
};

class Measure {
public:
    Measure(const Item& a, const Item& b) : a_(a), b_(b), tree_a_(a.mesh), tree_b_(b.mesh), workspace_(100000) {}

    void at(const sqmap::Pose& pose, Totals& totals)
    {
        const std::vector<Pair> pairs = cutting(a_, b_, pose, std::numeric_limits<int>::max());
        if (pairs.empty()) return;
        Curves curves(a_.mesh.triangles.size(), b_.mesh.triangles.size(), pairs);
        std::vector<std::uint32_t> ids;
        for (const Pair& p : pairs) ids.push_back(curves.of_a(p.a));
        std::vector<std::uint32_t> distinct = ids;
        std::sort(distinct.begin(), distinct.end());
        distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
        ++totals.poses;
        totals.curves += distinct.size();
        const auto count = [&](const query::QueryOptions& options, Count& missed) {
            const query::PairResult r = query(pose, options);
            missed.poses += r.contacts.empty() ? 1u : 0u;
            std::vector<std::uint32_t> seen;
            for (std::size_t i = 0; i < pairs.size(); ++i)
                if (is_marked(pairs[i])) seen.push_back(ids[i]);
            std::sort(seen.begin(), seen.end());
            std::vector<std::uint32_t> lost;
            for (const std::uint32_t id : distinct)
                if (!std::binary_search(seen.begin(), seen.end(), id)) lost.push_back(id);
            missed.curves += lost.size();
            return lost;
        };
        const std::vector<std::uint32_t> lost = count({.layer = query::Layer::Exact}, totals.exact);
        count({}, totals.layer3);
        count({.offset = true}, totals.offset);
        count(with_margin(), totals.margin);
        // How near a vertex comes to the other surface where none is in it.
        for (const std::uint32_t id : lost) {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < pairs.size(); ++i) {
                if (ids[i] != id) continue;
                for (const std::uint32_t v : b_.mesh.triangles[pairs[i].b])
                    least =
                        std::min(least, tree_a_.closest_point(pose.rotation * b_.mesh.vertices[v] + pose.translation).distance);
                for (const std::uint32_t v : a_.mesh.triangles[pairs[i].a])
                    least = std::min(
                        least,
                        tree_b_.closest_point(transpose_mul(pose.rotation, a_.mesh.vertices[v] - pose.translation)).distance);
            }
            totals.sagitta.push_back(least);
        }
    }

    /// A pose where the meshes do not touch.
    void apart(const sqmap::Pose& pose, Totals& totals)
    {
        ++totals.apart;
        totals.offset_false += query(pose, {.offset = true}).contacts.empty() ? 0u : 1u;
        totals.margin_false += query(pose, with_margin()).contacts.empty() ? 0u : 1u;
    }

private:
    query::QueryOptions with_margin() const
    {
        return {.layer = query::Layer::Exact, .margin = k_margin * a_.view.header.r_max * a_.view.header.unit};
    }
    query::PairResult query(const sqmap::Pose& pose, const query::QueryOptions& options)
    {
        const query::PairResult r = query::query_pair({&a_.view, &a_.probe, {}}, {&b_.view, &b_.probe, pose},
                                                      {.query = options, .merge_distance = 0}, workspace_);
        in_a_.assign(a_.mesh.vertices.size(), 0);
        in_b_.assign(b_.mesh.vertices.size(), 0);
        for (const query::PairContact& c : r.contacts) (c.vertex_of == query::Side::A ? in_a_ : in_b_)[c.index] = 1;
        return r;
    }
    bool is_marked(const Pair& p) const
    {
        const auto any = [](const mesh::Triangle& t, const std::vector<char>& marked) {
            return marked[t[0]] || marked[t[1]] || marked[t[2]];
        };
        return any(a_.mesh.triangles[p.a], in_a_) || any(b_.mesh.triangles[p.b], in_b_);
    }

    const Item &a_, &b_;
    mesh::Bvh tree_a_, tree_b_;
    query::PairWorkspace workspace_;
    std::vector<char> in_a_, in_b_;
};

void print(const char* depth, const Totals& t, double r_max)
{
    const auto share = [](std::size_t part, std::size_t of) {
        return of == 0 ? 0. : 100. * static_cast<double>(part) / static_cast<double>(of);
    };
    std::vector<double> s = t.sagitta;
    std::sort(s.begin(), s.end());
    const auto at = [&](double q) {
        return s.empty() ? 0. : 100 * s[static_cast<std::size_t>(q * static_cast<double>(s.size() - 1))] / r_max;
    };
    const auto line = [&](const char* what, std::size_t of, auto missed) {
        std::printf("  %-6s %4zu  missed %%: exact %5.1f  layer 3 %5.1f  offset %5.1f  margin %5.1f\n", what, of,
                    share(missed(t.exact), of), share(missed(t.layer3), of), share(missed(t.offset), of),
                    share(missed(t.margin), of));
    };
    std::printf("pressed %s of R_max\n", depth);
    line("poses", t.poses, [](const Count& c) { return c.poses; });
    line("curves", t.curves, [](const Count& c) { return c.curves; });
    std::printf("  as far apart, in contact %%: offset %.1f  margin %.1f\n", share(t.offset_false, t.apart),
                share(t.margin_false, t.apart));
    std::printf(
        "  of curves that the exact layer misses, nearest vertex off the other surface, %% of R_max: median %.3f  p99 %.3f  max "
        "%.3f\n",
        at(0.5), at(0.99), at(1));
}

int run(int poses, const char* path_a, const char* path_b)
{
    const std::unique_ptr<Setting> setting = load_setting({path_a, path_b});
    const Item a(setting->object), b(setting->probe);
    const sqmap::Sphere sa = query::sphere_of({&a.view, &a.probe, {}}), sb = query::sphere_of({&b.view, &b.probe, {}});
    Measure measure(a, b);
    constexpr double k_press[] = {0.0002, 0.001, 0.005, 0.02};  // of R_max
    Totals totals[std::size(k_press)];
    SplitMix64 random(5);
    for (int i = 0; i < poses; ++i) {
        const Mat3d turn = random_rotation(random), look = random_rotation(random);
        const Vec3d direction = look.row[0];
        // Along a line past the object, off its middle by up to half its size.
        const Vec3d aside = 0.5 * sa.radius * (random.between(-1, 1) * look.row[1] + random.between(-1, 1) * look.row[2]);
        const auto pose_at = [&](double d) { return sqmap::Pose{turn, sa.centre + aside + d * direction - turn * sb.centre}; };
        double out = sa.radius + sb.radius, in = out;
        while (in > -out && cutting(a, b, pose_at(in), 1).empty()) in -= 0.02 * setting->r_max;
        if (in <= -out) continue;
        for (out = in + 0.02 * setting->r_max; out - in > 1e-7 * setting->r_max;) {
            const double middle = 0.5 * (in + out);
            (cutting(a, b, pose_at(middle), 1).empty() ? out : in) = middle;
        }
        for (std::size_t k = 0; k < std::size(k_press); ++k) {
            measure.at(pose_at(in - k_press[k] * setting->r_max), totals[k]);
            measure.apart(pose_at(out + k_press[k] * setting->r_max), totals[k]);
        }
    }
    const query::QueryOptions offset{.offset = true};
    std::printf("offsets up to %.3f %% (a) and %.3f %% (b) of a's R_max, margin %.3f %%\n",
                100 * query::reach_of({&a.view, nullptr, {}}, offset) / setting->r_max,
                100 * query::reach_of({&b.view, nullptr, {}}, offset) / setting->r_max, 100 * k_margin);
    for (std::size_t k = 0; k < std::size(k_press); ++k) {
        char name[32];
        std::snprintf(name, sizeof(name), "%.2f %%", 100 * k_press[k]);
        print(name, totals[k], setting->r_max);
    }
    return 0;
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_edge_edge(int argc, char** argv)
{
    if (argc != 4) return k_wrong_usage;
    return run(std::atoi(argv[1]), argv[2], argv[3]);
}
