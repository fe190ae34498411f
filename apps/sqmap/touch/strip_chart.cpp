#include "touch/strip_chart.h"

#include "touch/setup.h"

#include "io/replace_file.h"
#include "sqmap/device/trace.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace sqmap::app {
namespace {

constexpr const char* k_ground = "#fcfcfa";
constexpr const char* k_ink = "#22252a";
constexpr const char* k_faint = "#5c636e";
constexpr const char* k_grid = "#e3e4e0";
constexpr double k_left = 78, k_right = 24, k_width = 1000, k_strip = 150, k_gap = 40, k_top = 62;

struct Curve {
    const char* name;
    const char* colour;
    std::vector<double> values{};
};

struct Strip {
    const char* title;
    std::vector<Curve> curves;
};

std::string text(const char* format, auto... values)
{
    char out[256];
    return {out, static_cast<std::size_t>(std::clamp(std::snprintf(out, sizeof out, format, values...), 0, 255))};
}

std::string escaped(const std::string& words)
{
    std::string out;
    for (const char c : words)
        out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '\'' ? "&apos;" : std::string(1, c);
    return out;
}

/// A round step that parts a range into at most count.
double tick_step(double range, int count)
{
    const double power = std::pow(10, std::floor(std::log10(range / count)));
    for (const double s : {1.0, 2.0, 5.0, 10.0})
        if (range / (s * power) <= count) return s * power;
    return 10 * power;
}

/// The axes of a strip: first and last time, s; zero and the largest value; the top of the strip, pixels.
struct Axes {
    double first, last, top;
    double high = 1;
};

/// One curve from least to most a column of pixels.
std::string path_of(const Curve& curve, const std::vector<double>& times, const Axes& axes)
{
    const double width = k_width - k_left - k_right;
    std::string d;
    const auto x_of = [&](double t) { return k_left + width * (t - axes.first) / (axes.last - axes.first); };
    const auto y_of = [&](double v) { return axes.top + k_strip * (1 - v / axes.high); };
    bool pen = false;
    for (std::size_t i = 0; i < times.size();) {
        const double column = std::floor(x_of(times[i]));
        double least = std::numeric_limits<double>::infinity(), max = -least;
        double begin = least, end = least;
        for (; i < times.size() && std::floor(x_of(times[i])) <= column; ++i) {
            const double v = curve.values[i];
            if (!std::isfinite(v)) continue;
            if (!std::isfinite(begin)) begin = v;
            end = v;
            least = std::min(least, v);
            max = std::max(max, v);
        }
        if (!std::isfinite(begin)) {
            pen = false;
            continue;
        }
        d += text("%c%.0f %.1f", pen ? 'L' : 'M', column, y_of(begin));
        if (max > least) d += text("V%.1fV%.1fV%.1f", y_of(least), y_of(max), y_of(end));
        pen = true;
    }
    return text("<path fill='none' stroke='%s' stroke-width='1.3' stroke-linejoin='round' d='", curve.colour) + d + "'/>\n";
}

/// A line of text in the picture: where, how large, in which colour.
struct TextStyle {
    double x, y;
    const char* anchor = "start";
    int size = 12;
    const char* colour = k_ink;
};

std::string words(const TextStyle& at, const std::string& what)
{
    return text("<text x='%.1f' y='%.1f' text-anchor='%s' font-size='%d' fill='%s'>", at.x, at.y, at.anchor, at.size, at.colour) +
           escaped(what) + "</text>\n";
}

/// The ticks of a trace, and of what they are compared with.
std::vector<Strip> read_strips(device::TraceReader& reader, const Comparison* other, std::vector<double>& times)
{
    const std::size_t zones = reader.header().zones;
    std::vector<Strip> strips{
        {"deepest contact, mm", {{"depth", "#2a6fc9"}}},
        {"force, N", {{"computed", "#d9622b"}, {"sent", "#22252a"}}},
        {"torque, N mm", {{"computed", "#6a4bb5"}, {"sent", "#22252a"}}},
        {"CPU time a tick, us", {{"CPU time", "#14906a"}}},
    };
    device::TraceRow row;
    while (reader.next(row)) {
        double force = 0, torque = 0, sent_force = 0, sent_torque = 0;
        for (std::size_t z = 0; z < zones; ++z) {
            // The zone that feels most.
            force = std::max(force, norm(row.computed[z].force));
            torque = std::max(torque, norm(row.computed[z].torque));
            sent_force = std::max(sent_force, norm(row.sent[z].force));
            sent_torque = std::max(sent_torque, norm(row.sent[z].torque));
        }
        times.push_back(row.time);
        strips[0].curves[0].values.push_back(1e3 * row.depth);
        strips[1].curves[0].values.push_back(force);
        strips[1].curves[1].values.push_back(sent_force);
        strips[2].curves[0].values.push_back(1e3 * torque);
        strips[2].curves[1].values.push_back(1e3 * sent_torque);
        strips[3].curves[0].values.push_back(1e6 * row.cpu);
    }
    if (other != nullptr) {
        const auto add = [](Strip& strip, const std::vector<double>& values, double scale) {
            strip.curves.front().name = "recorded";
            Curve& curve = strip.curves.emplace_back(Curve{"against", "#14906a"});
            for (const double v : values) curve.values.push_back(scale * v);
        };
        add(strips[0], other->depth, 1e3);
        add(strips[1], other->force, 1);
        add(strips[2], other->torque, 1e3);
    }
    return strips;
}

/// times: ascending or not. bottom: the strip carries the axis of time. axes.high is found here.
std::string draw_strip(const Strip& strip, const std::vector<double>& times, Axes axes, bool bottom)
{
    const double first = axes.first, last = axes.last, top = axes.top;
    std::string out;
    double& high = axes.high;
    for (const Curve& curve : strip.curves)
        for (const double v : curve.values)
            if (std::isfinite(v)) high = std::max(high, v);
    high = high > 0 ? 1.08 * high : 1;
    const double step = tick_step(high, 4), time_step = tick_step(last - first, 10);
    for (double v = 0; v <= high; v += step) {
        const double y = top + k_strip * (1 - v / high);
        out += text("<path d='M%.0f %.1fH%.0f' stroke='%s'/>\n", k_left, y, k_width - k_right, k_grid);
        out += words({k_left - 8, y + 4, "end", 11, k_faint}, text("%.6g", v));
    }
    for (double t = std::ceil(first / time_step) * time_step; t <= last; t += time_step) {
        const double x = k_left + (k_width - k_left - k_right) * (t - first) / (last - first);
        out += text("<path d='M%.1f %.1fv5' stroke='%s'/>\n", x, top + k_strip, k_faint);
        if (bottom) out += words({x, top + k_strip + 18, "middle", 11, k_faint}, text("%.6g", t));
    }
    out += words({k_left, top - 8, "start", 12, k_ink}, strip.title);
    // The names of several curves stand at the right, above the strip.
    double x = k_width - k_right;
    if (strip.curves.size() > 1)
        for (auto curve = strip.curves.rbegin(); curve != strip.curves.rend(); ++curve) {
            out += words({x, top - 8, "end", 12, curve->colour}, curve->name);
            x -= 74;
        }
    for (const Curve& curve : strip.curves) out += path_of(curve, times, axes);
    out += text("<path d='M%.0f %.1fH%.0f' stroke='%s'/>\n", k_left, top + k_strip, k_width - k_right, k_faint);
    return out;
}

}  // namespace

