// A record is a line of lengths and a digest, followed by the model, the picture, the outcome and the measurements:
//     sqmap-result KEY MODEL PICTURE OUTCOME MEASURED MODEL_SHA256 PAYLOAD_SHA256
// A record counts when the file holds all of it and the digest is right.
#include "batch/results.h"
#include "batch/text.h"
#include "sqmap/io/model_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <sstream>

namespace sqmap::batch {
namespace {

constexpr std::string_view k_word = "sqmap-result";
constexpr std::size_t k_max_head = 512;

struct Head {
    std::string word, key, sha256, digest;
    std::uint64_t model = 0, picture = 0, outcome = 0, measured = 0;
    [[nodiscard]] std::uint64_t payload() const { return model + picture + outcome + measured; }
};

bool read_head(const std::string& line, Head& head)
{
    std::istringstream in(line);
    in >> head.word >> head.key >> head.model >> head.picture >> head.outcome >> head.measured >> head.sha256 >> head.digest;
    const std::uint64_t max = std::uint64_t{1} << 40;
    return !in.fail() && head.word == k_word && std::max({head.model, head.picture, head.outcome, head.measured}) < max;
}

std::uint64_t size_of(int fd)
{
    struct stat info {};
    return ::fstat(fd, &info) == 0 ? static_cast<std::uint64_t>(info.st_size) : 0;
}

bool lock(int fd)
{
    // fcntl locks for the process, not for the open file: children do not inherit the lock, and it ends with the process.
    struct flock whole {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    return ::fcntl(fd, F_SETLK, &whole) == 0 || (errno != EACCES && errno != EAGAIN);
}

}  // namespace

Journal::Journal(const std::filesystem::path& path) : path_(path), file_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644))
{
    if (!file_) fail("cannot be opened");
    if (!lock(file_.get()))
        throw io::ModelFileError(path.string() + ": another process works on this shard: wait for it, or end it");
    recover();
}

void Journal::fail(const char* what) const
{
    throw io::ModelFileError(path_.string() + ": " + what + ": " + std::strerror(errno) +
                             "; what is finished is kept: run the same command again");
}

void Journal::recover()
{
    const std::uint64_t size = size_of(file_.get());
    while (end_ < size) {
        const std::string start = read_at(file_.get(), end_, std::min<std::uint64_t>(size - end_, k_max_head));
        const std::size_t line = start.find('\n');
        Head head;
        if (line == std::string::npos || !read_head(start.substr(0, line), head)) break;
        const std::uint64_t at = end_ + line + 1, texts = head.model + head.picture;
        if (size - at < head.payload()) break;
        const std::string payload = read_at(file_.get(), at, head.payload());
        if (sha256(payload) != head.digest) break;
        found_.insert_or_assign(head.key, Finished{.outcome = {payload.substr(texts, head.outcome)},
                                                   .measured = payload.substr(texts + head.outcome),
                                                   .sha256 = head.sha256,
                                                   .file = file_.get(),
                                                   .model_offset = at,
                                                   .model_size = head.model,
                                                   .picture_offset = at + head.model,
                                                   .picture_size = head.picture});
        end_ = at + head.payload();
    }
    if (end_ < size && ::ftruncate(file_.get(), static_cast<off_t>(end_)) != 0) fail("cannot be cut to its last whole record");
}

void Journal::read_into(Results& results) const
{
    for (const auto& [key, finished] : found_) results.insert_or_assign(key, finished);
}

Finished Journal::append(const std::string& key, Finished result)
{
    std::string record = read_at(result.file, result.model_offset, result.model_size) +
                         read_at(result.file, result.picture_offset, result.picture_size);
    record.append(result.outcome.text).append(result.measured);
    std::ostringstream head;
    head << k_word << ' ' << key << ' ' << result.model_size << ' ' << result.picture_size << ' ' << result.outcome.text.size()
         << ' ' << result.measured.size() << ' ' << result.sha256 << ' ' << sha256(record) << '\n';
    record.insert(0, head.str());
    if (::lseek(file_.get(), static_cast<off_t>(end_), SEEK_SET) < 0 || !write_all(file_.get(), record)) {
        const int error = errno;
        (void)::ftruncate(file_.get(), static_cast<off_t>(end_));
        errno = error;
        fail("cannot be written");
    }
    result.file = file_.get();
    result.model_offset = end_ + head.str().size();
    result.picture_offset = result.model_offset + result.model_size;
    end_ += record.size();
    return result;
}

}  // namespace sqmap::batch
