// Contacts of triangle meshes that have no vertex in them: bodies that just touch, at random poses, by FCL's pairs of triangles,
// by query_pair with and without the offset of eq. 12, and by query_contacts; and the time of these along a path.
#include "clock.h"
#include "error.h"
#include "fcl_tree.h"
#include "frames.h"
#include "measure.h"
#include "path.h"
#include "query/probe/triangle_tree.h"
#include "setting.h"

#include "math/random.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/query/contacts.h"

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

struct Item {
    explicit Item(mesh::Mesh m)
        : mesh(std::move(m)),
          baked(bake_mesh(mesh)),
          view(baked.view()),
          probe(mesh.vertices, mesh.triangles),
          tree(fcl_tree<fcl::OBBRSS<double>>(mesh.vertices, mesh.triangles))
    {
    }
    mesh::Mesh mesh;
    BakedModel baked;
    model::ModelView view;
    query::Probe probe;
    std::shared_ptr<fcl::BVHModel<fcl::OBBRSS<double>>> tree;
};

constexpr double k_margin = 0.002;  ///< of a's R_max

struct Pair {
    std::uint32_t a, b;
};

/// Pairs of triangles that cut each other, b posed.
std::vector<Pair> cutting(const Item& a, const Item& b, const Pose& pose, std::size_t largest)
{
    fcl::CollisionResultd result;
    fcl::collide(a.tree.get(), fcl::Transform3d::Identity(), b.tree.get(), fcl_transform(pose),
                 fcl::CollisionRequestd(largest, false), result);
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
    Count exact, layer3, offset, margin, complete;
    std::size_t apart = 0, offset_false = 0, margin_false = 0, complete_false = 0;  ///< poses off each other, and those reported
    std::size_t meetings = 0, pairs = 0;  ///< pairs of triangles, by query_contacts and by FCL
    std::vector<double> sagitta;          ///< of curves no vertex is in: nearest vertex to the other surface, over its spacing
};

class Measure {
public:
    Measure(const Item& a, const Item& b) : a_(a), b_(b), tree_a_(a.mesh), tree_b_(b.mesh), workspace_(100000), complete_(100000)
    {
    }

    void at(const Pose& pose, Totals& totals)
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
            const std::vector<std::uint32_t> lost = lost_curves(pairs, ids, distinct);
            missed.curves += lost.size();
            return lost;
        };
        const std::vector<std::uint32_t> lost = count({.layer = query::Layer::Exact}, totals.exact);
        count({}, totals.layer3);
        count({.offset = true}, totals.offset);
        count(with_margin(), totals.margin);
        const query::ContactResult complete = query_complete(pose);
        totals.complete.poses += complete.contacts.empty() ? 1u : 0u;
        totals.complete.curves += lost_curves(pairs, ids, distinct).size();
        totals.meetings += complete.meetings;
        totals.pairs += pairs.size();
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

    /// A pose beyond one where the meshes do not touch: another touch may have been stepped over, which FCL's triangles say.
    void apart(const Pose& pose, Totals& totals)
    {
        if (!cutting(a_, b_, pose, 1).empty()) return;
        ++totals.apart;
        totals.offset_false += query(pose, {.offset = true}).contacts.empty() ? 0u : 1u;
        totals.margin_false += query(pose, with_margin()).contacts.empty() ? 0u : 1u;
        totals.complete_false += query_complete(pose).contacts.empty() ? 0u : 1u;
    }

