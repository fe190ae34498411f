#include "commands.h"
#include "load_options.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;

ordered_json as_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

/// The file's name may hold any bytes; JSON is UTF-8.
std::string dumped(const ordered_json& j) { return j.dump(2, ' ', false, ordered_json::error_handler_t::replace); }

ordered_json as_json(const std::string& file, const LoadedMesh& loaded)
{
    const bool refused = loaded.refused();
    const auto text_or_null = [&](const std::string& text) { return refused ? ordered_json(text) : ordered_json(nullptr); };
    ordered_json out{{"file", file},
                     {"format", loaded.format.empty() ? ordered_json(nullptr) : ordered_json(loaded.format)},
                     {"verdict", verdict_name(loaded.verdict)},
                     {"code", text_or_null(loaded.diagnosis.code)},
                     {"element", text_or_null(loaded.diagnosis.element)},
                     {"message", text_or_null(loaded.diagnosis.message)},
                     {"cure", text_or_null(loaded.diagnosis.cure)},
                     {"repairs", ordered_json::array()},
                     {"warnings", ordered_json::array()}};
    for (const mesh::RepairNote& r : loaded.repairs)
        out["repairs"].push_back({{"kind", mesh::name_of(r.kind)}, {"count", r.count}});
    for (const mesh::Warning& w : loaded.warnings)
        out["warnings"].push_back({{"code", mesh::name_of(w.kind)}, {"count", w.count}, {"message", w.message}});
    if (refused) return out;
    const mesh::MeshFacts& f = loaded.facts;
    out["facts"] = {{"vertices", f.vertex_count},
                    {"triangles", f.triangle_count},
                    {"solid", loaded.solid},
                    {"components", f.component_count},
                    {"genus", loaded.solid ? ordered_json(f.genus) : ordered_json(nullptr)},
                    {"boundary_edges", f.boundary_edge_count},
                    {"self_intersecting_pairs", f.self_intersecting_pairs},
                    {"box_min", as_json(f.box.lo)},
                    {"box_max", as_json(f.box.hi)},
                    {"area", f.area},
                    {"volume", loaded.solid ? ordered_json(f.volume) : ordered_json(nullptr)}};
    return out;
}

void print(const std::string& file, const LoadedMesh& loaded)
{
    std::printf("%s: %s", file.c_str(), report(loaded).c_str());
    if (loaded.refused()) return;
    const mesh::MeshFacts& f = loaded.facts;
    const Vec3d size = sqmap::size(f.box);
    std::printf("  %s, %llu vertices, %llu triangles, %llu component%s\n", loaded.format.c_str(),
                static_cast<unsigned long long>(f.vertex_count), static_cast<unsigned long long>(f.triangle_count),
                static_cast<unsigned long long>(f.component_count), f.component_count == 1 ? "" : "s");
    if (loaded.solid)
        std::printf("  closed, genus %lld, volume %.6g, area %.6g\n", static_cast<long long>(f.genus), f.volume, f.area);
    else
        std::printf("  open, %llu boundary edges, area %.6g\n", static_cast<unsigned long long>(f.boundary_edge_count), f.area);
    std::printf("  box %.6g x %.6g x %.6g\n", size.x, size.y, size.z);
}

}  // namespace

void add_check(CommandLine& line)
{
    struct Options {
        std::string file;
        LoadOptions load;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    Command command = line.add("check", "Say whether a mesh can be used, what would be repaired, or why not");
    command.option("mesh", options->file, "OFF, OBJ, STL, PLY, glTF or GLB; with the program assimp also DAE, 3MF, FBX")
        .required()
        .existing_file();
    command.flag("--json", options->json, "Answer as JSON");
    add_load_options(command, options->load);
    command.footer("Exit code: 0 accepted or repaired, 2 refused, 64 wrong usage, 70 internal error.");
    command.run([options] {
        const LoadedMesh loaded = load_mesh(options->file, options->load);
        if (options->json)
            std::printf("%s\n", dumped(as_json(options->file, loaded)).c_str());
        else
            print(options->file, loaded);
        return loaded.refused() ? 2 : 0;
    });
}

}  // namespace sqmap::app
