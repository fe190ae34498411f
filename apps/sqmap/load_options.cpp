#include "load_options.h"

#include "commands.h"

#include <map>
#include <string>

namespace sqmap::app {

void add_load_options(CLI::App& command, LoadOptions& options)
{
    const std::map<std::string, mesh::Repair> repairs{
        {"none", mesh::Repair::None}, {"safe", mesh::Repair::Safe}, {"holes", mesh::Repair::Holes}};
    command.add_option("--repair", options.repair, "What may be changed: none, safe, or safe and small holes filled")
        ->transform(CLI::CheckedTransformer(repairs, CLI::ignore_case))
        ->type_name("none|safe|holes")
        ->default_str("safe");
    command.add_flag("--surface", options.accept_surface, "Take an open mesh as a surface without inside");
    command
        .add_option("--thickness", options.thickness,
                    "Make open meshes and flat ones, also closed, plates this thick, in units of the result")
        ->check(above_zero());
    // The result is in metres, so that "--unit mm" divides by a thousand.
    command
        .add_option_function<std::string>(
            "--unit",
            [&options](const std::string& text) {
                const std::map<std::string, double> units{{"um", 1e-6}, {"mm", 1e-3},   {"cm", 1e-2},   {"dm", 0.1},
                                                          {"m", 1.0},   {"km", 1000.0}, {"in", 0.0254}, {"ft", 0.3048}};
                double value = 0;
                if (const auto known = units.find(text); known != units.end())
                    value = known->second;
                else if (!CLI::detail::lexical_cast(text, value) || !(value >= 1e-12 && value <= 1e12))
                    throw CLI::ValidationError("--unit", "um, mm, cm, dm, m, km, in, ft or metres per unit");
                options.unit = value;
            },
            "The file's unit of length: um, mm, cm, dm, m, km, in, ft or metres per unit; the result is in metres")
        ->type_name("UNIT");
    const char* const k_limits = "Limits (beyond them: E_LIMIT)";
    command.add_option("--max-bytes", options.limits.max_bytes, "Largest file; also as 500MB or 4GB, of 1024 each")
        ->transform(CLI::AsSizeValue(false))
        ->check(above_zero())
        ->type_name("SIZE")
        ->default_str("2GB")
        ->group(k_limits);
    command.add_option("--max-faces", options.limits.max_faces, "Most faces in the file")
        ->check(above_zero())
        ->capture_default_str()
        ->group(k_limits);
    command.add_option("--max-components", options.max_components, "Most connected pieces of the surface")
        ->check(above_zero())
        ->capture_default_str()
        ->group(k_limits);
}

}  // namespace sqmap::app
