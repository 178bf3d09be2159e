// A body bounded by sheets of rational Bezier patches: tessellated for topology, refined for truth.
//
// A closed mesh cuts the sheets into curved triangles: the images of straight triangles in a sheet's parameters. What a
// ray meets is decided in two steps that cannot contradict each other.
//
// Topology. How often a ray crosses a curved triangle, entering counted against leaving, is the winding number about
// the ray of the triangle's boundary seen along it. The boundary is three edges, each four parabolas through points on
// the surface, and both triangles at an edge hold the same numbers. A chord adds to the winding number what it adds in
// a mesh; where the ray passes between a chord and its arc, the loop of the two winds about the ray once more, in the
// sense in which the edge is run. Both change sign with that sense, in floating point too, so over the closed body
// every line enters as often as it leaves: no crossing is lost at seams, vertices, poles or silhouettes, whatever
// becomes of the second step.
//
// Geometry. Newton on the exact sheet, in the triangle's barycentric coordinates, from where the ray meets the flat
// triangle. It need not stop at the triangle's side: the sheet goes on there, and edges are off it by the fourth order
// of their length only, so a foot just outside is as exact. A foot of the wrong sense lies beyond the silhouette,
// and the one before it is sought. Where no foot of the right sense is found nearby, the point of the flat triangle has
// to do.
//
// Silhouettes. Where the winding number is 0 and the ray can be tangent to the triangle at all (a cone around its
// normals tells), it may still enter and leave: then Newton finds two feet of opposite sense, or the ray passes by.
// Only pairs are reported, so they do not touch the count, and a pair that two triangles claim does no harm.
//
// Order. Crossings are compared by their exact distances; boxes hold the curved triangles, not the flat ones. The
// crossing that a ray starts at is known by its triangle, place and sense: a triangle that the ray cannot be tangent to
// is met once, so it is passed over; on another only the second foot counts. A neighbour that claims the same crossing,
// at a shared edge, contradicts what the ray is inside of, and is passed over for that. No distance is compared with a
// wall's thickness. At a crease that a ray cuts off by less than the sheets are apart there, both its crossings may
// come in the wrong order: one of them is off its triangle, and says by how much, as its slack.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "hierarchy.hpp"
#include "shear.hpp"
#include "sheet.hpp"
#include "vector.hpp"

namespace glass {

// Parabolas in turn, each by its end, its middle and the next one's end.
struct CurvedEdge {
    static constexpr int pieces = 4;
    Vector point[2 * pieces + 1];
};

// What curved_triangles.py knows of a triangle; edge k runs from corner k to the next.
struct CurvedTriangle {
    Vector corner[3];
    std::int32_t edge[3];
    bool along[3];  // whether the edge is run in the sense in which it is stored
    std::int32_t sheet;
    double u[3], v[3];
    std::int32_t pole;  // 0: none; 1, 2: corner 0 lies on a collapsed edge, along which u, v runs
    Vector cone_axis;
    double cone_sine;  // the ray can be tangent only if the sine of its angle with the axis' plane is no more
};

class Patches {
public:
    Patches(std::vector<Sheet> sheets, std::vector<CurvedEdge> edges, const std::vector<CurvedTriangle>& triangles,
            const std::vector<Box>& boxes)
        : sheets_(std::move(sheets)), edges_(std::move(edges)), hierarchy_(boxes) {
        triangles_.reserve(triangles.size());
        for (const std::int32_t number : hierarchy_.order()) {
            triangles_.emplace_back(triangles[number], edges_);
            largest_slack_ = greater(largest_slack_, triangles_.back().size);
        }
    }

    double largest_slack() const { return largest_slack_; }

    const Box& bounds() const { return hierarchy_.bounds(); }

    template <class Visit>
    void crossings(const Ray& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        const Shear shear(ray);
        hierarchy_.visit(ray, t_min, t_best, [&](std::int32_t number) { test(ray, shear, number, start, visit); });
    }

