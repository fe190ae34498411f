#include "viewer/server/scene/page_words.h"

namespace sqmap::viewer {

const mesh::SettingNames k_page_settings{
    .names = {"“Repair”", nullptr, "“take it as a surface”", "“Sheets are”", "“Sheets are”", "“Unit of the file”", nullptr,
              nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, "“Parts at most”", "“Depth error at most”", nullptr},
    .equals = ": ",
    .value =
        [](mesh::Setting setting, std::string_view word) {
            if (setting != mesh::Setting::Repair) return std::string(word);
            return std::string(word == "safe"    ? "“only what moves nothing”"
                               : word == "close" ? "“close holes, no wrapping”"
                                                 : "“whatever it needs”");
        },
};

}  // namespace sqmap::viewer
