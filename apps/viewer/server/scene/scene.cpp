#include "viewer/server/scene/scene.h"

#include "io/replace_file.h"
#include "sqmap/mesh/error.h"
#include "sqmap/paper/model.h"
#include "viewer/server/scene/edits.h"
#include "viewer/server/scene/facts.h"

#include <algorithm>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t k_max_history = 64;
constexpr std::size_t k_max_removed = 16;

/// The parts after a split, a merge, a moved cut or another fit; null where that cannot be.
std::shared_ptr<const Parts> recut(const Message& m, const Object& object, const Parts& before, const Words& words)
{
    if (m.say == Say::Refit) return std::make_shared<const Parts>(refitted(object, before, m.part));
    if (m.say == Say::MoveCut) {
        auto moved = moved_cut(object, before.partition, m.part, m.other, m.distance);
        return moved ? std::make_shared<const Parts>(fitted(object, std::move(*moved), &before, words)) : nullptr;
    }
    const decompose::Cutter cutter(object.mesh);
    if (m.say == Say::Merge)
        return std::make_shared<const Parts>(fitted(object, cutter.merge(before.partition, m.part, m.other), &before, words));
    decompose::Split split = cutter.split(before.partition, m.part);
    return split.found ? std::make_shared<const Parts>(fitted(object, std::move(split.partition), &before, words)) : nullptr;
}

}  // namespace

Scene::Scene(Audience& audience, Worker& pictures, Worker& bakes, const SceneOptions& options)
    : audience_(audience), pictures_(pictures), bakes_(bakes), options_(options)
{
}

std::vector<ObjectPtr> Scene::objects() const
{
    std::vector<ObjectPtr> out;
    for (const Entry& entry : entries_) out.push_back(entry.object);
    return out;
}

std::vector<ObjectPtr> Scene::touchable(const Settings& settings) const
{
    std::vector<ObjectPtr> out = objects();
    for (std::size_t i = 0; i < out.size(); ++i)
        if (entries_[i].hidden && !(settings.tool == ToolKind::Mesh && settings.tool_object == i)) out[i] = nullptr;
    return out;
}

std::vector<Scene::Entry>::iterator Scene::entry_of(std::uint32_t id)
{
    return std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.id == id; });
}

void Scene::remove(std::uint32_t object)
{
    if (removed_.size() == k_max_removed) removed_.erase(removed_.begin());
    removed_.push_back({object, std::move(entries_[object])});
    entries_.erase(entries_.begin() + object);
    on_remove(object);
    send();
    on_objects();
}

void Scene::restore()
{
    if (removed_.empty()) return;
    if (entries_.size() >= options_.max_objects)
        return audience_.send_trouble("The scene is full: remove an object, then take this one back.");
    const std::size_t at = std::min(removed_.back().at, entries_.size());
    Entry entry = std::move(removed_.back().entry);
    removed_.pop_back();
    rename(entry, entry.object->name);  // another may have its name now
    entries_.insert(entries_.begin() + static_cast<std::ptrdiff_t>(at), std::move(entry));
    on_insert(static_cast<std::uint32_t>(at));
    send();
    on_objects();
}

/// The page moves what it has drawn, so that the revision stays unless the object turns.
void Scene::stand(Entry& entry, Vec3d position, Up up)
{
    const bool turns = up != entry.object->up;
    const auto standing = std::make_shared<Object>(*entry.object);
    standing->put_at(standing->metres_per_unit, position, up);
    if (turns) {
        standing->position.y += standing->half.y - entry.object->half.y;  // what stood on the ground stands on it again
        ++entry.revision;
    }
    entry.object = standing;
    send();
    on_objects();
}

/// The name, or with a number behind it where another object has it: two of one name could not be told apart in a list.
std::string Scene::free_name(const std::string& name, const Entry* own) const
{
    std::string out = name;
    const auto taken = [&](const Entry& e) { return &e != own && e.object->name == out; };
    for (int n = 2; std::any_of(entries_.begin(), entries_.end(), taken); ++n) out = name + " " + std::to_string(n);
    return out;
}

void Scene::rename(Entry& entry, const std::string& name)
{
    const std::string free = free_name(name, &entry);
    if (free == entry.object->name) return;
    const auto renamed = std::make_shared<Object>(*entry.object);
    renamed->name = free;
    entry.object = renamed;
}

void Scene::load(std::vector<std::function<std::shared_ptr<Object>(const BakeMeshOptions&)>> makers,
                 const std::function<void(const std::string&)>& on_failure)
{
    loading_ += makers.size();
    for (auto& make : makers)
        bakes_.work([this, make = std::move(make), on_failure] {
            try {
                const std::shared_ptr<Object> object = make(watched(options_.bake, {}));
                audience_.post([this, object] {
                    --loading_;
                    add(object);
                    send_progress({object->name}, "done");
                    send();
                    on_objects();
                });
            } catch (const std::runtime_error& e) {
                audience_.post([this] { --loading_, send(); });
                on_failure(e.what());
            }
        });
}

