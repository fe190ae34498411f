#include "sqmap/device/path.h"

#include "device/channel.h"
#include "math/number_text.h"
#include "sqmap/query/point.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string_view>
#include <utility>

namespace sqmap::device {

PathDevice::PathDevice(std::string name, std::vector<Pose> poses, double rate, std::size_t zones) : poses_(std::move(poses))
{
    if (zones < 1 || zones > k_max_zones || poses_.empty() || poses_.size() % zones != 0)
        throw DeviceError(name + ": " + std::to_string(poses_.size()) + " poses are no path of " + std::to_string(zones) +
                          " zones");
    if (!(rate > 0)) throw DeviceError(name + ": the rate must be above zero");
    capabilities_ = {.name = std::move(name), .simulated = true, .zones = zones, .rotates_in = true, .rate = rate};
    capabilities_.max_force = capabilities_.max_torque = capabilities_.continuous_force = 1000;  // no motors that could heat up
}

bool PathDevice::read(Sample& sample) noexcept
{
    if (next_ == ticks()) return false;
    const std::size_t zones = capabilities_.zones;
    sample = {};
    sample.time = now();
    std::copy_n(poses_.begin() + static_cast<std::ptrdiff_t>(next_ * zones), zones, sample.poses.begin());
    sample.sequence = ++next_;
    return true;
}

bool PathDevice::write(std::span<const Wrench>) noexcept { return next_ < ticks(); }

namespace {

constexpr std::string_view k_header = "r00,r01,r02,r10,r11,r12,r20,r21,r22,tx,ty,tz";
constexpr double k_rotation_tolerance = 1e-4;  // rows may be written with seven digits

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    return text;
}

/// Empty if the row is good, else the fault.
std::string parse_row(std::string_view line, Pose& pose)
{
    double v[12];
    for (int i = 0; i < 12; ++i) {
        const std::size_t comma = line.find(',');
        if ((comma == std::string_view::npos) != (i == 11)) return "expected 12 numbers, one pose";
        const std::string_view cell = trimmed(line.substr(0, comma));
        const auto [end, error] = sqmap::from_chars(cell.data(), cell.data() + cell.size(), v[i]);
        if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(v[i]))
            return "column " + std::to_string(i + 1) + " is no finite number: '" + std::string(cell.substr(0, 40)) + "'";
        if (i < 11) line.remove_prefix(comma + 1);
    }
    pose.rotation = {{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}}};
    pose.translation = {v[9], v[10], v[11]};
    const auto& r = pose.rotation.row;
    bool rotation = std::abs(norm_sq(r[0]) - 1) <= 2 * k_rotation_tolerance;  // rows of zeros pass the products below
    for (int i = 0; i < 3; ++i) rotation = rotation && norm(cross(r[i], r[(i + 1) % 3]) - r[(i + 2) % 3]) <= k_rotation_tolerance;
    return rotation ? "" : "the first nine columns are no rotation (rows must be orthonormal and right-handed)";
}

}  // namespace

std::vector<Pose> read_path(const std::filesystem::path& path)
{
    const std::string name = path.string();
    std::ifstream in(path);
    if (!in || std::filesystem::is_directory(path)) throw DeviceError(name + ": cannot be opened");
    std::string line;
    const bool read = static_cast<bool>(std::getline(in, line));
    if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // as spreadsheets begin a file
    if (!read || trimmed(line) != k_header)
        throw DeviceError(name + ":1: the header must be " + std::string(k_header) + ", found '" + line.substr(0, 60) +
                          "'\n  cure: one pose a row, rotation row-major, then translation");
    std::vector<Pose> poses;
    std::size_t blank = 0;  // number of the first empty line: only the end may have some
    for (std::size_t number = 2; std::getline(in, line); ++number) {
        if (trimmed(line).empty()) {
            if (blank == 0) blank = number;
            continue;
        }
        if (blank > 0)
            throw DeviceError(name + ":" + std::to_string(blank) + ": expected 12 numbers, one pose, found an empty line");
        Pose pose;
        if (const std::string wrong = parse_row(trimmed(line), pose); !wrong.empty())
            throw DeviceError(name + ":" + std::to_string(number) + ": " + wrong);
        poses.push_back(pose);
    }
    if (poses.empty()) throw DeviceError(name + ": no pose after the header");
    return poses;
}

