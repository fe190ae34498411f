// The driver has one thread, which waits by poll() for messages and ends of its processes. Only these processes read meshes and
// archives, which nobody trusts.
#include "batch/run.h"

#include "batch/member_stream.h"
#include "batch/running.h"
#include "batch/text.h"
#include "io/replace_file.h"
#include "sqmap/io/model_archive.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <deque>
#include <list>
#include <optional>
#include <span>
#include <utility>

namespace sqmap::batch {
namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned k_max_tries = 3;  // how often the driver starts an item whose process somebody kills

/// The entries that a shard bakes.
struct Items {
    std::string fingerprint;  ///< the fingerprint of the whole manifest
    std::vector<Entry> own;   ///< the entries of this shard
};

/// A mesh to bake.
struct Task {
    std::size_t item = 0;
    std::optional<std::string> bytes{};  ///< the content, where the mesh is a member of an archive
    unsigned tries = 0;
};

struct Job {
    Task task;
    Child child;
    std::string message;  ///< bytes of the child that are not a whole line yet
    std::string key;
    std::string answer;  ///< the sizes and the digest of the child's output
    bool is_going = false;
};

std::string host_name()
{
    char name[256] = "";
    ::gethostname(name, sizeof name - 1);
    return name;
}

std::string measured_json(const std::string& key, const Ended& ended)
{
    return dumped({{"key", key},
                   {"seconds", ended.cpu_seconds},
                   {"wall_seconds", ended.wall_seconds},
                   {"peak_bytes", ended.peak_bytes},
                   {"host", host_name()}});
}

Outcome outcome_of_end(const Ended& ended)
{
    switch (ended.ending) {
        case Ending::Timeout:
            return outcome_of("timeout",
                              {"E_TIME", "process", ended.reason, "sqmap batch retry OUT --verdict timeout --time SECONDS"});
        case Ending::Memory:
            return outcome_of("memory",
                              {"E_MEMORY", "process", ended.reason, "sqmap batch retry OUT --verdict memory --memory SIZE"});
        case Ending::Output:
            return outcome_of("output",
                              {"E_OUTPUT", "process", ended.reason, "sqmap batch retry OUT --verdict output --output-size SIZE"});
        case Ending::Killed:
            return outcome_of("killed", {"E_KILLED", "process", ended.reason, "run the same command again"});
        case Ending::Crash:
        case Ending::Done:
            break;
    }
    return outcome_of("crash", {"E_CRASH", "process", ended.reason, "report it, with the file"});
}

/// Results of earlier runs: those of this shard, and those of the merged library.
class Before {
public:
    explicit Before(const Plan& plan) : library_(plan.output)
    {
        std::error_code ignored;
        const std::filesystem::path archive = library_.archive(plan.shard);
        if (std::filesystem::exists(archive, ignored)) own_.read(archive);
        for (const auto& path : library_.merged()) merged_.read(path);
    }

    Results& own() { return own_.results(); }
    /// Tells whether the merged library has all of these rows.
    [[nodiscard]] bool has_merged(const std::vector<Row>& rows) const
    {
        std::set<std::string, std::less<>> left;
        for (const Row& row : rows) left.insert(row.line());
        for (const auto& path : library_.merged())
            each_line(io::ModelArchive(path).rows(), [&](std::string_view line) {
                if (const auto found = left.find(line); found != left.end()) left.erase(found);
            });
        return left.empty();
    }
    [[nodiscard]] const Finished* merged(const std::string& key) const
    {
        const auto found = merged_.results().find(key);
        return found == merged_.results().end() ? nullptr : &found->second;
    }

private:
    Library library_;
    OpenArchives own_, merged_;
};

class Baking {
public:
    Baking(const Plan& plan, Items items, Journal& journal, Before& before)
        : plan_(plan),
          root_(root_of(plan.manifest, plan.root)),
          entries_(std::move(items.own)),
          keys_(entries_.size()),
          journal_(journal),
          before_(before),
          results_(std::move(before.own())),
          running_(Library::rows_of(Library(plan.output).journal(plan.shard)), items.fingerprint),
          progress_(plan.progress, entries_.size())
    {
        journal_.read_into(results_);
        for (auto it = results_.begin(); it != results_.end();) {
            const auto here = it++;
            if (plan_.retry.contains(here->second.outcome.verdict())) retried_.insert(results_.extract(here));
        }
    }

