#include "frames.h"

#include "distance_grid.h"
#include "error.h"
#include "report.h"
#include "settings.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <memory>

namespace sqmap::bench {
namespace {

/// A race of methods by name.
std::map<std::string, Record> raced(const Setting& setting, const std::vector<Pose>& path, const std::vector<std::string>& names,
                                    const RaceOptions& options)
{
    std::vector<std::unique_ptr<Method>> methods;
    std::vector<Contestant> contestants;
    for (const MethodEntry& entry : method_entries())
        if (std::find(names.begin(), names.end(), entry.name) != names.end()) {
            methods.push_back(entry.make(setting, entry.argument));
            contestants.push_back({&entry, methods.back().get()});
        }
    std::map<std::string, Record> records;
    for (Record& r : race(setting, path, true_contacts(setting, path), contestants, options)) records[r.method] = r;
    return records;
}

TEST(Frames, PercentilesAreNearestRanks)
{
    const std::vector<double> samples{5, 1, 4, 2, 3};
    EXPECT_EQ(percentile(samples, 0.5), 3);
    EXPECT_EQ(percentile(samples, 0.2), 1);
    EXPECT_EQ(percentile(samples, 0.21), 2);
    EXPECT_EQ(percentile(samples, 0.99), 5);
    EXPECT_EQ(percentile({7}, 0.999), 7);
}

TEST(Frames, MethodsAnswerAsWellAsTheyCan)
{
    const auto setting = test::egg_on_ring();
    const std::vector<Pose> path = test::short_path(*setting, 0.03);
    const auto records =
        raced(*setting, path, {"dense64", "dense64_simd", "adf", "embree_exact", "sqmap_layer3", "sqmap_exact"}, {});
    // A trilinear function through exact values is nowhere further off than from a corner to the middle of a cell.
    const DistanceGrid grid = distance_grid(*setting, 64);
    const double half_cell = 0.5 * norm(grid.spacing) * 100 / setting->r_max;
    for (const char* name : {"dense64", "dense64_simd"}) {
        const Accuracy& a = records.at(name).accuracy.value();
        EXPECT_LE(a.depth_error_max_pct, half_cell) << name;
        EXPECT_LE(a.missed_depth_max_pct, half_cell) << name;
        EXPECT_LE(a.false_distance_max_pct, half_cell) << name;
        EXPECT_GT(a.depth_error_mean_pct, 0) << name;
    }
    EXPECT_NEAR(records.at("dense64").accuracy->depth_error_mean_pct, records.at("dense64_simd").accuracy->depth_error_mean_pct,
                1e-3);
    EXPECT_NEAR(records.at("adf").accuracy->depth_error_mean_pct, 0, 0.1);
    for (const char* name : {"embree_exact", "sqmap_exact"}) {
        const Accuracy& a = records.at(name).accuracy.value();
        EXPECT_LE(a.missed_depth_max_pct, 0.001) << name;
        EXPECT_LE(a.false_distance_max_pct, 0.001) << name;
    }
    EXPECT_LE(records.at("embree_exact").accuracy->depth_error_max_pct, 0.001);
    EXPECT_LE(records.at("sqmap_layer3").accuracy->missed_depth_max_pct, 0.5);
    for (const auto& [name, r] : records) {
        EXPECT_EQ(r.frames, 20u) << name;
        EXPECT_GT(r.bytes, 0u) << name;
        EXPECT_GT(r.contacts, 1) << name;
        EXPECT_GT(r.p50_us, 0) << name;
        EXPECT_LE(r.p50_us, r.p99_us) << name;
    }
    EXPECT_EQ(records.at("dense64").bytes, 64u * 64 * 64 * 4);
    EXPECT_EQ(records.at("dense64_simd").bytes, 64u * 64 * 64 * 2);
}

TEST(Frames, SlowMethodsSeeEveryKthFrameAndTheRecordSaysSo)
{
    const auto setting = test::egg_on_ring();
    const auto records = raced(*setting, test::short_path(*setting, 0.01), {"dense64_simd", "embree_exact"}, {.slow_frames = 6});
    EXPECT_EQ(records.at("dense64_simd").frames, 20u);
    EXPECT_EQ(records.at("embree_exact").frames, 5u);
}

TEST(Frames, AnswersDoNotDependOnTurns)
{
    const auto setting = test::egg_on_ring();
    const std::vector<Pose> path = test::short_path(*setting, 0.01);
    const auto by_frame = raced(*setting, path, {"dense64_simd", "embree_exact"}, {.block = 1});
    const auto by_pass = raced(*setting, path, {"dense64_simd", "embree_exact"}, {.block = 1000});
    for (const auto& [name, r] : by_frame) EXPECT_EQ(r.hash, by_pass.at(name).hash) << name;
}

/// Answers another way from its hundredth run on.
class Moody final : public Method {
public:
    void run(const Pose&) override { ++runs_; }
    void read(FrameAnswer& out) const override { out.vertices.push_back({0, runs_ < 100 ? 0.1f : 0.2f}); }

private:
    int runs_ = 0;
};

TEST(Frames, AMethodThatChangesItsAnswerIsCaught)
{
    const auto setting = test::egg_on_ring();
    const std::vector<Pose> path = test::short_path(*setting, 0.01);
    const MethodEntry entry{.name = "moody"};
    Moody moody;
    const Contestant contestant{&entry, &moody};
    EXPECT_THROW((void)race(*setting, path, true_contacts(*setting, path), std::span(&contestant, 1), {}), BenchError);
}

/// Claims a list of contacts in every frame.
class Claim final : public Method {
public:
    explicit Claim(std::vector<VertexContact> contacts) : contacts_(std::move(contacts)) {}
    void run(const Pose&) override {}
    void read(FrameAnswer& out) const override { out.vertices = contacts_; }

private:
    std::vector<VertexContact> contacts_;
};

TEST(Frames, MissedAndFalseContactsAndDepthsAreCountedAgainstTheTruth)
{
    const auto setting = test::egg_on_ring();
    const std::vector<Pose> path = test::short_path(*setting, 0.03, 1);
    const std::vector<std::vector<TrueContact>> truth = true_contacts(*setting, path);
    ASSERT_GE(truth[0].size(), 4u);
    const std::size_t inside = truth[0].size(), outside = setting->probe.vertices.size() - inside;
    // The first is missed, the second too deep by 0.01, the rest is right; one vertex is false.
    std::vector<VertexContact> claimed;
    for (std::size_t i = 1; i < inside; ++i)
        claimed.push_back({truth[0][i].vertex, static_cast<float>(truth[0][i].depth + (i == 1 ? 0.01 : 0))});
    const std::vector<double> distances = test::signed_distances(*setting, path[0]);
    const auto stranger = static_cast<std::uint32_t>(std::max_element(distances.begin(), distances.end()) - distances.begin());
    claimed.push_back({stranger, 0.5f});
    std::sort(claimed.begin(), claimed.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
    const MethodEntry entry{.name = "claim"};
    Claim claim(claimed);
    const Contestant contestant{&entry, &claim};
    const Accuracy a = race(*setting, path, truth, std::span(&contestant, 1), {})[0].accuracy.value();
    const double percent = 100 / setting->r_max;
    EXPECT_NEAR(a.missed_pct, 100.0 / static_cast<double>(inside), 1e-9);
    EXPECT_NEAR(a.false_pct, 100.0 / static_cast<double>(outside), 1e-9);
    EXPECT_NEAR(a.missed_depth_max_pct, percent * truth[0][0].depth, 1e-9);
    EXPECT_NEAR(a.false_distance_max_pct, percent * distances[stranger], 1e-9);
    EXPECT_NEAR(a.depth_error_mean_pct, percent * (truth[0][0].depth + 0.01) / static_cast<double>(inside), 1e-5);
    EXPECT_NEAR(a.depth_error_max_pct, percent * std::max(truth[0][0].depth, 0.01), 1e-5);
}

TEST(Report, HasEveryFieldAndNullWhereAMethodReportsPairs)
{
    Record pairs{.method = "fcl_obb_all", .p50_us = 3, .accuracy = {}};
    Record judged{.method = "dense64_simd", .p50_us = 2, .bytes = 7, .accuracy = Accuracy{.missed_pct = 1.5}, .hash = 0xabc};
    const auto json = nlohmann::json::parse(
        json_text(std::vector{pairs, judged}, {.object = "a.obj", .probe = "b.obj", .path = "a.b.deep.csv"}));
    ASSERT_EQ(json.size(), 2u);
    for (const auto& r : json)
        for (const char* field : {"method", "p50_us", "p99_us", "p999_us", "bytes", "build_s", "contacts", "missed_pct",
                                  "false_pct", "depth_error_mean_pct", "depth_error_max_pct", "hash", "frames"})
            EXPECT_TRUE(r.contains(field)) << field;
    for (const char* field : {"missed_pct", "false_pct", "depth_error_mean_pct", "depth_error_max_pct"}) {
        EXPECT_TRUE(json[0][field].is_null()) << field;
        EXPECT_TRUE(json[1][field].is_number()) << field;
    }
    EXPECT_EQ(json[1]["missed_pct"], 1.5);
    EXPECT_EQ(json[1]["hash"], "0000000000000abc");
}

}  // namespace
}  // namespace sqmap::bench
