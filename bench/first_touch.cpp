// The elementary queries of first touch on queries with exact truth: verdicts and time.
#include "clock.h"
#include "error.h"
#include "frames.h"
#include "measure.h"
#include "sample_queries.h"

#include <cstdio>

namespace sqmap::bench {
namespace {

int run(const char* folder)
{
    const std::vector<SampleQuery> queries = read_sample_queries(folder);
    if (queries.empty()) throw BenchError(std::string(folder) + ": no queries\n  cure: name a clone of Sample-Queries");
    const FrameClock clock;
    for (const bool edges : {false, true}) {
        std::size_t count = 0, touching = 0, missed = 0, wrong = 0;
        std::vector<double> us;
        double sum = 0;
        for (const SampleQuery& q : queries) {
            if (q.is_edges != edges) continue;
            std::vector<double> samples;
            query::Touch touch;
            for (int pass = 0; pass < 5; ++pass) {
                const FrameClock::Mark mark = FrameClock::start();
                touch = q.answer();
                samples.push_back(clock.stop_us(mark));
            }
            ++count;
            touching += q.touches ? 1u : 0u;
            missed += q.touches && !touch.touches ? 1u : 0u;
            wrong += !q.touches && touch.touches ? 1u : 0u;
            if (!q.touches && touch.touches) std::printf("  false positive in %s at %.9g\n", q.scene.c_str(), touch.time);
            us.push_back(percentile(samples, 0.5));
            sum += us.back();
        }
        if (count == 0) continue;
        std::printf("%s: %zu queries, %zu touch; missed %zu, false %zu; us: mean %.3f  p50 %.3f  p99 %.3f  max %.1f\n",
                    edges ? "edge-edge" : "vertex-face", count, touching, missed, wrong, sum / static_cast<double>(count),
                    percentile(us, 0.5), percentile(us, 0.99), percentile(us, 1));
    }
    return 0;
}

}  // namespace
}  // namespace sqmap::bench

int sqmap::bench::measure_first_touch(int argc, char** argv) { return argc == 2 ? run(argv[1]) : k_wrong_usage; }
