// Complete contacts: vertices by the exact layer, edges and faces by all pairs of triangles that meet, each decided exactly.
#include "sqmap/query/contacts.h"

#include "candidates.h"
#include "crossing_rows.h"
#include "manifold.h"
#include "own_part.h"
#include "separating_axes.h"
#include "supports.h"

#include "math/union_find.h"

#include <algorithm>
#include <bit>

namespace sqmap::query {

namespace {

/// The kinds of things that keys of the workspace's table name.
enum class Key : std::uint64_t { EdgeOfA, EdgeOfB, EdgePair, Vertex, ContactOfEdges, ContactOfVertex };

std::uint64_t key_of(Key kind, std::uint32_t first, std::uint32_t second)
{
    static_assert(3 * TriangleTree::k_max < std::size_t{1} << 30);
    return static_cast<std::uint64_t>(kind) << 60 | std::uint64_t{first} << 30 | second;
}

Vec3d turned(const Pose& pose, Vec3d direction) { return pose.rotation * direction; }

}  // namespace

Affine b_in_a(const Body& a, const Body& b) noexcept
{
    const Pose pose = compose(inverse(a.pose), b.pose);
    return {pose.rotation, pose.translation};
}

class ContactQuery {
public:
    ContactQuery(const Body& a, const Body& b, const ContactOptions& options, ContactWorkspace& workspace) noexcept
        : a_(a), b_(b), options_(options), workspace_(workspace), b_in_a_(b_in_a(a, b))
    {
    }

    ContactResult run() noexcept
    {
        if (!is_finite(a_.pose) || !is_finite(b_.pose)) {
            result_.status |= k_not_finite;
            return result_;
        }
        if (++workspace_.round_ == 0) {  // once in four thousand million queries
            for (ContactWorkspace::Entry& e : workspace_.table_) e.round = 0;
            workspace_.round_ = 1;
        }
        add_vertices(a_, b_, Side::B);
        if (!is_done()) add_vertices(b_, a_, Side::A);
        if (!is_done()) add_meetings();
        if (!is_done()) {
            if (options_.supports) add_supports();
            finish_regions();
        }
        result_.contacts = std::span(workspace_.contacts_).first(count_);
        return result_;
    }

private:
    using Meeting = ContactWorkspace::Meeting;

    [[nodiscard]] bool is_done() const { return options_.first_only && result_.found > 0; }

    void add(const SurfaceContact& contact)
    {
        ++result_.found;
        if (count_ < workspace_.contacts_.size())
            workspace_.contacts_[count_++] = contact;
        else
            result_.status |= k_full;
    }

    /// Vertices of the collider in the touched body.
    void add_vertices(const Body& touched, const Body& collider, Side vertex_of)
    {
        const ProbeResult found =
            query_probe(touched, collider, {.layer = Layer::Exact, .first_only = options_.first_only}, workspace_.found_);
        result_.status |= found.status;
        std::span<const Contact> written = found.written(workspace_.found_);
        if (options_.first_only)
            written = written.first(std::min<std::size_t>(written.size(), 1));
        else
            result_.found += found.contacts - written.size();
        for (const Contact& c : written) {
            const Vec3d surface = found.position(c), vertex = surface - static_cast<double>(c.depth) * cast<double>(c.normal);
            const bool of_b = vertex_of == Side::B;
            SurfaceContact contact{.witness = {of_b ? surface : vertex, of_b ? vertex : surface},
                                   .normal = of_b ? c.normal : -c.normal,
                                   .depth = c.depth,
                                   .certain = c.certain,
                                   .status = c.status};
            (of_b ? contact.feature_b : contact.feature_a) = Feature::Vertex;
            (of_b ? contact.index_b : contact.index_a) = c.index;
            (of_b ? contact.part_a : contact.part_b) = c.part;
            (of_b ? contact.part_b : contact.part_a) = OwnPart(collider).of_vertex(c.index);
            add(contact);
        }
    }

