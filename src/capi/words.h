// Names of settings in the words of the language that calls.
#pragma once

#include "sqmap/mesh/words.h"

#include <cstdint>

namespace sqmap::capi {

/// words: of sqmap_words; element names it. @throw Failure for a number that is none
[[nodiscard]] const mesh::SettingNames& names_of(std::int32_t words, const char* element);

}  // namespace sqmap::capi