    void run()
    {
        sort_out();
        while (start_jobs() || !jobs_.empty() || stream_) wait();
        results_.merge(retried_);
        for (const auto& [key, item] : waiting_) report(item, 0, true);
        progress_.end();
    }

    [[nodiscard]] const Results& results() const { return results_; }
    /// The rows of all items, in the manifest's order.
    [[nodiscard]] std::vector<Row> rows() const
    {
        std::vector<Row> out;
        for (std::size_t i = 0; i < entries_.size(); ++i) out.push_back(row(i));
        return out;
    }

private:
    /// Queues the items to bake and reports those that have an outcome already.
    void sort_out()
    {
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            const Item& item = entries_[i].item;
            if (entries_[i].outcome)
                report(i, 0, true);
            else if (item.member.empty())
                tasks_.push_back({i});
            else
                archives_[item.path].emplace(item.member, i);
        }
    }

    void report(std::size_t item, double seconds, bool is_new)
    {
        const TimedRow timed{row(item), seconds};
        running_.add(timed);
        progress_.add(timed.row, seconds, is_new);
    }

    [[nodiscard]] Row row(std::size_t item) const
    {
        const Entry& entry = entries_[item];
        if (entry.outcome) return row_of(entry.item, keys_[item], *entry.outcome);
        const auto found = results_.find(keys_[item]);
        if (found != results_.end()) return row_of(entry.item, keys_[item], found->second.outcome);
        return row_of(entry.item, keys_[item],
                      outcome_of_end(Ended{.ending = Ending::Killed, .reason = "the one that bakes its like was killed"}));
    }

    /// Starts jobs while there is room; false where nothing is left to start.
    bool start_jobs()
    {
        bool any = false;
        for (; jobs_.size() < plan_.jobs; any = true) {
            if (!stream_ && tasks_.empty() && !archives_.empty()) open_archive();
            while (stream_ && tasks_.empty() && !stream_->ready().empty()) take_member();
            if (stream_ && stream_->is_over()) stream_.reset();
            if (tasks_.empty()) break;
            start(std::exchange(tasks_.front(), {}));
            tasks_.pop_front();
        }
        return any || !archives_.empty();
    }

    void open_archive()
    {
        auto first = archives_.begin();
        stream_.emplace(root_ / first->first, std::move(first->second),
                        MemberStream::Options{plan_.caps, plan_.settings.bake.mesh.limits.max_bytes});
        archives_.erase(first);
    }

    void take_member()
    {
        Unpacked member = std::move(stream_->ready().front());
        stream_->ready().pop_front();
        stream_->renew_deadline();
        if (!member.outcome) {
            tasks_.push_front({member.item, std::move(member.bytes)});
            return;
        }
        entries_[member.item].outcome = std::move(member.outcome);
        report(member.item, 0, true);
    }

    void start(Task task)
    {
        const Item& item = entries_[task.item].item;
        Source source{.file = item.member.empty() ? file_of(item, root_) : std::filesystem::path(item.member)};
        if (task.bytes) source.bytes = std::as_bytes(std::span(*task.bytes));
        const auto work = [&](int channel, int output) { bake_item(source, plan_.settings, channel, output); };
        Child child(work, plan_.caps);  // before the task moves: it reads the task's bytes
        jobs_.push_back(Job{std::move(task), std::move(child), "", "", ""});
    }

    void wait()
    {
        std::vector<pollfd> wanted;
        auto deadline = Clock::now() + std::chrono::seconds(1);  // for the progress
        for (const Job& job : jobs_) {
            wanted.push_back({job.child.channel(), POLLIN, 0});
            wanted.push_back({job.child.handle(), POLLIN, 0});
            deadline = std::min(deadline, job.child.deadline());
        }
        const bool listens = stream_ && stream_->channel() >= 0 && stream_->ready().size() < plan_.jobs;
        if (listens) {
            wanted.push_back({stream_->channel(), POLLIN, 0});
            deadline = std::min(deadline, stream_->deadline());
        }
        if (wanted.empty()) return;
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
        const auto patience = static_cast<int>(std::max<std::int64_t>(left.count(), 0));
        if (::poll(wanted.data(), wanted.size(), patience) < 0 && errno != EINTR)
            throw std::system_error(errno, std::generic_category(), "poll");
        if (listens) attend_stream(wanted.back().revents != 0);
        attend_jobs(wanted);
        progress_.refresh();
    }

