// Clearance of two meshes that are apart, beside FCL's distance: time, and what both differ by.
#include "clock.h"
#include "fcl_tree.h"
#include "frames.h"
#include "measure.h"
#include "setting.h"

#include "math/random.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/math/rotation.h"
#include "sqmap/query/clearance.h"

#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <vector>

namespace sqmap::bench {
namespace {

/// A mesh as sqmap and as FCL have it; FCL's distance is quickest with spheres swept along rectangles.
struct ClearanceItem {
    explicit ClearanceItem(const mesh::Mesh& m)
        : baked(bake_mesh(m)),
          view(baked.view()),
          probe(m.vertices, m.triangles),
          rss(fcl_tree<fcl::RSS<double>>(m.vertices, m.triangles)),
          obbrss(fcl_tree<fcl::OBBRSS<double>>(m.vertices, m.triangles))
    {
    }
    BakedModel baked;
    model::ModelView view;
    query::Probe probe;
    std::shared_ptr<fcl::BVHModel<fcl::RSS<double>>> rss;
    std::shared_ptr<fcl::BVHModel<fcl::OBBRSS<double>>> obbrss;
};

template <class Model>
double fcl_distance(const Model& a, const Model& b, const Pose& pose)
{
    fcl::DistanceResultd result;
    return fcl::distance(&a, fcl::Transform3d::Identity(), &b, fcl_transform(pose), fcl::DistanceRequestd(true), result);
}

/// Medians of three passes, of all poses.
struct ClearanceTimes {
    std::vector<double> own, rss, obbrss, within, beyond;
    double difference = 0, uncertain = 0;  ///< the largest
    std::size_t wrong = 0;                 ///< answers of is_within
};

class ClearanceRace {
public:
    ClearanceRace(const ClearanceItem& a, const ClearanceItem& b) : a_(a), b_(b) {}

    void at(const Pose& pose, ClearanceTimes& times) const
    {
        const query::Body a{&a_.view, &a_.probe, {}}, b{&b_.view, &b_.probe, pose};
        std::vector<double> samples[5];
        const auto time = [&](std::size_t which, auto&& work) {
            const FrameClock::Mark mark = FrameClock::start();
            work();
            samples[which].push_back(clock_.stop_us(mark));
        };
        query::Clearance own;
        double rss = 0, obbrss = 0;
        bool within = false, beyond = true;
        for (int pass = 0; pass < 3; ++pass) {
            time(0, [&] { own = query::clearance(a, b); });
            time(1, [&] { rss = fcl_distance(*a_.rss, *b_.rss, pose); });
            time(2, [&] { obbrss = fcl_distance(*a_.obbrss, *b_.obbrss, pose); });
            time(3, [&] { within = query::is_within(a, b, 1.25 * own.distance); });
            time(4, [&] { beyond = query::is_within(a, b, 0.8 * own.distance); });
        }
        std::vector<double>* const all[] = {&times.own, &times.rss, &times.obbrss, &times.within, &times.beyond};
        for (std::size_t k = 0; k < std::size(all); ++k) all[k]->push_back(percentile(samples[k], 0.5));
        times.difference = std::max({times.difference, std::abs(own.distance - rss), std::abs(own.distance - obbrss)});
        times.uncertain = std::max(times.uncertain, own.distance - own.at_least);
        times.wrong += (within ? 0u : 1u) + (beyond ? 1u : 0u);
    }

private:
    const ClearanceItem &a_, &b_;
    const FrameClock clock_;
};

void print_clearance(double share, const ClearanceTimes& t, double r_max)
{
    const double own = percentile(t.own, 0.5), rss = percentile(t.rss, 0.5), obbrss = percentile(t.obbrss, 0.5);
    std::printf(
        "%6.2f %% of R_max, %3zu poses, medians in us: clearance %7.1f  FCL RSS %7.1f  OBBRSS %7.1f (%4.1f times)  is_within yes "
        "%5.1f no %5.1f\n"
        "         largest, of R_max: difference from FCL %.1e  uncertainty %.1e; wrong answers of is_within %zu\n",
        100 * share, t.own.size(), own, rss, obbrss, std::min(rss, obbrss) / own, percentile(t.within, 0.5),
        percentile(t.beyond, 0.5), t.difference / r_max, t.uncertain / r_max, t.wrong);
}

int run_clearance(int poses, const char* path_a, const char* path_b)
{
    const std::unique_ptr<Setting> setting = load_setting({path_a, path_b});
    const ClearanceItem a(setting->object), b(setting->probe);
    const sqmap::Sphere sa = query::sphere_of({&a.view, &a.probe, {}}), sb = query::sphere_of({&b.view, &b.probe, {}});
    const ClearanceRace race(a, b);
    constexpr double k_shares[] = {0.001, 0.01, 0.1, 1};  // of R_max
    ClearanceTimes times[std::size(k_shares)];
    SplitMix64 random(5);
    const auto turn = [&] { return rotation_by({random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)}); };
    for (int i = 0; i < poses; ++i) {
        const Mat3d rotation = turn(), look = turn();
        const Vec3d aside = 0.5 * sa.radius * (random.between(-1, 1) * look.row[1] + random.between(-1, 1) * look.row[2]);
        const auto pose_at = [&](double d) { return Pose{rotation, sa.centre + aside + d * look.row[0] - rotation * sb.centre}; };
        for (std::size_t k = 0; k < std::size(k_shares); ++k) {
            // Towards a along the line until so much is left.
            const double left = k_shares[k] * setting->r_max;
            double d = 2 * (sa.radius + sb.radius) + left;
            for (int step = 0; step < 100; ++step) {
                const double gap = query::clearance({&a.view, &a.probe, {}}, {&b.view, &b.probe, pose_at(d)}).distance;
                if (gap < left * 1.01 || d < 0) break;
                d -= gap - left;
            }
            if (d > 0) race.at(pose_at(d), times[k]);
        }
    }
    for (std::size_t k = 0; k < std::size(k_shares); ++k) print_clearance(k_shares[k], times[k], setting->r_max);
    return 0;
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_clearance(int argc, char** argv)
{
    if (argc != 4 || std::atoi(argv[1]) <= 0) return k_wrong_usage;
    return run_clearance(std::atoi(argv[1]), argv[2], argv[3]);
}
