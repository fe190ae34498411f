#include "urdf_sweep.h"

#include "common/program_words.h"
#include "io/replace_file.h"
#include "sqmap/collider/export.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sqmap::app {
namespace {

using nlohmann::ordered_json;
using robot::PairVerdict;
using robot::SweptPair;

/// "A:B"
std::pair<std::string, std::string> link_pair(const std::string& text)
{
    const std::size_t colon = text.find(':');
    if (colon == 0 || colon == std::string::npos || colon + 1 == text.size() || text.find(':', colon + 1) != std::string::npos)
        throw WrongUsage("--pairs", "'" + text + "' is not LINK:LINK");
    return {text.substr(0, colon), text.substr(colon + 1)};
}

std::string pose_words(const SweptPair& pair)
{
    if (pair.fixed) return "in every pose";
    std::string out;
    for (const SweptPair::Position& p : pair.pose) {
        char text[32];
        std::snprintf(text, sizeof text, "%.4g", p.value);
        out += (out.empty() ? "" : " ") + p.joint + '=' + text;
    }
    return out;
}

/// Millimetres with four digits; of a bound towards zero, so that the printed one is proven too.
std::string millimetres(double metres, bool is_bound)
{
    if (!std::isfinite(metres) || metres <= 0) return is_bound ? "-" : "0";
    const double unit = std::pow(10., std::floor(std::log10(1000 * metres)) - 3);
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", is_bound ? unit * std::floor(1000 * metres / unit * (1 - 1e-12)) : 1000 * metres);
    return text;
}

void print_sweep(const robot::Sweep& swept)
{
    std::printf("%-20s %-20s %-10s %12s %12s  %s\n", "link", "link", "verdict", "proven (mm)", "seen (mm)", "pose or reason");
    std::size_t count[4] = {};
    for (const SweptPair& p : swept.pairs) {
        ++count[static_cast<std::size_t>(p.verdict)];
        const bool is_adjacent = p.verdict == PairVerdict::Adjacent;
        const std::string proven = p.verdict == PairVerdict::Free ? millimetres(p.bound, true) : "-";
        const std::string seen = is_adjacent || (p.cells == 0 && p.pose.empty() && !p.fixed) ? "-" : millimetres(p.seen, false);
        std::printf("%-20s %-20s %-10s %12s %12s  %s\n", p.a.c_str(), p.b.c_str(), robot::name_of(p.verdict), proven.c_str(),
                    seen.c_str(), (p.reason.empty() && !is_adjacent ? pose_words(p) : p.reason.text(k_program_settings)).c_str());
    }
    std::printf("%zu pairs: %zu colliding, %zu free, %zu adjacent, %zu open\n", swept.pairs.size(), count[0], count[1], count[3],
                count[2]);
}

std::string sweep_json(const robot::Sweep& swept)
{
    const auto text_or_null = [](const std::string& text) { return text.empty() ? ordered_json(nullptr) : ordered_json(text); };
    ordered_json links = ordered_json::array(), pairs = ordered_json::array();
    for (const robot::SweptLink& l : swept.links)
        links.push_back({{"name", l.name},
                         {"triangles", l.triangles},
                         {"verdict", text_or_null(l.verdict)},
                         {"problem", text_or_null(l.problem.text(k_program_settings))}});
    for (const SweptPair& p : swept.pairs) {
        ordered_json pose = ordered_json::object();
        for (const SweptPair::Position& at : p.pose) pose[at.joint] = at.value;
        const bool is_looked_at = p.fixed ? p.cells > 0 : !p.pose.empty();
        pairs.push_back({{"link1", p.a},
                         {"link2", p.b},
                         {"verdict", robot::name_of(p.verdict)},
                         {"proven_clearance", p.verdict == PairVerdict::Free ? ordered_json(p.bound) : ordered_json(nullptr)},
                         {"clearance_seen", is_looked_at ? ordered_json(p.seen) : ordered_json(nullptr)},
                         {"pose", is_looked_at ? pose : ordered_json(nullptr)},
                         {"fixed", p.fixed},
                         {"cells", p.cells},
                         {"open_share", p.verdict == PairVerdict::Open ? ordered_json(p.left) : ordered_json(nullptr)},
                         {"reason", text_or_null(p.reason.text(k_program_settings))}});
    }
    const ordered_json out{{"links", links}, {"pairs", pairs}};
    return out.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace

void add_sweep_options(Command& command, SweepArguments& sweep)
{
    Command titled = command.titled("Sweep of the joints");
    titled.flag("--sweep", sweep.sweep,
                "Instead: which links can collide within the joints' limits, proven; -o writes SRDF for those that cannot");
    titled.option("--pairs", sweep.pairs, "Pairs of links to sweep; without it, all")
        .delimiter(',')
        .type_name("A:B,...")
        .shows_default("");
    titled.option("--seconds", sweep.options.seconds, "Time after which pairs are left open").above_zero(1e6);
    titled.flag("--json", sweep.json, "Print the table as JSON");
}

int run_sweep(const SweepArguments& arguments, const std::string& text, const SweepFiles& files)
{
    robot::SweepOptions options = arguments.options;
    for (const std::string& pair : arguments.pairs) options.pairs.push_back(link_pair(pair));
    const robot::Sweep swept = robot::sweep(text, files.robot, options);
    std::vector<collider::ExportFile> made;
    if (!files.report.empty()) made.push_back({files.report, sweep_json(swept)});
    if (!files.output.empty())
        made.push_back({files.output, robot::srdf_text(robot::read_description(text, files.robot).name, swept)});
    collider::write(made);
    if (arguments.json)
        std::fputs(sweep_json(swept).c_str(), stdout);
    else
        print_sweep(swept);
    bool is_whole = true;
    for (const robot::SweptLink& link : swept.links)
        if (!link.problem.empty()) {
            is_whole = false;
            std::fprintf(stderr, "%s: link '%s' is not swept whole: %s\n", files.robot.c_str(), link.name.c_str(),
                         link.problem.text(k_program_settings).c_str());
        }
    return is_whole ? 0 : 2;
}

}  // namespace sqmap::app
