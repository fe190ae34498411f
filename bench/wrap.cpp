// Wrapping beside CGAL's alpha wrap: time, triangles and distances of both from the input; see docs/algorithms/wrap.md. CGAL's
// algorithm is GPL: it is used by this bench and by nothing that is shipped.
#include "sqmap/mesh/wrap.h"
#include "clock.h"
#include "measure.h"
#include "sqmap/io/read.h"
#include "sqmap/math/box.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace sqmap;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// Polygons as fans.
mesh::Mesh triangles_of(const io::PolygonSoup& soup)
{
    mesh::Mesh mesh;
    mesh.vertices = soup.positions;
    for (std::size_t f = 0; f + 1 < soup.polygon_offsets.size(); ++f)
        for (std::uint32_t k = soup.polygon_offsets[f] + 2; k < soup.polygon_offsets[f + 1]; ++k)
            mesh.triangles.push_back({static_cast<std::uint32_t>(soup.indices[soup.polygon_offsets[f]]),
                                      static_cast<std::uint32_t>(soup.indices[k - 1]),
                                      static_cast<std::uint32_t>(soup.indices[k])});
    return mesh;
}

mesh::Mesh alpha_wrap(const mesh::Mesh& input, double alpha, double offset)
{
    std::vector<Kernel::Point_3> points;
    std::vector<std::array<std::size_t, 3>> faces;
    for (const Vec3d& p : input.vertices) points.emplace_back(p.x, p.y, p.z);
    for (const mesh::Triangle& t : input.triangles) faces.push_back({t[0], t[1], t[2]});
    SurfaceMesh wrapped;
    CGAL::alpha_wrap_3(points, faces, alpha, offset, wrapped);
    mesh::Mesh result;
    for (const auto v : wrapped.vertices()) {
        const auto& p = wrapped.point(v);
        result.vertices.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto f : wrapped.faces()) {
        mesh::Triangle triangle{};
        std::size_t k = 0;
        for (const auto v : CGAL::vertices_around_face(wrapped.halfedge(f), wrapped))
            triangle[k++] = static_cast<std::uint32_t>(v);
        result.triangles.push_back(triangle);
    }
    return result;
}

void report(const std::string& name, const char* method, double seconds, const mesh::Mesh& result, const mesh::Deviation& moved,
            double r_max)
{
    const auto percent = [&](double length) { return 100 * length / r_max; };
    std::printf("| %s | %s | %.1f | %zu | %.3f | %.3f | %.3f | %.3f | %.3f |\n", name.c_str(), method, seconds,
                result.triangles.size(), percent(moved.input_to_result.p99), percent(moved.input_to_result.max),
                percent(moved.result_to_input.p99), percent(moved.result_to_input.max), 100 * moved.made_up_share);
    std::fflush(stdout);
}

}  // namespace

int sqmap::bench::measure_wrap(int argc, char** argv)
{
    double alpha = 0.01, offset = 0.002;
    int first = 1;
    for (; first + 1 < argc && argv[first][0] == '-'; first += 2)
        (std::string(argv[first]) == "--alpha" ? alpha : offset) = std::atof(argv[first + 1]);
    if (first >= argc) return k_wrong_usage;
    std::puts("| mesh | method | CPU s | triangles | to result p99 % | max | to input p99 % | max | made up % |");
    std::puts("|---|---|---:|---:|---:|---:|---:|---:|---:|");
    for (int i = first; i < argc; ++i) {
        const std::string path = argv[i], name = path.substr(path.find_last_of('/') + 1);
        const io::ReadResult file = io::read_mesh_file(path);
        if (file.error) {
            std::fprintf(stderr, "%s: %s: %s\n", path.c_str(), file.error->code.c_str(), file.error->message.c_str());
            return 2;
        }
        const mesh::Mesh input = triangles_of(file.soup);
        const double r_max = mesh::largest_vertex_distance(input);
        double start = bench::process_seconds();
        const mesh::WrapResult own = mesh::wrap(input.vertices, input.triangles);
        report(name, "sqmap", bench::process_seconds() - start, own.mesh, mesh::deviation(input, own.mesh, own.made_up), r_max);
        start = bench::process_seconds();
        const mesh::Mesh rival = alpha_wrap(input, alpha * r_max, offset * r_max);
        report(name, "alpha wrap", bench::process_seconds() - start, rival, mesh::deviation(input, rival), r_max);
    }
    return 0;
}