    void add_meetings()
    {
        if (!has_triangles(a_) || !has_triangles(b_)) {
            result_.status |= k_no_triangles;
            return;
        }
        const CandidateJob job(a_.probe->triangles(), b_.probe->triangles(), b_in_a_);
        find_candidates(
            job,
            [](void* self, std::span<const TrianglePair> pairs) noexcept {
                return static_cast<ContactQuery*>(self)->take(pairs);
            },
            this);
    }

    [[nodiscard]] Vec3d point_a(std::uint32_t i) const { return a_.probe->triangles().point(i); }
    [[nodiscard]] Vec3d point_b(std::uint32_t i) const { return apply(b_in_a_, b_.probe->triangles().point(i)); }
    [[nodiscard]] TriangleCorners corners_a(std::uint32_t t) const
    {
        const ProbeTriangle& v = a_.probe->triangles().triangle(t);
        return {point_a(v[0]), point_a(v[1]), point_a(v[2])};
    }
    [[nodiscard]] TriangleCorners corners_b(std::uint32_t t) const
    {
        const ProbeTriangle& v = b_.probe->triangles().triangle(t);
        return {point_b(v[0]), point_b(v[1]), point_b(v[2])};
    }

    bool take(std::span<const TrianglePair> pairs)
    {
        constexpr std::size_t k_block = CrossingRows::k_max;
        CrossingRows rows;
        for (; !pairs.empty(); pairs = pairs.subspan(std::min(k_block, pairs.size()))) {
            const std::span<const TrianglePair> block = pairs.first(std::min(k_block, pairs.size()));
            find_crossings(a_.probe->triangles(), b_.probe->triangles(), b_in_a_, block, rows);
            for (std::size_t i = 0; i < block.size(); ++i) {
                Crossing& crossing = rows.crossings[i];
                if ((rows.open >> i & 1u) != 0) crossing = crossing_of(corners_a(block[i].a), corners_b(block[i].b));
                if (!crossing.meets()) continue;
                meet(block[i], crossing, rows.depths[i]);
                if (is_done()) return false;
            }
        }
        return true;
    }

    void meet(const TrianglePair& pair, const Crossing& crossing, double depth)
    {
        ++result_.meetings;
        if (options_.first_only) {
            add(contact_of(separate(corners_a(pair.a), corners_b(pair.b)), pair.a, pair.b));
            return;
        }
        if (meetings_ == workspace_.meetings_.size()) {
            ++result_.found;
            result_.status |= k_full;
            return;
        }
        const auto self = static_cast<std::uint32_t>(meetings_++);
        workspace_.meetings_[self] = {pair.a, pair.b, 0, depth};
        workspace_.parents_[self] = self;
        std::uint32_t last_a = 0, last_b = 0;
        for (std::uint32_t sides = crossing.sides_a; sides != 0; sides &= sides - 1) {
            last_a = 3 * pair.a + static_cast<std::uint32_t>(std::countr_zero(sides));
            join(self, key_of(Key::EdgeOfA, edge_of(a_, last_a), pair.b));
        }
        for (std::uint32_t sides = crossing.sides_b; sides != 0; sides &= sides - 1) {
            last_b = 3 * pair.b + static_cast<std::uint32_t>(std::countr_zero(sides));
            join(self, key_of(Key::EdgeOfB, edge_of(b_, last_b), pair.a));
        }
        // In special position an edge meets several sides of the other triangle: then no single pair of edges separates the two.
        if (std::has_single_bit(crossing.sides_a) && std::has_single_bit(crossing.sides_b)) add_edges(self, last_a, last_b);
    }
    /// The number of an edge by one of its half-edges.
    static std::uint32_t edge_of(const Body& body, std::uint32_t half_edge)
    {
        return std::min(half_edge, body.probe->triangles().twin(half_edge));
    }

