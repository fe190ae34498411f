// Ticks of a slow hand: a probe query with a workspace beside one without, the same frames in turns, and that their contacts have
// the same bits.
#include "clock.h"
#include "frames.h"
#include "measure.h"
#include "path.h"
#include "setting.h"

#include "sqmap/bake_mesh.h"
#include "sqmap/math/rotation.h"
#include "sqmap/query/probe_workspace.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

namespace sqmap::bench {
namespace {

/// From a pose to another in steps of which none moves a vertex farther than the step, the first left out.
void append_ticks(const mesh::Mesh& probe, const Pose& from, const Pose& to, double step, std::vector<Pose>& ticks)
{
    double farthest = 0;
    for (const Vec3d& v : probe.vertices) farthest = std::max(farthest, norm(apply(to, v) - apply(from, v)));
    const auto count = static_cast<int>(std::ceil(farthest / step));
    const Vec3d by = rotation_vector(to.rotation * transpose(from.rotation));
    for (int i = 1; i <= count; ++i) {
        const double share = static_cast<double>(i) / count;
        ticks.push_back(
            {rotation_by(share * by) * from.rotation, from.translation + share * (to.translation - from.translation)});
    }
}

/// Medians over passes of each tick.
struct TickTimes {
    std::vector<double> without, with;
};

class TickRace {
public:
    TickRace(const model::ModelView& model, const query::Probe& probe)
        : model_(model), probe_(probe), plain_(probe.size()), workspace_(probe, probe.size())
    {
    }

    void run(std::span<const Pose> ticks, int passes, TickTimes& times)
    {
        std::vector<std::vector<double>> samples[2];
        for (auto& s : samples) s.resize(ticks.size());
        for (int pass = 0; pass < passes; ++pass)
            for (std::size_t half = 0; half < 2; ++half) {
                const std::size_t which = (half + static_cast<std::size_t>(pass)) % 2;
                for (std::size_t i = 0; i < ticks.size(); ++i) {
                    const query::Body touched{&model_, nullptr, {}}, tool{nullptr, &probe_, ticks[i]};
                    constexpr query::QueryOptions k_options{.layer = query::Layer::Exact};
                    const FrameClock::Mark mark = FrameClock::start();
                    const query::ProbeResult found = which == 0 ? query::query_probe(touched, tool, k_options, plain_)
                                                                : query::query_probe(touched, tool, k_options, workspace_);
                    samples[which][i].push_back(clock_.stop_us(mark));
                    if (pass > 0) continue;
                    hash_.resize(ticks.size());
                    const std::uint64_t hash = hash_of(found, which == 0 ? plain_ : workspace_.contacts());
                    if (which == 0) {
                        hash_[i] = hash;
                        continue;
                    }
                    different += hash_[i] == hash ? 0 : 1;
                    contacts += found.contacts;
                    clusters += workspace_.reuse().kept ? workspace_.reuse().clusters : probe_.clusters();
                }
            }
        for (std::size_t i = 0; i < ticks.size(); ++i) {
            times.without.push_back(percentile(samples[0][i], 0.5));
            times.with.push_back(percentile(samples[1][i], 0.5));
        }
    }

    std::size_t different = 0, contacts = 0, clusters = 0;

private:
    static std::uint64_t hash_of(const query::ProbeResult& found, std::span<const query::Contact> contacts)
    {
        Hash hash;
        hash.add(found.contacts);
        hash.add(found.status);
        hash.add(found.unseen);
        for (const query::Contact& c : found.written(contacts)) {
            std::uint32_t words[9];
            static_assert(sizeof words == sizeof c);
            std::memcpy(words, &c, sizeof words);
            for (const std::uint32_t w : words) hash.add(w);
        }
        return hash.value();
    }

    const model::ModelView& model_;
    const query::Probe& probe_;
    std::vector<query::Contact> plain_;
    query::ProbeWorkspace workspace_;
    std::vector<std::uint64_t> hash_;
    const FrameClock clock_;
};

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double v : values) sum += v;
    return sum / static_cast<double>(values.size());
}

int run_coherence(double millimetres, const char* path, const Files& files)
{
    constexpr std::size_t k_starts = 20, k_ticks = 200;
    constexpr int k_passes = 5;
    const std::unique_ptr<Setting> setting = load_setting(files);
    const BakedModel baked = bake_mesh(setting->object);
    const model::ModelView view = baked.view();
    const query::Probe probe(setting->probe.vertices);
    const std::vector<Pose> poses = read_path(path);
    const double step = millimetres / 300;  // the object is 0.3 m long
    std::vector<std::vector<Pose>> runs;
    for (std::size_t s = 0; s < k_starts; ++s) {
        std::vector<Pose> ticks;
        for (std::size_t i = s * poses.size() / k_starts; ticks.size() < k_ticks && i + 1 < poses.size(); ++i)
            append_ticks(setting->probe, poses[i], poses[i + 1], step, ticks);
        if (ticks.size() > k_ticks) ticks.resize(k_ticks);
        runs.push_back(std::move(ticks));
    }
    TickRace race(view, probe);
    TickTimes times;
    for (const std::vector<Pose>& ticks : runs) race.run(ticks, k_passes, times);
    const auto n = static_cast<double>(times.with.size());
    std::printf(
        "exact layer, %.0f ticks of %g mm, us: without p50 %.2f p99 %.2f  with p50 %.2f p99 %.2f  ratio of p50 %.3f of means "
        "%.3f\n"
        "  contacts a tick %.0f; clusters looked at %.1f of %zu; ticks with other contacts: %zu\n",
        n, millimetres, percentile(times.without, 0.5), percentile(times.without, 0.99), percentile(times.with, 0.5),
        percentile(times.with, 0.99), percentile(times.with, 0.5) / percentile(times.without, 0.5),
        mean(times.with) / mean(times.without), static_cast<double>(race.contacts) / n, static_cast<double>(race.clusters) / n,
        probe.clusters(), race.different);
    return race.different == 0 ? 0 : 1;
}

}  // namespace

int measure_coherence(int argc, char** argv)
{
    if (argc != 5) return k_wrong_usage;
    const double millimetres = std::atof(argv[1]);
    if (!(millimetres > 0)) return k_wrong_usage;
    return run_coherence(millimetres, argv[2], {argv[3], argv[4]});
}

}  // namespace sqmap::bench
