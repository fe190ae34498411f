#include "batch/members.h"

#include <archive.h>
#include <archive_entry.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <clocale>
#include <set>
#include <utility>

namespace sqmap::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t k_read = std::size_t{1} << 16, k_max_line = 64;
constexpr const char* k_cure = "mend the archive, or unpack it and name the folder";

void send(int channel, Frame::Kind kind, const std::string& name, std::string_view bytes)
{
    const std::string head =
        std::string(1, static_cast<char>(kind)) + " " + std::to_string(name.size()) + " " + std::to_string(bytes.size()) + "\n";
    if (!write_all(channel, head + name) || !write_all(channel, bytes)) ::_exit(1);
}

/// Calls take(archive, entry, name) with each member until take returns false. take may read the member's data.
template <class Take>
void each_member(const fs::path& path, int channel, Take&& take)
{
    std::setlocale(LC_CTYPE, "C.UTF-8");  // libarchive decodes the names of zip archives by the locale
    archive* const in = archive_read_new();
    archive_read_support_format_tar(in);
    archive_read_support_format_gnutar(in);
    archive_read_support_format_zip(in);
    archive_read_support_filter_gzip(in);
    archive_read_support_filter_bzip2(in);
    archive_read_support_filter_xz(in);
    archive_read_support_filter_zstd(in);
    archive_entry* entry = nullptr;
    int status = archive_read_open_filename(in, path.c_str(), k_read);
    while (status >= ARCHIVE_WARN && status != ARCHIVE_EOF) {
        status = archive_read_next_header(in, &entry);
        if (status == ARCHIVE_EOF || status < ARCHIVE_WARN) break;
        const char* name = archive_entry_pathname(entry);
        if (name == nullptr) name = archive_entry_pathname_utf8(entry);
        if (name != nullptr && !take(in, entry, std::string(name))) break;
    }
    if (status != ARCHIVE_EOF && status < ARCHIVE_WARN) {
        const char* why = archive_error_string(in);
        send(channel, Frame::Kind::Broken, "", why != nullptr ? why : "it cannot be read");
    }
    archive_read_free(in);
}

bool leaves(const std::string& name)
{
    const fs::path path(name);
    return path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end();
}

Outcome unreadable(const char* code, const std::string& element, const std::string& why)
{
    return outcome_of("unreadable", {code, element, why, k_cure});
}

void list_members(const fs::path& path, int channel)
{
    each_member(path, channel, [&](archive*, archive_entry* entry, const std::string& name) {
        if (!has_mesh_name(name) || archive_entry_filetype(entry) == AE_IFDIR) return true;
        if (leaves(name))
            send(channel, Frame::Kind::Fault, name, unreadable("E_PATH", "member", "its name leaves the archive").text);
        else if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry) != nullptr)
            send(channel, Frame::Kind::Fault, name, unreadable("E_PATH", "member", "it is a link, not a file").text);
        else
            send(channel, Frame::Kind::Name, name, "");
        return true;
    });
}

/// Lists an archive in a process of its own. The last frame says why the list is not complete, if that is so.
std::vector<Frame> listed(const fs::path& path, const Caps& caps)
{
    Child child([&](int channel, int) { list_members(path, channel); }, caps);
    Frames frames;
    std::vector<Frame> out;
    Frame frame;
    for (bool open = true; open;) {
        pollfd sent{child.channel(), POLLIN, 0};
        const auto left = child.deadline() - std::chrono::steady_clock::now();
        const int wait = static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(left).count());
        if (wait <= 0 || (::poll(&sent, 1, wait) < 0 && errno != EINTR)) {
            child.stop();
            break;
        }
        if (sent.revents != 0) open = frames.read(child.channel());  // a process that ends closes its end
        while (frames.next(frame)) out.push_back(std::exchange(frame, {}));
    }
    const Ended ended = child.wait();
    if (ended.ending != Ending::Done) out.push_back({Frame::Kind::Broken, "", "while it was listed: " + ended.reason});
    return out;
}

