// The queries of Continuous-Collision-Detection/Sample-Queries, with exact truth: moving points against triangles, edges against
// edges (github.com/Continuous-Collision-Detection/Sample-Queries; no copy is in this repository).
#pragma once

#include "sqmap/query/first_touch.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::bench {

struct SampleQuery {
    bool is_edges = false;
    std::array<query::MovingPoint, 4> points{};  ///< a point and a triangle, or the ends of two edges
    bool touches = false;                        ///< exactly
    std::string scene;                           ///< the file's folder

    [[nodiscard]] query::Touch answer() const noexcept;
};

/// All queries below a clone's folder, file after file in the order of their names; a file that is a pointer of Git LFS is left
/// out.
/// @throw BenchError that names file and line
[[nodiscard]] std::vector<SampleQuery> read_sample_queries(const std::filesystem::path& folder);

}  // namespace sqmap::bench
