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
        std::string line = contents.line(row);
        if (json) {
            line.pop_back();
            std::printf("%s,\"seconds\":%.3f}\n", line.c_str(), seconds);
        } else {
            const nlohmann::json item = nlohmann::json::parse(line);
            const std::string member = item.value("member", "");
            const std::string_view verdict = contents.outcome(row).verdict();
            std::printf("%-10.*s %8.2f  %s%s%s%s%s\n", static_cast<int>(verdict.size()), verdict.data(), seconds,
                        item.value("path", "").c_str(), member.empty() ? "" : " ", member.c_str(),
                        item.contains("reason") ? ": " : "", item.value("reason", "").c_str());
        }
    }
}

void extract(const Library& library, const std::string& key, const std::filesystem::path& output)
{
    for (const std::filesystem::path& path : library.archives()) {
        const io::ModelArchive archive(path);
        if (archive.find(key)) return io::replace_file(output, archive.open(key).bytes());
    }
    throw io::ModelFileError(library.folder().string() + ": holds no model of key " + key + "; 'sqmap batch list' has the keys");
}

}  // namespace sqmap::batch