    void place(const Ray&, const Hit& hit, Vector& point, Vector& normal) const {
        const Triangle& triangle = triangles_[hit.part];
        const Tangents s = at(triangle, hit.u, hit.v);
        point = s.point;
        normal = cross(s.by_p, s.by_q);
        if (dot(normal, normal) <= 1e-16 * dot(s.by_p, s.by_p) * dot(s.by_q, s.by_q)) {
            // A collapsed edge has no normal: the limit from the triangle's middle.
            const Tangents inner = at(triangle, hit.u + towards_middle * (1.0 / 3.0 - hit.u),
                                      hit.v + towards_middle * (1.0 / 3.0 - hit.v));
            normal = cross(inner.by_p, inner.by_q);
        }
        normal = normalised(normal);
    }

private:
    static constexpr double towards_middle = 1e-7;
    static constexpr double at_pole = 1e-7;  // sum of the coordinates, below which all is as at the pole
    static constexpr int most_steps = 30;
    static constexpr int most_steps_to_silhouette = 8;
    static constexpr double starts[7][2] = {{2, 2}, {4, 1}, {1, 4}, {1, 1}, {3, 3}, {3, 0}, {0, 3}};  // in sixths
    static constexpr double beyond = 0.6;        // barycentric coordinates that Newton may fall below 0 by
    static constexpr double on_triangle = 1e-3;  // the same where a foot is on the triangle, but for the edges' error
    static constexpr double off_triangle = 0.1;  // the same for the partner of a foot that is known

    struct Triangle : CurvedTriangle {
        // What is seen of an edge by a ray that passes it farther off than its arc: the area of the triangle to its
        // ends is above `reach`, or the ends' product above `around` (the ray is outside the circle over the chord,
        // which is widened by the arc's height).
        double reach[3], around[3];
        double size = 0.0;  // the longest chord

        Triangle(const CurvedTriangle& triangle, const std::vector<CurvedEdge>& edges) : CurvedTriangle(triangle) {
            for (int k = 0; k < 3; ++k) {
                const CurvedEdge& e = edges[edge[k]];
                const Vector& start = e.point[0];
                const Vector chord = e.point[2 * CurvedEdge::pieces] - start;
                double off = 0.0;  // twice the triangle of the chord and a point of the arc
                for (const Vector& point : e.point) off = greater(off, length(cross(chord, point - start)));
                // An arc leaves the hull of its points by less than half.
                reach[k] = 1.5 * off;
                size = greater(size, length(chord));
                const double height = off > 0.0 ? reach[k] / length(chord) : 0.0;
                around[k] = height * (length(chord) + height);
            }
        }
    };

    // A point of a triangle's sheet, and its derivatives by the barycentric coordinates of corners 1 and 2.
    struct Tangents {
        Vector point, by_p, by_q;
    };

    struct Root {
        bool found = false;
        double p = 0.0, q = 0.0, t = 0.0;
        int sense = 0;       // 1 where the ray leaves, -1 where it enters
        double slack = 0.0;  // of the triangle's size, as Hit's
    };

    // The parameters that a triangle's barycentric coordinates stand for. At a pole they are those of a fan: the one
    // along the collapsed edge is constant on lines through the pole, where it has no value of its own.
    struct Parameter {
        double value, by_p, by_q;

        Parameter(const double* corner, bool fan, double p, double q) {
            if (!fan) {
                by_p = corner[1] - corner[0];
                by_q = corner[2] - corner[0];
                value = corner[0] + p * by_p + q * by_q;
                return;
            }
            const double away = p + q;
            value = corner[1] + q / away * (corner[2] - corner[1]);
            by_p = (corner[1] - value) / away;
            by_q = (corner[2] - value) / away;
        }
    };

    Tangents at(const Triangle& triangle, double p, double q) const {
        if (triangle.pole == 0 || std::fabs(p + q) >= at_pole) return regular(triangle, p, q);
        // The pole itself, on the tangent plane from just inside.
        Tangents s = regular(triangle, at_pole, at_pole);
        s.point = s.point + (p - at_pole) * s.by_p + (q - at_pole) * s.by_q;
        return s;
    }

    Tangents regular(const Triangle& triangle, double p, double q) const {
        const Parameter u(triangle.u, triangle.pole == 1, p, q), v(triangle.v, triangle.pole == 2, p, q);
        const SheetPoint s = sheets_[triangle.sheet].at(u.value, v.value);
        return {s.point, u.by_p * s.by_u + v.by_p * s.by_v, u.by_q * s.by_u + v.by_q * s.by_v};
    }