private:
    query::QueryOptions with_margin() const
    {
        return {.layer = query::Layer::Exact, .margin = k_margin * a_.view.header.r_max * a_.view.header.unit};
    }
    query::PairResult query(const Pose& pose, const query::QueryOptions& options)
    {
        const query::PairResult r = query::query_pair({&a_.view, &a_.probe, {}}, {&b_.view, &b_.probe, pose},
                                                      {.query = options, .merge_distance = 0}, workspace_);
        forget();
        for (const query::PairContact& c : r.contacts) (c.vertex_of == query::Side::A ? in_a_ : in_b_)[c.index] = 1;
        return r;
    }
    query::ContactResult query_complete(const Pose& pose)
    {
        const query::ContactResult r =
            query::query_contacts({&a_.view, &a_.probe, {}}, {&b_.view, &b_.probe, pose}, {}, complete_);
        forget();
        for (const query::SurfaceContact& c : r.contacts) {
            mark(c.feature_a, c.index_a, a_.probe.triangles(), in_a_, triangle_of_a_);
            mark(c.feature_b, c.index_b, b_.probe.triangles(), in_b_, triangle_of_b_);
        }
        return r;
    }
    void forget()
    {
        in_a_.assign(a_.mesh.vertices.size(), 0);
        in_b_.assign(b_.mesh.vertices.size(), 0);
        triangle_of_a_.assign(a_.mesh.triangles.size(), 0);
        triangle_of_b_.assign(b_.mesh.triangles.size(), 0);
    }
    static void mark(query::Feature feature, std::uint32_t index, const query::TriangleTree& tree, std::vector<char>& vertices,
                     std::vector<char>& triangles)
    {
        if (index == query::k_unnamed) return;
        if (feature == query::Feature::Vertex) vertices[index] = 1;
        if (feature == query::Feature::Face) triangles[index] = 1;
        if (feature == query::Feature::Edge) triangles[index / 3] = triangles[tree.twin(index) / 3] = 1;
    }
    std::vector<std::uint32_t> lost_curves(const std::vector<Pair>& pairs, const std::vector<std::uint32_t>& ids,
                                           const std::vector<std::uint32_t>& distinct) const
    {
        std::vector<std::uint32_t> seen, lost;
        for (std::size_t i = 0; i < pairs.size(); ++i)
            if (is_marked(pairs[i])) seen.push_back(ids[i]);
        std::sort(seen.begin(), seen.end());
        for (const std::uint32_t id : distinct)
            if (!std::binary_search(seen.begin(), seen.end(), id)) lost.push_back(id);
        return lost;
    }
    bool is_marked(const Pair& p) const
    {
        const auto any = [](const mesh::Triangle& t, const std::vector<char>& marked) {
            return marked[t[0]] || marked[t[1]] || marked[t[2]];
        };
        return triangle_of_a_[p.a] != 0 || triangle_of_b_[p.b] != 0 || any(a_.mesh.triangles[p.a], in_a_) ||
               any(b_.mesh.triangles[p.b], in_b_);
    }

    const Item &a_, &b_;
    mesh::Bvh tree_a_, tree_b_;
    query::PairWorkspace workspace_;
    query::ContactWorkspace complete_;
    std::vector<char> in_a_, in_b_, triangle_of_a_, triangle_of_b_;
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
        std::printf("  %-6s %4zu  missed %%: exact %5.1f  layer 3 %5.1f  offset %5.1f  margin %5.1f  complete %zu\n", what, of,
                    share(missed(t.exact), of), share(missed(t.layer3), of), share(missed(t.offset), of),
                    share(missed(t.margin), of), missed(t.complete));
    };
    std::printf("pressed %s of R_max\n", depth);
    line("poses", t.poses, [](const Count& c) { return c.poses; });
    line("curves", t.curves, [](const Count& c) { return c.curves; });
    std::printf("  as far apart, in contact %%: offset %.1f  margin %.1f  complete %zu of %zu\n", share(t.offset_false, t.apart),
                share(t.margin_false, t.apart), t.complete_false, t.apart);
    std::printf("  pairs of triangles: complete %zu, FCL %zu\n", t.meetings, t.pairs);
    std::printf(
        "  of curves that the exact layer misses, nearest vertex off the other surface, %% of R_max: median %.3f  p99 %.3f  max "
        "%.3f\n",
        at(0.5), at(0.99), at(1));
}

/// Each frame's median of three passes, in turns.
struct Times {
    std::vector<double> vertices, complete, kept, fcl;
    std::size_t contacts = 0, meetings = 0;
};

