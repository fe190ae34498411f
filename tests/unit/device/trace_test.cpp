#include "sqmap/device/trace.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

namespace sqmap::device {
namespace {

namespace fs = std::filesystem;

class Trace : public ::testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "sqmap-trace-XXXXXX").string();
        ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override { fs::remove_all(folder_); }
    [[nodiscard]] fs::path path(const char* name = "a.csv") const { return folder_ / name; }

    static std::string text_of(const fs::path& path)
    {
        std::ifstream in(path);
        std::ostringstream out;
        out << in.rdbuf();
        return out.str();
    }
    void write_text(const std::string& text) const { std::ofstream(path()) << text; }

    /// The error of reading all rows; empty where it reads.
    [[nodiscard]] std::string complaint() const
    {
        try {
            TraceReader reader(path());
            TraceRow row;
            while (reader.next(row)) {
            }
            return {};
        } catch (const TraceError& e) {
            return e.what();
        }
    }

    fs::path folder_;
};

/// Any bits that are a number: denormal, huge, negative zero.
double any_double(std::mt19937_64& random)
{
    for (;;) {
        const double value = std::bit_cast<double>(random());
        if (std::isfinite(value)) return value;
    }
}

TraceRow any_row(std::mt19937_64& random, std::size_t zones)
{
    TraceRow row;
    for (double* const number : {&row.time, &row.dt, &row.cpu, &row.depth}) *number = any_double(random);
    row.sequence = random();
    for (std::uint32_t* const number : {&row.buttons, &row.input, &row.contacts, &row.status, &row.filter})
        *number = static_cast<std::uint32_t>(random());
    const auto any = [&] { return Vec3d{any_double(random), any_double(random), any_double(random)}; };
    for (std::size_t z = 0; z < zones; ++z) {
        for (Vec3d& r : row.poses[z].rotation.row) r = any();
        row.poses[z].translation = any();
        row.twists[z] = {any(), any()};
        row.computed[z] = {any(), any()};
        row.sent[z] = {any(), any()};
    }
    return row;
}

TEST_F(Trace, EveryNumberReadsBackToTheBit)
{
    for (const std::size_t zones : {std::size_t{1}, std::size_t{6}, k_max_zones}) {
        std::mt19937_64 random(zones);
        std::vector<TraceRow> rows;
        for (int i = 0; i < 200; ++i) rows.push_back(any_row(random, zones));
        rows[5].depth = -0.0;
        rows[6].computed[0].force.x = std::numeric_limits<double>::infinity();
        rows[7].poses[0].translation.y = std::numeric_limits<double>::quiet_NaN();
        rows[8].cpu = std::numeric_limits<double>::denorm_min();
        const TraceHeader header{.zones = zones,
                                 .fields = {{"made-by", "a test"}, {"object", "x y z"}, {"object", "w"}, {"empty", ""}}};
        {
            TraceWriter writer(path(), header);
            for (const TraceRow& row : rows) writer.push_wait(row);
            writer.finish();
        }
        TraceReader reader(path());
        EXPECT_EQ(reader.header().zones, zones);
        EXPECT_EQ(reader.header().fields, header.fields);
        EXPECT_EQ(reader.header().find("object"), "x y z");
        EXPECT_EQ(reader.header().find("absent"), std::nullopt);
        TraceRow row;
        for (const TraceRow& expected : rows) {
            ASSERT_TRUE(reader.next(row));
            EXPECT_TRUE(same_bits(row, expected, zones)) << differences(row, expected, zones);
            EXPECT_EQ(std::bit_cast<std::uint64_t>(row.cpu), std::bit_cast<std::uint64_t>(expected.cpu));
        }
        EXPECT_FALSE(reader.next(row));
        EXPECT_TRUE(reader.complete());
        fs::remove(path());
    }
}

TEST_F(Trace, DifferencesNameTheColumnsAndLeaveCpuTimeOut)
{
    std::mt19937_64 random(1);
    const TraceRow row = any_row(random, 2);
    TraceRow other = row;
    other.cpu += 1;
    EXPECT_TRUE(same_bits(row, other, 2));
    other.computed[1].torque.z = std::nextafter(other.computed[1].torque.z, 0);
    other.contacts ^= 1;
    EXPECT_FALSE(same_bits(row, other, 2));
    EXPECT_EQ(differences(row, other, 2), "contacts z1_tz");
    EXPECT_TRUE(differences(row, other, 1) == "contacts") << "zones beyond the count do not matter";
    TraceRow zero, minus;
    minus.depth = -0.0;
    EXPECT_EQ(differences(zero, minus, 1), "depth") << "the sign of zero is a bit";
    zero.depth = std::numeric_limits<double>::quiet_NaN();
    minus.depth = -std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(same_bits(zero, minus, 1));
}

