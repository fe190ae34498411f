// From untrusted bytes to a ModelView: everything is checked here, so that queries need not.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/model/model.h"

#include <cstddef>
#include <span>

namespace sqmap::model {

/// Why bytes are no model.
enum class ParseStatus {
    Ok,
    Truncated,     ///< too short, or the structure runs past the end of the bytes
    NotAModel,     ///< the file identifier is missing
    PaperModel,    ///< a paper model: paper::parse reads it
    WrongVersion,  ///< made by another format version: bake again
    BadHash,       ///< the content differs from what was written
    BadStructure,  ///< sizes or indices that contradict each other
    BadValue,      ///< a number that is not finite or out of its range
};

/// The meaning of a status, in a few words.
[[nodiscard]] const char* to_string(ParseStatus status) noexcept;
/// The cure of a status, in a few words; empty for Ok.
[[nodiscard]] const char* cure_of(ParseStatus status) noexcept;

/// Verifies bytes and sets view to spans over them; the bytes must be 8-byte aligned and outlive the view.
/// Failures: any status but Ok, view untouched. Cost: linear in the bytes, no allocation.
[[nodiscard]] ParseStatus parse(std::span<const std::byte> bytes, ModelView& view) noexcept;

/// Hash of the content (FNV-1a over 64-bit words of every array): stored at bake, checked by parse.
[[nodiscard]] std::uint64_t content_hash(const ModelView& view) noexcept;

}  // namespace sqmap::model
