// The notes and the refusal of a mesh file through the doors of C++ and of the page, as JSON, for doors_test.py.
// usage: doors MESH
#include "sqmap/bake_mesh.h"
#include "viewer/server/scene/facts.h"
#include "viewer/server/scene/load.h"
#include "viewer/server/scene/page_words.h"

#include <nlohmann/json.hpp>

#include <cstdio>

int main(int argc, char** argv)
{
    using namespace sqmap;
    if (argc != 2) return 64;
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
