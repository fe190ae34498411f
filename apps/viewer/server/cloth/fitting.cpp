#include "viewer/server/cloth/fitting.h"

#include "common/dress/avatar.h"
#include "common/dress/costumes.h"
#include "common/dress/handling.h"
#include "common/dress/tool.h"
#include "sqmap/sim/cloth.h"
#include "viewer/server/cloth/slit.h"
#include "viewer/server/jobs/temporary_file.h"
#include "viewer/server/protocol/bytes.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <fstream>
#include <mutex>
#include <thread>

namespace sqmap::viewer {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double k_height = 1.75, k_rate = app::k_cloth_rate;  // m, steps a second
constexpr double k_max_behind = 0.1;                           // s: what is later is left out, and the cloth moves slowly
constexpr double k_max_pull = 30;                              // N, of the hand on the cloth
constexpr double k_grip = 0.02, k_pin = 0.02;                  // m about a point that is taken or pinned
constexpr double k_near_body = 0.06;                           // m: a pin goes into the body up to there, else into the air
constexpr int k_niceness = 10;                                 // the servo and the page come first
constexpr std::uint32_t k_vertices = 3000;
constexpr std::size_t k_max_seams = 24;  // cuts are seams that are open

/// Numbers of garments go on through all figures: a page knows by them that it has to fetch new shapes.
std::atomic<std::uint32_t> garments_yet{0};

/// The closing of a program ends the baking of the figure.
struct Ended {};

}  // namespace

struct Fitting::Work {
    std::function<void(double)> progress;
    std::function<void(const std::string&)> trouble;
    OwnAvatar own;

    std::mutex mutex;  // of what follows
    std::deque<Message> messages;
    std::shared_ptr<const std::string> newest, shape;
    nlohmann::ordered_json state;
    std::condition_variable wake;
    std::atomic<bool> quit{false}, made{false};

    // The thread's own.
    app::Avatar avatar;
    std::vector<sqmap::Pose> poses;
    std::vector<sim::Collider> solids;
    app::Costume worn;
    sim::Fabric fabric{};
    std::string garment_name, fabric_name;
    std::unique_ptr<sim::Cloth> cloth;
    std::vector<std::uint8_t> sewn;
    std::vector<std::uint32_t> pinned;
    double pose_time = 0;
    bool walks = false, held = false;
    std::unique_ptr<app::ClothTool> tool;  // the pointer's tip, which stops at the body
    sqmap::Pose pointed;
    app::ToolForces forces;
    std::uint32_t number = 0, frames = 0;

    std::thread thread;  // last

    void run();
    [[nodiscard]] app::Avatar make_avatar();
    [[nodiscard]] app::Costume costume() const;
    [[nodiscard]] std::uint32_t waist_joint() const;
    void dress(bool anew, std::vector<Vec3d> start = {});
    void cut(const std::vector<ClothPoint>& line);
    void publish_shapes();
    void take(const Message& m);
    void pose(bool first);
    void drag();
    void publish(const sim::StepReport& report, double speed, double step_ms);
    void say_state();
    [[nodiscard]] std::vector<std::uint32_t> within(std::uint32_t node, double radius) const;
    [[nodiscard]] std::uint32_t bone_near(Vec3d p, double within = k_near_body) const;
};

void Fitting::Work::pose(bool first)
{
    avatar.pose(pose_time, poses);
    for (std::size_t p = 0; p < poses.size(); ++p) {
        solids[p].previous = first ? poses[p] : solids[p].pose;
        solids[p].pose = poses[p];
    }
}