    /// The key's own entry of the table, or the empty one where it would be. The workspace holds tables of 1, 2, 4, ... slots one
    /// behind the other; a query takes the smallest that is enough, so most queries stay in one that the caches hold.
    ContactWorkspace::Entry& entry_of(std::uint64_t key)
    {
        for (std::size_t i = (key * 0x9e3779b97f4a7c15u) >> 20;; ++i) {
            ContactWorkspace::Entry& e = workspace_.table_[slots_ + (i & (slots_ - 1))];
            if (e.round != workspace_.round_ || e.key == key) return e;
        }
    }
    /// Twice the slots.
    void grow()
    {
        const std::size_t old = slots_;
        slots_ *= 2;
        for (std::size_t i = old; i < 2 * old; ++i)
            if (const ContactWorkspace::Entry e = workspace_.table_[i]; e.round == workspace_.round_) entry_of(e.key) = e;
    }
    /// The value of a key, `value` where it is new.
    std::uint32_t put(std::uint64_t key, std::uint32_t value)
    {
        ContactWorkspace::Entry& e = entry_of(key);
        if (e.round == workspace_.round_) return e.value;
        e = {key, value, workspace_.round_};
        if (++used_ > slots_ / 2 && 4 * slots_ <= workspace_.table_.size()) grow();
        return value;
    }

    std::uint32_t root_of(std::uint32_t i) { return sqmap::root_of(workspace_.parents_, i); }
    /// Regions are in the order of their first pairs.
    void join(std::uint32_t i, std::uint32_t j) { sqmap::join(workspace_.parents_, i, j); }
    /// Two pairs of triangles that share where an edge meets a triangle belong together.
    void join(std::uint32_t self, std::uint64_t key) { join(self, put(key, self)); }

    template <class PointOf>
    static Wedge wedge_of(const TriangleTree& tree, std::uint32_t half_edge, PointOf&& point)
    {
        const std::uint32_t twin = tree.twin(half_edge);
        const auto corner = [&](std::uint32_t h, std::uint32_t k) { return point(tree.triangle(h / 3)[(h % 3 + k) % 3]); };
        return {corner(half_edge, 0), corner(half_edge, 1), {corner(half_edge, 2), corner(twin, 2)}};
    }

    void add_edges(std::uint32_t self, std::uint32_t edge_a, std::uint32_t edge_b)
    {
        const Wedge a = wedge_of(a_.probe->triangles(), edge_a, [&](std::uint32_t i) { return point_a(i); });
        const Wedge b = wedge_of(b_.probe->triangles(), edge_b, [&](std::uint32_t i) { return point_b(i); });
        if (surely_lack_support(a, b)) return;
        if (put(key_of(Key::EdgePair, edge_of(a_, edge_a), edge_of(b_, edge_b)), self) != self) return;
        std::optional<Separation> s = separate(a, b);
        if (!s) return;
        s->corner_a = static_cast<int>(edge_a % 3);
        s->corner_b = static_cast<int>(edge_b % 3);
        SurfaceContact contact = contact_of(*s, edge_a / 3, edge_b / 3);
        contact.region = self;  // until all pairs are known
        add(contact);
    }

    SurfaceContact contact_of(const Separation& s, std::uint32_t triangle_a, std::uint32_t triangle_b) const
    {
        const auto index = [](Feature feature, const Body& body, std::uint32_t triangle, int corner) {
            const auto k = static_cast<std::uint32_t>(corner);
            if (feature == Feature::Face) return triangle;
            return feature == Feature::Edge ? 3 * triangle + k : body.probe->triangles().triangle(triangle)[k];
        };
        SurfaceContact c;
        c.witness = {apply(a_.pose, s.on_a), apply(a_.pose, s.on_b)};
        c.normal = cast<float>(turned(a_.pose, s.normal));
        c.depth = static_cast<float>(s.depth);
        c.feature_a = s.feature_a;
        c.feature_b = s.feature_b;
        c.index_a = index(s.feature_a, a_, triangle_a, s.corner_a);
        c.index_b = index(s.feature_b, b_, triangle_b, s.corner_b);
        c.part_a = OwnPart(a_).of_triangle(triangle_a);
        c.part_b = OwnPart(b_).of_triangle(triangle_b);
        c.certain = true;
        return c;
    }

