// Borders of parts and of named parts beside the shortest ones near them.
#include "measure.h"

#include "sqmap/bake_mesh.h"
#include "sqmap/model/named_parts.h"
#include "support/least_border.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace {

using namespace sqmap;
using Borders = std::vector<test::BorderLength>;

void print_row(const std::string& name, Borders borders)
{
    if (borders.empty()) return;
    std::sort(borders.begin(), borders.end(), [](const auto& l, const auto& r) { return l.excess() < r.excess(); });
    double over = 0, on_open_ground = 0;
    for (const test::BorderLength& b : borders) {
        if (b.excess() <= 1.1) continue;
        over += 1;
        on_open_ground += b.crease_share < 0.5 ? 1 : 0;
    }
    const auto count = static_cast<double>(borders.size());
    std::printf("| %s | %.0f | %.3f | %.3f | %.1f | %.1f |\n", name.c_str(), count, borders[borders.size() / 2].excess(),
                borders.back().excess(), 100 * over / count, 100 * on_open_ground / count);
    std::fflush(stdout);
}

}  // namespace

int sqmap::bench::measure_borders(int argc, char** argv)
{
    if (argc < 2) return k_wrong_usage;
    std::puts("| mesh | borders | length over the least: median | greatest | over 1.10, % | and not in a crease, % |");
    std::puts("|---|---:|---:|---:|---:|---:|");
    Borders all_named, all_parts;
    for (int i = 1; i < argc; ++i) {
        const std::filesystem::path path = argv[i];
        BakeMeshOptions options;
        options.bake.locator = options.bake.exact = false;  // parts alone count
        options.bake.target_error = 100;
        const BakedModel baked = bake_mesh(path, options);
        const std::vector<std::uint32_t>& parts = baked.report.partition.part_of_triangle;
        std::vector<std::uint32_t> names;
        for (const std::uint32_t part : parts) names.push_back(model::group_of_part(baked.view(), part));
        const Borders named = test::border_lengths(baked.mesh.mesh, names), fine = test::border_lengths(baked.mesh.mesh, parts);
        all_named.insert(all_named.end(), named.begin(), named.end());
        all_parts.insert(all_parts.end(), fine.begin(), fine.end());
        print_row(path.stem().string() + ", named", named);
        print_row(path.stem().string() + ", parts", fine);
    }
    print_row("all, named", all_named);
    print_row("all, parts", all_parts);
    return 0;
}
