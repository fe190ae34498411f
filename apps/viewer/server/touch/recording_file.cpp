#include "viewer/server/touch/recording_file.h"

#include "common/hash_text.h"
#include "io/files.h"
#include "sqmap/device/trace.h"
#include "sqmap/model/parse.h"
#include "sqmap/paper/model.h"
#include "viewer/server/jobs/temporary_file.h"
#include "viewer/server/protocol/text.h"
#include "viewer/server/touch/touch_setup.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

namespace sqmap::viewer {
namespace {

using device::TraceError;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* k_version_key = "page";
constexpr const char* k_version = "1";
constexpr std::size_t k_max_field = 32 * 1024;  // bytes of a header's field, well below a trace's longest line
constexpr double k_tick = 1e-3;                 // s from the end of a take to the next

/// Adds a list as fields of one key, each short enough for a line.
void add_list(device::TraceHeader& header, const char* key, const std::vector<ordered_json>& list)
{
    std::string text;
    const auto end_field = [&] {
        if (!text.empty()) header.fields.emplace_back(key, text + "]");
        text.clear();
    };
    for (const ordered_json& item : list) {
        const std::string next = text_of(item);
        if (text.size() + next.size() > k_max_field) end_field();
        text += (text.empty() ? "[" : ",") + next;
    }
    end_field();
}

/// Adds the settings of a take that some tick has, with the row from which on they hold.
void add_settings(std::vector<ordered_json>& list, const Take& take, std::size_t first_row)
{
    std::optional<std::uint32_t> before;
    for (std::size_t i = 0; i < take.ticks.size(); ++i) {
        const std::uint32_t number = take.ticks[i].number;
        if (before == number) continue;
        before = number;
        ordered_json settings = settings_json(take.settings[number]);
        settings["row"] = first_row + i;
        list.push_back(std::move(settings));
    }
}

device::TraceHeader header_of(const Recording& recording)
{
    std::vector<ObjectPtr> known;
    std::vector<ordered_json> objects, takes, settings;
    std::size_t row = 0;
    for (const std::shared_ptr<const Take>& take : recording) {
        if (take->ticks.empty()) continue;
        ordered_json numbers = ordered_json::array();
        for (const ObjectPtr& object : take->objects) {
            if (object == nullptr) {
                numbers.push_back(nullptr);
                continue;
            }
            const auto at = std::find(known.begin(), known.end(), object);
            numbers.push_back(at - known.begin());
            if (at != known.end()) continue;
            known.push_back(object);
            objects.push_back({{"name", object->name},
                               {"hash", app::hash_text(paper::content_hash(object->view))},
                               {"metresPerUnit", object->metres_per_unit},
                               {"position", {object->position.x, object->position.y, object->position.z}},
                               {"up", name_of(object->up)}});
        }
        takes.push_back({{"row", row}, {"objects", std::move(numbers)}, {"lost", take->lost}});
        add_settings(settings, *take, row);
        row += take->ticks.size();
    }
    device::TraceHeader header;
    header.fields = {{"made-by", "sqmap view"}, {k_version_key, k_version}};
    add_list(header, "objects", objects);
    add_list(header, "takes", takes);
    add_list(header, "settings", settings);
    return header;
}

device::TraceRow row_of(const Take::Tick& tick, double begin)
{
    device::TraceRow row;
    row.time = begin + tick.time;
    row.dt = tick.input.dt;
    row.sequence = tick.sequence;
    row.buttons = tick.buttons;
    row.input =
        (tick.input.has_twist ? device::k_trace_measured_twist : 0u) | (tick.input.degraded ? device::k_trace_degraded : 0u);
    row.cpu = tick.cpu;
    row.contacts = tick.contacts;
    row.depth = tick.depth;
    row.status = tick.status;
    row.filter = tick.filter;
    row.poses[0] = tick.input.pose;
    row.twists[0] = tick.input.twist;
    row.computed[0] = tick.commanded;
    row.sent[0] = tick.sent;
    return row;
}

Take::Tick tick_of(const device::TraceRow& row, double begin, std::uint32_t number)
{
    return {.input = {row.poses[0], row.twists[0], row.dt, (row.input & device::k_trace_measured_twist) != 0,
                      (row.input & device::k_trace_degraded) != 0},
            .commanded = row.computed[0],
            .sent = row.sent[0],
            .depth = row.depth,
            .time = row.time - begin,
            .cpu = row.cpu,
            .sequence = row.sequence,
            .number = number,
            .contacts = row.contacts,
            .status = row.status,
            .buttons = row.buttons,
            .filter = row.filter};
}

/// The items of all fields of a key; no more than max.
std::vector<json> read_list(const device::TraceHeader& header, std::string_view key, std::size_t max)
{
    std::vector<json> out;
    for (const auto& [name, text] : header.fields) {
        if (name != key) continue;
        bool deep = false;
        json list = json::parse(
            text,
            [&](int depth, json::parse_event_t event, json&) {
                deep = deep ||
                       (depth >= 3 && (event == json::parse_event_t::object_start || event == json::parse_event_t::array_start));
                return !deep;
            },
            false);
        if (deep || !list.is_array() || out.size() + list.size() > max)
            throw TraceError("its field '" + std::string(key) + "' is not as the page writes it");
        for (json& item : list) out.push_back(std::move(item));
    }
    return out;
}

[[noreturn]] void refuse(const char* what)
{
    throw TraceError(std::string("what it says of its ") + what + " is not as sqmap writes it");
}

std::uint64_t count_in(const json& in, const char* key, const char* what)
{
    const auto at = in.is_object() ? in.find(key) : in.end();
    if (at == in.end() || !at->is_number_unsigned()) refuse(what);
    return at->get<std::uint64_t>();
}

/// Recordings of before an object could be turned do not name its axis.
Up up_in(const json& in)
{
    const auto at = in.find("up");
    if (at == in.end()) return Up::Y;
    const std::optional<Up> up = at->is_string() ? up_named(at->get_ref<const std::string&>()) : std::nullopt;
    if (!up) refuse("objects");
    return *up;
}

RecordingFile::NamedObject object_in(const json& in)
{
    if (!in.is_object() || !in.contains("name") || !in.contains("hash") || !in.contains("metresPerUnit") ||
        !in.contains("position") || !in["name"].is_string() || !in["hash"].is_string() || !in["metresPerUnit"].is_number())
        refuse("objects");
    const std::optional<std::uint64_t> hash = app::hash_from(in["hash"].get_ref<const std::string&>());
    const auto metres_per_unit = in["metresPerUnit"].get<double>();
    const std::optional<Vec3d> position = vector_in(in["position"], 100);
    if (!hash || !position || !(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) refuse("objects");
    return {in["name"].get<std::string>(), *hash, metres_per_unit, *position, up_in(in)};
}

/// Settings that hold from a row on.
struct Change {
    std::uint64_t row = 0;
    Settings settings{};
};

/// The header's takes and changes of settings, in the order of the rows.
struct Plan {
    RecordingFile file;
    std::vector<std::uint64_t> first_rows;  // #takes
    std::vector<Change> changes;
};

/// A recording of sqmap touch is one take with one setting.
Plan plan_of_touch(const device::TraceHeader& header, const std::string& text)
{
    if (header.zones != 1)
        throw TraceError("its device has " + std::to_string(header.zones) +
                         " tools, the page has one\n  cure: sqmap replay computes it again");
    const std::optional<json> setup = shallow_object(text, 4);
    const auto objects = setup ? setup->find("objects") : json::const_iterator();
    if (!setup || objects == setup->end() || !objects->is_array() || objects->empty() || objects->size() > 16) refuse("setup");
    Plan plan;
    plan.file.of_touch = true;
    std::vector<std::uint32_t>& numbers = plan.file.objects_of.emplace_back();
    for (const json& in : *objects) {
        const auto field = [&](const char* key) { return in.is_object() ? in.value(key, json()) : json(); };
        const json file = field("file"), scale = field("metres_per_unit"), position = field("place");
        if (!file.is_string() || !position.is_array()) refuse("objects");
        const json named{{"name", std::filesystem::path(file.get<std::string>()).stem().string()},
                         {"hash", field("hash")},
                         {"metresPerUnit", scale},
                         {"position", position}};
        numbers.push_back(static_cast<std::uint32_t>(plan.file.objects.size()));
        plan.file.objects.push_back(object_in(named));
    }
    plan.first_rows = {0};
    plan.file.takes = {std::make_shared<Take>()};
    plan.changes = {{0, settings_of(*setup)}};
    return plan;
}

Plan plan_of(const device::TraceHeader& header)
{
    const auto setup = header.find("setup");
    if (const auto version = header.find(k_version_key); !version && setup)
        return plan_of_touch(header, *setup);
    else if (!version)
        throw TraceError("neither the page nor sqmap touch has recorded it\n  cure: open what one of these has saved");
    else if (version != k_version || header.zones != 1)
        throw TraceError("it is of another version of the page\n  cure: open it with the version that recorded it");
    Plan plan;
    for (const json& in : read_list(header, "objects", k_max_takes * 16)) plan.file.objects.push_back(object_in(in));
    for (const json& in : read_list(header, "takes", k_max_takes)) {
        const std::uint64_t row = count_in(in, "row", "takes");
        if (plan.first_rows.empty() ? row != 0 : row <= plan.first_rows.back()) refuse("takes");
        plan.first_rows.push_back(row);
        plan.file.takes.push_back(std::make_shared<Take>());
        plan.file.takes.back()->lost = count_in(in, "lost", "takes");
        std::vector<std::uint32_t>& numbers = plan.file.objects_of.emplace_back();
        if (!in.contains("objects") || !in["objects"].is_array() || in["objects"].size() > 16) refuse("takes");
        for (const json& number : in["objects"]) {
            if (number.is_null()) {
                numbers.push_back(k_hidden_object);
                continue;
            }
            if (!number.is_number_unsigned() || number.get<std::uint64_t>() >= plan.file.objects.size()) refuse("takes");
            numbers.push_back(number.get<std::uint32_t>());
        }
    }
    for (const json& in : read_list(header, "settings", k_max_recorded)) {
        Change change{count_in(in, "row", "settings"), {}};
        if (in.size() != settings_fields(in) + 1 || !read_settings(in, change.settings)) refuse("settings");
        if (plan.changes.empty() ? change.row != 0 : change.row <= plan.changes.back().row) refuse("settings");
        plan.changes.push_back(change);
    }
    if (plan.file.takes.empty() || plan.changes.empty()) refuse("takes");
    return plan;
}

RecordingFile rows_of(device::TraceReader& reader)
{
    Plan plan = plan_of(reader.header());
    std::size_t row = 0, take = 0, change = 0;
    double begin = 0;
    for (device::TraceRow in; reader.next(in);) {
        if ((in.input & device::k_trace_idle) != 0) continue;
        if (row == k_max_recorded) throw TraceError("it is longer than two minutes");
        if (take + 1 < plan.first_rows.size() && plan.first_rows[take + 1] == row) ++take;
        Take& out = *plan.file.takes[take];
        if (plan.first_rows[take] == row) begin = in.time;
        const bool changes = change < plan.changes.size() && plan.changes[change].row == row;
        if (changes) out.settings.push_back(plan.changes[change++].settings);
        if (out.settings.empty()) refuse("settings");
        if (!std::isfinite(in.time) || !std::isfinite(in.dt) || in.dt < 0 || in.time < begin) refuse("clock");
        out.ticks.push_back(tick_of(in, begin, static_cast<std::uint32_t>(out.settings.size() - 1)));
        ++row;
    }
    plan.file.takes.back()->lost += reader.dropped();
    if (row == 0 || take + 1 != plan.file.takes.size()) throw TraceError("it was cut short");
    return std::move(plan.file);
}

}  // namespace

std::string recording_text(const Recording& recording)
{
    const TemporaryFile file("recording");
    {
        device::TraceWriter writer(file.path(), header_of(recording));
        double begin = 0;
        for (const std::shared_ptr<const Take>& take : recording) {
            for (const Take::Tick& tick : take->ticks) writer.push_wait(row_of(tick, begin));
            if (!take->ticks.empty()) begin += take->ticks.back().time + k_tick;
        }
        writer.finish();
    }
    return io::text_of_file(file.path()).value_or("");
}

RecordingFile read_recording(const std::string& text, const std::string& name)
{
    const TemporaryFile file("recording");
    if (std::ofstream out(file.path(), std::ios::binary); !(out << text) || !out.flush())
        throw TraceError("no temporary file can be written");
    try {
        device::TraceReader reader(file.path());
        return rows_of(reader);
    } catch (const TraceError& e) {
        // The user knows the file under its own name.
        std::string what = e.what();
        const std::string path = file.path().string();
        throw TraceError(what.starts_with(path) ? what.replace(0, path.size(), name) : name + ": " + what);
    }
}

}  // namespace sqmap::viewer
