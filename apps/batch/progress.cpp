#include "batch/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace sqmap::batch {
namespace {

using namespace std::chrono_literals;

/// "3 h 20 min", "4 min", "12 s"
std::string duration(double seconds)
{
    const auto whole = static_cast<unsigned long>(seconds);
    if (whole >= 3600) return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
    return whole >= 60 ? std::to_string(whole / 60) + " min" : std::to_string(whole) + " s";
}

}  // namespace

Progress::Progress(ProgressMode mode, std::size_t items) : mode_(mode), is_terminal_(::isatty(STDERR_FILENO) != 0), items_(items)
{
}

void Progress::add(const Row& row, double seconds, bool is_new)
{
    ++done_;
    const std::string_view verdict = row.outcome.verdict();
    ++counts_[std::string(verdict)];
    if (is_new) ++baked_;
    if (mode_ == ProgressMode::Json) {
        std::string line = timed_line(row, seconds);
        line.pop_back();
        std::printf("%s,\"done\":%zu,\"items\":%zu}\n", line.c_str(), done_, items_);
        std::fflush(stdout);
    } else if (mode_ == ProgressMode::Auto && is_new && !is_baked(verdict)) {
        if (is_terminal_) std::fprintf(stderr, "\r\033[K");
        std::fprintf(stderr, "%s\n", sentence(row).c_str());
    }
    refresh();
}

void Progress::refresh()
{
    if (Clock::now() - last_ >= (is_terminal_ ? 200ms : 30s)) show(false);
}

std::string Progress::state() const
{
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    const double rate = static_cast<double>(baked_) / std::max(seconds, 1e-3);
    char text[160];
    std::snprintf(text, sizeof text, "%zu of %zu", done_, items_);
    std::string out = text;
    for (const auto& [verdict, count] : counts_) out += ", " + verdict + " " + std::to_string(count);
    if (baked_ > 0) {
        std::snprintf(text, sizeof text, ", %.2f a second", rate);
        out += text;
        if (done_ < items_) out += ", " + duration(static_cast<double>(items_ - done_) / rate) + " left";
    }
    return out;
}

void Progress::show(bool is_last)
{
    last_ = Clock::now();
    if (mode_ != ProgressMode::Auto) return;
    if (is_terminal_)
        std::fprintf(stderr, "\r\033[K%s%s", state().c_str(), is_last ? "\n" : "");
    else
        std::fprintf(stderr, "%s\n", state().c_str());
    std::fflush(stderr);
}

void Progress::end() { show(true); }

}  // namespace sqmap::batch