void expand_one(const Item& archive, const std::vector<Frame>& frames, std::vector<Entry>& out)
{
    const std::size_t before = out.size();
    for (const Frame& frame : frames) {
        Item item = archive;
        item.member = frame.name;
        if (frame.kind == Frame::Kind::Name)
            out.push_back({std::move(item), {}});
        else
            out.push_back({std::move(item), frame.kind == Frame::Kind::Fault ? Outcome{frame.bytes}
                                                                             : unreadable("E_ARCHIVE", "archive", frame.bytes)});
    }
    if (out.size() == before) out.push_back({archive, unreadable("E_ARCHIVE", "archive", "it holds no mesh")});
}

/// Reads a member's data into out.first. Returns false, with the reason in out.second, where the member has more than max_bytes
/// or libarchive cannot unpack it.
bool read_member(archive* in, archive_entry* entry, std::uint64_t max_bytes, std::pair<std::string, Outcome>& out)
{
    const auto too_large = [&] {
        out.second = unreadable("E_LIMIT", "member", "unpacked it has more than " + std::to_string(max_bytes) + " bytes");
        return false;
    };
    out.first.clear();
    if (archive_entry_size_is_set(entry) != 0 && static_cast<std::uint64_t>(archive_entry_size(entry)) > max_bytes)
        return too_large();
    char buffer[k_read];
    for (;;) {
        const la_ssize_t n = archive_read_data(in, buffer, sizeof buffer);
        if (n == 0) return true;
        if (n < 0) {
            const char* why = archive_error_string(in);
            out.second = unreadable("E_ARCHIVE", "member", why != nullptr ? why : "it cannot be unpacked");
            return false;
        }
        if (out.first.size() + static_cast<std::size_t>(n) > max_bytes) return too_large();
        out.first.append(buffer, static_cast<std::size_t>(n));
    }
}

}  // namespace

bool Frames::read(int channel)
{
    bytes_.erase(0, std::exchange(taken_, 0));
    const std::size_t had = bytes_.size();
    bytes_.resize(had + 16 * k_read);
    const ssize_t n = ::read(channel, bytes_.data() + had, 16 * k_read);
    bytes_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    return n > 0 || (n < 0 && errno == EINTR);
}

bool Frames::next(Frame& frame)
{
    const std::string_view rest = std::string_view(bytes_).substr(taken_);
    const std::size_t line = rest.substr(0, k_max_line).find('\n');
    if (line == std::string_view::npos || line < 5) return false;
    std::size_t name = 0, size = 0;
    const auto first = std::from_chars(rest.data() + 2, rest.data() + line, name);
    std::from_chars(first.ptr + 1, rest.data() + line, size);
    if (rest.size() < line + 1 + name + size) return false;
    frame.kind = static_cast<Frame::Kind>(rest[0]);
    frame.name = rest.substr(line + 1, name);
    frame.bytes = rest.substr(line + 1 + name, size);
    taken_ += line + 1 + name + size;
    return true;
}

std::vector<Entry> expanded(std::vector<Entry> entries, const fs::path& root, const Caps& caps)
{
    std::vector<Entry> out;
    for (Entry& entry : entries) {
        std::error_code ignored;
        const fs::path path = file_of(entry.item, root);
        if (entry.outcome || !entry.item.member.empty() || !has_archive_name(entry.item.path) ||
            !fs::is_regular_file(path, ignored))
            out.push_back(std::move(entry));
        else
            expand_one(entry.item, listed(path, caps), out);
    }
    return out;
}

void send_members(const fs::path& archive_path, const std::vector<std::string>& wanted, std::uint64_t max_bytes, int channel)
{
    std::set<std::string> left(wanted.begin(), wanted.end());
    each_member(archive_path, channel, [&](archive* in, archive_entry* entry, const std::string& name) {
        if (left.erase(name) > 0) {
            std::pair<std::string, Outcome> data;
            if (read_member(in, entry, max_bytes, data))
                send(channel, Frame::Kind::Bytes, name, data.first);
            else
                send(channel, Frame::Kind::Fault, name, data.second.text);
        }
        return !left.empty();
    });
}

}  // namespace sqmap::batch
