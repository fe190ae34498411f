#include "batch/operations.h"
#include "batch/text.h"
#include "sqmap/io/model_archive.h"
#include "sqmap/paper/model_file.h"

#include <cstdio>
#include <map>
#include <string_view>

namespace sqmap::batch {
namespace {

class Verifier {
public:
    Verifier(const std::filesystem::path& path, Depth depth) : archive_(path), depth_(depth) {}

    Verification run()
    {
        out_.archives = 1;
        read_rows();
        std::string_view before;
        for (std::size_t i = 0; i < archive_.size(); ++i) {
            const io::ArchivedModel model = archive_.entry(i);
            if (model.key <= before) fault(model.key, "the index is not sorted");
            before = model.key;
            check(model);
        }
        for (const auto& [key, has_model] : wanted_)
            if (has_model) fault(key, "a row names a model that is not there");
        return out_;
    }

private:
    /// Notes for each key whether its row speaks of a model.
    void read_rows()
    {
        each_line(archive_.rows(), [&](std::string_view line) {
            const Row row = row_of(line);
            ++out_.rows;
            if (!row.key.empty()) wanted_[row.key] = is_baked(row.outcome.verdict());
        });
    }

    void check(const io::ArchivedModel& model)
    {
        ++out_.models;
        const auto row = wanted_.find(model.key);
        if (row == wanted_.end() || !row->second)
            fault(model.key, "no row speaks of it");
        else
            row->second = false;
        if (model.offset % 512 != 0) fault(model.key, "does not stand at a multiple of 512 bytes");
        if (depth_ == Depth::Index) return;
        try {
            if (sha256(archive_.bytes(model.offset, model.size)) != model.sha256)
                fault(model.key, "its bytes have another digest");
            (void)paper::MappedModel(archive_.map(model.key), archive_.path());
        } catch (const io::ModelFileError& e) {
            fault(model.key, e.what());
        }
    }

    void fault(std::string_view key, const char* why)
    {
        ++out_.faults;
        std::fprintf(stderr, "%s: %.*s: %s\n", archive_.path().c_str(), static_cast<int>(key.size()), key.data(), why);
    }

    io::ModelArchive archive_;
    Depth depth_;
    Verification out_;
    std::map<std::string, bool, std::less<>> wanted_;
};

}  // namespace

Verification verify(const Library& library, Depth depth)
{
    Verification out;
    const std::vector<std::filesystem::path> archives = library.archives();
    if (archives.empty()) throw io::ModelFileError(library.folder().string() + ": no shard is finished: nothing to verify");
    for (const std::filesystem::path& path : archives) {
        try {
            const Verification one = Verifier(path, depth).run();
            out.archives += one.archives;
            out.models += one.models;
            out.rows += one.rows;
            out.faults += one.faults;
        } catch (const io::ModelFileError& e) {
            std::fprintf(stderr, "%s\n", e.what());
            ++out.faults;
        }
    }
    out.faults += library.unfinished().stale.size();
    return out;
}

}  // namespace sqmap::batch
