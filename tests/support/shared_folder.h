// Where the real meshes are that tests ask for. A test without them is skipped, and says why.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace sqmap::test {

/// Folder with meshes/ and paths/: the environment's SQMAP_SHARED_DIR, or what the build was configured with.
inline std::filesystem::path shared_folder()
{
    const char* folder = std::getenv("SQMAP_SHARED_DIR");
    return folder != nullptr ? folder : SQMAP_SHARED_DIR;
}

}  // namespace sqmap::test