    template <class Visit>
    void test(const Ray& ray, const Shear& shear, std::int32_t number, const Hit& start, Visit&& visit) const {
        const Triangle& triangle = triangles_[number];
        const bool may_touch = std::fabs(dot(ray.direction, triangle.cone_axis)) <= triangle.cone_sine;
        if (number == start.part && !may_touch) return;
        Vector corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = shear.point(triangle.corner[k]);
        // Seen along the ray, lengths and areas grow by what the shear stretches, if they do.
        const double stretch = std::fabs(shear.sz);
        double areas[3];
        int turns = 0;
        for (int k = 0; k < 3; ++k) {
            const Vector &p = corner[k], &q = corner[(k + 1) % 3];
            areas[k] = area(p, q);
            if (std::fabs(areas[k]) > stretch * triangle.reach[k] ||
                dot_across(p, q) > stretch * stretch * triangle.around[k]) {
                turns += winding(p, q, areas[k]);
            } else {
                const int once = winding_of(shear, edges_[triangle.edge[k]]);
                turns += triangle.along[k] ? once : -once;
            }
        }
        if (number == start.part) {
            test_again(shear, triangle, number, start, turns, visit);
            return;
        }
        if (turns != 0) {
            const Root root = crossing(shear, triangle, corner, areas, turns);
            for (int k = 0; k < std::abs(turns); ++k) report(number, root, turns, visit);
        } else if (may_touch) {
            const Pair both = pair(shear, triangle, 1.0 / 3.0, 1.0 / 3.0);
            if (!both.found) return;
            if (greater(outside(both.entering), outside(both.leaving)) > on_triangle) return;
            report(number, both.entering, -1, visit);
            report(number, both.leaving, 1, visit);
        }
    }

    // The crossings besides the one that the ray starts at, until they add up to the winding number.
    template <class Visit>
    void test_again(const Shear& shear, const Triangle& triangle, std::int32_t number, const Hit& start, int turns,
                    Visit&& visit) const {
        constexpr int most_feet = 4;
        Root feet[most_feet] = {known(shear, triangle, start.u, start.v)};
        int count = 1, sum = feet[0].sense;
        const auto settles = [&](const Root& root) {
            if (root.found && outside(root) <= off_triangle) {
                report(number, root, root.sense, visit);
                feet[count++] = root;
                sum += root.sense;
            }
            return sum == turns || count == most_feet;
        };
        if (sum == turns) return;
        const Pair both = pair(shear, triangle, start.u, start.v);
        if (both.found && settles(both.of_sense(-sum))) return;
        for (const auto& from : starts)
            if (settles(refined(shear, triangle, from[0] / 6.0, from[1] / 6.0, feet, count))) return;
    }

    template <class Visit>
    void report(std::int32_t number, const Root& root, int turns, Visit&& visit) const {
        const double off = lesser(greater(root.slack, 4.0 * outside(root)), 1.0);
        visit(Hit{root.t, turns < 0, number, root.p, root.q, off * triangles_[number].size});
    }

    static double outside(const Root& root) {
        return greater(greater(-root.p, -root.q), greater(root.p + root.q - 1.0, 0.0));
    }

    static int winding_of(const Shear& shear, const CurvedEdge& edge) {
        int turns = 0;
        Vector p = shear.point(edge.point[0]);
        for (int k = 0; k < CurvedEdge::pieces; ++k) {
            const Vector middle = shear.point(edge.point[2 * k + 1]), q = shear.point(edge.point[2 * k + 2]);
            turns += winding(p, q, area(p, q)) + lens(p, q, middle);
            p = q;
        }
        return turns;
    }

    // How often the loop from p along the parabola through the middle to q, and straight back, winds about the ray.
    // In the barycentric coordinates of its control triangle (a, b, c at q, p and the control point) the parabola is
    // c^2 = 4 a b, the chord c = 0.
    static int lens(const Vector& p, const Vector& q, const Vector& middle) {
        const Vector control = 2.0 * middle - 0.5 * (p + q);
        const double a = area(p, control), b = area(control, q), c = area(q, p);
        if (a > 0.0 && b > 0.0 && c > 0.0) return c * c < 4.0 * a * b;
        if (a < 0.0 && b < 0.0 && c < 0.0) return -(c * c < 4.0 * a * b);
        return 0;
    }

