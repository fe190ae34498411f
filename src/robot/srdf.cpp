#include "sqmap/robot/sweep.h"

#include <pugixml.hpp>

#include <cstdio>
#include <sstream>

namespace sqmap::robot {

std::string srdf_text(const std::string& robot, const Sweep& swept)
{
    pugi::xml_document document;
    pugi::xml_node root = document.append_child("robot");
    root.append_attribute("name").set_value(robot.c_str());
    for (const SweptPair& pair : swept.pairs) {
        const bool is_free = pair.verdict == PairVerdict::Free;
        if (!is_free && pair.verdict != PairVerdict::Adjacent) continue;
        if (is_free) {
            char words[96];
            std::snprintf(words, sizeof words, " sqmap: proven farther apart than %.4g m; nearest seen %.4g m ", pair.bound,
                          pair.seen);
            root.append_child(pugi::node_comment).set_value(words);
        }
        pugi::xml_node line = root.append_child("disable_collisions");
        line.append_attribute("link1").set_value(pair.a.c_str());
        line.append_attribute("link2").set_value(pair.b.c_str());
        line.append_attribute("reason").set_value(is_free ? "Never" : "Adjacent");
    }
    std::ostringstream stream;
    document.save(stream, "  ", pugi::format_indent, pugi::encoding_utf8);
    return stream.str();
}

}  // namespace sqmap::robot