void Scene::edit(const Message& m)
{
    if (m.say == Say::Restore) return restore();
    if (m.object >= entries_.size()) return;
    Entry& entry = entries_[m.object];
    const std::uint32_t count = entry.parts()->partition.part_count;
    switch (m.say) {
        case Say::Undo:
            if (entry.at > 0) --entry.at, ++entry.revision;
            if (entry.renamed) refresh_names(entry);
            return send();
        case Say::Redo:
            if (entry.at + 1 < entry.history.size()) ++entry.at, ++entry.revision;
            if (entry.renamed) refresh_names(entry);
            return send();
        case Say::Remove:
            return remove(m.object);
        case Say::Hide:
            entry.hidden = m.held;
            send();
            return on_objects();
        case Say::Move:
            return stand(entry, m.target, entry.object->up);
        case Say::Turn:
            return stand(entry, entry.object->position, m.up);
        case Say::Rename:
            rename(entry, m.name);
            send();
            return on_objects();
        case Say::Bake:
            return bake_edited(entry);
        case Say::Rebake:
            return bake_twin(entry);
        case Say::Name:
            if (m.part < count && !entry.object->mesh.triangles.empty()) name_part(entry, m.part, m.name);
            return;
        default:
            break;
    }
    if (m.part >= count || ((m.say == Say::Merge || m.say == Say::MoveCut) && m.other >= count) ||
        entry.object->mesh.triangles.empty() || pictures_.busy())
        return;
    recut_later(m, entry);
}

void Scene::recut_later(const Message& m, const Entry& entry)
{
    pictures_.work([this, m, id = entry.id, object = entry.object, before = entry.parts(), words = entry.words] {
        const std::shared_ptr<const Parts> after = recut(m, *object, *before, words);
        audience_.post([this, id, before, after, say = m.say] {
            const auto at = entry_of(id);
            if (at == entries_.end() || at->parts() != before) return;  // the scene has moved on
            if (after == nullptr)
                return audience_.send_trouble(say == Say::MoveCut
                                                  ? "These parts do not touch, or too little of the other one would be left."
                                                  : "This part has nowhere to be cut.");
            change(*at, after);
        });
    });
}

void Scene::change(Entry& entry, std::shared_ptr<const Parts> parts)
{
    entry.history.resize(entry.at + 1);
    if (entry.history.size() >= k_max_history) entry.history.erase(entry.history.begin() + 1);
    entry.history.push_back(std::move(parts));
    entry.at = entry.history.size() - 1;
    ++entry.revision;
    send();
}

BakeMeshOptions SceneOptions::bake_options(bool is_paper) const
{
    BakeMeshOptions options = bake;
    if (!is_paper) options.paper_maps.reset();
    if (is_paper && !options.paper_maps) options.paper_maps.emplace();
    return options;
}

BakeMeshOptions Scene::watched(BakeMeshOptions options, const Job& job)
{
    options.bake.progress = [this, job](const char* stage, double done) {
        if (bakes_.quits()) throw Cancelled{};
        if (cancelled_.has(job.upload)) {
            audience_.post([this, job] { send_progress(job, "cancelled"); });
            throw Cancelled{};
        }
        audience_.post([this, job, text = std::string(stage), done] { send_progress(job, text, done); });
    };
    return options;
}

void Scene::send_progress(const Job& job, const std::string& stage, double done)
{
    audience_.send_progress(job.name, stage, done, job.upload);
}

void Scene::send_failure(const Job& job, const std::string& why)
{
    audience_.post([this, job, why] {
        send_progress(job, "failed");
        audience_.send_trouble(job.name + ": " + why);
    });
}

void Scene::bake_edited(const Entry& entry)
{
    if (entry.at == 0 || bakes_.busy()) return;
    bakes_.work([this, id = entry.id, object = entry.object, parts = entry.parts(), words = entry.words] {
        const BakeMeshOptions options = watched(options_.bake_options(paper::is_paper(object->view)), {object->name});
        try {
            const auto after = rebaked(*object, *parts, options, words);
            audience_.post([this, id, object, after] {
                send_progress({object->name}, "done");
                replace(id, after);
            });
        } catch (const mesh::Error& e) {
            send_failure({object->name}, e.what());
        }
    });
}