    // The crossing that the winding number promises.
    Root crossing(const Shear& shear, const Triangle& triangle, const Vector* corner, const double* areas,
                  int turns) const {
        const double total = areas[0] + areas[1] + areas[2];
        // The area of edge k belongs to the corner across.
        double p = areas[2] / total, q = areas[0] / total;
        if (!(p >= 0.0 && q >= 0.0 && p + q <= 1.0)) nearest_on_side(corner, p, q);
        const int sense = turns < 0 ? -1 : 1;
        const double depth = (1.0 - p - q) * corner[0].z + p * corner[1].z + q * corner[2].z;
        const Root flat{true, p, q, shear.sz * depth, sense, 1.0};
        // Other feet may lie nearby, on the sheet beyond the triangle: the one that is least outside is meant.
        Root best = flat;
        double least = INFINITY;
        const auto settles = [&](const Root& root) {
            if (!root.found || root.sense != sense) return false;
            if (outside(root) < least) {
                least = outside(root);
                best = root;
            }
            return least <= on_triangle;
        };
        const Root root = refined(shear, triangle, p, q);
        if (settles(root)) return best;
        const Pair both = pair(shear, triangle, root.found ? root.p : p, root.found ? root.q : q);
        if (both.found && settles(both.of_sense(sense))) return best;
        for (const auto& start : starts)
            if (settles(refined(shear, triangle, start[0] / 6.0, start[1] / 6.0))) break;
        return best;
    }

    // The point of the flat triangle's sides that the ray passes nearest to, as it is seen along the ray.
    static void nearest_on_side(const Vector* corner, double& p, double& q) {
        double least = INFINITY;
        for (int k = 0; k < 3; ++k) {
            const Vector &start = corner[k], side = corner[(k + 1) % 3] - start;
            const double along = -dot_across(start, side) / dot_across(side, side);
            const double s = along > 0.0 ? lesser(along, 1.0) : 0.0;
            const Vector point = start + s * side;
            if (!(dot_across(point, point) < least)) continue;
            least = dot_across(point, point);
            p = k == 0 ? s : k == 1 ? 1.0 - s : 0.0;
            q = k == 1 ? s : k == 2 ? 1.0 - s : 0.0;
        }
    }

    struct Projected {
        Vector value, by_p, by_q;
        double determinant;
    };

    Projected projected(const Shear& shear, const Triangle& triangle, double p, double q) const {
        const Tangents s = at(triangle, p, q);
        const Vector by_p = shear.direction(s.by_p), by_q = shear.direction(s.by_q);
        return {shear.point(s.point), by_p, by_q, area(by_p, by_q)};
    }

    Root known(const Shear& shear, const Triangle& triangle, double p, double q) const {
        const Projected f = projected(shear, triangle, p, q);
        return {true, p, q, shear.sz * f.value.z, f.determinant < 0.0 ? -1 : 1};
    }

    // Newton from (p, q) to a foot of the ray on the sheet, in or near the triangle. Feet known already are divided out
    // of the equations (deflation: Brown and Gearhart, Numerische Mathematik 16, 1971).
    Root refined(const Shear& shear, const Triangle& triangle, double p, double q, const Root* feet = nullptr,
                 int count = 0) const {
        double previous = 1.0;
        for (int i = 0; i < most_steps; ++i) {
            const Projected f = projected(shear, triangle, p, q);
            const double inverse = -1.0 / f.determinant;
            double d_p = inverse * area(f.value, f.by_q), d_q = inverse * area(f.by_p, f.value);
            double pull = 1.0;
            for (int k = 0; k < count; ++k) {
                const double away_p = p - feet[k].p, away_q = q - feet[k].q, square = away_p * away_p + away_q * away_q;
                pull += 2.0 * (away_p * d_p + away_q * d_q) / (square * (1.0 + square));
            }
            d_p /= pull;
            d_q /= pull;
            double step = greater(std::fabs(d_p), std::fabs(d_q));
            if (!(step < INFINITY)) return {};
            if (step > 0.5) {
                d_p *= 0.5 / step;
                d_q *= 0.5 / step;
                step = 0.5;
            }
            p += d_p;
            q += d_q;
            if (!(p >= -beyond && q >= -beyond && p + q <= 1.0 + beyond)) return {};
            // Near a double root steps only halve, and a small one does not mean that the root is near.
            if (step < 1e-13 || (step < 1e-8 && step < 0.01 * previous)) {
                const double depth = f.value.z + d_p * f.by_p.z + d_q * f.by_q.z;
                return {true, p, q, shear.sz * depth, f.determinant < 0.0 ? -1 : 1};
            }
            previous = step;
        }
        return {};
    }

