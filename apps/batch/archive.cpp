// The archive: POSIX ustar with nothing in its headers but names and sizes. libarchive writes it, io::ModelArchive reads it.
#include "batch/results.h"
#include "sqmap/io/model_archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t k_block = 512, k_max_member = std::uint64_t{8} << 30;
constexpr std::size_t k_buffer = std::size_t{1} << 20;

std::uint64_t padded(std::uint64_t size) { return (size + k_block - 1) / k_block * k_block; }

/// A POSIX ustar archive that libarchive writes to an open file. Nothing in its headers tells one run from another.
class Output {
public:
    explicit Output(int fd) : fd_(fd)
    {
        archive_write_set_format_ustar(tar_);
        archive_write_set_bytes_per_block(tar_, k_buffer);
        check(archive_write_open_fd(tar_, fd));
    }
    ~Output()
    {
        archive_entry_free(entry_);
        archive_write_free(tar_);
    }
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    void add_member(const std::string& name, std::string_view bytes)
    {
        begin(name, bytes.size());
        add(bytes);
    }
    void copy_member(const std::string& name, int file, std::uint64_t offset, std::uint64_t size)
    {
        begin(name, size);
        for (std::uint64_t done = 0; done < size;) {
            buffer_.resize(std::min<std::uint64_t>(size - done, k_buffer));
            const ssize_t n = ::pread(file, buffer_.data(), buffer_.size(), static_cast<off_t>(offset + done));
            if (n == 0) throw std::system_error(EIO, std::generic_category());
            if (n < 0 && errno != EINTR) throw std::system_error(errno, std::generic_category());
            if (n < 0) continue;
            add({buffer_.data(), static_cast<std::size_t>(n)});
            done += static_cast<std::uint64_t>(n);
        }
    }
    void finish()
    {
        check(archive_write_close(tar_));
        if (::fsync(fd_) != 0) throw std::system_error(errno, std::generic_category());
    }

private:
    void begin(const std::string& name, std::uint64_t size)
    {
        if (size >= k_max_member) throw std::system_error(EFBIG, std::generic_category());
        archive_entry_clear(entry_);
        archive_entry_set_pathname(entry_, name.c_str());
        archive_entry_set_filetype(entry_, AE_IFREG);
        archive_entry_set_perm(entry_, 0644);
        archive_entry_set_size(entry_, static_cast<la_int64_t>(size));
        check(archive_write_header(tar_, entry_));
    }
    void add(std::string_view bytes)
    {
        if (archive_write_data(tar_, bytes.data(), bytes.size()) != static_cast<la_ssize_t>(bytes.size())) check(ARCHIVE_FAILED);
    }
    void check(int status)
    {
        if (status == ARCHIVE_OK) return;
        const int error = archive_errno(tar_);
        throw std::system_error(error > 0 ? error : EIO, std::generic_category());
    }

    int fd_;
    archive* tar_ = archive_write_new();
    archive_entry* entry_ = archive_entry_new();
    std::string buffer_;
};

/// As the index has numbers.
std::string digits(std::uint64_t number)
{
    const std::string text = std::to_string(number);
    if (text.size() > io::ModelArchive::k_digits) throw std::system_error(EFBIG, std::generic_category());
    return std::string(io::ModelArchive::k_digits - text.size(), '0') + text;
}

bool has_model(const Results::value_type* result) { return result->second.model_size > 0; }

std::string index_of(std::span<const Results::value_type* const> results, std::size_t rows_size)
{
    const auto models = static_cast<std::uint64_t>(std::count_if(results.begin(), results.end(), has_model));
    std::uint64_t at = k_block + padded(models * io::ModelArchive::k_line) + k_block + padded(rows_size);
    std::string out;
    for (const auto* result : results) {
        if (!has_model(result)) continue;
        const Finished& f = result->second;
        const std::uint64_t picture = f.picture_size > 0 ? at + k_block : 0;
        if (f.picture_size > 0) at += k_block + padded(f.picture_size);
        out += result->first + ' ' + digits(at + k_block) + ' ' + digits(f.model_size) + ' ' + f.sha256 + ' ' + digits(picture) +
               ' ' + digits(f.picture_size) + '\n';
        at += k_block + padded(f.model_size);
    }
    return out;
}

void write_members(Output& out, std::span<const Results::value_type* const> results, std::string_view rows)
{
    out.add_member("index", index_of(results, rows.size()));
    out.add_member("rows.jsonl", rows);
    for (const auto* result : results) {
        if (!has_model(result)) continue;
        const auto& [key, f] = *result;
        if (f.picture_size > 0) out.copy_member(key + ".png", f.file, f.picture_offset, f.picture_size);
        out.copy_member(key + ".sqmap", f.file, f.model_offset, f.model_size);
    }
    out.finish();
}

}  // namespace

void write_archive(const fs::path& path, std::span<const Results::value_type* const> results, std::string_view rows)
{
    const fs::path temporary = path.string() + ".tmp";
    const auto fail = [&](int error) {
        ::unlink(temporary.c_str());
        throw io::ModelFileError("cannot write " + path.string() + ": " + std::strerror(error) +
                                 "; what is finished is kept: run the same command again");
    };
    const Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (!file) fail(errno);
    try {
        Output out(file.get());
        write_members(out, results, rows);
    } catch (const std::system_error& e) {
        fail(e.code().value());
    }
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail(errno);
    sync_folder(path.parent_path());
}

void read_archive(const fs::path& path, int file, Results& results)
{
    const io::ModelArchive archive(path);
    each_line(archive.rows(), [&](std::string_view line) {
        Row row = row_of(line);
        const std::string_view verdict = row.outcome.verdict();
        if (row.key.empty() || verdict == "killed") return;
        const auto [here, is_new] = results.try_emplace(std::move(row.key));
        // One key may have run out of time in one shard and not in another.
        if (is_new || (here->second.model_size == 0 && is_baked(verdict))) here->second.outcome = std::move(row.outcome);
    });
    for (std::size_t i = 0; i < archive.size(); ++i) {
        const io::ArchivedModel model = archive.entry(i);
        const auto found = results.find(model.key);
        if (found == results.end() || found->second.model_size > 0) continue;
        Finished& f = found->second;
        f.sha256 = model.sha256;
        f.file = file;
        f.model_offset = model.offset;
        f.model_size = model.size;
        f.picture_offset = model.picture_offset;
        f.picture_size = model.picture_size;
    }
}

Descriptor open_file(const fs::path& path)
{
    Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file) throw io::ModelFileError("cannot open " + path.string() + ": " + std::strerror(errno));
    return file;
}

void sync_folder(const fs::path& folder)
{
    const Descriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd) ::fsync(fd.get());
}

}  // namespace sqmap::batch
