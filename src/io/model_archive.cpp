#include "sqmap/io/model_archive.h"

#include "platform/files.h"
#include "sqmap/io/read.h"
#include "sqmap/math/assert.h"

#include <charconv>
#include <cstring>
#include <string>
#include <utility>

namespace sqmap::io {
namespace {

// Offsets in a header of POSIX ustar.
constexpr std::size_t k_block = 512, k_size_field = 124, k_magic_field = 257;

std::size_t padded(std::size_t size) { return (size + k_block - 1) / k_block * k_block; }

}  // namespace

ModelArchiveError::ModelArchiveError(const std::filesystem::path& path, std::string why, std::string cure)
    : ModelFileError(path.string() + ": " + why + ": " + cure), why_(std::move(why)), cure_(std::move(cure))
{
}

ModelArchive::ModelArchive(const std::filesystem::path& path) : path_(path)
{
    const platform::Mapping file = platform::map_file(path);
    if (!file.was_opened)
        throw ModelArchiveError(
            path, file.error == std::errc::no_such_file_or_directory ? k_no_file : "cannot be opened: " + file.error.message(),
            "give the path of an archive that can be read");
    if (file.error == std::errc::invalid_argument || file.size < 2 * k_block) {
        platform::unmap(file);
        refuse();
    }
    if (file.error) throw ModelArchiveError(path, "cannot be mapped: " + file.error.message(), "copy it to another disk");
    size_ = file.size;
    data_ = reinterpret_cast<const char*>(file.bytes());
    try {
        index_ = member(0, "index");
        if (index_.size() % k_line != 0) fail("has a damaged index");
        rows_ = member(k_block + padded(index_.size()), "rows.jsonl");
    } catch (...) {
        platform::unmap({data_, 0, size_, {}, true});
        throw;
    }
}

ModelArchive::~ModelArchive() { platform::unmap({data_, 0, size_, {}, true}); }

ModelArchive::ModelArchive(ModelArchive&& other) noexcept
    : path_(std::move(other.path_)),
      data_(std::exchange(other.data_, nullptr)),
      size_(other.size_),
      index_(other.index_),
      rows_(other.rows_)
{
}

void ModelArchive::refuse() const
{
    throw ModelArchiveError(path_, "is not an archive of models", "make archives with 'sqmap batch MANIFEST -o FOLDER'");
}

void ModelArchive::fail(const char* why) const
{
    throw ModelArchiveError(path_, why, "copy the whole file again; 'sqmap batch verify FOLDER' checks a library");
}

std::string_view ModelArchive::member(std::size_t at, std::string_view name) const
{
    const std::string_view header = bytes(at, k_block);
    std::size_t size = 0;
    const char* const digits = header.data() + k_size_field;
    if (header.substr(0, header.find('\0')) != name || header.substr(k_magic_field, 5) != "ustar" ||
        std::from_chars(digits, digits + 11, size, 8).ptr != digits + 11)
        refuse();
    return bytes(at + k_block, size);
}

std::string_view ModelArchive::bytes(std::uint64_t offset, std::uint64_t size) const
{
    if (offset > size_ || size > size_ - offset) fail("was cut: it ends before what its index names");
    return {data_ + offset, static_cast<std::size_t>(size)};
}

ArchivedModel ModelArchive::entry(std::size_t i) const
{
    SQMAP_ASSERT(i < size());
    const std::string_view line = index_.substr(i * k_line, k_line);
    std::size_t at = 0;
    const auto text = [&](std::size_t length, char end) {
        const std::string_view out = line.substr(at, length);
        at += length;
        if (line[at++] != end) fail("has a damaged index");
        return out;
    };
    const auto number = [&](char end) {
        const std::string_view digits = text(k_digits, end);
        std::uint64_t value = 0;
        if (std::from_chars(digits.data(), digits.data() + k_digits, value).ptr != digits.data() + k_digits)
            fail("has a damaged index");
        return value;
    };
    ArchivedModel out;
    out.key = text(k_key, ' ');
    out.offset = number(' ');
    out.size = number(' ');
    out.sha256 = text(k_key, ' ');
    out.picture_offset = number(' ');
    out.picture_size = number('\n');
    return out;
}

std::optional<ArchivedModel> ModelArchive::find(std::string_view key) const
{
    std::size_t low = 0, high = size();
    while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        const ArchivedModel here = entry(middle);
        if (here.key == key) return here;
        if (here.key < key)
            low = middle + 1;
        else
            high = middle;
    }
    return std::nullopt;
}

MappedBytes ModelArchive::map(std::string_view key) const
{
    const std::optional<ArchivedModel> found = find(key);
    if (!found || found->size == 0) throw ModelFileError(path_.string() + ": holds no model of key " + std::string(key));
    (void)bytes(found->offset, found->size);
    return MappedBytes(path_, found->offset, found->size);
}

}  // namespace sqmap::io