/// The tip goes where the pointer is, at 1 kHz and not into the body, and takes the cloth along.
void Fitting::Work::drag()
{
    constexpr int k_ticks = 8;
    const app::ToolScene scene = tool->scene(solids, cloth.get(), forces.tip, pointed.translation);
    for (int i = 0; i < k_ticks; ++i) forces = tool->tick(scene, pointed, 1 / (k_rate * k_ticks));
    // At the greatest pull the hand follows the cloth, as a person's does.
    if (const double pull = norm(forces.cloth); pull > k_max_pull) {
        forces.tip += ((1 - k_max_pull / pull) / app::ClothTool::k_stiffness) * forces.cloth;
        forces.cloth = (k_max_pull / pull) * forces.cloth;
    }
    cloth->drag(forces.tip);
}

/// anew: in the pattern's own position on a figure with stretched arms; else in the folds of now, or of `start`.
void Fitting::Work::dress(bool anew, std::vector<Vec3d> start)
{
    sim::Garment garment = worn.garment;
    if (anew || cloth == nullptr) {
        pose_time = 0;
        pose(true);
    } else {
        if (start.empty()) start.assign(cloth->positions().begin(), cloth->positions().end());
        garment.start = std::move(start);
    }
    for (std::size_t s = 0; s < sewn.size() && !anew; ++s) garment.seams[s].sewn = sewn[s] != 0;
    cloth = std::make_unique<sim::Cloth>(garment, fabric, sim::ClothOptions{.iterations = app::k_cloth_shares});
    cloth->expect(avatar.skin->lattice);
    held = false;
    if (anew) {
        pinned.clear();
        sewn.clear();
        for (const sim::Seam& s : garment.seams) sewn.push_back(s.sewn ? 1 : 0);
    }
    if (!worn.waist_bone.empty()) {
        const std::uint32_t joint = waist_joint();
        cloth->pin(worn.garment.waist, joint, joint == sim::Cloth::k_world ? sqmap::Pose{} : poses[joint]);
    }
    for (const std::uint32_t n : pinned) {
        const std::uint32_t bone = bone_near(cloth->positions()[n]);
        cloth->pin({&n, 1}, bone, bone == sim::Cloth::k_world ? sqmap::Pose{} : poses[bone]);
    }
    if (anew) publish_shapes();
}

void Fitting::Work::publish_shapes()
{
    number = ++garments_yet;
    const app::SkinnedBody& body = *avatar.skin;
    Bytes out("SQC2");
    for (const std::size_t n : {static_cast<std::size_t>(number), body.maps.size(), cloth->size(), cloth->triangles().size(),
                                body.drawn.size(), body.bound.triangles.size()})
        out.count(n);
    for (const Vec3d& v : body.drawn) out.point(cast<float>(v));
    for (const auto& t : body.bound.triangles)
        for (const std::uint32_t v : t) out.put(v);
    for (const auto& joints : body.influences.joints)
        for (const std::uint16_t j : joints) out.count(j);
    for (const auto& weights : body.influences.weights)
        for (const double w : weights) out.put(static_cast<float>(w));
    for (const auto& t : cloth->triangles())
        for (const std::uint32_t v : t) out.put(v);
    for (const Vec3d& v : worn.garment.flat) out.point(cast<float>(v));
    const std::lock_guard lock(mutex);
    shape = std::make_shared<const std::string>(out.take());
}

void Fitting::Work::cut(const std::vector<ClothPoint>& line)
{
    if (worn.garment.seams.size() >= k_max_seams) return trouble("It has been cut often enough: start again.");
    int cuts = 1;
    for (const sim::Seam& s : worn.garment.seams) cuts += s.name.starts_with("cut ") ? 1 : 0;
    auto after = slit(worn.garment, cloth->positions(), line, "cut " + std::to_string(cuts));
    if (!after) return trouble("Nothing was cut: the line is too short.");
    const auto before = static_cast<std::uint32_t>(cloth->size());
    worn.garment = std::move(after->garment);
    sewn.push_back(0);
    const std::size_t pins = pinned.size();
    for (std::uint32_t i = 0; i < after->from.size(); ++i)
        if (std::find(pinned.begin(), pinned.begin() + static_cast<std::ptrdiff_t>(pins), after->from[i]) !=
            pinned.begin() + static_cast<std::ptrdiff_t>(pins))
            pinned.push_back(before + i);
    dress(false, std::move(after->positions));
    publish_shapes();
}