void Scene::bake_twin(const Entry& entry)
{
    const auto index = static_cast<std::size_t>(&entry - entries_.data());
    if (entry.at > 0 || entry.object->mesh.triangles.empty() || twin_of(index) || bakes_.busy() ||
        entries_.size() >= options_.max_objects)
        return;
    bakes_.work([this, object = entry.object, parts = entry.parts(), words = entry.words] {
        const bool to_paper = !paper::is_paper(object->view);
        const std::string name = object->name + (to_paper ? ", paper's maps" : ", central maps");
        const BakeMeshOptions options = watched(options_.bake_options(to_paper), {name});
        try {
            const auto twin = rebaked(*object, *parts, options, words);
            twin->name = name;
            twin->names_file.clear();
            audience_.post([this, twin] {
                send_progress({twin->name}, "done");
                add(twin);
                send();
                on_objects();
            });
        } catch (const mesh::Error& e) {
            send_failure({name}, e.what());
        }
    });
}

std::optional<std::size_t> Scene::twin_of(std::size_t entry) const
{
    const Object& object = *entries_[entry].object;
    for (std::size_t i = 0; i < entries_.size(); ++i)
        if (paper::is_paper(entries_[i].object->view) != paper::is_paper(object.view) &&
            are_of_one_mesh(object, *entries_[i].object))
            return i;
    return std::nullopt;
}

void Scene::add(std::shared_ptr<Object> object, std::uint32_t upload)
{
    std::vector<ObjectPtr> others;
    for (const Entry& entry : entries_) others.push_back(entry.object);
    put_beside(*object, others);
    object->name = free_name(object->name, nullptr);
    Entry entry;
    entry.history.push_back(std::make_shared<const Parts>(object->parts));
    entry.words = object->words;
    entry.id = next_id_++;
    entry.upload = upload;
    entry.object = std::move(object);
    entries_.push_back(std::move(entry));
}

/// An object that was moved or renamed meanwhile stays so.
void Scene::replace(std::uint32_t id, std::shared_ptr<Object> after)
{
    if (const auto entry = entry_of(id); entry != entries_.end()) {
        const Object& now = *entry->object;
        after->put_at(now.metres_per_unit, now.position, now.up);
        after->name = now.name;
        entry->history = {std::make_shared<const Parts>(after->parts)};
        entry->at = 0;
        ++entry->revision;
        entry->object = std::move(after);
    }
    send();
    on_objects();
}

bool Scene::rearrange(std::span<const std::pair<ObjectPtr, ObjectPtr>> copies)
{
    const auto entry_with = [this](const ObjectPtr& object) {
        return std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.object == object; });
    };
    for (const auto& [before, after] : copies)
        if (entry_with(before) == entries_.end()) return false;
    for (const auto& [before, after] : copies) {
        Entry& entry = *entry_with(before);
        entry.object = after;
        ++entry.revision;
    }
    if (!copies.empty()) send(), on_objects();
    return true;
}

void Scene::name_part(Entry& entry, std::uint32_t part, const std::string& name)
{
    set_words(entry, renamed(entry.words, entry.object->mesh, entry.parts()->partition, part, name, entry.object->frame()));
}

/// Names are of surface points, not of parts: undo does not take them back. The step that is shown gets them now, another when it
/// is shown.
void Scene::refresh_names(Entry& entry)
{
    auto named = std::make_shared<Parts>(*entry.parts());
    named->names = part_names(entry.object->mesh, entry.object->dual, named->partition, named->superquadrics, entry.words,
                              entry.object->frame());
    entry.history[entry.at] = std::move(named);
}

void Scene::set_words(Entry& entry, const Words& words)
{
    entry.words = words;
    entry.renamed = true;
    refresh_names(entry);
    if (!entry.object->names_file.empty()) {
        const std::string text = names_json(words).dump(1) + "\n";
        try {
            io::replace_file(entry.object->names_file, std::as_bytes(std::span(text)));
        } catch (const std::exception& e) {
            audience_.send_trouble(std::string("The names are not kept: ") + e.what());
        }
    }
    send();
}

void Scene::send() { audience_.send_all(json()); }

nlohmann::ordered_json Scene::json() const
{
    ordered_json out{{"say", "scene"}, {"objects", ordered_json::array()}, {"loading", loading_}};
    out["removed"] = removed_.empty() ? ordered_json() : ordered_json(removed_.back().entry.object->name);
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        const Entry& entry = entries_[i];
        ordered_json facts = facts_json(*entry.object, *entry.parts(), entry.at > 0);
        facts["id"] = entry.id;
        facts["upload"] = entry.upload;
        const std::optional<std::size_t> twin = twin_of(i);
        facts["twin"] = twin ? ordered_json(*twin) : ordered_json();
        facts["namesKept"] = !entry.object->names_file.empty();
        facts["revision"] = entry.revision;
        facts["hidden"] = entry.hidden;
        facts["canUndo"] = entry.at > 0;
        facts["canRedo"] = entry.at + 1 < entry.history.size();
        out["objects"].push_back(std::move(facts));
    }
    return out;
}

}  // namespace sqmap::viewer
