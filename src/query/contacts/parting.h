// How far one mesh has to move along a given direction until the two no longer meet.
#pragma once

#include "math/triangle_crossing.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/separating.h"

namespace sqmap::query {

/// Translations t of b along +z after which triangles have a point in common: [low, high], empty where low > high.
struct MeetingRange {
    double low, high;
    /// The features that touch last, at high, and their position on a.
    struct Touch {
        Vec3d on_a{};
        Feature feature_a = Feature::Face, feature_b = Feature::Face;
        int corner_a = 0, corner_b = 0;  ///< of the triangles: a vertex, or where an edge begins
    } last{};
};
/// near: positions so near each other in x and y count as one.
[[nodiscard]] MeetingRange meeting_range(const TriangleCorners& a, const TriangleCorners& b, double near) noexcept;

/// The search along one direction. Positions are turned so that the direction is z; b's are b_in_a's, all from the middle of a.
class PartingSearch {
public:
    /// direction: unit, in a's frame. @pre workspace.holds both trees
    PartingSearch(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, Vec3d direction,
                  SeparatingWorkspace& workspace) noexcept;

    /// The first translation, from 0 on, that leaves b free of a. False where none was proven.
    [[nodiscard]] bool run(double& distance) noexcept;
    /// The most that rounding has added to the last run's distance.
    [[nodiscard]] double error() const { return slack_; }

private:
    using Range = SeparatingWorkspace::Range;
    struct Mesh {
        const TriangleTree& tree;
        SeparatingWorkspace::Side& space;
        std::size_t leaves, groups;
    };

    void prepare(Mesh& m, const Affine& map, const Vec3d (&axes)[3]);
    void find_pieces(Mesh& m);
    [[nodiscard]] TriangleCorners corners(const Mesh& m, std::uint32_t t) const;
    /// Calls visit for pairs of triangles whose boxes overlap in x and y and that a test of their boxes allows.
    template <class Test, class Visit>
    void each_pair(Test&& test, Visit&& visit);
    /// Moves t on as long as triangles meet there.
    void leave_meetings(double& t);
    /// The next translation beyond t at which triangles begin to meet; infinite where none does.
    [[nodiscard]] double next_meeting(double t);
    [[nodiscard]] bool is_contained(double t);
    [[nodiscard]] bool has_inside(const Mesh& outer, Vec3d p) const;
    /// No triangles meet, by exact predicates.
    [[nodiscard]] bool is_free(double t) const;

    Mesh a_, b_;
    const Affine& b_in_a_;
    const Vec3d direction_;
    double near_ = 0, gap_ = 0, slack_ = 0;
};

}  // namespace sqmap::query