std::vector<std::uint32_t> Fitting::Work::within(std::uint32_t node, double radius) const
{
    const auto at = cloth->positions();
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < at.size(); ++i)
        if (norm(at[i] - at[node]) <= radius) out.push_back(i);
    return out;
}

/// The collider that carries what is pinned at a point: the joint that moves the skin there most; the world where the skin is
/// far.
std::uint32_t Fitting::Work::bone_near(Vec3d p, double within) const
{
    const app::SkinnedBody& body = *avatar.skin;
    std::uint32_t best = sim::Cloth::k_world;
    double least = within * within;
    const std::vector<Vec3d> now = body.posed();
    for (std::size_t v = 0; v < now.size(); ++v) {
        if (!(norm_sq(now[v] - p) < least)) continue;
        least = norm_sq(now[v] - p);
        const auto& w = body.influences.weights[v];
        const auto largest = static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin());
        best = static_cast<std::uint32_t>(avatar.parts.size()) + body.influences.joints[v][largest];
    }
    return best;
}

void Fitting::Work::take(const Message& m)
{
    if (m.say == Say::Undress) {
        cloth.reset();
        garment_name = fabric_name = "";
        return;
    }
    if (m.say == Say::Fit) {
        const bool anew = m.garment != garment_name;
        const bool other = anew || m.fabric != fabric_name;
        garment_name = m.garment;
        fabric_name = m.fabric;
        walks = m.walks;
        if (other) {
            fabric = sim::fabric(fabric_name);
            if (anew) worn = costume();
            dress(anew);
        }
        return;
    }
    if (cloth == nullptr) return;
    switch (m.handling) {
        case Handling::Grasp: {
            // It is taken where it is: the point that was pointed at may have moved since.
            const std::uint32_t node = app::nearest_vertex(*cloth, m.target);
            if (norm(cloth->positions()[node] - m.target) > 0.1) return;
            pointed.translation = forces.tip = cloth->positions()[node];
            cloth->grasp(node, k_grip, forces.tip, app::ClothTool::k_stiffness);
            tool = std::make_unique<app::ClothTool>(solids);
            held = true;
            break;
        }
        case Handling::Drag:
            if (held) pointed.translation = m.target;
            break;
        case Handling::Release:
            if (held) cloth->release();
            held = false;
            break;
        case Handling::Pin: {
            const std::uint32_t node = app::nearest_vertex(*cloth, m.target);
            if (norm(cloth->positions()[node] - m.target) > 0.1) return;
            const std::vector<std::uint32_t> nodes = within(node, k_pin);
            const std::uint32_t bone = bone_near(cloth->positions()[node]);
            cloth->pin(nodes, bone, bone == sim::Cloth::k_world ? sqmap::Pose{} : poses[bone]);
            for (const std::uint32_t n : nodes)
                if (std::find(pinned.begin(), pinned.end(), n) == pinned.end()) pinned.push_back(n);
            break;
        }
        case Handling::Unpin:
            cloth->unpin(pinned);
            pinned.clear();
            break;
        case Handling::Cut:
        case Handling::Sew:
            if (m.part >= cloth->seams()) return;
            m.handling == Handling::Sew ? cloth->sew(m.part) : cloth->cut(m.part);
            sewn[m.part] = m.handling == Handling::Sew ? 1 : 0;
            break;
        case Handling::Slit:
            cut(m.line);
            break;
        case Handling::Restart:
            worn = costume();  // whole again
            dress(true);
            break;
    }
}

