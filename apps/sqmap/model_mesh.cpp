#include "model_mesh.h"

#include "common/hash_text.h"
#include "common/program_words.h"

#include <cstdio>

namespace sqmap::app {
namespace {

bool is_mesh_of(const model::ModelView& m, const mesh::Mesh& mesh)
{
    return m.header.triangle_count == mesh.triangles.size() && m.header.vertex_count == mesh.vertices.size() &&
           (m.mesh_hash == 0 || m.mesh_hash == mesh::content_hash(mesh));
}

std::string hash_suffix(std::uint64_t hash) { return hash == 0 ? "" : " (hash " + hash_text(hash) + ")"; }

}  // namespace

std::optional<AdmittedMesh> mesh_of_model(const model::ModelView& m, const std::string& model_name, const std::string& mesh,
                                          const MeshOptions& options)
{
    AdmittedMesh loaded = admit_mesh(mesh, options);
    if (loaded.refused()) {
        std::fprintf(stderr, "%s: %s", mesh.c_str(), report(loaded).c_str());
        return std::nullopt;
    }
    if (is_mesh_of(m, loaded.mesh)) return loaded;
    std::fprintf(stderr,
                 "%s was not baked from %s: it was made of %s, %u vertices and %u triangles%s; this mesh has %zu and %zu%s\n"
                 "  give the mesh it was baked from, with the same --repair, --surface, --thickness and --unit\n",
                 model_name.c_str(), mesh.c_str(), std::string(m.source).c_str(), m.header.vertex_count, m.header.triangle_count,
                 hash_suffix(m.mesh_hash).c_str(), loaded.mesh.vertices.size(), loaded.mesh.triangles.size(),
                 hash_suffix(mesh::content_hash(loaded.mesh)).c_str());
    return std::nullopt;
}

}  // namespace sqmap::app
