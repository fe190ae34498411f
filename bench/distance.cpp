// Signed distances of a baked model against the exact oracle in double, and their time beside Embree's closest point with sign.
#include "clock.h"
#include "distance_grid.h"
#include "embree_nearest.h"
#include "error.h"
#include "measure.h"
#include "setting.h"

#include "math/random.h"
#include "parallel/for_each.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/math/rotation.h"
#include "sqmap/query/distance.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace sqmap::bench {
namespace {

constexpr double k_band = 0.05;  // of R_max
constexpr std::size_t k_timed = 100000;
constexpr int k_rounds = 5;

/// On the surface, moved along its normal by up to a share of R_max.
class BandPoints {
public:
    BandPoints(const Setting& setting, std::uint64_t seed, double share = k_band)
        : setting_(setting), random_(seed), share_(share)
    {
        double sum = 0;
        for (const mesh::Triangle& t : setting.object.triangles) cumulated_.push_back(sum += norm(across(t)));
    }
    Vec3d next()
    {
        const auto at = std::upper_bound(cumulated_.begin(), cumulated_.end(), cumulated_.back() * random_.uniform());
        const mesh::Triangle& t = setting_.object.triangles[static_cast<std::size_t>(at - cumulated_.begin())];
        const auto& v = setting_.object.vertices;
        double a = random_.uniform(), b = random_.uniform();
        if (a + b > 1) {
            a = 1 - a;
            b = 1 - b;
        }
        return v[t[0]] + a * (v[t[1]] - v[t[0]]) + b * (v[t[2]] - v[t[0]]) +
               random_.between(-1, 1) * share_ * setting_.r_max * normalized(across(t));
    }

private:
    Vec3d across(const mesh::Triangle& t) const
    {
        const auto& v = setting_.object.vertices;
        return cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]);
    }

    const Setting& setting_;
    SplitMix64 random_;
    double share_;
    std::vector<double> cumulated_;
};

struct Errors {
    std::size_t wrong_signs = 0, exact = 0, bounds = 0;
    double worst = 0, p99 = 0, least_ratio = 1, greatest_ratio = 0;
};

/// Against the oracle; lengths in percent of R_max.
Errors errors_of(const Setting& setting, std::span<const Vec3d> points, std::span<const query::SignedDistance> answers)
{
    std::vector<double> truth(points.size());
    parallel::for_each(points.size(), 0, [&](std::size_t i) { truth[i] = signed_distance(setting.solid, points[i]); });
    Errors e;
    std::vector<double> errors;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const query::SignedDistance& a = answers[i];
        if ((a.distance < 0) != (truth[i] < 0) && std::abs(truth[i]) > 1e-5 * setting.r_max) ++e.wrong_signs;
        if (a.known == query::DistanceKind::LowerBound) {
            ++e.bounds;
            const double ratio = std::abs(a.distance) / std::abs(truth[i]);
            e.least_ratio = std::min(e.least_ratio, ratio);
            e.greatest_ratio = std::max(e.greatest_ratio, ratio);
        } else {
            ++e.exact;
            errors.push_back(100 * std::abs(a.distance - truth[i]) / setting.r_max);
        }
    }
    if (errors.empty()) return e;
    std::sort(errors.begin(), errors.end());
    e.worst = errors.back();
    e.p99 = errors[errors.size() * 99 / 100];
    return e;
}

struct Times {
    double embree_ns = 0, ours_ns = 0;
};

/// In turns, medians of rounds.
Times race(std::size_t points, const std::function<void()>& embree, const std::function<void()>& ours)
{
    std::vector<double> times[2];
    for (int r = 0; r < k_rounds; ++r)
        for (int k = 0; k < 2; ++k) {
            const double start = thread_seconds();
            (k == 0 ? embree : ours)();
            times[k].push_back(1e9 * (thread_seconds() - start) / static_cast<double>(points));
        }
    for (auto& t : times) std::nth_element(t.begin(), t.begin() + k_rounds / 2, t.end());
    return {times[0][k_rounds / 2], times[1][k_rounds / 2]};
}

/// ours(points, answers)
template <class Ours>
Times race(const EmbreeNearest& embree, std::span<const Vec3d> points, Ours&& ours)
{
    std::vector<query::SignedDistance> answers(points.size());
    float sum = 0;
    const Times times = race(
        points.size(),
        [&] {
            for (const Vec3d& p : points) sum += embree.signed_distance(cast<float>(p));
        },
        [&] { ours(points, std::span(answers)); });
    if (std::isnan(sum)) std::printf("nan\n");
    return times;
}

void print(const char* name, const Times& t)
{
    std::printf("  %-28s embree %5.0f ns, sqmap %5.0f ns, %.1f times less\n", name, t.embree_ns, t.ours_ns,
                t.embree_ns / t.ours_ns);
}