void Fitting::Work::say_state()
{
    if (cloth == nullptr) {
        const std::lock_guard lock(mutex);
        state = nullptr;
        shape = newest = nullptr;
        return;
    }
    nlohmann::ordered_json out{
        {"garment", garment_name}, {"fabric", fabric_name}, {"walks", walks}, {"pinned", pinned.size()}, {"number", number}};
    out["seams"] = nlohmann::ordered_json::array();
    for (std::size_t s = 0; s < sewn.size(); ++s)
        out["seams"].push_back({{"name", worn.garment.seams[s].name}, {"sewn", sewn[s] != 0}});
    const std::lock_guard lock(mutex);
    state = std::move(out);
}

void Fitting::Work::publish(const sim::StepReport& report, double speed, double step_ms)
{
    std::vector<float> out{2.f,
                           static_cast<float>(frames++ & 0xffff),
                           static_cast<float>(cloth->size()),
                           static_cast<float>(avatar.skin->maps.size()),
                           static_cast<float>(report.status),
                           static_cast<float>(speed),
                           static_cast<float>(step_ms)};
    const Vec3d tension = held ? forces.cloth : Vec3d{}, body = held ? forces.body : Vec3d{};
    double gap = 0;
    for (std::size_t s = 0; s < cloth->seams(); ++s) gap = std::max(gap, cloth->gap(s));
    for (const double x :
         {tension.x, tension.y, tension.z, report.fastest, static_cast<double>(report.contacts), gap,
          static_cast<double>(pinned.size()), held ? 1.0 : 0.0, static_cast<double>(number), body.x, body.y, body.z})
        out.push_back(static_cast<float>(x));
    for (const Affine& map : avatar.skin->maps) {
        for (const Vec3d& row : map.linear.row)
            for (int c = 0; c < 3; ++c) out.push_back(static_cast<float>(row[c]));
        for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(map.shift[k]));
    }
    for (const Vec3d& p : cloth->positions())
        for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(p[k]));
    auto bytes = std::make_shared<std::string>(4 * out.size(), '\0');
    std::memcpy(bytes->data(), out.data(), bytes->size());
    const std::lock_guard lock(mutex);
    newest = std::move(bytes);
}

/// A garment of the person, for a figure of another height.
app::Costume Fitting::Work::costume() const
{
    app::Costume out = app::costume(garment_name, k_vertices);
    const double scale = avatar.height / k_height;
    for (std::vector<Vec3d>* points : {&out.garment.start, &out.garment.flat})
        for (Vec3d& p : *points) p = scale * p;
    return out;
}

/// The collider that a waist rides: the joint of that name; of an own avatar the one that moves the skin nearest to it.
std::uint32_t Fitting::Work::waist_joint() const
{
    for (std::uint32_t j = 0; j < avatar.joints.size(); ++j)
        if (avatar.joints[j] == worn.waist_bone) return static_cast<std::uint32_t>(avatar.parts.size()) + j;
    Vec3d middle{};
    for (const std::uint32_t v : worn.garment.waist)
        middle += worn.garment.start[v] / static_cast<double>(worn.garment.waist.size());
    return bone_near(middle, avatar.height);
}

app::Avatar Fitting::Work::make_avatar()
{
    if (!own.bytes.empty()) {
        const TemporaryFile file("avatar.glb");
        std::ofstream(file.path(), std::ios::binary) << own.bytes;
        const auto read = [&](bool moves) { return app::skinned_avatar(file.path(), moves, "", app::k_figure_error); };
        try {
            try {
                return read(true);
            } catch (const app::AvatarError&) {
                return read(false);  // one without an animation stands
            }
        } catch (const std::exception& e) {
            std::string why = e.what();
            const std::string path = file.path().string();
            for (std::size_t at = why.find(path); at != std::string::npos; at = why.find(path, at + own.name.size()))
                why.replace(at, path.size(), own.name);
            trouble(why + ". The page's own figure is dressed instead.");
        }
    }
    return app::walking_avatar(k_height, {}, app::k_figure_spacing, app::k_figure_error,
                               [this, said = ~std::size_t{0}](std::size_t done, std::size_t of) mutable {
                                   if (quit) throw Ended{};
                                   if (done != said) progress(static_cast<double>(done) / static_cast<double>(of));
                                   said = done;
                               });
}

