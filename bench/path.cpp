#include "path.h"

#include "error.h"
#include "sqmap/device/path.h"

#include <cstdio>

namespace sqmap::bench {

std::vector<Pose> read_path(const std::filesystem::path& path)
{
    try {
        std::vector<Pose> poses;
        for (const Pose& pose : device::read_path(path)) poses.push_back({pose.rotation, pose.translation});
        return poses;
    } catch (const device::DeviceError& e) {
        const std::string what = e.what();
        throw BenchError(what.find("cure:") != std::string::npos
                             ? what
                             : what + "\n  cure: correct the file, or make a path with sqmap_bench path");
    }
}

std::string path_text(std::span<const Pose> poses)
{
    std::string text = "r00,r01,r02,r10,r11,r12,r20,r21,r22,tx,ty,tz\n";
    char cell[32];
    for (const Pose& pose : poses) {
        for (int i = 0; i < 12; ++i) {
            const double value = i < 9 ? pose.rotation.row[i / 3][i % 3] : pose.translation[i - 9];
            std::snprintf(cell, sizeof cell, i < 11 ? "%.7g," : "%.7g\n", value);
            text += cell;
        }
    }
    return text;
}

}  // namespace sqmap::bench
