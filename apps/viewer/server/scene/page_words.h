// Words of the page about meshes: the choices of its dialog stand where a setting is named.
#pragma once

#include "sqmap/mesh/words.h"

namespace sqmap::viewer {

extern const mesh::SettingNames k_page_settings;

}  // namespace sqmap::viewer
