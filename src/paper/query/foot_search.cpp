// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2.2: the search step by step.
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include "sqmap/paper/projection.h"

#include "job.h"

#include <hwy/highway.h>

#include <cmath>

#include "one_point-inl.h"

namespace sqmap::paper {

namespace {

/// Writes a search down.
class Recorder {
public:
    Recorder(const SuperquadricLanes& shape, const V3& q, std::span<FootSearchStep> steps) : shape_(shape), q_(q), steps_(steps)
    {
    }

    void level(std::int32_t stride) noexcept { stride_ = stride; }
    void write(const PositionLanes& at, std::int32_t stride, bool better) noexcept
    {
        if (count_++ >= steps_.size()) return;
        const AngleLanes angles = PartLanes::angles_at(at);
        const SurfaceLanes s = shape_.surface(at);
        const V3 line = minus(s.point, q_);
        const float away = hn::GetLane(length(line));
        steps_[count_ - 1] = {{hn::GetLane(angles.eta), hn::GetLane(angles.omega)},
                              away,
                              away > 0 ? std::abs(hn::GetLane(dot(s.normal, line))) / away : 1,
                              static_cast<std::uint32_t>(stride),
                              better};
    }
    [[nodiscard]] std::int32_t stride() const { return stride_; }
    [[nodiscard]] std::size_t count() const { return count_; }

private:
    const SuperquadricLanes& shape_;
    const V3 q_;
    std::span<FootSearchStep> steps_;
    std::size_t count_ = 0;
    std::int32_t stride_ = 1;
};

/// As a search takes it: by value.
struct RecordTo {
    Recorder* to;
    void level(std::int32_t stride) const noexcept { to->level(stride); }
    void sample(const GridLanes& grid, const NodeLanes& node, const M& better) const noexcept
    {
        to->write(grid.position(grid.wrapped(node)), to->stride(), any(better));
    }
    void position(const PositionLanes& at) const noexcept { to->write(at, 0, true); }
};

}  // namespace

std::size_t record_foot_search(const MapView& map, Vec3f p, Projector projector, std::span<FootSearchStep> steps) noexcept
{
    SQMAP_ASSERT(is_consistent(map));
    const OnePoint point(map, p, {.projector = projector});
    if (!point.is_held) return 0;
    Recorder recorder(point.part.shape(), point.held.q, steps);
    I flags = hn::Zero(di);
    (void)point.part.foot(point.held, all(), flags, RecordTo{&recorder});
    return recorder.count();
}

}  // namespace sqmap::paper
