#include "sample_queries.h"

#include "error.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace sqmap::bench {
namespace {

struct Row {
    Vec3d point;
    bool touches;
};

/// "n,d,n,d,n,d,truth" with whole numbers: coordinates n / d.
bool parse(const std::string& line, Row& row)
{
    const char* at = line.c_str();
    double number[7];
    for (int i = 0; i < 7; ++i) {
        char* end = nullptr;
        number[i] = std::strtod(at, &end);
        if (end == at || (i < 6 && *end != ',')) return false;
        at = end + 1;
    }
    if (number[1] == 0 || number[3] == 0 || number[5] == 0) return false;
    row = {{number[0] / number[1], number[2] / number[3], number[4] / number[5]}, number[6] != 0};
    return true;
}

void read(const std::filesystem::path& file, std::vector<SampleQuery>& queries)
{
    std::ifstream in(file);
    std::string line;
    std::vector<Row> rows;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        if (number == 1 && line.rfind("version https://git-lfs", 0) == 0) return;
        if (!parse(line, rows.emplace_back()))
            throw BenchError(file.string() + ": line " + std::to_string(number) +
                             " is not three fractions and a truth\n  cure: clone Sample-Queries again");
    }
    if (rows.size() % 8 != 0)
        throw BenchError(file.string() + ": " + std::to_string(rows.size()) +
                         " lines, not eight for each query\n  cure: clone Sample-Queries again");
    for (std::size_t i = 0; i < rows.size(); i += 8) {
        SampleQuery q{file.parent_path().filename() == "edge-edge",
                      {},
                      rows[i].touches,
                      file.parent_path().parent_path().filename().string()};
        for (std::size_t k = 0; k < 4; ++k) q.points[k] = {rows[i + k].point, rows[i + 4 + k].point};
        queries.push_back(q);
    }
}

}  // namespace

query::Touch SampleQuery::answer() const noexcept
{
    if (is_edges) {
        const query::MovingPoint a[2] = {points[0], points[1]}, b[2] = {points[2], points[3]};
        return query::first_touch(a, b);
    }
    const query::MovingPoint triangle[3] = {points[1], points[2], points[3]};
    return query::first_touch(points[0], triangle);
}

std::vector<SampleQuery> read_sample_queries(const std::filesystem::path& folder)
{
    if (!std::filesystem::is_directory(folder))
        throw BenchError(folder.string() +
                         ": no such folder\n  cure: git clone "
                         "https://github.com/Continuous-Collision-Detection/Sample-Queries");
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".csv") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<SampleQuery> queries;
    for (const std::filesystem::path& file : files) read(file, queries);
    return queries;
}

}  // namespace sqmap::bench
