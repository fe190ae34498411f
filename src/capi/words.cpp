// How the languages behind the C interface write the settings that notes and cures name.
#include "words.h"

#include "structs.h"

#include <cctype>
#include <string>
#include <string_view>

namespace sqmap::capi {
namespace {

using mesh::Setting;

/// The enumerators of sqmap_repair, and units as numbers.
std::string c_value(Setting setting, std::string_view word)
{
    if (setting == Setting::Unit && word == "mm") return "0.001";
    if (setting != Setting::Repair) return std::string(word);
    std::string out = "SQMAP_REPAIR_";
    for (const char c : word) out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return out;
}

/// Texts stand in quotes in Python and JavaScript.
std::string quoted(Setting setting, std::string_view word)
{
    const bool is_text = setting == Setting::Repair || setting == Setting::Unit;
    return is_text ? '"' + std::string(word) + '"' : std::string(word);
}

/// Members of sqmap_bake_options and functions of sqmap.h.
const mesh::SettingNames k_c_settings({{Setting::Repair, "repair"},
                                       {Setting::Surface, "accepts_surface"},
                                       {Setting::Thickness, "thickness"},
                                       {Setting::PlateThickness, "thickness"},
                                       {Setting::Unit, "unit"},
                                       {Setting::WrapTolerance, "wrap_tolerance"},
                                       {Setting::MaxParts, "max_parts"},
                                       {Setting::TargetError, "target_error"},
                                       {Setting::Exact, "without_exact = 0"},
                                       {Setting::KeepInput, "without_input = 0"},
                                       {Setting::SolidProbe, "sqmap_make_solid_probe"},
                                       {Setting::Bake, "sqmap_bake"},
                                       {Setting::BakedMesh, "sqmap_triangles"}},
                                      " = ", c_value);

const mesh::SettingNames k_python_settings({{Setting::Repair, "repair"},
                                            {Setting::Surface, "surface=True"},
                                            {Setting::Thickness, "thickness"},
                                            {Setting::PlateThickness, "thickness"},
                                            {Setting::Unit, "unit"},
                                            {Setting::WrapTolerance, "wrap_tolerance"},
                                            {Setting::MaxParts, "max_parts"},
                                            {Setting::TargetError, "target_error"},
                                            {Setting::Exact, "exact=True"},
                                            {Setting::KeepInput, "keep_input=True"},
                                            {Setting::SolidProbe, "Probe(points, triangles)"},
                                            {Setting::Bake, "sqmap.bake"},
                                            {Setting::BakedMesh, "Model.mesh"}},
                                           "=", quoted);

const mesh::SettingNames k_javascript_settings({{Setting::Repair, "repair"},
                                                {Setting::Surface, "surface: true"},
                                                {Setting::Thickness, "thickness"},
                                                {Setting::PlateThickness, "thickness"},
                                                {Setting::Unit, "unit"},
                                                {Setting::WrapTolerance, "wrapTolerance"},
                                                {Setting::MaxParts, "maxParts"},
                                                {Setting::TargetError, "targetError"},
                                                {Setting::Exact, "exact: true"},
                                                {Setting::KeepInput, "keepInput: true"},
                                                {Setting::SolidProbe, "sqmap.probe(points, triangles)"},
                                                {Setting::Bake, "sqmap.bake"},
                                                {Setting::BakedMesh, "Model.mesh"}},
                                               ": ", quoted);

}  // namespace

const mesh::SettingNames& names_of(std::int32_t words, const char* element)
{
    switch (words) {
        case SQMAP_WORDS_C:
            return k_c_settings;
        case SQMAP_WORDS_PYTHON:
            return k_python_settings;
        case SQMAP_WORDS_JAVASCRIPT:
            return k_javascript_settings;
        default:
            throw Failure{SQMAP_E_ARGUMENT, element, "is " + std::to_string(words), "take one of sqmap_words"};
    }
}

}  // namespace sqmap::capi