namespace {

/// Finds the heights at which a tool touches a model.
class ToolProbe {
public:
    ToolProbe(const model::ModelView& model, const query::Probe& tool) : model_(model), tool_(tool)
    {
        const Sphere sphere = tool.sphere();
        // A tool farther than this from the origin cannot touch the model.
        far_ = 2 * model.header.r_max * model.header.unit + norm(sphere.centre) + sphere.radius;
    }

    [[nodiscard]] Vec3d origin() const { return {model_.header.origin[0], model_.header.origin[1], model_.header.origin[2]}; }
    [[nodiscard]] double far() const { return far_; }

    [[nodiscard]] bool touches(Vec3d position) const
    {
        query::Contact contact[1];
        const query::Body touched{&model_, nullptr, {}}, tool{nullptr, &tool_, {{}, position}};
        return query::query_probe(touched, tool, {.first_only = true}, contact).contacts > 0;
    }

    /// The greatest height up to from at which the tool, at base + height along normal, touches; false if it never does.
    bool height(Vec3d base, Vec3d normal, double from, double& found) const
    {
        const double step = far_ / 400;
        double free = from;
        if (touches(base + free * normal)) return false;
        while (free > -far_) {
            const double deeper = free - step;
            if (touches(base + deeper * normal)) {
                double in = deeper;
                for (int i = 0; i < 45; ++i) {
                    const double middle = 0.5 * (in + free);
                    (touches(base + middle * normal) ? in : free) = middle;
                }
                found = in;
                return true;
            }
            free = deeper;
        }
        return false;
    }

    /// Surface point and outward normal below a position a little inside; false if the position is outside.
    bool surface(Vec3d at, Vec3d& point, Vec3d& normal) const
    {
        const query::PointResult c = query::query_point(model_, at, {.layer = query::Layer::Exact});
        if (!c.contact || norm(c.normal) == 0) return false;
        point = c.witness;
        normal = normalized(c.normal);
        return true;
    }

private:
    const model::ModelView& model_;
    const query::Probe& tool_;
    double far_;
};

struct SurfacePoint {
    Vec3d point, normal;
};

/// Finds the first surface point on the line from outside to the origin; false if there is none.
bool meets(const ToolProbe& probe, const model::ModelView& model, Vec3d direction, SurfacePoint& start)
{
    const Vec3d out = normalized(direction);
    const query::Probe point(std::vector<Vec3d>{{}});
    const ToolProbe needle(model, point);
    double height = 0;
    if (!needle.height(needle.origin(), out, needle.far(), height)) return false;
    // query_point needs a point inside. The map and the probe's locator may differ by a hair, so the depth grows until it is
    // inside.
    for (double inside = 1e-4 * probe.far(); inside < 1e-2 * probe.far(); inside *= 2)
        if (probe.surface(needle.origin() + (height - inside) * out, start.point, start.normal)) return true;
    return false;
}

SurfacePoint anchor(const ToolProbe& probe, const model::ModelView& model, Vec3d direction)
{
    SurfacePoint start;
    if (norm_sq(direction) > 0) {
        if (meets(probe, model, direction, start)) return start;
        throw DeviceError("no surface lies in that direction of the model's origin: choose another, or none");
    }
    for (const Vec3d axis : {Vec3d{0, 0, 1}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, -1}, Vec3d{-1, 0, 0}, Vec3d{0, -1, 0}})
        if (meets(probe, model, axis, start)) return start;
    throw DeviceError("no surface lies along the axes through the model's origin: choose a direction");
}

constexpr double k_hurry = 1.875;  // peak speed over mean speed of a minimum-jerk motion

double smooth(double x)  // minimum jerk from 0 to 1
{
    x = std::clamp(x, 0.0, 1.0);
    return x * x * x * (10 + x * (6 * x - 15));
}