TEST_F(Trace, TheFileAppearsOnlyWhenItIsFinished)
{
    TraceWriter writer(path(), {});
    writer.push_wait({});
    EXPECT_FALSE(fs::exists(path()));
    EXPECT_TRUE(fs::exists(path("a.csv.recording")));
    writer.finish();
    EXPECT_TRUE(fs::exists(path()));
    EXPECT_FALSE(fs::exists(path("a.csv.recording")));
}

TEST_F(Trace, AnEarlierRecordingStaysUntilTheNewOneIsFinished)
{
    write_text("old");
    {
        TraceWriter writer(path(), {});
        writer.push_wait({});
    }
    EXPECT_EQ(text_of(path()), "old");
    // A recording that was cut short is not written over.
    EXPECT_THROW(TraceWriter(path(), {}), TraceError);
    fs::remove(path("a.csv.recording"));
    TraceWriter writer(path(), {});
    writer.finish();
    EXPECT_NE(text_of(path()), "old");
}

TEST_F(Trace, AKilledRecordingKeepsWhatWasWritten)
{
    const pid_t child = ::fork();
    if (child == 0) {
        TraceWriter writer(path(), {});
        TraceRow row;
        for (row.sequence = 1; row.sequence <= 1000; ++row.sequence) writer.push_wait(row);
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        ::kill(::getpid(), SIGKILL);
    }
    ASSERT_GT(child, 0);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_FALSE(fs::exists(path()));
    TraceReader reader(path("a.csv.recording"));
    TraceRow row;
    std::uint64_t rows = 0;
    while (reader.next(row)) EXPECT_EQ(row.sequence, ++rows);
    EXPECT_EQ(rows, 1000u);
    EXPECT_FALSE(reader.complete());
}

TEST_F(Trace, ARowCutInTheMiddleIsLeftOutWhereverTheCut)
{
    std::mt19937_64 random(3);
    {
        TraceWriter writer(path(), {});
        for (int i = 0; i < 3; ++i) writer.push_wait(any_row(random, 1));
        writer.finish();
    }
    const std::string whole = text_of(path());
    const std::size_t header_end = whole.find("time,");
    for (std::size_t cut = whole.find('\n', header_end) + 1; cut < whole.size(); cut += 7) {
        write_text(whole.substr(0, cut));
        TraceReader reader(path());
        TraceRow row;
        std::size_t rows = 0;
        while (reader.next(row)) ++rows;
        EXPECT_EQ(rows, std::min<std::size_t>(3, static_cast<std::size_t>(std::count(
                                                     whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut), '\n')) -
                                                     4 + 1));
        EXPECT_FALSE(reader.complete());
    }
}

