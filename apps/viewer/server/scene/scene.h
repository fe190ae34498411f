// The objects that the page shows: their edits, their names, what is baked of them.
#pragma once

#include "viewer/server/http/audience.h"
#include "viewer/server/jobs/cancellations.h"
#include "viewer/server/jobs/worker.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/load.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::viewer {

struct SceneOptions {
    double size = 0.2;  ///< m, that R_max of every object becomes
    BakeMeshOptions bake{};
    std::size_t max_objects = 16;
    io::ReadLimits limits{.max_bytes = 64u << 20, .max_faces = 500'000};  ///< of an uploaded mesh

    /// Options of a bake with the paper's maps or central ones.
    [[nodiscard]] BakeMeshOptions bake_options(bool is_paper) const;
};

/// All is called on the server's thread.
class Scene {
public:
    /// An object and its edits, newest last; the first are the model's own parts.
    struct Entry {
        ObjectPtr object;
        std::vector<std::shared_ptr<const Parts>> history;
        std::size_t at = 0;
        std::uint32_t revision = 0;  ///< grows with every change of what the page shows
        std::uint32_t id = 0;        ///< no other object of this program has it
        std::uint32_t upload = 0;    ///< the page's number of the file that it came from; 0: from none
        Words words;                 ///< what its parts are called; edits of parts keep it
        bool renamed = false;        ///< since it was opened: steps of the history may have other names
        bool hidden = false;         ///< neither seen nor touched
        [[nodiscard]] std::shared_ptr<const Parts> parts() const { return history[at]; }
    };

    /// pictures: does what takes part of a second; bakes: what takes longer. Both end before the scene.
    Scene(Audience& audience, Worker& pictures, Worker& bakes, const SceneOptions& options);

    std::function<void()> on_objects = [] {};                    ///< there are others than before
    std::function<void(std::uint32_t)> on_remove = [](auto) {};  ///< this one is gone; those behind it move up
    std::function<void(std::uint32_t)> on_insert = [](auto) {};  ///< one stands at this number; those from it on have moved down

    void add(std::shared_ptr<Object> object, std::uint32_t upload = 0);
    /// Makes objects one after the other on the worker's thread; the pages are sent the number of those to come. on_failure: gets
    /// the reason where one cannot be made, on the worker's thread.
    void load(std::vector<std::function<std::shared_ptr<Object>(const BakeMeshOptions&)>> makers,
              const std::function<void(const std::string&)>& on_failure);
    /// Does an act on an object, from Split to Rename; one that does not fit the scene of now is passed over.
    void edit(const Message& message);
    /// Mesh, model or names: answers with the verdict, then adds the object. The page numbers its uploads, to cancel them.
    void upload(HttpRequest request, const Answer& answer);

    /// Objects give way to copies of themselves that stand elsewhere. False, and nothing is changed, where the first of some pair
    /// is no longer there.
    bool rearrange(std::span<const std::pair<ObjectPtr, ObjectPtr>> copies);

    /// An upload, whether it is being baked or still waits; once its object stands, nothing happens.
    void cancel(std::uint32_t upload) { cancelled_.add(upload); }

    [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
    [[nodiscard]] std::vector<ObjectPtr> objects() const;
    /// The same, null where one is hidden that is not the tool.
    [[nodiscard]] std::vector<ObjectPtr> touchable(const Settings& settings) const;
    /// The first object of the same mesh and the other projection; nothing where there is none.
    [[nodiscard]] std::optional<std::size_t> twin_of(std::size_t entry) const;
    [[nodiscard]] nlohmann::ordered_json json() const;
    void send();  ///< all pages

private:
    /// The name of an object that is baked, and the upload that it comes from.
    struct Job {
        std::string name;
        std::uint32_t upload = 0;
    };

    /// A removed object and its number in the scene.
    struct Removed {
        std::size_t at = 0;
        Entry entry;
    };

    [[nodiscard]] std::vector<Entry>::iterator entry_of(std::uint32_t id);
    void remove(std::uint32_t object);
    void restore();
    void stand(Entry& entry, Vec3d position, Up up);
    void rename(Entry& entry, const std::string& name);
    void recut_later(const Message& message, const Entry& entry);
    void change(Entry& entry, std::shared_ptr<const Parts> parts);
    void bake_edited(const Entry& entry);
    void bake_twin(const Entry& entry);
    void replace(std::uint32_t id, std::shared_ptr<Object> after);
    [[nodiscard]] std::string free_name(const std::string& name, const Entry* own) const;
    void name_part(Entry& entry, std::uint32_t part, const std::string& name);
    void set_words(Entry& entry, const Words& words);
    static void refresh_names(Entry& entry);
    [[nodiscard]] HttpReply take_names(const std::string& file, const std::string& text);
    // On the worker's thread.
    void take_model(const Job& job, std::span<const std::byte> bytes, const Answer& answer);
    void take_mesh(const Job& job, AdmittedMesh loaded, const BakeMeshOptions& options, const Answer& answer);
    /// Options with the job's progress: a bake that the page takes back, or a server that quits, ends there.
    [[nodiscard]] BakeMeshOptions watched(BakeMeshOptions options, const Job& job);
    void send_progress(const Job& job, const std::string& stage, double done = 1);
    void send_failure(const Job& job, const std::string& why);

    Audience& audience_;
    Worker &pictures_, &bakes_;
    SceneOptions options_;
    std::vector<Entry> entries_;
    std::vector<Removed> removed_;  ///< newest last
    std::uint32_t next_id_ = 1;
    std::size_t loading_ = 0;  ///< objects that are still to come
    Cancellations cancelled_;
};

}  // namespace sqmap::viewer
