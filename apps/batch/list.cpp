#include "batch/operations.h"
#include "sqmap/io/model_archive.h"
#include "sqmap/io/replace_file.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <span>

namespace sqmap::batch {
namespace {

double seconds_of(const Contents& contents, const Row& row)
{
    const auto found = contents.results().find(row.key);
    if (found == contents.results().end() || found->second.measured.empty()) return 0;
    return nlohmann::json::parse(found->second.measured, nullptr, false).value("seconds", 0.0);
}

}  // namespace

void list(const Library& library, bool json)
{
    (void)library.recipe();
    const Contents contents(library.archives());
    for (const Row& row : contents.rows()) {
        const double seconds = seconds_of(contents, row);
        const Row whole{row.item, row.key, contents.outcome(row)};
        if (json) {
            std::string line = whole.line();
            line.pop_back();
            std::printf("%s,\"seconds\":%.3f}\n", line.c_str(), seconds);
        } else {
            std::printf("%8.2f  %s\n", seconds, sentence(whole).c_str());
        }
    }
}

void extract(const Library& library, const std::string& key, const std::filesystem::path& output)
{
    for (const std::filesystem::path& path : library.archives()) {
        const io::ModelArchive archive(path);
        if (archive.find(key)) return io::replace_file(output, archive.open(key).bytes());
    }
    throw io::ModelFileError(library.folder().string() + ": holds no model of key " + key +
                             "; 'sqmap batch list --json' has the keys");
}

}  // namespace sqmap::batch
