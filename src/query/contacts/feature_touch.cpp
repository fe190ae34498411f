// Times are divided until a direction separates the features all through a piece of time: their difference is linear in time and
// in the position on either feature, so its corner values bound it (B. Wang, Z. Ferguson, T. Schneider, X. Jiang, M. Attene, D.
// Panozzo, "A large scale benchmark and an inclusion-based algorithm for continuous collision detection", TOG 40(5), 2021, divide
// all three parameters and test along the axes; a direction chosen for the middle of the piece spares the other two).
#include "sqmap/query/first_touch.h"

#include "math/triangle.h"
#include "math/twofold.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

namespace sqmap::query {
namespace {

constexpr int k_deepest = 30;  // halvings: 1e-9
constexpr int k_doubtful = 8;  // from here on numbers of twice the digits are tried too
constexpr int k_max_steps = 4096;
constexpr double k_rounding = 64 * 0x1p-53;
// Pieces that double cannot decide are searched on in numbers of twice the digits, so many halvings more.
constexpr int k_deepest_twofold = 45, k_max_steps_twofold = 400;
constexpr double k_rounding_twofold = 64 * 0x1p-100;

/// Corners of both features at a time.
template <class Real, std::size_t N, std::size_t M>
struct Features {
    std::array<Vec3<Real>, N> a;
    std::array<Vec3<Real>, M> b;
};

/// The nearest positions of two segments (C. Ericson, Real-Time Collision Detection, 2005, 5.1.9): their difference.
Vec3d between_segments(const std::array<Vec3d, 2>& a, const std::array<Vec3d, 2>& b)
{
    const Vec3d da = a[1] - a[0], db = b[1] - b[0], r = a[0] - b[0];
    const double aa = norm_sq(da), bb = norm_sq(db), ab = dot(da, db), ar = dot(da, r), br = dot(db, r);
    const double over = aa * bb - ab * ab;
    double s = over > 0 ? std::clamp((ab * br - ar * bb) / over, 0., 1.) : 0.;
    double t = bb > 0 ? (ab * s + br) / bb : 0.;
    if (t < 0 || t > 1 || !(bb > 0)) {
        t = std::clamp(t, 0., 1.);
        s = aa > 0 ? std::clamp((ab * t - ar) / aa, 0., 1.) : 0.;
    }
    return (a[0] + s * da) - (b[0] + t * db);
}

/// Directions that may separate them: between their nearest positions, and the normal that is common to both.
std::array<Vec3d, 2> directions(const Features<double, 1, 3>& f)
{
    return {f.a[0] - closest_point_on_triangle(f.a[0], f.b[0], f.b[1], f.b[2]), cross(f.b[1] - f.b[0], f.b[2] - f.b[0])};
}
std::array<Vec3d, 2> directions(const Features<double, 2, 2>& f)
{
    return {between_segments(f.a, f.b), cross(f.a[1] - f.a[0], f.b[1] - f.b[0])};
}
// The same without a division: normals of faces and sides, and from corner to corner. Each separates where the nearest positions
// are in its features.
std::array<Vec3<Twofold>, 7> directions(const Features<Twofold, 1, 3>& f)
{
    const Vec3<Twofold> n = cross(f.b[1] - f.b[0], f.b[2] - f.b[0]);
    return {n,
            cross(f.b[1] - f.b[0], n),
            cross(f.b[2] - f.b[1], n),
            cross(f.b[0] - f.b[2], n),
            f.a[0] - f.b[0],
            f.a[0] - f.b[1],
            f.a[0] - f.b[2]};
}
std::array<Vec3<Twofold>, 9> directions(const Features<Twofold, 2, 2>& f)
{
    const Vec3<Twofold> da = f.a[1] - f.a[0], db = f.b[1] - f.b[0];
    const auto beside = [](const Vec3<Twofold>& along, const Vec3<Twofold>& w) {
        return dot(along, along) * w - dot(along, w) * along;
    };
    return {cross(da, db),
            beside(da, f.b[0] - f.a[0]),
            beside(da, f.b[1] - f.a[0]),
            beside(db, f.a[0] - f.b[0]),
            beside(db, f.a[1] - f.b[0]),
            f.a[0] - f.b[0],
            f.a[0] - f.b[1],
            f.a[1] - f.b[0],
            f.a[1] - f.b[1]};
}

/// The first number changes its sign where one feature passes through the plane of the other (for edges: the common plane). The
/// others, sides of the borders, all have one sign where the features overlap.
std::array<double, 4> sides(const Features<double, 1, 3>& f)
{
    const Vec3d p = f.a[0], n = cross(f.b[1] - f.b[0], f.b[2] - f.b[0]);
    const auto side = [&](const Vec3d& from, const Vec3d& to) { return dot(n, cross(to - from, p - from)); };
    return {dot(n, p - f.b[0]), side(f.b[0], f.b[1]), side(f.b[1], f.b[2]), side(f.b[2], f.b[0])};
}
std::array<double, 5> sides(const Features<double, 2, 2>& f)
{
    const Vec3d da = f.a[1] - f.a[0], db = f.b[1] - f.b[0], n = cross(da, db), w = f.b[0] - f.a[0];
    const double nn = norm_sq(n), s = dot(cross(w, db), n), t = dot(cross(w, da), n);
    return {dot(n, w), s, nn - s, t, nn - t};
}

template <std::size_t N, std::size_t M>
class Search {
public:
    Search(const MovingPoint (&a)[N], const MovingPoint (&b)[M], const TouchOptions& options)
        : a_(a), b_(b), until_(options.until), separation_(options.separation)
    {
        for (const MovingPoint& p : a) include(largest_, p);
        for (const MovingPoint& p : b) include(largest_, p);
    }

