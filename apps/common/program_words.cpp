#include "common/program_words.h"

#include <algorithm>

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

std::string as_option(const std::string& name)
{
    std::string out = "--" + name;
    std::replace(out.begin(), out.end(), '_', '-');
    return out;
}

std::string option_of(const IdleOption& idle)
{
    const std::string name = idle.name;
    return as_option(name == "gaps" || name == "pruning" ? "no_" + name : name);
}

std::string reason_of(const IdleOption& idle)
{
    const std::string cure = idle.cure;
    std::string out = std::string(idle.why) + ": ";
    for (std::size_t at = 0; at < cure.size();) {
        const std::size_t open = cure.find('\'', at), close = open == std::string::npos ? open : cure.find('\'', open + 1);
        out += cure.substr(at, open - at);
        if (close == std::string::npos) break;
        out += as_option(cure.substr(open + 1, close - open - 1));
        at = close + 1;
    }
    return out;
}

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