TEST_F(Trace, ErrorsNameLineAndColumn)
{
    {
        TraceWriter writer(path(), {.fields = {{"device", "d"}}});
        writer.push_wait({});
        writer.push_wait({});
        writer.finish();
    }
    const std::string good = text_of(path());
    ASSERT_EQ(complaint(), "");
    const auto spoil = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        write_text(text.replace(at, from.size(), to));
        return complaint();
    };
    const std::string file = path().string();
    EXPECT_EQ(spoil("\n0,0,", "\n0,zero,"), file + ":5: column 2 (dt) is no number: 'zero'");
    EXPECT_EQ(spoil("\n0,0,0,", "\n0,0,-1,"), file + ":5: column 3 (sequence) is no number: '-1'");
    EXPECT_EQ(spoil("\n0,0,", "\n0,1e999,"), file + ":5: column 2 (dt) is no number: '1e999'");
    EXPECT_EQ(spoil("\n0,0,0,0,", "\n0,0\n0,0,0,0,"), file + ":5: expected 'sequence' in column 3, the row ends before");
    EXPECT_EQ(spoil("\n0,0,", "\n0,0,0,"), file + ":5: more than 40 columns");
    EXPECT_EQ(spoil("depth,", "deep,"), file + ":4: column 8 must be 'depth', found 'deep'");
    EXPECT_EQ(spoil("# end 2", "# end 3"), file + ":7: the end speaks of 3 rows, there are 2: rows were removed or added");
    EXPECT_EQ(spoil("# end 2 rows", "# end of rows"), file + ":7: the end must read '# end N rows, M dropped'");
    EXPECT_EQ(spoil("# zones 1", "# zones 17"), file + ":2: zones must be 1 to 16, found '17'");
    EXPECT_EQ(spoil("# zones 1\n", ""), file + ":3: the header has no line '# zones N'");
    EXPECT_TRUE(spoil("# sqmap-trace 1", "# sqmap-trace 2")
                    .starts_with(file + ":1: version '2' of the format, this program reads version 1"));
    EXPECT_TRUE(spoil("# sqmap-trace 1", "time,x,y").starts_with(file + ":1: not a trace"));
    write_text(good + "0,0\n");
    EXPECT_EQ(complaint(), file + ":8: something follows the end");
    write_text("");
    EXPECT_TRUE(complaint().starts_with(file + ":1: not a trace"));
    write_text("# sqmap-trace 1\n# zones 1\n" + std::string(70000, 'x'));
    EXPECT_EQ(complaint(), file + ":3: longer than 65536 bytes: no trace");
    fs::remove(path());
    EXPECT_EQ(complaint(), file + ": cannot be opened");
    EXPECT_THROW(TraceReader{folder_}, TraceError);
}

TEST_F(Trace, MutatedBytesReadOrAreRefusedAndNothingElse)
{
    std::mt19937_64 random(4);
    {
        TraceWriter writer(path(), {.zones = 2});
        for (int i = 0; i < 5; ++i) writer.push_wait(any_row(random, 2));
        writer.finish();
    }
    const std::string good = text_of(path());
    int refused = 0;
    for (int i = 0; i < 2000; ++i) {
        std::string text = good;
        for (std::uint64_t n = 1 + random() % 4; n > 0; --n) text[random() % text.size()] = static_cast<char>(random());
        write_text(text);
        refused += !complaint().empty();
    }
    EXPECT_GT(refused, 500);
}

TEST_F(Trace, HeadersThatWouldNotReadBackAreRefused)
{
    for (const auto& [key, value] :
         std::vector<std::pair<std::string, std::string>>{{"", "x"}, {"a b", "x"}, {"a", "x\ny"}, {"end", "x"}, {"zones", "2"}})
        EXPECT_THROW(TraceWriter(path(), {.fields = {{key, value}}}), TraceError) << key;
    EXPECT_THROW(TraceWriter(path(), {.zones = 0}), TraceError);
    EXPECT_THROW(TraceWriter(path(), {.zones = 17}), TraceError);
    EXPECT_THROW(TraceWriter(folder_ / "no" / "folder.csv", {}), TraceError);
}

TEST_F(Trace, AFullDiskIsReportedAndDoesNotStopTheServo)
{
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
    TraceWriter writer("/dev/full", {});
    for (std::size_t i = 0; i < 3 * TraceWriter::k_ring; ++i) writer.push_wait({});
    EXPECT_THROW(writer.finish(), TraceError);
}

TEST_F(Trace, DroppedRowsAreCountedAndTheRestIsInOrder)
{
    TraceRow row;
    std::uint64_t kept = 0, dropped = 0;
    {
        TraceWriter writer(path(), {});
        // Faster than any writer: some must be dropped.
        for (row.sequence = 0; row.sequence < 60000; ++row.sequence) writer.push(row) ? ++kept : ++dropped;
        EXPECT_EQ(writer.dropped(), dropped);
        writer.finish();
    }
    EXPECT_GT(dropped, 0u);
    TraceReader reader(path());
    std::uint64_t last = 0, rows = 0;
    while (reader.next(row)) {
        EXPECT_TRUE(rows == 0 || row.sequence > last);
        last = row.sequence;
        ++rows;
    }
    EXPECT_EQ(rows, kept);
    EXPECT_EQ(reader.dropped(), dropped);
    EXPECT_TRUE(reader.complete());
}

}  // namespace
}  // namespace sqmap::device
