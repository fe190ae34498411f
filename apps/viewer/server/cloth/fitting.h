// The costume designer's view (section 7): a figure dressed live, in a thread of its own, never in the servo.
#pragma once

#include "viewer/server/protocol/messages.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>

namespace sqmap::viewer {

/// An avatar as it came: glTF, binary or with its buffers inside.
struct OwnAvatar {
    std::string name;   ///< of its file
    std::string bytes;  ///< empty: there is none
};

/// Runs from construction to destruction. The figure, a person on 13 bones or an own avatar, is baked first: some seconds. Where
/// an own one cannot be dressed, trouble says why and the person is taken.
class Fitting {
public:
    /// progress: called by the thread with what share of the figure is baked; trouble: with what made it end.
    Fitting(std::function<void(double)> progress, std::function<void(const std::string&)> trouble, OwnAvatar own = {});
    ~Fitting();
    Fitting(const Fitting&) = delete;
    Fitting& operator=(const Fitting&) = delete;

    // Any thread.
    /// Say::Fit, Say::Cloth or Say::Undress; after the last the figure waits for another garment. Another fabric goes on in the
    /// folds that are there; another garment starts anew.
    void send(const Message& message);
    /// The newest frame, once; null where there is none since. 32-bit floats: 2, frame, #vertices, #bones, StepReport::status
    /// bits, seconds simulated a second, ms of CPU time a step, tension on the tool (3, N), speed of the fastest vertex (m/s),
    /// #contacts, largest distance of a pair of any seam, m (0 where none), #pinned, held (0 or 1), garment's number; then 12 a
    /// bone (rows of its map from rest, shift); 3 a vertex, m.
    [[nodiscard]] std::shared_ptr<const std::string> frame();
    /// "SQC2", garment's number, #bones, #vertices, #triangles of the cloth, #vertices, #triangles of the figure; the figure's
    /// positions at rest, corners, four bones a vertex, four weights a vertex; the cloth's corners; its flat pattern (3 floats a
    /// vertex). Null before there is any.
    [[nodiscard]] std::shared_ptr<const std::string> shapes();
    /// The figure is made: messages take effect at once.
    [[nodiscard]] bool ready() const;
    /// {garment, fabric, walks, seams: [{name, sewn}], pinned}; null before there is any.
    [[nodiscard]] nlohmann::ordered_json status();

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace sqmap::viewer
