// The manifest's fingerprint, then rows as `list --json` prints them. A line without an end was not written whole.
#include "batch/running.h"

#include <cstdlib>
#include <string_view>

namespace sqmap::batch {

RunningRows::RunningRows(const std::filesystem::path& path, const std::string& fingerprint)
    : out_(path, std::ios::binary | std::ios::trunc)
{
    out_ << fingerprint << std::endl;
}

void RunningRows::add(const TimedRow& row) { out_ << timed_line(row.row, row.seconds) << std::endl; }

std::vector<TimedRow> running_rows(const Library& library)
{
    constexpr std::string_view k_seconds = ",\"seconds\":";
    const std::string fingerprint = library.recipe().fingerprint;
    const Unfinished unfinished = library.unfinished();
    std::vector<TimedRow> out;
    for (const auto* shards : {&unfinished.absent, &unfinished.stale}) {
        for (const Shard& shard : *shards) {
            std::ifstream in(Library::rows_of(library.journal(shard)), std::ios::binary);
            std::string line;
            if (!std::getline(in, line) || line != fingerprint) continue;
            while (std::getline(in, line) && !in.eof()) {
                const std::size_t at = line.rfind(k_seconds);
                out.push_back({row_of(line.substr(0, at) + "}"), std::strtod(line.c_str() + at + k_seconds.size(), nullptr)});
            }
        }
    }
    return out;
}

}  // namespace sqmap::batch
