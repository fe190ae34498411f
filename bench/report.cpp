#include "report.h"

#include "error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>

namespace sqmap::bench {
namespace {

using nlohmann::ordered_json;

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// "deep" of elephant.hand.deep.csv; the whole stem where there is no such word.
std::string kind_of(const std::string& path)
{
    const std::string stem = std::filesystem::path(path).stem().string();
    return stem.substr(stem.rfind('.') + 1);
}

std::string cell(std::optional<double> value, const char* format)
{
    if (!value) return "";
    char text[64];
    std::snprintf(text, sizeof text, format, *value);
    return text;
}

}  // namespace

std::string series_text(std::span<const Record> records)
{
    std::string text = "frame";
    std::size_t frames = 0;
    for (const Record& r : records) {
        text += "," + r.method + "_us," + r.method + "_contacts";
        frames = std::max(frames, (r.frame_us.size() - 1) * r.stride + 1);
    }
    for (std::size_t f = 0; f < frames; ++f) {
        text += "\n" + std::to_string(f);
        for (const Record& r : records) {
            char cells[64] = ",,";
            if (const std::size_t i = f / r.stride; f % r.stride == 0 && i < r.frame_us.size())
                std::snprintf(cells, sizeof cells, ",%.3f,%u", r.frame_us[i], r.frame_contacts[i]);
            text += cells;
        }
    }
    return text + "\n";
}

std::string json_text(std::span<const Record> records, const RunFacts& facts)
{
    ordered_json out = ordered_json::array();
    for (const Record& r : records) {
        const auto judged = [&](double Accuracy::*value) {
            // A record without vertices has no share either.
            return r.accuracy && std::isfinite((*r.accuracy).*value) ? ordered_json((*r.accuracy).*value) : ordered_json();
        };
        char hash[17];
        std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(r.hash));
        out.push_back({{"method", r.method},
                       {"p50_us", r.p50_us},
                       {"p99_us", r.p99_us},
                       {"p999_us", r.p999_us},
                       {"bytes", r.bytes},
                       {"build_s", r.build_s},
                       {"contacts", r.contacts},
                       {"missed_pct", judged(&Accuracy::missed_pct)},
                       {"false_pct", judged(&Accuracy::false_pct)},
                       {"depth_error_mean_pct", judged(&Accuracy::depth_error_mean_pct)},
                       {"depth_error_max_pct", judged(&Accuracy::depth_error_max_pct)},
                       {"hash", hash},
                       {"missed_depth_max_pct", judged(&Accuracy::missed_depth_max_pct)},
                       {"false_distance_max_pct", judged(&Accuracy::false_distance_max_pct)},
                       {"probe_bytes", r.probe_bytes},
                       {"frames", r.frames},
                       {"passes", facts.passes},
                       {"object", facts.object},
                       {"probe", facts.probe},
                       {"path", facts.path},
                       {"instructions", facts.instructions},
                       {"object_triangles", facts.object_triangles},
                       {"probe_vertices", facts.probe_vertices}});
    }
    return out.dump(2) + '\n';
}

std::string tables(std::span<const std::filesystem::path> files)
{
    struct Column {
        const char *field, *title, *format;
        double scale;
    };
    static constexpr Column k_columns[] = {{"p50_us", "p50 µs", "%.2f", 1},
                                           {"p99_us", "p99 µs", "%.2f", 1},
                                           {"p999_us", "p99.9 µs", "%.2f", 1},
                                           {"bytes", "MB", "%.3f", 1e-6},
                                           {"build_s", "build s", "%.2f", 1},
                                           {"contacts", "contacts", "%.1f", 1},
                                           {"missed_pct", "missed %", "%.3g", 1},
                                           {"false_pct", "false %", "%.3g", 1},
                                           {"depth_error_mean_pct", "depth error mean %", "%.2g", 1},
                                           {"depth_error_max_pct", "max %", "%.2g", 1}};
    static const std::vector<std::string> k_rivals{"fcl_obb_all", "dense64_simd", "dense128_simd", "dense256_simd"};

    using Figures = std::map<std::string, std::vector<double>>;     // a field or a rival's name: a value a file
    std::map<std::string, std::map<std::string, Figures>> by_kind;  // kind, method
    std::vector<std::string> order;
    for (const std::filesystem::path& file : files) {
        try {
            std::ifstream in(file);
            if (!in)
                throw BenchError(file.string() + ": cannot be opened\n  cure: name files that sqmap_bench frames has written");
            const ordered_json records = ordered_json::parse(in);
            std::map<std::string, double> p50;
            for (const ordered_json& r : records) p50[r.at("method")] = r.at("p50_us");
            for (const ordered_json& r : records) {
                const std::string name = r.at("method");
                if (std::find(order.begin(), order.end(), name) == order.end()) order.push_back(name);
                Figures& figures = by_kind[kind_of(r.at("path"))][name];
                for (const Column& c : k_columns)
                    if (r.at(c.field).is_number()) figures[c.field].push_back(c.scale * r.at(c.field).get<double>());
                for (const std::string& rival : k_rivals)
                    if (p50.contains(rival)) figures[rival].push_back(p50[rival] / p50[name]);
            }
        } catch (const nlohmann::json::exception& e) {
            throw BenchError(file.string() + ": " + e.what() + "\n  cure: name files that sqmap_bench frames has written");
        }
    }
    std::string text;
    for (const auto& [kind, methods] : by_kind) {
        const std::size_t runs = std::max_element(methods.begin(), methods.end(),
                                                  [](const auto& a, const auto& b) {
                                                      return a.second.at("p50_us").size() < b.second.at("p50_us").size();
                                                  })
                                     ->second.at("p50_us")
                                     .size();
        text += "### " + kind + ": medians over " + std::to_string(runs) + (runs == 1 ? " path" : " paths") + "\n\n| method |";
        std::string rule = "|---|";
        for (const Column& c : k_columns) {
            text += std::string(" ") + c.title + " |";
            rule += "---|";
        }
        for (const std::string& rival : k_rivals) {
            text += " " + rival + " / it |";
            rule += "---|";
        }
        text += "\n" + rule + "\n";
        for (const std::string& name : order) {
            const auto found = methods.find(name);
            if (found == methods.end()) continue;
            const auto middle = [&](const std::string& field) -> std::optional<double> {
                const auto values = found->second.find(field);
                if (values == found->second.end()) return {};
                return median(values->second);
            };
            text += "| " + name + " |";
            for (const Column& c : k_columns) text += " " + cell(middle(c.field), c.format) + " |";
            for (const std::string& rival : k_rivals) text += " " + cell(middle(rival), "%.2f") + " |";
            text += "\n";
        }
        text += "\n";
    }
    return text;
}

}  // namespace sqmap::bench
