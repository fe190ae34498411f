#include "sqmap/robot/sweep.h"

#include "parallel/for_each.h"
#include "robot/bodies.h"
#include "robot/pair_sweep.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

namespace sqmap::robot {
namespace {

using Clock = std::chrono::steady_clock;

/// A pair on its path to a verdict.
struct PairTask {
    std::size_t a, b;  ///< links
    SweptPair row;
    std::unique_ptr<Chain> chain{};
    std::unique_ptr<PairSweep> search{};
};

std::string percent_words(double share)
{
    char text[32];
    std::snprintf(text, sizeof text, share > 0.1 ? "%.0f" : "%.2g", 100 * share);
    return text;
}

class RobotSweep {
public:
    RobotSweep(std::string_view text, const std::filesystem::path& robot_file, const SweepOptions& options)
        : robot_(read_description(text, robot_file.string())), file_(robot_file), options_(options)
    {
    }

    Sweep run()
    {
        const auto begin = Clock::now();
        choose_pairs();
        load_shapes();
        parallel::for_each(tasks_.size(), options_.threads, [&](std::size_t i) { prepare(tasks_[i]); });
        const auto end = begin + std::chrono::duration<double>(std::min(options_.seconds, 1e9));
        search_until(std::chrono::time_point_cast<Clock::duration>(end));
        Sweep out;
        for (std::size_t i = 0; i < robot_.links.size(); ++i)
            if (shapes_[i])
                out.links.push_back(
                    {robot_.links[i].name, shapes_[i]->triangles().size(), shapes_[i]->verdict, shapes_[i]->problem});
        for (PairTask& task : tasks_) {
            finish(task);
            out.pairs.push_back(std::move(task.row));
        }
        return out;
    }

private:
    [[nodiscard]] bool has_shapes(std::size_t link) const
    {
        return !robot_.links[link].meshes.empty() || !robot_.links[link].solids.empty();
    }
    [[nodiscard]] std::size_t link_named(const std::string& name) const
    {
        for (std::size_t i = 0; i < robot_.links.size(); ++i)
            if (robot_.links[i].name == name) return i;
        throw DescriptionError(file_.string() + ": there is no link '" + name + "'; name two links of the robot");
    }
    void choose_pairs()
    {
        const auto add = [&](std::size_t a, std::size_t b) {
            tasks_.push_back({.a = a, .b = b, .row = {.a = robot_.links[a].name, .b = robot_.links[b].name}});
        };
        for (const auto& [name_a, name_b] : options_.pairs) {
            const std::size_t a = link_named(name_a), b = link_named(name_b);
            if (a == b)
                throw DescriptionError(file_.string() + ": the pair '" + name_a + "' and '" + name_b +
                                       "' is one link; name two links of the robot");
            for (const std::size_t link : {a, b})
                if (!has_shapes(link))
                    throw DescriptionError(file_.string() + ": link '" + robot_.links[link].name +
                                           "' has no collision shape; name links that have one");
            add(std::min(a, b), std::max(a, b));
        }
        if (!options_.pairs.empty()) return;
        for (std::size_t a = 0; a < robot_.links.size(); ++a)
            for (std::size_t b = a + 1; b < robot_.links.size(); ++b)
                if (has_shapes(a) && has_shapes(b)) add(a, b);
    }
    void load_shapes()
    {
        shapes_.resize(robot_.links.size());
        std::vector<std::uint8_t> is_wanted(robot_.links.size(), 0);
        for (const PairTask& task : tasks_) is_wanted[task.a] = is_wanted[task.b] = 1;
        parallel::for_each(robot_.links.size(), options_.threads, [&](std::size_t i) {
            if (is_wanted[i] != 0)
                shapes_[i] = std::make_unique<LinkShape>(robot_.links[i], file_, options_.packages, options_.mesh);
        });
    }

