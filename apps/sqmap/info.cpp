#include "commands.h"
#include "common/reports.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/model_json.h"
#include "sqmap/model/parse.h"

#include <cstdio>
#include <memory>

namespace sqmap::app {
namespace {

struct Options {
    std::string model;
    bool json = false;
};

bool is_central(const model::ModelView& m)
{
    return m.header.projection == static_cast<std::uint32_t>(model::Projection::Central);
}

void print(const std::string& name, const model::ModelView& m, const io::SectionBytes& bytes)
{
    const bool central = is_central(m);
    print_doubt(m.measured);
    std::printf("%s: %zu parts, %s projection, %u triangles, made by %s from %s%s\n", name.c_str(), m.parts.size(),
                central ? "central" : "normal", m.header.triangle_count, std::string(m.made_by).c_str(),
                std::string(m.source).c_str(), rung_suffix(m.cure));
    print_cure(m.cure);
    std::printf("  %zu bytes: superquadrics %zu, %smap %zu, locator %zu, exact layer %zu + %zu, distances %zu\n", bytes.total,
                bytes.superquadrics, central ? "" : "normal ", central ? bytes.map : bytes.normal_map, bytes.locator,
                bytes.exact + (central ? 0 : bytes.map), bytes.mesh, bytes.distance);
    std::printf("  R_max %.6g; 16-bit storage moves a radius by at most %.5f %% of it\n", m.header.r_max * m.header.unit,
                100 * m.header.quantisation / m.header.r_max);
    print_measured(m.measured);
    std::printf("  signed distances exact within %.6g of the surface\n",
                static_cast<double>(m.distance.header.band) * m.header.unit);
    std::printf("  part      a1       a2       a3    eps1  eps2  triangles  largest F\n");
    for (std::size_t i = 0; i < m.parts.size(); ++i) {
        const model::Part& p = m.parts[i];
        std::printf("  %4zu %8.4f %8.4f %8.4f  %5.2f %5.2f  %9u  %.6f%s%s%s\n", i, p.a[0], p.a[1], p.a[2], p.eps[0], p.eps[1],
                    p.triangle_count, p.largest_f, p.taper[0] != 0 || p.taper[1] != 0 ? " tapered" : "",
                    p.bend != 0 ? " bent" : "", model::is_fallback(p) ? " fallback" : "");
    }
}

int run(const Options& o)
{
    try {
        const io::MappedModel file(o.model);
        const model::ModelView& m = file.view();
        const io::SectionBytes bytes = io::section_bytes(m, file.size());
        if (o.json)
            std::printf("%s\n", io::model_json(m, file.size()).c_str());
        else
            print(o.model, m, bytes);
        return 0;
    } catch (const io::ModelFileError& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 2;
    }
}

}  // namespace

void add_info(CommandLine& line)
{
    const auto options = std::make_shared<Options>();
    Command command = line.add("info", "Say what is in a model: parts, certificates, bytes, measured error");
    command.option("model", options->model, "Model (.sqmap)").required().existing_file();
    command.flag("--json", options->json, "Answer as JSON");
    command.footer("Exit code: 0 printed, 2 not a valid model, 64 wrong usage, 70 internal error.");
    command.run([options] { return run(*options); });
}

}  // namespace sqmap::app
