// Bytes as text: digests, hexadecimal digits, base64, lower case.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace sqmap::batch {

/// The SHA-256 of some bytes, by which models are found and checked, as 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);
[[nodiscard]] std::string hexadecimal(std::string_view bytes);
[[nodiscard]] std::string base64(std::string_view bytes);

/// ASCII letters in lower case.
[[nodiscard]] std::string lower(std::string_view text);

/// JSON in one line; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string dumped(const nlohmann::ordered_json& json);

/// Bytes of an open file. @throw io::ModelFileError where they cannot be read, or the file has fewer
[[nodiscard]] std::string read_at(int file, std::uint64_t offset, std::uint64_t size);

}  // namespace sqmap::batch