    [[nodiscard]] bool are_adjacent(const Chain& chain) const
    {
        const auto links = chain.between();
        return chain.moving().size() <= 1 && chain.unbounded().empty() &&
               std::none_of(links.begin(), links.end(), [&](std::size_t link) { return has_shapes(link); });
    }
    /// Verdicts that need no search, or its first steps.
    void prepare(PairTask& task) const
    {
        constexpr double k_largest = 1e5;  // of a joint's position: beyond, rounding of angles is no longer small
        task.chain = std::make_unique<Chain>(robot_, task.a, task.b);
        const Chain& chain = *task.chain;
        const LinkShape &a = *shapes_[task.a], &b = *shapes_[task.b];
        task.row.fixed = chain.moving().empty();
        if (are_adjacent(chain)) {
            task.row.verdict = PairVerdict::Adjacent;
            return;
        }
        if (!chain.unbounded().empty())
            task.row.reason = "joint '" + chain.unbounded() + "' has no limits: it floats, or moves in a plane";
        for (const Chain::Variable& v : chain.variables())
            if (!(v.range.lower >= -k_largest && v.range.upper <= k_largest))
                task.row.reason = "joint '" + robot_.joints[v.joint].name + "' has limits beyond 100,000";
        if (a.empty() || b.empty()) task.row.reason = missing(task);
        if (!task.row.reason.empty()) {
            task.row.left = 1;
            return;
        }
        task.search = std::make_unique<PairSweep>(chain, a, b);
        task.search->sample();
    }

    /// In turns, so that a pair that is hard to decide does not take the time of all others.
    void search_until(Clock::time_point end)
    {
        constexpr std::uint64_t k_turn = 2048;
        for (std::uint64_t cells = k_turn;; cells = std::min(2 * cells, 16 * k_turn)) {
            std::vector<PairSweep*> unfinished;
            for (const PairTask& task : tasks_)
                if (task.search && !task.search->finished()) unfinished.push_back(task.search.get());
            if (unfinished.empty() || Clock::now() >= end) return;
            parallel::for_each(unfinished.size(), options_.threads, [&](std::size_t i) {
                constexpr std::uint64_t k_between_looks = 32;
                for (std::uint64_t done = 0; done < cells && !unfinished[i]->finished(); done += k_between_looks) {
                    unfinished[i]->search(k_between_looks);
                    if (Clock::now() >= end) return;
                }
            });
        }
    }

    void finish(PairTask& task) const
    {
        if (!task.search) return;
        const PairSweep& search = *task.search;
        SweptPair& row = task.row;
        row.cells = search.cells();
        row.seen = search.seen();
        for (std::size_t v = 0; v < task.chain->variables().size(); ++v)
            row.pose.push_back({robot_.joints[task.chain->variables()[v].joint].name, search.pose()[v]});
        if (search.seen() <= 0) {
            row.verdict = PairVerdict::Colliding;
            return;
        }
        row.left = search.left();
        if (row.left > 0) {
            row.reason = search.finished() ? "clearances are within rounding in " : "the time ended the search; open are ";
            row.reason += percent_words(row.left) + " % of the joints' range";
        } else if (const mesh::Words words = missing(task); !words.empty()) {
            row.reason = mesh::Words("what is there is free, but ") + words;
        } else {
            row.verdict = PairVerdict::Free;
            row.bound = search.bound();
        }
    }
    [[nodiscard]] mesh::Words missing(const PairTask& task) const
    {
        for (const std::size_t link : {task.a, task.b})
            if (!shapes_[link]->problem.empty())
                return mesh::Words("link '" + robot_.links[link].name + "': ") + shapes_[link]->problem;
        return {};
    }

    Description robot_;
    const std::filesystem::path& file_;
    const SweepOptions& options_;
    std::vector<std::unique_ptr<LinkShape>> shapes_;
    std::vector<PairTask> tasks_;
};

}  // namespace

const char* name_of(PairVerdict verdict) noexcept
{
    switch (verdict) {
        case PairVerdict::Colliding:
            return "colliding";
        case PairVerdict::Free:
            return "free";
        case PairVerdict::Adjacent:
            return "adjacent";
        default:
            return "open";
    }
}

Sweep sweep(std::string_view text, const std::filesystem::path& robot_file, const SweepOptions& options)
{
    if (!(options.seconds > 0)) throw mesh::InvalidInput("seconds of a sweep must be above 0");
    return RobotSweep(text, robot_file, options).run();
}

}  // namespace sqmap::robot
