#include "sqmap/device/trace.h"

#include "device/handover.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <thread>

namespace sqmap::device {
namespace {

constexpr std::string_view k_first_words = "# sqmap-trace ";
constexpr std::string_view k_end = "# end ";
constexpr std::size_t k_max_line = 64 * 1024;
constexpr std::size_t k_max_header = 256;

/// Calls visit(name, zone, value of every row...) for each scalar, zone -1 for what all zones share: the order of the columns,
/// for writing, reading and comparing.
template <class Visit, class... Rows>
void each_column(std::size_t zones, Visit visit, Rows&... rows)
{
    visit("time", -1, rows.time...);
    visit("dt", -1, rows.dt...);
    visit("sequence", -1, rows.sequence...);
    visit("buttons", -1, rows.buttons...);
    visit("input", -1, rows.input...);
    visit("cpu", -1, rows.cpu...);
    visit("contacts", -1, rows.contacts...);
    visit("depth", -1, rows.depth...);
    visit("status", -1, rows.status...);
    visit("filter", -1, rows.filter...);
    static constexpr const char* k_rotation[3][3] = {{"r00", "r01", "r02"}, {"r10", "r11", "r12"}, {"r20", "r21", "r22"}};
    static constexpr const char* k_names[7][3] = {{"px", "py", "pz"},
                                                  {"vx", "vy", "vz"},
                                                  {"wx", "wy", "wz"},
                                                  {"fx", "fy", "fz"},
                                                  {"tx", "ty", "tz"},
                                                  {"sent_fx", "sent_fy", "sent_fz"},
                                                  {"sent_tx", "sent_ty", "sent_tz"}};
    for (std::size_t z = 0; z < zones; ++z) {
        const auto vector = [&](const char* const(&names)[3], auto&... v) {
            visit(names[0], static_cast<int>(z), v.x...);
            visit(names[1], static_cast<int>(z), v.y...);
            visit(names[2], static_cast<int>(z), v.z...);
        };
        for (int i = 0; i < 3; ++i) vector(k_rotation[i], rows.poses[z].rotation.row[i]...);
        vector(k_names[0], rows.poses[z].translation...);
        vector(k_names[1], rows.twists[z].linear...);
        vector(k_names[2], rows.twists[z].angular...);
        vector(k_names[3], rows.computed[z].force...);
        vector(k_names[4], rows.computed[z].torque...);
        vector(k_names[5], rows.sent[z].force...);
        vector(k_names[6], rows.sent[z].torque...);
    }
}

std::string column_name(const char* name, int zone)
{
    return zone < 0 ? std::string(name) : "z" + std::to_string(zone) + "_" + name;
}

std::string column_line(std::size_t zones)
{
    std::string line;
    TraceRow row;
    const auto append = [&](const char* name, int zone, auto&) {
        if (!line.empty()) line += ',';
        line += column_name(name, zone);
    };
    each_column(zones, append, row);
    return line;
}

/// Calls visit(name, zone) for each column, but cpu, in which two rows differ; NaN equals NaN.
template <class Visit>
void each_difference(const TraceRow& a, const TraceRow& b, std::size_t zones, Visit visit)
{
    const auto compare = [&]<class T>(const char* name, int zone, const T& x, const T& y) {
        bool same = std::memcmp(&x, &y, sizeof x) == 0;
        if constexpr (std::is_floating_point_v<T>) same = same || (std::isnan(x) && std::isnan(y));
        if (!same && std::string_view(name) != "cpu") visit(name, zone);
    };
    each_column(zones, compare, a, b);
}

void append_row(std::string& text, const TraceRow& row, std::size_t zones)
{
    char cell[32];
    bool first = true;
    const auto append = [&](const char*, int, const auto& value) {
        if (!first) text += ',';
        first = false;
        // The shortest digits that read back as the same number.
        text.append(cell, std::to_chars(cell, cell + sizeof cell, value).ptr);
    };
    each_column(zones, append, row);
    text += '\n';
}

}  // namespace

std::optional<std::string> TraceHeader::find(std::string_view key) const
{
    const auto at = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.first == key; });
    return at == fields.end() ? std::nullopt : std::optional(at->second);
}