    /// Adds the corners of what flat faces share that lie on each other: one nearest direction for each vertex, as the exact
    /// layer reports it, may be that to a side face. A support that another contact already gives is left out.
    void add_supports()
    {
        if (meetings_ == 0) return;
        const TriangleTree &a = a_.probe->triangles(), &b = b_.probe->triangles();
        for (std::uint32_t i = 0; i < meetings_; ++i) {
            const Meeting& m = workspace_.meetings_[i];
            if ((a.sharp(m.a) | b.sharp(m.b)) == 0) continue;
            bearing_ = i;
            find_supports(
                a, b, b_in_a_, {m.a, m.b},
                [](void* self, const Support& support) noexcept { static_cast<ContactQuery*>(self)->add_support(support); },
                this);
        }
    }
    /// Notes what the contacts before the first support are of, and which regions have one.
    void note_contacts()
    {
        if (supported_ != k_unnamed) return;
        supported_ = static_cast<std::uint32_t>(count_);
        for (std::uint32_t k = 0; k < supported_; ++k) {
            const SurfaceContact& c = workspace_.contacts_[k];
            put(contact_key(c), k);
            if (c.region != k_unnamed) workspace_.meetings_[root_of(c.region)].contacts = 1;
        }
    }
    void add_support(const Support& support)
    {
        note_contacts();
        SurfaceContact contact = contact_of(support.separation, support.triangle_a, support.triangle_b);
        contact.region = bearing_;
        std::uint32_t& has_contact = workspace_.meetings_[root_of(bearing_)].contacts;
        if (count_ < workspace_.contacts_.size()) {
            const auto self = static_cast<std::uint32_t>(count_);
            const std::uint64_t key = contact_key(contact);
            const std::uint32_t known = put(key, self);
            if (known != self) {
                SurfaceContact& other = workspace_.contacts_[known];
                const bool is_there = known >= supported_ || dot(other.normal, contact.normal) > 0.9f;
                if (is_there && has_contact == 1) return;
                // Regions that meet in a corner have it each.
                if (is_there && other.region == k_unnamed) {
                    other.region = bearing_;
                    has_contact = 1;
                    return;
                }
                if (!is_there) entry_of(key).value = self;
            }
        }
        has_contact = 1;
        add(contact);
    }
    /// A name of the two features of a contact; of vertices in a body the vertex alone.
    [[nodiscard]] std::uint64_t contact_key(const SurfaceContact& c) const
    {
        if (c.feature_b == Feature::Vertex) return key_of(Key::ContactOfVertex, 1, c.index_b);
        if (c.feature_a == Feature::Vertex) return key_of(Key::ContactOfVertex, 0, c.index_a);
        return key_of(Key::ContactOfEdges, edge_of(a_, c.index_a), edge_of(b_, c.index_b));
    }

    /// Numbers the regions, and gives a contact to those that have no pair of edges: of their pairs of triangles the deepest.
    void finish_regions()
    {
        std::vector<Meeting>& m = workspace_.meetings_;
        for (std::size_t i = 0; i < count_; ++i)
            if (const std::uint32_t region = workspace_.contacts_[i].region; region != k_unnamed) m[root_of(region)].contacts = 1;
        for (std::uint32_t i = 0; i < meetings_; ++i) {
            const std::uint32_t root = root_of(i);
            result_.regions += root == i ? 1u : 0u;
            if (m[root].contacts == 1) continue;
            if (m[root].contacts == 0 || m[i].depth > m[m[root].contacts - k_deepest].depth) m[root].contacts = k_deepest + i;
        }
        add_deepest();
        if (options_.per_region > 0) join_vertices();
        number_regions();
        if (options_.per_region > 0) reduce();
    }

