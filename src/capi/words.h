// Names of settings in the words of the language that calls.
#pragma once

#include "sqmap.h"
#include "sqmap/mesh/words.h"

#include <cstddef>
#include <cstdint>

namespace sqmap::capi {

inline constexpr std::size_t k_words = SQMAP_WORDS_JAVASCRIPT + 1;  ///< number of sqmap_words

/// words: of sqmap_words; element names it. @throw Failure for a number that is none
[[nodiscard]] const mesh::SettingNames& names_of(std::int32_t words, const char* element);

}  // namespace sqmap::capi