bool same_bits(const TraceRow& a, const TraceRow& b, std::size_t zones) noexcept
{
    bool all = true;
    each_difference(a, b, zones, [&](const char*, int) { all = false; });
    return all;
}

std::string differences(const TraceRow& a, const TraceRow& b, std::size_t zones)
{
    std::string names;
    each_difference(a, b, zones, [&](const char* name, int zone) {
        if (!names.empty()) names += ' ';
        names += column_name(name, zone);
    });
    return names;
}

struct TraceWriter::State {
    std::filesystem::path target, temporary;  // temporary is empty where the target is written to in place
    int file = -1;
    std::size_t zones = 1;
    Ring<TraceRow, k_ring> ring;
    std::uint64_t pushed = 0;  // by the servo
    std::atomic<std::uint64_t> dropped{0};
    std::atomic<bool> stop{false};
    std::atomic<int> error{0};
    std::thread thread;

    void write(std::string_view text)
    {
        while (!text.empty() && error.load() == 0) {
            const ssize_t n = ::write(file, text.data(), text.size());
            if (n > 0)
                text.remove_prefix(static_cast<std::size_t>(n));
            else if (n == 0)
                error = ENOSPC;
            else if (errno != EINTR)
                error = errno;
        }
    }

    void run()
    {
        std::string text;
        TraceRow row;
        for (;;) {
            const bool last = stop.load(std::memory_order_acquire);
            while (ring.pop(row)) {
                append_row(text, row, zones);
                if (text.size() > 1 << 16) write(std::exchange(text, {}));
            }
            write(std::exchange(text, {}));
            if (last) return;
            // Rows reach the file within this time of their tick.
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    }

    void join()
    {
        stop.store(true, std::memory_order_release);
        if (thread.joinable()) thread.join();
    }

    [[nodiscard]] std::string reason() const { return std::strerror(error.load()); }
};

namespace {

/// A recording's file: beside the target until the recording ends, or the target itself if that is no regular file.
struct Opened {
    std::filesystem::path target, temporary;
    int file = -1;
};

Opened open_recording(const std::filesystem::path& path)
{
    Opened o;
    std::error_code ignored;
    o.target = std::filesystem::is_symlink(path, ignored) ? std::filesystem::weakly_canonical(path, ignored) : path;
    struct stat info {};
    const bool there = ::stat(o.target.c_str(), &info) == 0;
    if (there && S_ISDIR(info.st_mode))
        throw TraceError("cannot write " + o.target.string() + ": it is a folder\n  cure: a file's name in it");
    const bool in_place = there && !S_ISREG(info.st_mode);
    if (!in_place) o.temporary = o.target.string() + ".recording";
    const std::filesystem::path& name = in_place ? o.target : o.temporary;
    o.file = ::open(name.c_str(), in_place ? O_WRONLY | O_CLOEXEC : O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (o.file < 0 && errno == EEXIST)
        throw TraceError(name.string() +
                         " is a recording that was cut short or is still running\n  cure: move it away or remove it");
    if (o.file < 0) throw TraceError("cannot write " + name.string() + ": " + std::strerror(errno));
    return o;
}

}  // namespace

void check_recording(const std::filesystem::path& path)
{
    struct stat info {};
    if (::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode)) return;  // a pipe opens once
    const Opened o = open_recording(path);
    ::close(o.file);
    if (!o.temporary.empty()) ::unlink(o.temporary.c_str());
}

TraceWriter::TraceWriter(const std::filesystem::path& path, const TraceHeader& header) : state_(std::make_unique<State>())
{
    if (header.zones < 1 || header.zones > k_max_zones) throw TraceError("a trace has 1 to 16 zones");
    State& s = *state_;
    s.zones = header.zones;
    const Opened opened = open_recording(path);
    s.target = opened.target;
    s.temporary = opened.temporary;
    s.file = opened.file;
    std::string text =
        std::string(k_first_words) + std::to_string(k_trace_version) + "\n# zones " + std::to_string(header.zones) + "\n";
    for (const auto& [key, value] : header.fields) {
        if (key.empty() || key.find_first_of(" \n\r") != std::string::npos || value.find_first_of("\n\r") != std::string::npos ||
            key == "end" || key == "zones")
            throw TraceError("no field of a trace: '" + key + "'");
        text += "# " + key + " " + value + "\n";
    }
    s.write(text + column_line(s.zones) + "\n");
    s.thread = std::thread([&s] { s.run(); });
}

TraceWriter::~TraceWriter()
{
    state_->join();
    if (state_->file >= 0) ::close(state_->file);
}

bool TraceWriter::push(const TraceRow& row) noexcept
{
    const bool taken = state_->ring.push(row);
    if (taken)
        ++state_->pushed;
    else
        state_->dropped.fetch_add(1, std::memory_order_relaxed);
    return taken;
}

void TraceWriter::push_wait(const TraceRow& row)
{
    while (!state_->ring.push(row)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++state_->pushed;
}

std::uint64_t TraceWriter::dropped() const noexcept { return state_->dropped.load(std::memory_order_relaxed); }

void TraceWriter::finish()
{
    State& s = *state_;
    s.join();
    s.write(std::string(k_end) + std::to_string(s.pushed) + " rows, " + std::to_string(s.dropped.load()) + " dropped\n");
    if (s.error == 0 && !s.temporary.empty() && ::fsync(s.file) != 0) s.error = errno;
    ::close(std::exchange(s.file, -1));
    if (s.error == 0 && !s.temporary.empty() && ::rename(s.temporary.c_str(), s.target.c_str()) != 0) s.error = errno;
    if (s.error != 0)
        throw TraceError("cannot write " + s.target.string() + ": " + s.reason() +
                         (s.temporary.empty() ? "" : "; what was written is in " + s.temporary.string()));
}

struct TraceReader::State {
    std::string name;
    std::ifstream in;
    TraceHeader header;
    std::string text;
    std::size_t line = 0;
    std::uint64_t rows = 0, dropped = 0;
    bool complete = false, ended = false, whole = false;

    [[noreturn]] void fail(const std::string& what) const { throw TraceError(name + ":" + std::to_string(line) + ": " + what); }

    /// The next line without its break. False at the end of the file; whole says whether the line had its break.
    bool next_line()
    {
        text.clear();
        whole = false;
        ++line;
        std::streambuf& buffer = *in.rdbuf();
        for (int c = buffer.sbumpc(); c != std::streambuf::traits_type::eof(); c = buffer.sbumpc()) {
            if (c == '\n') {
                whole = true;
                if (!text.empty() && text.back() == '\r') text.pop_back();
                return true;
            }
            if (text.size() == k_max_line) fail("longer than " + std::to_string(k_max_line) + " bytes: no trace");
            text += static_cast<char>(c);
        }
        return !text.empty();
    }

    void read_header()
    {
        if (!next_line() || !text.starts_with(k_first_words))
            fail("not a trace: the first line must be '" + std::string(k_first_words) + std::to_string(k_trace_version) + "'");
        if (text.substr(k_first_words.size()) != std::to_string(k_trace_version))
            fail("version '" + text.substr(k_first_words.size(), 20) + "' of the format, this program reads version " +
                 std::to_string(k_trace_version) + "\n  cure: record again, or replay with the version that recorded it");
        bool zones = false;
        while (next_line() && text.starts_with("# ")) {
            if (header.fields.size() == k_max_header) fail("more than " + std::to_string(k_max_header) + " fields");
            const std::size_t blank = text.find(' ', 2);
            const std::string key = text.substr(2, blank == std::string::npos ? blank : blank - 2);
            const std::string value = blank == std::string::npos ? "" : text.substr(blank + 1);
            if (key == "zones") {
                std::uint64_t count = 0;
                if (!parse(value, count) || count < 1 || count > k_max_zones)
                    fail("zones must be 1 to " + std::to_string(k_max_zones) + ", found '" + value.substr(0, 20) + "'");
                header.zones = count;
                zones = true;
            } else {
                header.fields.emplace_back(key, value);
            }
        }
        if (!zones) fail("the header has no line '# zones N'");
        if (text != column_line(header.zones)) fail(wrong_columns());
    }

    /// Names the first column that is not as expected.
    [[nodiscard]] std::string wrong_columns() const
    {
        const std::string expected = column_line(header.zones);
        std::string_view a = expected, b = text;
        for (std::size_t column = 1;; ++column) {
            const std::string_view x = a.substr(0, a.find(',')), y = b.substr(0, b.find(','));
            if (x != y)
                return "column " + std::to_string(column) + " must be '" + std::string(x) + "', found '" +
                       std::string(y.substr(0, 40)) + "'";
            if (a.size() == x.size() || b.size() == y.size())
                return "expected " + std::to_string(std::count(expected.begin(), expected.end(), ',') + 1) + " columns, found " +
                       std::to_string(std::count(text.begin(), text.end(), ',') + 1);
            a.remove_prefix(x.size() + 1);
            b.remove_prefix(y.size() + 1);
        }
    }

    template <class T>
    static bool parse(std::string_view cell, T& value)
    {
        const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        return error == std::errc() && end == cell.data() + cell.size();
    }

    void read_end()
    {
        std::uint64_t count = 0, lost = 0;
        const std::string_view words = std::string_view(text).substr(k_end.size());
        const std::size_t blank = words.find(" rows, "), last = words.find(" dropped");
        if (blank == std::string_view::npos || last == std::string_view::npos || !parse(words.substr(0, blank), count) ||
            !parse(words.substr(blank + 7, last - blank - 7), lost))
            fail("the end must read '# end N rows, M dropped'");
        if (count != rows)
            fail("the end speaks of " + std::to_string(count) + " rows, there are " + std::to_string(rows) +
                 ": rows were removed or added");
        dropped = lost;
        complete = true;
        if (next_line()) fail("something follows the end");
    }
};

TraceReader::TraceReader(const std::filesystem::path& path) : state_(std::make_unique<State>())
{
    state_->name = path.string();
    state_->in.open(path, std::ios::binary);
    if (!state_->in || std::filesystem::is_directory(path)) throw TraceError(path.string() + ": cannot be opened");
    state_->read_header();
}

TraceReader::~TraceReader() = default;

const TraceHeader& TraceReader::header() const noexcept { return state_->header; }
bool TraceReader::complete() const noexcept { return state_->complete; }
std::size_t TraceReader::line() const noexcept { return state_->line; }
std::uint64_t TraceReader::dropped() const noexcept { return state_->dropped; }

bool TraceReader::next(TraceRow& row)
{
    State& s = *state_;
    if (s.ended) return false;
    if (!s.next_line() || !s.whole) {  // cut short, perhaps within a row
        s.ended = true;
        return false;
    }
    if (s.text.starts_with(k_end)) {
        s.ended = true;
        s.read_end();
        return false;
    }
    std::string_view rest = s.text;
    bool more = true;
    std::size_t column = 0;
    const auto read = [&](const char* name, int zone, auto& value) {
        ++column;
        if (!more)
            s.fail("expected '" + column_name(name, zone) + "' in column " + std::to_string(column) + ", the row ends before");
        const std::size_t comma = rest.find(',');
        const std::string_view cell = rest.substr(0, comma);
        if (!State::parse(cell, value))
            s.fail("column " + std::to_string(column) + " (" + column_name(name, zone) + ") is no number: '" +
                   std::string(cell.substr(0, 40)) + "'");
        more = comma != std::string_view::npos;
        if (more) rest.remove_prefix(comma + 1);
    };
    each_column(s.header.zones, read, row);
    if (more) s.fail("more than " + std::to_string(column) + " columns");
    ++s.rows;
    return true;
}

}  // namespace sqmap::device
