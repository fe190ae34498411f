// Bakes the meshes of a shard, each in a process of its own.
#pragma once

#include "batch/child.h"
#include "batch/item.h"
#include "batch/library.h"
#include "batch/progress.h"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace sqmap::batch {

struct Plan {
    std::filesystem::path manifest, root, output;
    Shard shard;
    unsigned jobs = 1;
    Caps caps;
    Settings settings;
    std::vector<std::string> arguments;        ///< the options of baking as they were given
    std::set<std::string, std::less<>> retry;  ///< verdicts that are not taken as final
    ProgressMode progress = ProgressMode::Auto;
};

/// Gives every item of the shard a row and writes the shard's archive; keys that are finished are not baked again. May be killed
/// at any moment and run again.
/// @throw ManifestError, io::ModelFileError where the folder cannot be written; what is finished is kept
void run(const Plan& plan);

}  // namespace sqmap::batch