Times time_path(const Item& a, const Item& b, const std::vector<Pose>& path)
{
    constexpr std::size_t k_frames = 200;
    constexpr int k_passes = 5;
    const FrameClock clock;
    query::PairWorkspace pair(100000);
    query::ContactWorkspace complete(100000);
    Times times;
    const std::size_t stride = std::max<std::size_t>(1, path.size() / k_frames);
    for (std::size_t i = 0; i < path.size(); i += stride) {
        const query::Body body_a{&a.view, &a.probe, {}}, body_b{&b.view, &b.probe, {path[i].rotation, path[i].translation}};
        std::vector<double> samples[4];
        const auto time = [&](std::size_t which, auto&& work) {
            const FrameClock::Mark mark = FrameClock::start();
            work();
            samples[which].push_back(clock.stop_us(mark));
        };
        for (int pass = 0; pass < k_passes; ++pass) {
            time(0, [&] {
                (void)query::query_pair(body_a, body_b, {.query = {.layer = query::Layer::Exact}, .merge_distance = 0}, pair);
            });
            query::ContactResult r;
            time(1, [&] { r = query::query_contacts(body_a, body_b, {}, complete); });
            times.contacts += r.contacts.size();
            times.meetings += r.meetings;
            time(2, [&] { (void)query::query_contacts(body_a, body_b, {.per_region = 4}, complete); });
            time(3, [&] { (void)cutting(a, b, body_b.pose, std::numeric_limits<int>::max()); });
        }
        for (std::size_t k = 0; k < 4; ++k)
            (k == 0 ? times.vertices : (k == 1 ? times.complete : (k == 2 ? times.kept : times.fcl)))
                .push_back(percentile(samples[k], 0.5));
    }
    times.contacts /= k_passes * times.fcl.size();
    times.meetings /= k_passes * times.fcl.size();
    return times;
}

int run_path(const char* file, const char* path_a, const char* path_b)
{
    const std::unique_ptr<Setting> setting = load_setting({path_a, path_b});
    const Item a(setting->object), b(setting->probe);
    const Times t = time_path(a, b, read_path(file));
    const double vertices = percentile(t.vertices, 0.5), complete = percentile(t.complete, 0.5), kept = percentile(t.kept, 0.5),
                 fcl = percentile(t.fcl, 0.5);
    std::printf(
        "%zu frames, medians in us: exact vertices %.1f  complete %.1f (%.2f times)  four a region %.1f  FCL %.1f (%.1f times)\n",
        t.fcl.size(), vertices, complete, complete / vertices, kept, fcl, fcl / complete);
    std::printf("  %zu contacts and %zu pairs of triangles a frame\n", t.contacts, t.meetings);
    return 0;
}

int run(int poses, const char* path_a, const char* path_b)
{
    const std::unique_ptr<Setting> setting = load_setting({path_a, path_b});
    const Item a(setting->object), b(setting->probe);
    const sqmap::Sphere sa = query::sphere_of({&a.view, &a.probe, {}}), sb = query::sphere_of({&b.view, &b.probe, {}});
    Measure measure(a, b);
    constexpr double k_press[] = {0.000001, 0.0002, 0.001, 0.005, 0.02};  // of R_max
    Totals totals[std::size(k_press)];
    SplitMix64 random(5);
    for (int i = 0; i < poses; ++i) {
        const Mat3d turn = random_rotation(random), look = random_rotation(random);
        const Vec3d direction = look.row[0];
        // Along a line past the object, off its middle by up to half its size.
        const Vec3d aside = 0.5 * sa.radius * (random.between(-1, 1) * look.row[1] + random.between(-1, 1) * look.row[2]);
        const auto pose_at = [&](double d) { return Pose{turn, sa.centre + aside + d * direction - turn * sb.centre}; };
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
        std::snprintf(name, sizeof(name), "%.4g %%", 100 * k_press[k]);
        print(name, totals[k], setting->r_max);
    }
    return 0;
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_contacts(int argc, char** argv)
{
    if (argc != 4) return k_wrong_usage;
    const int poses = std::atoi(argv[1]);
    return poses > 0 ? run(poses, argv[2], argv[3]) : run_path(argv[1], argv[2], argv[3]);
}
