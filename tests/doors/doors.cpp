// The notes and the refusal of a mesh file through the doors of C++ and of the page, or the ranges of all options that are
// numbers, as JSON, for doors_test.py. usage: doors MESH | --options
#include "sqmap/bake_mesh.h"
#include "viewer/server/scene/facts.h"
#include "viewer/server/scene/load.h"
#include "viewer/server/scene/page_words.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstring>

namespace {

/// Each table's names with the least and the greatest value.
nlohmann::json ranges()
{
    nlohmann::json out;
    const auto add = [&](const auto& table) {
        for (const auto& option : table) out[option.name] = {option.range.least, option.range.max};
    };
    add(sqmap::bake::k_bake_numbers);
    add(sqmap::decompose::k_thresholds);
    add(sqmap::mesh::k_admission_numbers);
    add(sqmap::mesh::k_wrap_numbers);
    add(sqmap::paper::k_map_numbers);
    add(sqmap::paper::k_grid_numbers);
    return out;
}

}  // namespace

int main(int argc, char** argv)
{
    using namespace sqmap;
    if (argc != 2) return 64;
    if (std::strcmp(argv[1], "--options") == 0) return std::printf("%s\n", ranges().dump().c_str()) > 0 ? 0 : 1;
    nlohmann::json out;
    const auto refusal = [](const mesh::Diagnosis& d, const mesh::SettingNames& names) {
        return nlohmann::json{
            {"code", mesh::name_of(d.code)}, {"element", d.element}, {"message", d.message}, {"cure", d.cure.text(names)}};
    };
    try {
        const BakedModel model = bake_mesh(argv[1]);
        const auto object = viewer::object_from_mesh(admit_mesh(argv[1]), "mesh", 0.1, {});
        out["cpp"]["notes"] = words(model.notes);
        out["page"]["notes"] = viewer::facts_json(*object, object->parts, false)["notes"];
    } catch (const mesh::RefusedMesh& e) {
        out["cpp"] = refusal(e.diagnosis(), mesh::k_cpp_settings);
        out["page"] = refusal(admit_mesh(argv[1]).diagnosis, viewer::k_page_settings);
    }
    std::printf("%s\n", out.dump().c_str());
}