    Touch run() const
    {
        if (!std::isfinite(largest_ + separation_)) return {true, 0};
        return search<double>({0., 1., 0, false}, k_rounding, k_max_steps, [this](const Piece<double>& piece) {
            if (piece.is_sure || surely_touches(piece)) return piece.depth < k_deepest ? Verdict::Sure : Verdict::Touch;
            // A separation beyond rounding is known well enough.
            if (separation_ > k_rounding * largest_) return piece.depth < k_deepest ? Verdict::Open : Verdict::Touch;
            if (piece.depth < k_doubtful) return Verdict::Open;
            const Piece<Twofold> twofold{piece.first, piece.last, 0, false};
            if (is_apart(twofold, k_rounding_twofold)) return Verdict::Apart;
            if (piece.depth < k_deepest) return Verdict::Open;
            const Touch touch = search<Twofold>(twofold, k_rounding_twofold, k_max_steps_twofold, [](const Piece<Twofold>& p) {
                return p.depth < k_deepest_twofold ? Verdict::Open : Verdict::Touch;
            });
            return touch.touches ? Verdict::Touch : Verdict::Apart;
        });
    }

private:
    template <class Real>
    struct Piece {
        Real first, last;
        int depth;
        bool is_sure;  ///< a touch lies in it, and only its time is sought
    };
    enum class Verdict : std::uint8_t { Open, Sure, Touch, Apart };

    static void include(double& largest, const MovingPoint& p)
    {
        for (int k = 0; k < 3; ++k) {
            // Not by std::max, which forgets NaN.
            const double v = std::abs(p.from[k]), w = std::abs(p.to[k]);
            if (!(v <= largest)) largest = v;
            if (!(w <= largest)) largest = w;
        }
    }

