#include "common/program_words.h"

namespace sqmap::app {

const mesh::SettingNames k_program_settings{
    .names = {"--repair", "--max-filled", "--surface", "--thickness", "sqmap bake --thickness", "--unit", "--max-bytes",
              "--max-faces", "--max-components", "--max-cured-faces", "--max-wrapped-faces", "--wrap-tolerance", "--max-cells",
              "--max-parts", "--target-error", "--exact"},
};

std::string report(const AdmittedMesh& mesh)
{
    std::string out = mesh::name_of(mesh.admission);
    const mesh::Diagnosis& d = mesh.diagnosis;
    if (mesh.refused())
        out += std::string(" ") + mesh::name_of(d.code) + " at " + d.element + ": " + d.message +
               "\n  cure: " + d.cure.text(k_program_settings);
    out += "\n";
    for (const std::string& note : words(mesh.notes(), k_program_settings)) out += "  " + note + "\n";
    return out;
}

}  // namespace sqmap::app