    void attend_stream(bool is_ready)
    {
        if (is_ready)
            stream_->receive();
        else if (Clock::now() >= stream_->deadline())
            stream_->stop();
    }

    void attend_jobs(const std::vector<pollfd>& events)
    {
        std::size_t at = 0;
        for (auto job = jobs_.begin(); job != jobs_.end(); at += 2) {
            const auto here = job++;
            if (events[at].revents != 0) listen(*here);
            if (events[at + 1].revents == 0) {
                if (Clock::now() < here->child.deadline()) continue;
                here->child.stop();
            }
            listen(*here);
            finish(*here);
            jobs_.erase(here);
        }
    }

    /// Reads what a child has sent and takes each whole line.
    void listen(Job& job)
    {
        char buffer[4096];
        for (pollfd more{job.child.channel(), POLLIN, 0}; ::poll(&more, 1, 0) > 0 && (more.revents & POLLIN) != 0;) {
            const ssize_t n = ::read(job.child.channel(), buffer, sizeof buffer);
            if (n <= 0) break;
            job.message.append(buffer, static_cast<std::size_t>(n));
        }
        for (std::size_t end = job.message.find('\n'); end != std::string::npos; end = job.message.find('\n')) {
            const std::string line = job.message.substr(0, end);
            job.message.erase(0, end + 1);
            hear(job, line);
        }
    }

    void hear(Job& job, const std::string& line)
    {
        const std::string text = line.substr(1);
        if (line[0] == k_key) {
            job.key = text;
            job.is_going = !is_known(text) && in_work_.insert(text).second;
            // Somebody may have killed the child meanwhile; SIGPIPE would then end the driver too.
            (void)::send(job.child.channel(), job.is_going ? &k_go : &k_skip, 1, MSG_NOSIGNAL);
        } else if (line[0] == k_unreadable) {
            entries_[job.task.item].outcome = Outcome{text};
        } else if (line[0] == k_done) {
            job.answer = text;
        }
    }

    /// Tells whether an earlier run or this one has the key's result.
    bool is_known(const std::string& key)
    {
        if (results_.contains(key)) return true;
        const Finished* const merged = before_.merged(key);
        if (merged == nullptr || plan_.retry.contains(merged->outcome.verdict())) return false;
        results_.emplace(key, *merged);
        return true;
    }

    void finish(Job& job)
    {
        const Ended ended = job.child.wait();
        const std::size_t item = job.task.item;
        if (job.is_going) in_work_.erase(job.key);
        if (ended.ending == Ending::Killed && !entries_[item].outcome && job.task.tries + 1 < k_max_tries) {
            ++job.task.tries;
            tasks_.push_back(std::move(job.task));
            return;
        }
        keys_[item] = job.key;
        const bool is_skipped = ended.ending == Ending::Done && !job.is_going && !job.key.empty();
        if (ended.ending == Ending::Done && !job.answer.empty())
            keep(job.key, finished_of(job, ended));
        else if (ended.ending == Ending::Killed || (job.key.empty() && !entries_[item].outcome))
            entries_[item].outcome = outcome_of_end(ended);
        else if (job.is_going)
            keep(job.key, {.outcome = outcome_of_end(ended), .measured = measured_json(job.key, ended), .sha256 = "-"});
        if (is_skipped && !results_.contains(job.key)) {
            waiting_.emplace(job.key, item);
            return;
        }
        report(item, is_skipped ? 0 : ended.cpu_seconds, !is_skipped || made_.contains(job.key));
        const auto [first, last] = waiting_.equal_range(job.key);
        for (auto other = first; other != last; ++other) report(other->second, 0, true);
        waiting_.erase(first, last);
    }

    void keep(const std::string& key, Finished result)
    {
        results_.insert_or_assign(key, journal_.append(key, std::move(result)));
        made_.insert(key);
    }

    /// The result that a child has left in its output.
    static Finished finished_of(const Job& job, const Ended& ended)
    {
        unsigned long long model = 0, picture = 0, outcome = 0;
        char digest[65] = "";
        if (std::sscanf(job.answer.c_str(), "%llu %llu %llu %64s", &model, &picture, &outcome, digest) != 4)
            throw std::runtime_error("a process of this program answered in other words");
        return {.outcome = {read_at(job.child.output(), model + picture, outcome)},
                .measured = measured_json(job.key, ended),
                .sha256 = digest,
                .file = job.child.output(),
                .model_offset = 0,
                .model_size = model,
                .picture_offset = model,
                .picture_size = picture};
    }

