#include "path.h"

#include "error.h"

#include <charconv>
#include <cstdio>
#include <fstream>
#include <string_view>

namespace sqmap::bench {
namespace {

constexpr std::string_view k_header = "r00,r01,r02,r10,r11,r12,r20,r21,r22,tx,ty,tz";
constexpr double k_rotation_tolerance = 1e-4;  // rows are written with seven digits

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    return text;
}

/// Empty where the row is good, else what is wrong with it.
std::string parse_row(std::string_view line, Pose& pose)
{
    double v[12];
    for (int i = 0; i < 12; ++i) {
        const std::size_t comma = line.find(',');
        if ((comma == std::string_view::npos) != (i == 11)) return "expected 12 numbers, one pose";
        const std::string_view cell = trimmed(line.substr(0, comma));
        const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), v[i]);
        if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(v[i]))
            return "column " + std::to_string(i + 1) + " is no finite number: '" + std::string(cell.substr(0, 40)) + "'";
        if (i < 11) line.remove_prefix(comma + 1);
    }
    pose.rotation = {{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}}};
    pose.translation = {v[9], v[10], v[11]};
    const auto& r = pose.rotation.row;
    for (int i = 0; i < 3; ++i)
        if (norm(cross(r[i], r[(i + 1) % 3]) - r[(i + 2) % 3]) > k_rotation_tolerance)
            return "the first nine columns are no rotation (rows must be orthonormal and right-handed)";
    return {};
}

}  // namespace

std::vector<Pose> read_path(const std::filesystem::path& path)
{
    const std::string name = path.string();
    std::ifstream in(path);
    if (!in || std::filesystem::is_directory(path))
        throw BenchError(name + ": cannot be opened\n  cure: check the name, or make a path with sqmap_bench path");
    std::string line;
    if (!std::getline(in, line) || trimmed(line) != k_header)
        throw BenchError(name + ":1: the header must be " + std::string(k_header) + ", found '" + line.substr(0, 60) +
                         "'\n  cure: one pose of the probe a row, rotation row-major, then translation");
    std::vector<Pose> poses;
    for (std::size_t number = 2; std::getline(in, line); ++number) {
        if (trimmed(line).empty() && in.peek() == std::ifstream::traits_type::eof()) break;
        Pose pose;
        if (const std::string wrong = parse_row(trimmed(line), pose); !wrong.empty())
            throw BenchError(name + ":" + std::to_string(number) + ": " + wrong + "\n  cure: correct the row or remove it");
        poses.push_back(pose);
    }
    if (poses.empty()) throw BenchError(name + ": no pose after the header\n  cure: make a path with sqmap_bench path");
    return poses;
}

std::string path_text(std::span<const Pose> poses)
{
    std::string text{k_header};
    text += '\n';
    char cell[32];
    for (const Pose& pose : poses) {
        for (int i = 0; i < 12; ++i) {
            const double value = i < 9 ? pose.rotation.row[i / 3][i % 3] : pose.translation[i - 9];
            std::snprintf(cell, sizeof cell, i < 11 ? "%.7g," : "%.7g\n", value);
            text += cell;
        }
    }
    return text;
}

}  // namespace sqmap::bench