    // Two feet on either side of a silhouette.
    struct Pair {
        Root entering, leaving;
        bool found = false;

        const Root& of_sense(int sense) const { return sense < 0 ? entering : leaving; }
    };

    // The feet on both sides of the silhouette near (p, q). With e the direction in which the projection of the
    // surface still spreads there, and k the one in the triangle that it does not spread in, the silhouette's nearest
    // point is where the determinant and e . F vanish, by Newton. From there the surface bends away from the ray like a
    // parabola along k: where that meets the ray, if it does, Newton starts for either foot.
    Pair pair(const Shear& shear, const Triangle& triangle, double p, double q) const {
        constexpr double probe = 1e-4;
        for (int i = 0; i < most_steps_to_silhouette; ++i) {
            const Projected f = projected(shear, triangle, p, q);
            const bool p_longer = dot_across(f.by_p, f.by_p) > dot_across(f.by_q, f.by_q);
            const Vector& e = p_longer ? f.by_p : f.by_q;
            const double spread_p = dot_across(e, f.by_p), spread_q = dot_across(e, f.by_q);
            const double slope_p = (projected(shear, triangle, p + probe, q).determinant - f.determinant) / probe;
            const double slope_q = (projected(shear, triangle, p, q + probe).determinant - f.determinant) / probe;
            const double inverse = -1.0 / (slope_p * spread_q - slope_q * spread_p), off = dot_across(e, f.value);
            const double d_p = inverse * (f.determinant * spread_q - off * slope_q);
            const double d_q = inverse * (off * slope_p - f.determinant * spread_p);
            const double step = greater(std::fabs(d_p), std::fabs(d_q));
            if (!(step < 2.0)) return {};
            p += d_p;
            q += d_q;
            if (!(p >= -beyond && q >= -beyond && p + q <= 1.0 + beyond)) return {};
            if (step < 1e-2) return feet(shear, triangle, p, q);
        }
        return {};
    }

    Pair feet(const Shear& shear, const Triangle& triangle, double p, double q) const {
        constexpr double probe = 1e-3;
        const Projected f = projected(shear, triangle, p, q);
        const bool p_longer = dot_across(f.by_p, f.by_p) > dot_across(f.by_q, f.by_q);
        const Vector& e = p_longer ? f.by_p : f.by_q;
        const double square = dot_across(e, e);
        const double k_p = p_longer ? -dot_across(e, f.by_q) / square : 1.0;
        const double k_q = p_longer ? 1.0 : -dot_across(e, f.by_p) / square;
        const Projected ahead = projected(shear, triangle, p + probe * k_p, q + probe * k_q);
        const Vector bend = k_p * (ahead.by_p - f.by_p) + k_q * (ahead.by_q - f.by_q);
        const double way = std::sqrt(-2.0 * probe * area(e, f.value) / area(e, bend));
        if (!(way < 2.0)) return {};
        const Root first = refined(shear, triangle, p - way * k_p, q - way * k_q);
        if (!first.found) return {};
        const Root second = refined(shear, triangle, p + way * k_p, q + way * k_q);
        if (!second.found || second.sense == first.sense) return {};
        return first.sense < 0 ? Pair{first, second, true} : Pair{second, first, true};
    }

    static double dot_across(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y; }

    std::vector<Sheet> sheets_;
    std::vector<CurvedEdge> edges_;
    Hierarchy hierarchy_;
    std::vector<Triangle> triangles_;
    double largest_slack_ = 0.0;
};

}  // namespace glass
