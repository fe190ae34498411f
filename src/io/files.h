// Mesh files by their names; whole files as text.
#pragma once

#include "sqmap/io/read.h"

#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <optional>
#include <string>

namespace sqmap::io {

/// The format whose ending the name has, in whatever case; nothing for any other name.
[[nodiscard]] std::optional<MeshFormat> format_of_name(const std::filesystem::path& path);

/// All bytes of a file, or of a pipe up to its end; nothing where they cannot be read.
[[nodiscard]] inline std::optional<std::string> text_of_file(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in) return std::nullopt;
    try {
        return std::string{std::istreambuf_iterator<char>(in), {}};
    } catch (const std::ios_base::failure&) {  // a folder opens, and is not read
        return std::nullopt;
    }
}

}  // namespace sqmap::io
