// Dressing as the pages steer it: the figure is made at the first wish and kept for the next.
#pragma once

#include "viewer/server/http/audience.h"
#include "viewer/server/http/routes.h"
#include "viewer/server/jobs/worker.h"
#include "viewer/server/protocol/messages.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>

namespace sqmap::viewer {

class Fitting;
struct OwnAvatar;

/// All is called on the server's thread. Where the program was built without cloth, nothing happens.
class Wardrobe {
public:
    /// pictures: where a figure that nobody wants any more comes to its end. Both must outlive this.
    Wardrobe(Audience& audience, Worker& pictures) : audience_(audience), pictures_(pictures) {}

    std::function<void()> on_status = [] {};  ///< something that json() says has changed

    /// Adds /api/fitting, and /api/avatar: a glTF file's bytes; none: the page's own figure again.
    void add_routes(Routes& routes);
    /// Fit, Cloth or Undress.
    void dress(const Message& message);
    void undress();
    /// Sends the newest frame of the cloth, where there is one.
    void stream();
    void end() { fitting_.reset(); }

    /// {here: the program has cloth, worn}
    [[nodiscard]] nlohmann::ordered_json json() const;

private:
    void wear(std::shared_ptr<const OwnAvatar> own);

    Audience& audience_;
    Worker& pictures_;
    std::shared_ptr<Fitting> fitting_;  ///< shared, so that a program without cloth need not know how to destroy one
    std::shared_ptr<const OwnAvatar> own_;
    std::string sent_;
};

}  // namespace sqmap::viewer
