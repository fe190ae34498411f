#include "load_options.h"

#include <map>
#include <string>

namespace sqmap::app {

void add_load_options(Command& command, LoadOptions& options)
{
    const std::map<std::string, mesh::Repair> repairs{
        {"none", mesh::Repair::None}, {"safe", mesh::Repair::Safe}, {"holes", mesh::Repair::Holes}};
    command.choice("--repair", options.repair, repairs, "What may be changed: none, safe, or safe and small holes filled",
                   "none|safe|holes");
    command.flag("--surface", options.accept_surface, "Take an open mesh as a surface without inside");
    command
        .option("--thickness", options.thickness,
                "Make open meshes and flat ones, also closed, plates this thick, in units of the result")
        .above_zero();
    // The result is in metres, so that "--unit mm" divides by a thousand.
    command.unit(
        "--unit", [&options](double metres) { options.unit = metres; },
        "The file's unit of length: um, mm, cm, dm, m, km, in, ft or metres per unit; the result is in metres");
    const char* const k_limits = "Limits (beyond them: E_LIMIT)";
    command.option("--max-bytes", options.limits.max_bytes, "Largest file; also as 500MB or 4GB, of 1024 each")
        .size_in_bytes()
        .above_zero()
        .type_name("SIZE")
        .shows_default("2GB")
        .group(k_limits);
    command.option("--max-faces", options.limits.max_faces, "Most faces in the file")
        .above_zero()
        .shows_default()
        .group(k_limits);
    command.option("--max-components", options.max_components, "Most connected pieces of the surface")
        .above_zero()
        .shows_default()
        .group(k_limits);
}

}  // namespace sqmap::app