    /// Contacts of regions without a pair of edges. Several pairs about one corner are as deep along their normals: of these the
    /// one that is hardest to separate.
    void add_deepest()
    {
        std::vector<Meeting>& m = workspace_.meetings_;
        const std::size_t first = count_;
        for (std::uint32_t i = 0; i < meetings_; ++i) {
            const std::uint32_t root = root_of(i);
            if (m[root].contacts == 1) continue;
            const Meeting& deepest = m[m[root].contacts - k_deepest];
            if (!(m[i].depth >= deepest.depth * (1 - 1e-9))) continue;
            SurfaceContact contact = contact_of(separate(corners_a(m[i].a), corners_b(m[i].b)), m[i].a, m[i].b);
            contact.region = root;
            // The region's own contact, where it has one already, is near the end.
            std::size_t own = count_;
            while (own > first && workspace_.contacts_[own - 1].region != root) --own;
            if (own == first)
                add(contact);
            else if (contact.depth > workspace_.contacts_[own - 1].depth)
                workspace_.contacts_[own - 1] = contact;
        }
    }

    /// A node of the union for each contact, behind the meetings: its region's, or for a vertex that no face bears one of its own
    /// that is joined to those of vertices along its edges and of the triangles that meet about it.
    void join_vertices()
    {
        const auto first = static_cast<std::uint32_t>(meetings_);
        const std::span<SurfaceContact> contacts = std::span(workspace_.contacts_).first(count_);
        set_vertex_entries();
        for (std::uint32_t i = 0; i < contacts.size(); ++i) {
            SurfaceContact& c = contacts[i];
            if (c.feature_a != Feature::Vertex && c.feature_b != Feature::Vertex) continue;
            if (c.region == k_unnamed) workspace_.parents_[first + i] = c.region = first + i;
            put_vertex(is_vertex_of_b(c), is_vertex_of_b(c) ? c.index_b : c.index_a, c.region);
        }
        for (std::uint32_t i = 0; i < contacts.size(); ++i)
            if (contacts[i].region == first + i) join_along_edges(contacts[i], first + i);
        for (std::uint32_t i = 0; i < meetings_; ++i) {
            const Meeting& m = workspace_.meetings_[i];
            for (std::size_t k = 0; k < 3; ++k) {
                join_vertex(false, a_.probe->triangles().triangle(m.a)[k], i);
                join_vertex(true, b_.probe->triangles().triangle(m.b)[k], i);
            }
        }
    }
    static bool is_vertex_of_b(const SurfaceContact& c) { return c.feature_b == Feature::Vertex; }
    void join_along_edges(const SurfaceContact& c, std::uint32_t node)
    {
        const bool of_b = is_vertex_of_b(c);
        const TriangleTree& tree = (of_b ? b_ : a_).probe->triangles();
        const std::uint32_t vertex = of_b ? c.index_b : c.index_a;
        if (vertex >= tree.points()) return;
        constexpr int k_max_ring = 64;  // a vertex with more neighbours is joined by theirs
        const std::uint32_t start = tree.half_edge_from(vertex);
        std::uint32_t h = start;
        for (int step = 0; step < k_max_ring && h != TriangleTree::k_no_half_edge; ++step) {
            join_vertex(of_b, tree.triangle(h / 3)[(h % 3 + 1) % 3], node);
            h = tree.twin(3 * (h / 3) + (h % 3 + 2) % 3);
            if (h == start) break;
        }
    }
    /// Gives each vertex an entry of its own behind the table that is used, where the workspace has so many: a search of the
    /// table takes four times as long.
    void set_vertex_entries()
    {
        vertices_b_ = a_.probe != nullptr ? a_.probe->size() : 0;
        const std::size_t count = vertices_b_ + (b_.probe != nullptr ? b_.probe->size() : 0);
        if (count <= workspace_.table_.size() - 2 * slots_) vertices_ = 2 * slots_;
    }
    ContactWorkspace::Entry& entry_of_vertex(bool of_b, std::uint32_t vertex)
    {
        if (vertices_ == 0) return entry_of(key_of(Key::Vertex, of_b ? 1 : 0, vertex));
        return workspace_.table_[vertices_ + (of_b ? vertices_b_ : 0) + vertex];
    }
    void put_vertex(bool of_b, std::uint32_t vertex, std::uint32_t node)
    {
        if (vertices_ == 0)
            put(key_of(Key::Vertex, of_b ? 1 : 0, vertex), node);
        else if (ContactWorkspace::Entry& e = entry_of_vertex(of_b, vertex); e.round != workspace_.round_)
            e = {0, node, workspace_.round_};
    }
    void join_vertex(bool of_b, std::uint32_t vertex, std::uint32_t node)
    {
        const ContactWorkspace::Entry& e = entry_of_vertex(of_b, vertex);
        if (e.round == workspace_.round_) join(node, e.value);
    }