void Fitting::Work::run()
{
    (void)::setpriority(PRIO_PROCESS, 0, k_niceness);  // of this thread alone, as Linux has it
    avatar = make_avatar();
    poses.resize(avatar.parts.size() + avatar.joints.size());
    solids.resize(poses.size());
    solids[0].model = &avatar.parts[0].model;
    solids[0].skin = avatar.skin->moving.get();
    pose(true);
    made = true;
    Clock::time_point next = Clock::now(), since = next;
    double simulated = 0, speed = 1, step_ms = 0;
    while (!quit) {
        std::deque<Message> now;
        {
            std::unique_lock lock(mutex);
            if (cloth == nullptr) wake.wait(lock, [this] { return quit || !messages.empty(); });
            now.swap(messages);
        }
        for (const Message& m : now) take(m);
        if (!now.empty()) say_state();
        if (cloth == nullptr) {
            next = since = Clock::now();
            continue;
        }
        sim::StepReport report;
        std::uint32_t status = 0;
        double seconds = 0;
        for (int i = 0; i < app::k_steps_a_frame; ++i) {
            if (walks) pose_time += 1 / k_rate;
            pose(false);
            if (held) drag();
            report = cloth->step(1 / k_rate, solids);
            status |= report.status;
            const sim::StepTime& s = report.seconds;
            seconds += s.predict + s.move + s.query + s.response + s.threads + s.self;
        }
        (void)cloth->settle(solids);
        report.status = status;
        simulated += app::k_steps_a_frame / k_rate;
        step_ms += 0.1 * (1e3 * seconds / app::k_steps_a_frame - step_ms);
        if (const double real = std::chrono::duration<double>(Clock::now() - since).count(); real > 0.5) {
            speed = simulated / real;
            simulated = 0;
            since = Clock::now();
        }
        publish(report, speed, step_ms);
        next += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(app::k_steps_a_frame / k_rate));
        const auto t = Clock::now();
        if (next < t - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(k_max_behind))) next = t;
        std::this_thread::sleep_until(next);
    }
}

Fitting::Fitting(std::function<void(double)> progress, std::function<void(const std::string&)> trouble, OwnAvatar own)
    : work_(std::make_unique<Work>())
{
    work_->progress = std::move(progress);
    work_->trouble = std::move(trouble);
    work_->own = std::move(own);
    work_->thread = std::thread([w = work_.get()] {
        try {
            w->run();
        } catch (const Ended&) {
        } catch (const std::exception& e) {
            w->trouble(e.what());
        }
    });
}

Fitting::~Fitting()
{
    {
        const std::lock_guard lock(work_->mutex);
        work_->quit = true;
    }
    work_->wake.notify_all();
    work_->thread.join();
}

void Fitting::send(const Message& message)
{
    const std::lock_guard lock(work_->mutex);
    // A drag says where the hand is now: only the newest matters.
    const auto drags = [](const Message& m) { return m.say == Say::Cloth && m.handling == Handling::Drag; };
    if (drags(message) && !work_->messages.empty() && drags(work_->messages.back()))
        work_->messages.back() = message;
    else if (work_->messages.size() < 64)
        work_->messages.push_back(message);
    work_->wake.notify_all();
}

bool Fitting::ready() const { return work_->made; }

std::shared_ptr<const std::string> Fitting::frame()
{
    const std::lock_guard lock(work_->mutex);
    return std::exchange(work_->newest, nullptr);
}

std::shared_ptr<const std::string> Fitting::shapes()
{
    const std::lock_guard lock(work_->mutex);
    return work_->shape;
}

nlohmann::ordered_json Fitting::status()
{
    const std::lock_guard lock(work_->mutex);
    return work_->state;
}

}  // namespace sqmap::viewer
