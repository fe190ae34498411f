#include "common/program_words.h"

namespace sqmap::app {

using mesh::Setting;

const mesh::SettingNames k_program_settings({{Setting::Repair, "--repair"},
                                             {Setting::MaxFilled, "--max-filled"},
                                             {Setting::Surface, "--surface"},
                                             {Setting::Thickness, "--thickness"},
                                             {Setting::PlateThickness, "sqmap bake --thickness"},
                                             {Setting::Unit, "--unit"},
                                             {Setting::MaxBytes, "--max-bytes"},
                                             {Setting::MaxFaces, "--max-faces"},
                                             {Setting::MaxComponents, "--max-components"},
                                             {Setting::MaxCuredFaces, "--max-cured-faces"},
                                             {Setting::MaxWrappedFaces, "--max-wrapped-faces"},
                                             {Setting::WrapTolerance, "--wrap-tolerance"},
                                             {Setting::MaxCells, "--max-cells"},
                                             {Setting::MaxParts, "--max-parts"},
                                             {Setting::TargetError, "--target-error"},
                                             {Setting::Exact, "--exact"},
                                             {Setting::Packages, "--package"}},
                                            " ");

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
