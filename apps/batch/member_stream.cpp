#include "batch/member_stream.h"

#include <utility>
#include <vector>

namespace sqmap::batch {

MemberStream::MemberStream(std::filesystem::path archive, std::map<std::string, std::size_t> wanted, const Options& options)
    : archive_(std::move(archive)), wanted_(std::move(wanted)), options_(options)
{
    Caps caps = options_.caps;
    caps.is_long = true;  // each member has the deadline
    std::vector<std::string> names;
    for (const auto& [name, item] : wanted_) names.push_back(name);
    const auto work = [this, names](int channel, int) { send_members(archive_, names, options_.max_bytes, channel); };
    child_ = std::make_unique<Child>(work, caps);
}

void MemberStream::renew_deadline()
{
    if (child_) child_->renew_deadline();
}

void MemberStream::receive()
{
    const bool open = frames_.read(child_->channel());
    Frame frame;
    while (frames_.next(frame)) take(frame);
    if (!open) end();
}

void MemberStream::take(const Frame& frame)
{
    child_->renew_deadline();
    const auto found = wanted_.find(frame.name);
    if (frame.kind == Frame::Kind::Broken) broken_ = frame.bytes;
    if (found == wanted_.end()) return;
    if (frame.kind == Frame::Kind::Bytes)
        ready_.push_back({found->second, frame.bytes, {}});
    else
        ready_.push_back({found->second, "", Outcome{frame.bytes}});
    wanted_.erase(found);
}

void MemberStream::stop()
{
    child_->stop();
    end();
}

void MemberStream::end()
{
    const Ended ended = child_->wait();
    child_.reset();
    const bool is_done = ended.ending == Ending::Done;
    const std::string why = !is_done          ? "while the archive was read: " + ended.reason
                            : broken_.empty() ? std::string("the archive holds no such member")
                                              : broken_;
    const char* const verdict = ended.ending == Ending::Killed    ? "killed"
                                : ended.ending == Ending::Timeout ? "timeout"
                                                                  : "unreadable";
    for (const auto& [name, item] : wanted_)
        ready_.push_back(
            {item, "", outcome_of(verdict, {"E_ARCHIVE", "archive", why, "mend the archive, or unpack it and name the folder"})});
    wanted_.clear();
}

}  // namespace sqmap::batch