    /// judge: of a piece that no direction separates.
    template <class Real, class Judge>
    Touch search(const Piece<Real>& whole, double rounding, int max_steps, Judge&& judge) const
    {
        // Pieces of time that are still to be searched, the earliest on top.
        std::array<Piece<Real>, std::max(k_deepest, k_deepest_twofold) + 2> stack;
        std::size_t size = 0;
        stack[size++] = whole;
        for (int step = 0; size > 0; ++step) {
            const Piece<Real> piece = stack[--size];
            if (std::is_same_v<Real, double> && rounded(piece.first) >= until_) return {};
            if (is_apart(piece, rounding)) continue;
            const Verdict verdict = step >= max_steps ? Verdict::Touch : judge(piece);
            if (verdict == Verdict::Touch) return {true, rounded(piece.first)};
            if (verdict == Verdict::Apart) continue;
            const Real middle = middle_of(piece);
            const bool is_sure = verdict == Verdict::Sure;
            stack[size++] = {middle, piece.last, piece.depth + 1, is_sure};
            stack[size++] = {piece.first, middle, piece.depth + 1, is_sure};
        }
        return {};
    }

    template <class Real>
    Features<Real, N, M> features(Real time) const
    {
        const auto at = [&](const MovingPoint& p) {
            const Vec3<Real> from{p.from.x, p.from.y, p.from.z}, to{p.to.x, p.to.y, p.to.z};
            return from + time * (to - from);
        };
        Features<Real, N, M> f;
        for (std::size_t i = 0; i < N; ++i) f.a[i] = at(a_[i]);
        for (std::size_t i = 0; i < M; ++i) f.b[i] = at(b_[i]);
        return f;
    }
    template <class Real>
    static Real middle_of(const Piece<Real>& piece)
    {
        return Real(0.5) * (piece.first + piece.last);
    }
    template <class Real>
    bool is_apart(const Piece<Real>& piece, double rounding) const
    {
        const double gap = separation_ + rounding * largest_;
        const Features<Real, N, M> first = features(piece.first), last = features(piece.last);
        for (const Vec3<Real>& d : directions(features(middle_of(piece)))) {
            // The sum of the sizes is no less than the length.
            const double length = std::abs(rounded(d.x)) + std::abs(rounded(d.y)) + std::abs(rounded(d.z));
            if (!(length > 0) || !std::isfinite(length)) continue;
            const double reach = gap * length * (1 + 1e-15);
            const int side = side_of(first, d, reach);
            if (side != 0 && side_of(last, d, reach) == side) return true;
        }
        return false;
    }
    /// +1 where all of a is farther along the direction than all of b, by more than the reach; -1 where it is nearer; else 0.
    template <class Real>
    int side_of(const Features<Real, N, M>& f, const Vec3<Real>& d, double reach) const
    {
        int side = 0;
        for (const Vec3<Real>& p : f.a)
            for (const Vec3<Real>& q : f.b) {
                const double v = rounded(dot(d, p - q));
                const int own = v > reach ? 1 : v < -reach ? -1 : 0;
                if (own == 0 || (side != 0 && own != side)) return 0;
                side = own;
            }
        return side;
    }
    /// The features change sides and overlap all the while, by more than rounding.
    bool surely_touches(const Piece<double>& piece) const
    {
        const auto first = sides(features(piece.first)), last = sides(features(piece.last));
        const double volume = k_rounding * largest_ * largest_ * largest_, margin = volume * largest_;
        if (!(std::min(first[0], last[0]) < -volume && std::max(first[0], last[0]) > volume)) return false;
        for (std::size_t i = 1; i < first.size(); ++i)
            if (!(first[i] > margin && last[i] > margin)) return false;
        return true;
    }

    const MovingPoint (&a_)[N];
    const MovingPoint (&b_)[M];
    double until_, separation_, largest_ = 0;
};

}  // namespace

Touch first_touch(const MovingPoint& point, const MovingPoint (&triangle)[3], const TouchOptions& options) noexcept
{
    const MovingPoint points[1] = {point};
    return Search<1, 3>(points, triangle, options).run();
}

Touch first_touch(const MovingPoint (&a)[2], const MovingPoint (&b)[2], const TouchOptions& options) noexcept
{
    return Search<2, 2>(a, b, options).run();
}

}  // namespace sqmap::query
