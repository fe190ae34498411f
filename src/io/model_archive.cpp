#include "sqmap/io/model_archive.h"

#include "platform/files.h"

#include <charconv>
#include <cstring>
#include <string>
#include <utility>

namespace sqmap::io {
namespace {

// Of a header of POSIX ustar.
constexpr std::size_t k_block = 512, k_size_field = 124, k_magic_field = 257;

std::size_t padded(std::size_t size) { return (size + k_block - 1) / k_block * k_block; }

}  // namespace

ModelArchive::ModelArchive(const std::filesystem::path& path) : path_(path)
{
    const platform::Mapping file = platform::map_file(path);
    if (!file.was_opened) throw ModelFileError("cannot open " + path.string() + ": " + file.error.message());
    if (file.error == std::errc::invalid_argument || file.size < 2 * k_block) {
        platform::unmap(file);
        fail("it is not an archive of models");
    }
    if (file.error) fail("it cannot be mapped");
    size_ = file.size;
    data_ = reinterpret_cast<const char*>(file.bytes());
    try {
        index_ = member(0, "index");
        if (index_.size() % k_line != 0) fail("its index is damaged");
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

void ModelArchive::fail(const char* why) const
{
    throw ModelFileError(path_.string() + ": " + why + ": make archives with 'sqmap batch MANIFEST -o FOLDER'");
}

std::string_view ModelArchive::member(std::size_t at, std::string_view name) const
{
    const std::string_view header = bytes(at, k_block);
    std::size_t size = 0;
    const char* const digits = header.data() + k_size_field;
    if (header.substr(0, header.find('\0')) != name || header.substr(k_magic_field, 5) != "ustar" ||
        std::from_chars(digits, digits + 11, size, 8).ptr != digits + 11)
        fail("it is not an archive of models");
    return bytes(at + k_block, size);
}

std::string_view ModelArchive::bytes(std::uint64_t offset, std::uint64_t size) const
{
    if (offset > size_ || size > size_ - offset) fail("it was cut");
    return {data_ + offset, static_cast<std::size_t>(size)};
}

ArchivedModel ModelArchive::entry(std::size_t i) const
{
    const std::string_view line = index_.substr(i * k_line, k_line);
    std::size_t at = 0;
    const auto text = [&](std::size_t length, char end) {
        const std::string_view out = line.substr(at, length);
        at += length;
        if (line[at++] != end) fail("its index is damaged");
        return out;
    };
    const auto number = [&](char end) {
        const std::string_view digits = text(k_digits, end);
        std::uint64_t value = 0;
        if (std::from_chars(digits.data(), digits.data() + k_digits, value).ptr != digits.data() + k_digits)
            fail("its index is damaged");
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

MappedModel ModelArchive::open(std::string_view key) const
{
    const std::optional<ArchivedModel> found = find(key);
    if (!found || found->size == 0) throw ModelFileError(path_.string() + ": holds no model of key " + std::string(key));
    return {path_, found->offset, found->size};
}

}  // namespace sqmap::io