void plot_trace(const std::filesystem::path& trace, const std::filesystem::path& svg, const Comparison* other)
{
    device::TraceReader reader(trace);
    std::vector<double> times;
    const std::vector<Strip> strips = read_strips(reader, other, times);
    for (const Strip& strip : strips)
        if (strip.curves.back().values.size() != times.size())
            throw device::TraceError(trace.string() + ": has changed while it was read");
    if (times.empty()) throw device::TraceError(trace.string() + ": no tick to draw");
    const auto [least, max] = std::minmax_element(times.begin(), times.end());
    const double first = *least, last = *max > *least ? *max : *least + 1e-3;
    const double height = k_top + static_cast<double>(strips.size()) * (k_strip + k_gap) + 16;
    std::string out = text(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' width='%.0f' height='%.0f' "
        "font-family='Helvetica,Arial,sans-serif'>\n",
        k_width, height, k_width, height);
    out += text("<rect width='%.0f' height='%.0f' rx='8' fill='%s'/>\n", k_width, height, k_ground);
    const std::string device = reader.header().find("device").value_or("unknown device");
    out += words({18, 27, "start", 15, k_ink}, trace.filename().string() + ": " + device + ", " + std::to_string(times.size()) +
                                                   " ticks" + (other != nullptr ? ", against " + other->name : "") +
                                                   (reader.complete() ? "" : ", cut short"));
    double top = k_top;
    for (const Strip& strip : strips) {
        out += draw_strip(strip, times, {first, last, top}, &strip == &strips.back());
        top += k_strip + k_gap;
    }
    out += words({0.5 * (k_left + k_width - k_right), height - 8, "middle", 12, k_ink}, "time, s");
    out += "</svg>\n";
    io::replace_file(svg, std::as_bytes(std::span(out)));
}

void check_plot_name(const std::filesystem::path& svg)
{
    const std::string end = svg.extension().string();
    if (svg.empty()) return;
    io::check_output(svg, {});
    if (end == ".svg" || end == ".SVG") return;
    throw BadTouch("--plot " + svg.string() + ": the picture is an SVG\n  cure: --plot " +
                   std::filesystem::path(svg).replace_extension(".svg").string());
}

}  // namespace sqmap::app
