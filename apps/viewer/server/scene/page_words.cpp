#include "viewer/server/scene/page_words.h"

namespace sqmap::viewer {

using mesh::Setting;

const mesh::SettingNames k_page_settings({{Setting::Repair, "“Repair”"},
                                          {Setting::Surface, "“take it as a surface”"},
                                          {Setting::Thickness, "“Sheets are”"},
                                          {Setting::PlateThickness, "“Sheets are”"},
                                          {Setting::Unit, "“Unit of the file”"},
                                          {Setting::MaxParts, "“Parts at most”"},
                                          {Setting::TargetError, "“Depth error at most”"}},
                                         ": ", [](Setting setting, std::string_view word) {
                                             if (setting != Setting::Repair) return std::string(word);
                                             return std::string(word == "safe"    ? "“only what moves nothing”"
                                                                : word == "close" ? "“close holes, no wrapping”"
                                                                                  : "“whatever it needs”");
                                         });

}  // namespace sqmap::viewer