    /// From roots to 0, 1, 2, ... in the order of the roots.
    void number_regions()
    {
        const auto first = static_cast<std::uint32_t>(meetings_);
        std::uint32_t regions = 0;
        // A root is older than what belongs to it: its number is known when it is needed.
        const auto number = [&](std::uint32_t node) {
            const std::uint32_t root = root_of(node);
            return root < first ? workspace_.meetings_[root].contacts : workspace_.contacts_[root - first].region;
        };
        for (std::uint32_t i = 0; i < meetings_; ++i)
            if (root_of(i) == i) workspace_.meetings_[i].contacts = regions++;
        for (std::uint32_t i = 0; i < count_; ++i) {
            SurfaceContact& c = workspace_.contacts_[i];
            if (c.region == k_unnamed) continue;
            const bool is_root = c.region == first + i && root_of(c.region) == c.region;
            c.region = is_root ? regions++ : number(c.region);
        }
        result_.regions = regions;
    }

    /// Region after region, of each what per_region allows.
    void reduce()
    {
        const std::span<SurfaceContact> from = std::span(workspace_.contacts_).first(count_), to(workspace_.kept_);
        const std::span<std::uint32_t> ends = std::span(workspace_.parents_).first(result_.regions);  // their nodes are done with
        std::fill(ends.begin(), ends.end(), 0u);
        for (const SurfaceContact& c : from) ++ends[c.region];
        std::uint32_t sum = 0;
        for (std::uint32_t& end : ends) end = sum += end;
        for (std::size_t i = from.size(); i-- > 0;) to[--ends[from[i].region]] = from[i];
        std::size_t kept = 0;
        for (std::size_t r = 0; r < ends.size(); ++r) {
            const std::size_t begin = ends[r], end = r + 1 < ends.size() ? ends[r + 1] : from.size();
            const std::span<SurfaceContact> region = to.subspan(begin, end - begin);
            const std::size_t count = keep_spanning(region, options_.per_region);
            std::copy(region.begin(), region.begin() + static_cast<std::ptrdiff_t>(count),
                      from.begin() + static_cast<std::ptrdiff_t>(kept));
            kept += count;
        }
        count_ = kept;
    }

    static constexpr std::uint32_t k_deepest = 1u
                                               << 31;  // + the deepest pair of triangles, of a region that has no pair of edges

    const Body &a_, &b_;
    const ContactOptions& options_;
    ContactWorkspace& workspace_;
    const Affine b_in_a_;
    ContactResult result_;
    std::size_t slots_ = ContactWorkspace::k_least_slots, used_ = 0;  // of the table
    std::size_t vertices_ = 0, vertices_b_ = 0;                       // entries before those of vertices; of a's vertices
    std::size_t count_ = 0;                                           // contacts kept
    std::size_t meetings_ = 0;                                        // kept
    std::uint32_t supported_ = k_unnamed;                             // contacts before the first support
    std::uint32_t bearing_ = 0;                                       // the meeting whose supports are looked for
};

ContactResult query_contacts(const Body& a, const Body& b, const ContactOptions& options, ContactWorkspace& workspace) noexcept
{
    return ContactQuery(a, b, options, workspace).run();
}

}  // namespace sqmap::query
