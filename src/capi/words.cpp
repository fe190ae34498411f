// How the languages behind the C interface write the settings that notes and cures name.
#include "words.h"

#include "structs.h"

#include <array>
#include <cctype>
#include <string>
#include <string_view>

namespace sqmap::capi {
namespace {

/// Members of sqmap_bake_options, in the order of mesh::Setting.
constexpr std::array<const char*, mesh::k_settings> k_members{
    "repair", nullptr, "accepts_surface", "thickness",      "thickness", "unit",      nullptr,        nullptr,
    nullptr,  nullptr, nullptr,           "wrap_tolerance", nullptr,     "max_parts", "target_error", "without_exact = 0"};

/// The enumerators of sqmap_repair, and units as numbers.
std::string c_value(mesh::Setting setting, std::string_view word)
{
    if (setting == mesh::Setting::Unit && word == "mm") return "0.001";
    if (setting != mesh::Setting::Repair) return std::string(word);
    std::string out = "SQMAP_REPAIR_";
    for (const char c : word) out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return out;
}

const mesh::SettingNames k_c_settings{.names = k_members, .equals = " = ", .value = c_value};

/// Texts stand in quotes in Python and JavaScript.
std::string quoted(mesh::Setting setting, std::string_view word)
{
    const bool is_text = setting == mesh::Setting::Repair || setting == mesh::Setting::Unit;
    return is_text ? '"' + std::string(word) + '"' : std::string(word);
}

const mesh::SettingNames k_python_settings{
    .names = {"repair", nullptr, "surface=True", "thickness", "thickness", "unit", nullptr, nullptr, nullptr, nullptr, nullptr,
              "wrap_tolerance", nullptr, "max_parts", "target_error", "exact=True"},
    .equals = "=",
    .value = quoted,
};

const mesh::SettingNames k_javascript_settings{
    .names = {"repair", nullptr, "surface: true", "thickness", "thickness", "unit", nullptr, nullptr, nullptr, nullptr, nullptr,
              "wrapTolerance", nullptr, "maxParts", "targetError", "exact: true"},
    .equals = ": ",
    .value = quoted,
};

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
