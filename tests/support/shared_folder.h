// Names the folder of the real meshes. A test without them is skipped, and says why.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

namespace sqmap::test {

/// Folder with meshes/ and paths/: the environment's SQMAP_SHARED_DIR, or what the build was configured with.
inline std::filesystem::path shared_folder()
{
    const char* folder = std::getenv("SQMAP_SHARED_DIR");
    return folder != nullptr ? folder : SQMAP_SHARED_DIR;
}

/// The file of a mesh such as "horse_5946.obj": that of the shared folder, or a mesh like it among those that ./dev test fetches,
/// or an empty path.
inline std::filesystem::path real_mesh_file(const std::string& name)
{
    static const std::map<std::string, std::string> k_like{
        {"armadillo_10000", "bear_bis"}, {"bull_7154", "bull"},       {"camel_4512", "dino"}, {"cat_8108", "triceratops"},
        {"elephant_10272", "elephant"},  {"fandisk_8000", "fandisk"}, {"hand_9344", "elk"},   {"hand_9556", "homer"},
        {"horse_5946", "cow"},           {"knot_6400", "knot1"}};
    if (const std::filesystem::path shared = shared_folder() / "meshes" / name; std::filesystem::exists(shared)) return shared;
    const auto like = k_like.find(std::filesystem::path(name).stem().string());
    if (like == k_like.end()) return {};
    const std::filesystem::path fetched = std::filesystem::path(SQMAP_TEST_MESHES_DIR) / (like->second + ".off");
    return std::filesystem::exists(fetched) ? fetched : std::filesystem::path();
}

}  // namespace sqmap::test
