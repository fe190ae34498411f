// A file for readers and writers that know no memory.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace sqmap::viewer {

/// A file of that name in a folder of its own, which the destructor removes.
class TemporaryFile {
public:
    /// @throw std::runtime_error where no folder can be made
    explicit TemporaryFile(const std::string& name)
    {
        std::string folder = (std::filesystem::temp_directory_path() / "sqmap-XXXXXX").string();
        if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error("no temporary file can be made in " + folder);
        folder_ = folder;
        path_ = folder_ / name;
    }
    ~TemporaryFile()
    {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path folder_, path_;
};

}  // namespace sqmap::viewer