/// Everywhere, in double and in float: near the surface, in the object's box, and in a box ten times as large.
void race_everywhere(const Setting& setting, const EmbreeNearest& embree, const model::ModelView& model, std::size_t count)
{
    BandPoints near(setting, 3, 0.04);
    SplitMix64 random(4);
    Box3<double> box;
    for (const Vec3d& v : setting.object.vertices) extend(box, v);
    const Vec3d middle = centre(box), half = 0.5 * size(box);
    const auto in_box = [&](double scale) {
        Vec3d p;
        for (int k = 0; k < 3; ++k) p[k] = middle[k] + random.between(-scale, scale) * half[k];
        return p;
    };
    const std::pair<const char*, std::function<Vec3d()>> sets[] = {{"within 4 %", [&] { return near.next(); }},
                                                                   {"in the box", [&] { return in_box(1); }},
                                                                   {"in ten times the box", [&] { return in_box(10); }}};
    for (const auto& [name, next] : sets) {
        std::vector<Vec3d> points;
        for (std::size_t i = 0; i < count; ++i) points.push_back(next());
        const auto in_float = [&](auto p, auto found) { query::distances(model, p, found, query::k_everywhere); };
        const auto in_double = [&](auto p, auto found) { query::exact_distances(model, p, found); };
        print((std::string(name) + ", double").c_str(), race(embree, points, in_double));
        print((std::string(name) + ", float").c_str(), race(embree, points, in_float));
    }
}

/// The probe at random poses about the object: its points within the band, in the order of its file.
std::vector<Vec3d> probe_points(const Setting& setting)
{
    SplitMix64 random(7);
    std::vector<Vec3d> points;
    const double band = k_band * setting.r_max;
    while (points.size() < k_timed / 4) {
        const Vec3d on = setting.object.vertices[random.bits() % setting.object.vertices.size()];
        const Pose pose{rotation_by(Vec3d{random.between(-2, 2), random.between(-2, 2), random.between(-2, 2)}),
                        on + 0.4 * normalized(on) * setting.r_max * 0.4};
        for (const Vec3d& v : setting.probe.vertices) {
            const Vec3d p = apply(pose, v);
            if (setting.solid.closest_boundary(p, band).distance < band) points.push_back(p);
        }
    }
    return points;
}

struct Blob {
    std::vector<std::uint64_t> words;
    model::ModelView view;
    explicit Blob(const BakedModel& baked)
    {
        const std::vector<std::byte> bytes = baked.bytes();
        words.resize((bytes.size() + 7) / 8);
        std::memcpy(words.data(), bytes.data(), bytes.size());
        const std::span<const std::byte> all(reinterpret_cast<const std::byte*>(words.data()), bytes.size());
        const model::ParseStatus status = model::parse(all, view);
        if (status != model::ParseStatus::Ok) throw BenchError(std::string("the baked model: ") + model::to_string(status));
    }
};

void run(std::size_t count, const Files& files, bool exact)
{
    const std::unique_ptr<Setting> setting = load_setting(files);
    const BakedModel baked = bake_mesh(setting->object, {.bake = {.exact = exact}});
    const Blob blob(baked);
    const model::ModelView& model = blob.view;
    double seconds = 0;
    for (const auto& [stage, s] : baked.report.seconds)
        if (stage == "distance") seconds = s;
    const std::size_t bytes = model::bytes_of(model.distance);
    std::printf("%-24s %s: %zu bytes of %zu (bounds %zu), %.1f %% more, %.2f s\n", files.object.filename().c_str(),
                exact ? "exact" : "layer 3", bytes, 8 * blob.words.size(), model.distance.bounds.size_bytes(),
                100.0 * static_cast<double>(bytes) / static_cast<double>(8 * blob.words.size() - bytes), seconds);

    BandPoints band(*setting, 1);
    std::vector<Vec3d> near, beyond;
    for (std::size_t i = 0; i < count; ++i) near.push_back(band.next());
    SplitMix64 random(2);
    while (beyond.size() < std::max(count / 5, k_timed)) {
        const Vec3d p{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        if (setting->solid.closest_boundary(p, k_band * setting->r_max).distance >= k_band * setting->r_max) beyond.push_back(p);
    }
    std::vector<query::SignedDistance> answers(std::max(near.size(), beyond.size()));
    query::distances(model, near, answers, query::k_baked_band);
    Errors e = errors_of(*setting, near, {answers.data(), near.size()});
    std::printf("  band:   %zu wrong signs, error p99 %.2g max %.2g %% of R_max, %zu exact, %zu bounds\n", e.wrong_signs, e.p99,
                e.worst, e.exact, e.bounds);
    query::distances(model, beyond, answers, query::k_baked_band);
    e = errors_of(*setting, beyond, {answers.data(), beyond.size()});
    std::printf("  beyond: %zu wrong signs, %.1f %% exact, max error %.2g %%, bounds %.3f to %.3f of the truth\n", e.wrong_signs,
                100.0 * static_cast<double>(e.exact) / static_cast<double>(beyond.size()), e.worst, e.least_ratio,
                e.greatest_ratio);
    if (!exact) return;
    const EmbreeNearest embree(setting->object);
    near.resize(std::min(near.size(), k_timed));
    beyond.resize(k_timed);
    std::vector<Vec3d> coherent = probe_points(*setting);
    const auto within = [&](auto p, auto found) { query::distances(model, p, found, query::k_baked_band); };
    for (const auto& [name, points] : {std::pair{"random in the band", &near}, std::pair{"a probe's points", &coherent},
                                       std::pair{"beyond the band", &beyond}})
        print(name, race(embree, *points, within));
    race_everywhere(*setting, embree, model, count);
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_distance(int argc, char** argv)
{
    std::size_t points = 0;
    const std::string_view number = argc > 3 ? argv[1] : "";
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), points);
    if (error != std::errc() || points < 1) return k_wrong_usage;
    for (int i = 3; i < argc; ++i)
        for (const bool exact : {true, false}) {
            // Approximate distances take a hundred times as long.
            run(exact ? points : std::min<std::size_t>(points, 30000), {argv[i], argv[2]}, exact);
            std::fflush(stdout);
        }
    return 0;
}
