#include "viewer/server/cloth/wardrobe.h"

#include "viewer/server/cloth/fitting.h"
#include "viewer/server/http/request_check.h"
#include "viewer/server/protocol/text.h"
#include "viewer/server/scene/file_name.h"

namespace sqmap::viewer {

#ifdef SQMAP_VIEWER_HAS_CLOTH
void Wardrobe::add_routes(Routes& routes)
{
    routes.get("/api/fitting", [this](const Call& call) {
        const auto shapes = fitting_ != nullptr ? fitting_->shapes() : nullptr;
        call.answer(shapes != nullptr ? bytes_reply(*shapes) : not_found());
    });
    routes.post("/api/avatar", [this](const Call& call) {
        const std::string name = harmless(query_value(call.request.target, "name"));
        wear(std::make_shared<OwnAvatar>(OwnAvatar{name, std::move(call.request.body)}));
        call.answer(json_reply({{"accepted", true}}));
    });
}

/// The page says next what the new figure wears.
void Wardrobe::wear(std::shared_ptr<const OwnAvatar> own)
{
    own_ = std::move(own);
    if (fitting_ != nullptr) pictures_.work([gone = std::move(fitting_)]() mutable { gone.reset(); });
    fitting_ = nullptr;
    sent_.clear();
    on_status();
}

nlohmann::ordered_json Wardrobe::json() const
{
    return {{"here", true}, {"worn", fitting_ != nullptr ? fitting_->status() : nlohmann::ordered_json(nullptr)}};
}

void Wardrobe::dress(const Message& message)
{
    if (message.say == Say::Undress) {
        undress();
        audience_.send_progress("the figure", "done", 1);
        return on_status();
    }
    if (fitting_ == nullptr) {
        if (message.say != Say::Fit) return;
        fitting_ = std::make_shared<Fitting>(
            [this](double done) {
                audience_.post([this, done] {
                    if (fitting_ != nullptr) audience_.send_progress("the figure", "bones", done);
                });
            },
            [this](const std::string& why) { audience_.post([this, why] { audience_.send_trouble(why); }); },
            own_ != nullptr ? *own_ : OwnAvatar{});
    }
    fitting_->send(message);
}

/// The figure stays for the next visit. Where it is not made yet, the making ends, elsewhere: its thread may be baking a bone,
/// and STOP must not wait for that.
void Wardrobe::undress()
{
    if (fitting_ == nullptr) return;
    if (fitting_->ready()) {
        Message message;
        message.say = Say::Undress;
        return fitting_->send(message);
    }
    pictures_.work([gone = std::move(fitting_)]() mutable { gone.reset(); });
    fitting_ = nullptr;
    sent_.clear();
}

void Wardrobe::stream()
{
    if (fitting_ == nullptr) return;
    if (const std::string state = text_of(fitting_->status()); state != sent_) {
        sent_ = state;
        if (state != "null") audience_.send_progress("the figure", "done", 1);
        on_status();
    }
    const auto bytes = fitting_->frame();
    if (bytes == nullptr) return;
    audience_.stream(bytes);
}
#else
void Wardrobe::add_routes(Routes& /*routes*/) {}
nlohmann::ordered_json Wardrobe::json() const { return {{"here", false}, {"worn", nullptr}}; }
void Wardrobe::dress(const Message& /*message*/) {}
void Wardrobe::undress() {}
void Wardrobe::stream() {}
#endif

}  // namespace sqmap::viewer
