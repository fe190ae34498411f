#include "frames.h"

#include "clock.h"
#include "error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace sqmap::bench {
namespace {

std::uint64_t hash_of(const FrameAnswer& answer)
{
    Hash hash;
    for (const VertexContact& c : answer.vertices) {
        hash.add(c.vertex);
        hash.add(static_cast<std::uint64_t>(std::lround(1e5 * static_cast<double>(c.depth))));
    }
    hash.add(answer.pairs);
    hash.add(answer.pairs_hash);
    return hash.value();
}

/// Sums over frames of how a method's vertices compare with the true ones.
class Judge {
public:
    Judge(const Setting& setting) : setting_(setting) {}

    void add(const Pose& pose, std::span<const TrueContact> truth, std::span<const VertexContact> found)
    {
        auto f = found.begin();
        const auto judge_false = [&] {
            ++false_;
            const Vec3d p = apply(pose, setting_.probe.vertices[f->vertex]);
            false_distance_ = std::max(false_distance_, setting_.solid.closest_boundary(p).distance);
            ++f;
        };
        for (const TrueContact& t : truth) {
            while (f != found.end() && f->vertex < t.vertex) judge_false();
            double depth = 0;
            if (f != found.end() && f->vertex == t.vertex) {
                depth = static_cast<double>((f++)->depth);
            } else {
                ++missed_;
                missed_depth_ = std::max(missed_depth_, t.depth);
            }
            error_sum_ += std::abs(depth - t.depth);
            error_max_ = std::max(error_max_, std::abs(depth - t.depth));
        }
        while (f != found.end()) judge_false();
        inside_ += truth.size();
        outside_ += setting_.probe.vertices.size() - truth.size();
    }

    [[nodiscard]] Accuracy result() const
    {
        const auto share = [](std::size_t part, std::size_t whole) {
            return whole == 0 ? std::numeric_limits<double>::quiet_NaN()
                              : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
        };
        const double percent = 100 / setting_.r_max;
        constexpr double k_none = std::numeric_limits<double>::quiet_NaN();
        return {.missed_pct = share(missed_, inside_),
                .false_pct = share(false_, outside_),
                .depth_error_mean_pct = percent * error_sum_ / static_cast<double>(inside_),
                .depth_error_max_pct = inside_ == 0 ? k_none : percent * error_max_,
                .missed_depth_max_pct = inside_ == 0 ? k_none : percent * missed_depth_,
                .false_distance_max_pct = outside_ == 0 ? k_none : percent * false_distance_};
    }

private:
    const Setting& setting_;
    std::size_t inside_ = 0, outside_ = 0, missed_ = 0, false_ = 0;
    double error_sum_ = 0, error_max_ = 0, missed_depth_ = 0, false_distance_ = 0;
};

/// One contestant's samples and answers.
struct Lane {
    explicit Lane(const Setting& setting) : judge(setting) {}

    std::size_t stride = 1;                    ///< frames that are multiples of it are run
    std::vector<std::vector<double>> samples;  ///< a frame: a sample a pass
    std::vector<std::uint64_t> hashes;         ///< a frame, of the first pass
    std::vector<std::uint32_t> frame_contacts;
    Judge judge;
    std::size_t contacts = 0;
};

}  // namespace

double percentile(std::vector<double> samples, double q)
{
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(samples.size())));
    const auto at = samples.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
    std::nth_element(samples.begin(), at, samples.end());
    return *at;
}

std::vector<Record> race(const Setting& setting, std::span<const Pose> path, std::span<const std::vector<TrueContact>> truth,
                         std::span<const Contestant> contestants, const RaceOptions& options)
{
    const FrameClock clock;
    std::vector<Lane> lanes(contestants.size(), Lane(setting));
    for (std::size_t c = 0; c < lanes.size(); ++c) {
        if (contestants[c].entry->slow)
            lanes[c].stride = std::max<std::size_t>(1, (path.size() + options.slow_frames - 1) / options.slow_frames);
        lanes[c].samples.resize((path.size() + lanes[c].stride - 1) / lanes[c].stride);
        lanes[c].hashes.resize(lanes[c].samples.size());
        lanes[c].frame_contacts.resize(lanes[c].samples.size());
    }
    FrameAnswer answer;
    const auto turn = [&](std::size_t c, std::size_t begin, std::size_t end, std::uint32_t pass) {
        Method& method = *contestants[c].method;
        Lane& lane = lanes[c];
        std::size_t f = (begin + lane.stride - 1) / lane.stride * lane.stride;
        // The caches are the previous method's: one frame to make them ours, unless that is what is to be measured.
        if (options.block > 1 && f < end) method.run(path[f > 0 ? f - 1 : 0]);
        for (; f < end; f += lane.stride) {
            const FrameClock::Mark mark = FrameClock::start();
            method.run(path[f]);
            lane.samples[f / lane.stride].push_back(clock.stop_us(mark));
            answer.vertices.clear();
            answer.pairs = answer.pairs_hash = 0;
            method.read(answer);
            std::uint64_t& hash = lane.hashes[f / lane.stride];
            if (pass == 0) {
                hash = hash_of(answer);
                lane.frame_contacts[f / lane.stride] = static_cast<std::uint32_t>(answer.vertices.size() + answer.pairs);
                lane.contacts += answer.vertices.size() + answer.pairs;
                if (contestants[c].entry->pairs) continue;
                answer.vertices.clear();
                method.read_all(path[f], answer);
                lane.judge.add(path[f], truth[f], answer.vertices);
            } else if (hash != hash_of(answer)) {
                throw BenchError(contestants[c].entry->name + ": frame " + std::to_string(f + 1) +
                                 " is answered differently in pass " + std::to_string(pass + 1) +
                                 "\n  cure: none at the user's end; please report it");
            }
        }
    };
    // Drawn anew for each block: layers of one model share memory, so the one that always came after another found it in caches.
    std::vector<std::size_t> order(contestants.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::mt19937 draw;  // NOLINT(cert-msc51-cpp): the same order in every run
    for (std::uint32_t pass = 0; pass < options.passes; ++pass)
        for (std::size_t begin = 0; begin < path.size(); begin += options.block) {
            std::shuffle(order.begin(), order.end(), draw);
            for (const std::size_t c : order) turn(c, begin, std::min<std::size_t>(path.size(), begin + options.block), pass);
        }

    std::vector<Record> records;
    for (std::size_t c = 0; c < contestants.size(); ++c) {
        const Lane& lane = lanes[c];
        const Method& method = *contestants[c].method;
        std::vector<double> medians, all;
        for (const std::vector<double>& samples : lane.samples) {
            medians.push_back(percentile(samples, 0.5));
            all.insert(all.end(), samples.begin(), samples.end());
        }
        Hash hash;
        for (const std::uint64_t h : lane.hashes) hash.add(h);
        Record record{.method = contestants[c].entry->name,
                      .p50_us = percentile(medians, 0.5),
                      .p99_us = percentile(medians, 0.99),
                      .p999_us = percentile(all, 0.999),
                      .bytes = method.bytes,
                      .probe_bytes = method.probe_bytes,
                      .build_s = method.build_s,
                      .contacts = static_cast<double>(lane.contacts) / static_cast<double>(lane.samples.size()),
                      .accuracy = {},
                      .hash = hash.value(),
                      .frames = static_cast<std::uint32_t>(lane.samples.size()),
                      .stride = lane.stride,
                      .frame_us = medians,
                      .frame_contacts = lane.frame_contacts};
        if (!contestants[c].entry->pairs) record.accuracy = lane.judge.result();
        records.push_back(std::move(record));
    }
    return records;
}

}  // namespace sqmap::bench
