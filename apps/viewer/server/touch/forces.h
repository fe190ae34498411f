// A tool over objects: what turns poses into forces, in the servo and when a recording is computed again.
#pragma once

#include "sqmap/haptic/step.h"
#include "sqmap/haptic/texture.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/paper/model.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/object.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::viewer {

/// Settings that the next tick can take.
struct Live {
    std::optional<query::Layer> layer{};
    double tolerance = 0, stiffness = 0, damping = 0;
    Friction law = Friction::Coulomb;
    double friction = 0, f_c = 0, k_f = 0;
    std::uint32_t number = 0;  ///< how many such settings came before these
};

/// The part of the settings that a tick can take.
[[nodiscard]] Live live_of(const Settings& settings, std::uint32_t number);

/// A tick of the tool's one zone, as far as forces depend on it.
struct ForceInput {
    sqmap::Pose pose{};
    haptic::Twist twist{};
    double dt = 0;
    bool has_twist = false, degraded = false;
};

/// The paper's force is that of its own maps: whether all objects have them; null ones do not count.
[[nodiscard]] bool has_paper_force(std::span<const ObjectPtr> objects);

class Forces {
public:
    /// Findings of the newest tick. Old planes give a force but do not say what is touched: a degraded tick changes the body
    /// alone.
    struct Found {
        double depth = 0;  ///< m, of a proxy the stretch of its spring, else the deepest point
        std::uint32_t contacts = 0;
        Vec3d point{}, normal{};
        sqmap::Pose body{};  ///< of what is drawn: with a proxy not the device's
    };

    /// An object that is held as the tool (settings) is not there to be touched. The paper's force counts where all others are of
    /// a paper model.
    Forces(std::vector<ObjectPtr> objects, const Settings& settings);
    Forces(const Forces&) = delete;
    Forces& operator=(const Forces&) = delete;

    // Real-time safe.
    void adjust(const Live& live) noexcept;
    haptic::StepResult step(const ForceInput& input, haptic::Wrench& wrench) noexcept;
    [[nodiscard]] const haptic::ZoneReport& report() const noexcept { return state_->report(0); }
    [[nodiscard]] const Found& found() const noexcept { return found_; }
    /// J that a stiffer spring under load has gained in the newest tick: for haptic::SafetyInput::stiffened.
    [[nodiscard]] double stiffened() const noexcept { return stiffened_; }

    [[nodiscard]] const std::vector<ObjectPtr>& objects() const noexcept { return objects_; }  ///< null: held as the tool

    // Any thread: what the servo changes is not read.
    [[nodiscard]] std::span<const Vec3d> points() const noexcept { return tool_.points(); }  ///< of the tool, its own frame, m
    [[nodiscard]] const query::Probe& probe() const noexcept { return tool_.probe(); }       ///< the same points
    /// The layer that answers with such settings.
    [[nodiscard]] query::Layer layer_of(const Live& live) const noexcept;

private:
    void read_objects(const paper::QueryOptions& options);
    /// Brings the spring nearer to the stiffness that is set. Returns the stiffness before.
    double stiffen(double dt) noexcept;

    std::vector<ObjectPtr> objects_;
    std::vector<std::unique_ptr<paper::Reading>> readings_;  ///< of paper models
    std::vector<model::ModelView> metres_;                   ///< of the objects that are touched
    std::vector<query::Probe> surfaces_;                     ///< of those whose edges touch
    std::vector<haptic::TouchedBody> solids_;
    bool doubtful_ = false;  ///< layers below the exact one give wrong verdicts on some object
    bool patch_ = false;     ///< a hand or a mesh, or the paper's force
    bool proxy_ = false;
    bool paper_force_ = false;  ///< of the maps, doubtful or not
    std::vector<float> texture_values_;
    haptic::Texture texture_{};
    haptic::Tool tool_;
    std::unique_ptr<haptic::State> state_;
    double wanted_ = 0;       ///< N/m, that is set
    double stiffened_ = 0;    ///< J
    double force_limit_ = 0;  ///< N
    Found found_{};
};

}  // namespace sqmap::viewer
