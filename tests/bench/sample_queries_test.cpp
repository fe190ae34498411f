#include "sample_queries.h"

#include "error.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace sqmap::bench {
namespace {

std::filesystem::path clone()
{
    const char* named = std::getenv("SQMAP_SAMPLE_QUERIES");
    return named != nullptr ? std::filesystem::path(named) : std::filesystem::path(SQMAP_SHARED_DIR) / "Sample-Queries";
}

TEST(SampleQueries, NoTouchIsMissedAndFewAreFalse)
{
    if (!std::filesystem::is_directory(clone()))
        GTEST_SKIP() << "no queries: git clone https://github.com/Continuous-Collision-Detection/Sample-Queries, and name its "
                        "folder by SQMAP_SAMPLE_QUERIES";
    const std::vector<SampleQuery> queries = read_sample_queries(clone());
    ASSERT_GE(queries.size(), 7279u);
    std::size_t missed = 0, wrong = 0, apart = 0;
    for (const SampleQuery& q : queries) {
        const bool touches = q.answer().touches;
        missed += q.touches && !touches ? 1u : 0u;
        wrong += !q.touches && touches ? 1u : 0u;
        apart += q.touches ? 0u : 1u;
    }
    EXPECT_EQ(missed, 0u);
    EXPECT_LE(1000 * wrong, apart) << wrong << " of " << apart << " that do not touch";
}

TEST(SampleQueries, AFileThatIsNoneIsNamedWithItsLine)
{
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "sample_queries" / "scene" / "edge-edge";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "data.csv") << "1,1,2,1,3,1,0\n1,0,2,1,3,1,0\n";
    try {
        (void)read_sample_queries(folder);
        FAIL();
    } catch (const BenchError& e) {
        EXPECT_NE(std::string(e.what()).find("data.csv: line 2"), std::string::npos) << e.what();
    }
    std::ofstream(folder / "data.csv") << "version https://git-lfs.github.com/spec/v1\n";
    EXPECT_TRUE(read_sample_queries(folder).empty());
}

}  // namespace
}  // namespace sqmap::bench