    const Plan& plan_;
    std::filesystem::path root_;
    std::vector<Entry> entries_;
    std::vector<std::string> keys_;  // of each entry
    Journal& journal_;
    Before& before_;
    Results results_, retried_;
    RunningRows running_;
    Progress progress_;
    std::deque<Task> tasks_;
    std::map<std::string, std::map<std::string, std::size_t>> archives_;  // archives to open: the item of each member
    std::optional<MemberStream> stream_;
    std::list<Job> jobs_;
    std::set<std::string> in_work_, made_;             // keys; made_: of this run
    std::multimap<std::string, std::size_t> waiting_;  // items whose key another job is baking
};

Items items_of(const Plan& plan)
{
    std::vector<Entry> all = expanded(read_manifest(plan.manifest, {.root = plan.root, .skip = plan.output}),
                                      root_of(plan.manifest, plan.root), plan.caps);
    mark_duplicates(all);
    Items out{.fingerprint = fingerprint_of(all), .own = {}};
    for (std::size_t i = plan.shard.index; i < all.size(); i += plan.shard.count) out.own.push_back(std::move(all[i]));
    return out;
}

/// Writes rows and results as the shard's archive, unless the archive holds them already.
void write_shard(const std::filesystem::path& archive, const std::filesystem::path& journal, const Baking& baking)
{
    std::vector<std::string> lines;
    std::set<std::string_view> named;
    const std::vector<Row> rows = baking.rows();
    for (const Row& row : rows) {
        lines.push_back(row.line());
        named.insert(row.key);
    }
    std::vector<const Results::value_type*> results;
    std::string measured, text;
    for (const auto& result : baking.results()) {
        results.push_back(&result);
        if (!result.second.measured.empty()) measured += result.second.measured + "\n";
        // A result that only an earlier manifest names stays until gc removes it.
        if (!named.contains(result.first)) lines.push_back(Row{R"({"path":null)", result.first, result.second.outcome}.line());
    }
    std::sort(lines.begin(), lines.end());
    for (const std::string& line : lines) text += line + "\n";
    std::error_code ignored;
    if (!std::filesystem::exists(archive, ignored) || io::ModelArchive(archive).rows() != text ||
        std::filesystem::file_size(journal, ignored) > 0)
        write_archive(archive, results, text);
    io::replace_file(Library::measured_of(archive), std::as_bytes(std::span(std::as_const(measured))));
}

}  // namespace

void run(const Plan& plan)
{
    const Library library(plan.output);
    const auto absolute = [](const std::filesystem::path& path) {
        return path.empty() ? "" : std::filesystem::absolute(path).string();
    };
    Items items = items_of(plan);
    const std::string fingerprint = items.fingerprint;
    library.begin({.made_by = plan.settings.bake.provenance.made_by,
                   .options = plan.settings.options,
                   .arguments = plan.arguments,
                   .shards = plan.shard.count,
                   .manifest = absolute(plan.manifest),
                   .root = absolute(plan.root),
                   .fingerprint = fingerprint});
    const std::filesystem::path archive = library.archive(plan.shard), journal_path = library.journal(plan.shard);
    Journal journal(journal_path);
    Before before(plan);
    Baking baking(plan, std::move(items), journal, before);
    baking.run();
    const Merged merged = library.merged_shards();
    std::error_code ignored;
    const bool is_merged = !std::filesystem::exists(archive, ignored) && merged.fingerprint == fingerprint &&
                           merged.has(plan.shard) && before.has_merged(baking.rows());
    if (!is_merged) {
        // While the archive is written the shard must count as not finished.
        if (!Library::is_of(archive, fingerprint)) std::filesystem::remove(Library::manifest_of(archive), ignored);
        write_shard(archive, journal_path, baking);
        const std::string line = fingerprint + "\n";
        io::replace_file(Library::manifest_of(archive), std::as_bytes(std::span(line)));
    }
    std::filesystem::remove(Library::rows_of(journal_path), ignored);
    std::filesystem::remove(journal_path, ignored);
}

}  // namespace sqmap::batch