Vec3d tangent(Vec3d travel, Vec3d normal)
{
    const Vec3d t = travel - dot(travel, normal) * normal;
    if (norm(t) > 1e-6 * norm(travel)) return normalized(t);
    return normalized(cross(normal, std::abs(normal.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
}

/// Moving average of 2 half + 1 values; fewer, as many on either side, near the ends.
std::vector<Vec3d> averaged(const std::vector<Vec3d>& values, std::size_t half)
{
    std::vector<Vec3d> sums(values.size() + 1), out(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t reach = std::min({half, i, values.size() - 1 - i});
        out[i] = (sums[i + reach + 1] - sums[i - reach]) / static_cast<double>(2 * reach + 1);
    }
    return out;
}

/// Positions at which a tool just does not touch, and the directions away from the surface there.
struct Travel {
    std::vector<Vec3d> positions, outwards;
    Vec3d binormal{};  ///< unit, where the path lies in a plane: binormal x path points out
};

/// Moves round a circle about the surface normal at the height at which the tool touches. The height falls by 45 degrees at most
/// in either direction, so that the tool hovers over drops; where it meets nothing, it keeps its height.
Travel circle(const ToolProbe& probe, const SurfacePoint& start, const ScriptOptions& o, std::size_t ticks)
{
    const Vec3d u = tangent(o.travel, start.normal), v = cross(start.normal, u);
    const double step = o.speed / o.rate;
    std::vector<Vec3d> bases(ticks);
    std::vector<double> heights(ticks);
    double height = 0;
    for (std::size_t k = 0; k < ticks; ++k) {
        const double angle = step * static_cast<double>(k) / o.radius;
        bases[k] = start.point + o.radius * (std::cos(angle) * u + std::sin(angle) * v);
        if (!probe.height(bases[k], start.normal, height + probe.far() / 100, height))
            (void)probe.height(bases[k], start.normal, probe.far(), height);
        heights[k] = height;
    }
    for (std::size_t k = 1; k < ticks; ++k) heights[k] = std::max(heights[k], heights[k - 1] - step);
    for (std::size_t k = ticks - 1; k > 0; --k) heights[k - 1] = std::max(heights[k - 1], heights[k] - step);
    Travel travel;
    for (std::size_t k = 0; k < ticks; ++k) travel.positions.push_back(bases[k] + heights[k] * start.normal);
    travel.outwards.assign(ticks, start.normal);
    return travel;
}

/// Moves in the plane of normal and travel with the surface always on the same side. Each step turns its direction inwards until
/// the tool would touch and stays just short of that, so the tool follows creases, edges and limbs and never jumps.
Travel slide(const ToolProbe& probe, const SurfacePoint& start, const ScriptOptions& o, std::size_t ticks)
{
    constexpr int k_directions = 25;
    constexpr double k_first = 2.0, k_last = -2.6;      // rad from straight ahead: outwards, inwards
    constexpr std::size_t k_lately = 60, k_stride = 8;  // ticks
    const double pace = o.speed / o.rate;
    std::size_t strides = 0;
    Vec3d out = start.normal, ahead = tangent(o.travel, out);
    Travel travel;
    double height = 0;
    if (!probe.height(start.point, out, probe.far(), height))
        throw DeviceError("the tool does not reach the surface in that direction: choose another");
    travel.binormal = cross(ahead, out);
    Vec3d at = start.point + (height + 1e-9 * probe.far()) * out;
    while (travel.positions.size() < ticks) {
        // A tool that has hardly moved over the last k_lately ticks goes to and fro in a pit or at a ledge: longer strides, for a
        // while, pass over the obstacle.
        const std::size_t gone = travel.positions.size();
        if (gone >= k_lately && norm(at - travel.positions[gone - k_lately]) < 0.25 * static_cast<double>(k_lately) * pace)
            strides = k_lately;
        const std::size_t ticks_of_stride = strides > 0 ? k_stride : 1;
        if (strides > 0) --strides;
        const double step = static_cast<double>(ticks_of_stride) * pace;
        const auto direction = [&](double angle) { return std::cos(angle) * ahead + std::sin(angle) * out; };
        const auto blocked = [&](double angle) { return probe.touches(at + step * direction(angle)); };
        const double turn = (k_last - k_first) / (k_directions - 1);
        double free = k_first;
        int i = 1;
        while (i < k_directions && !blocked(k_first + i * turn)) free = k_first + i++ * turn;
        if (i < k_directions) {
            double in = k_first + i * turn;
            for (int n = 0; n < 16; ++n) {
                const double middle = 0.5 * (in + free);
                (blocked(middle) ? in : free) = middle;
            }
        }
        const Vec3d next = direction(free);
        out = normalized(std::cos(free) * out - std::sin(free) * ahead);
        ahead = normalized(next);
        for (std::size_t k = 0; k < ticks_of_stride && travel.positions.size() < ticks; ++k) {
            travel.positions.push_back(at);
            travel.outwards.push_back(out);
            at += pace * ahead;
        }
    }
    return travel;
}

constexpr std::size_t k_half = 25;   // ticks to either side that travels are smoothed over
constexpr double k_min_rate = 1000;  // Hz at which paths are made: a slower one takes every n-th pose of a faster one

/// Smooths the positions of a travel and presses them in, starting at the gap. Leaves out the first and the last k_half, which
/// only smooth the others.
std::vector<Vec3d> pressed(const Travel& travel, const ScriptOptions& o)
{
    std::vector<Vec3d> positions = averaged(travel.positions, k_half);
    std::vector<Vec3d> outwards = travel.outwards;
    if (norm_sq(travel.binormal) > 0)
        // Directions come from the smoothed path: the map's small steps would make them jump.
        for (std::size_t k = 0; k < positions.size(); ++k) {
            const Vec3d along = positions[std::min(k + 1, positions.size() - 1)] - positions[k > 0 ? k - 1 : 0];
            if (norm_sq(along) > 0) outwards[k] = normalized(cross(travel.binormal, along));
        }
    outwards = averaged(outwards, k_half);
    const double in = k_hurry * (o.gap + o.depth) / o.speed;
    std::vector<Vec3d> out;
    for (std::size_t k = k_half; k + k_half < positions.size(); ++k)
        out.push_back(positions[k] + (o.gap - (o.gap + o.depth) * smooth(static_cast<double>(k - k_half) / o.rate / in)) *
                                         normalized(outwards[k]));
    return out;
}

}  // namespace

double script_needs(Script script, const ScriptOptions& o) noexcept
{
    const double hurry = script == Script::Tap ? std::numbers::pi : script == Script::Press ? 2 * k_hurry : k_hurry;
    return o.wait + hurry * (o.gap + o.depth) / o.speed;
}

std::vector<Pose> scripted_path(const model::ModelView& model, const query::Probe& tool, Script script, const ScriptOptions& o)
{
    const double numbers[] = {o.seconds, o.rate, o.speed, o.radius};
    if (!std::all_of(std::begin(numbers), std::end(numbers), [](double x) { return x > 0 && std::isfinite(x); }) ||
        !(o.wait >= 0 && o.wait < o.seconds) || !(o.gap + o.depth > 0) || !std::isfinite(o.gap + o.depth) ||
        !std::isfinite(norm(o.direction)) || !std::isfinite(norm(o.travel)) || o.seconds * o.rate > 1e8)
        throw DeviceError("a scripted path needs lengths, times and rates above zero and a direction");
    if (o.rate < k_min_rate) {
        const double finer = std::ceil(k_min_rate / o.rate);
        ScriptOptions all = o;
        all.rate = finer * o.rate;
        const std::vector<Pose> poses = scripted_path(model, tool, script, all);
        std::vector<Pose> out;
        for (std::size_t k = 0; k < poses.size(); k += static_cast<std::size_t>(finer)) out.push_back(poses[k]);
        return out;
    }
    const double seconds = o.seconds - o.wait;
    const auto all = static_cast<std::size_t>(std::max(1.0, std::round(o.seconds * o.rate)));
    const std::size_t waiting = std::min(all - 1, static_cast<std::size_t>(std::round(o.wait * o.rate))), ticks = all - waiting;
    const ToolProbe probe(model, tool);
    const SurfacePoint start = anchor(probe, model, o.direction);
    std::vector<Vec3d> positions;
    if (script == Script::Slide) {
        positions = pressed(slide(probe, start, o, ticks + 2 * k_half), o);
    } else if (script == Script::Circle) {
        positions = pressed(circle(probe, start, o, ticks + 2 * k_half), o);
    } else {
        double height = 0;
        if (!probe.height(start.point, start.normal, probe.far(), height))
            throw DeviceError("the tool does not reach the surface in that direction: choose another");
        const double stroke = o.gap + o.depth, in = k_hurry * stroke / o.speed;
        for (std::size_t k = 0; k < ticks; ++k) {
            const double t = static_cast<double>(k) / o.rate;
            double above;
            if (script == Script::Tap)
                above = o.gap - 0.5 * stroke * (1 - std::cos(2 * o.speed / stroke * t));
            else
                above = o.gap - stroke * std::min(smooth(t / in), smooth((seconds - t) / in));
            positions.push_back(start.point + (height + above) * start.normal);
        }
    }
    std::vector<Pose> poses(all);
    for (std::size_t k = 0; k < all; ++k) poses[k].translation = positions[k > waiting ? k - waiting : 0];
    return poses;
}

}  // namespace sqmap::device
