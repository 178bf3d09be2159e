// A meridian turned about an axis, and the crossings of a ray with it.
//
// In the (r, z) half-plane a ray is a hyperbola: with tau measured along the ray from a point near the axis,
//   r^2 = A tau^2 + 2 B tau + C,   z = z0 + tau dz.
// Eliminating tau gives a polynomial that degenerates to a perfect square for horizontal rays, which costs half the
// digits. So tau is eliminated in one of two charts, each well conditioned where it is used:
//   flat rays  (|dz| < a):  B = 0 by starting at the closest approach c to the axis, and on the branch s = +-1
//                           g(u) = (z(u) - z0) - s (dz / a) sqrt((r - c)(r + c)),
//   steep rays:             g(u) = r(u) - sqrt(C + tau (2 B + A tau)),  tau = (z(u) - z0) / dz.
// Roots of g are isolated and bracketed on monotone pieces, then polished in (u, tau) together.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "lanes.hpp"
#include "meridian.hpp"
#include "vector.hpp"

namespace glass {

class Revolved {
public:
    Revolved(const std::vector<Segment>& meridian, const Vector& base, const Vector& axis) : base_(base) {
        const Vector away = std::fabs(axis.x) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0};
        rotation_.row[2] = normalised(axis);
        rotation_.row[0] = normalised(away - dot(away, rotation_.row[2]) * rotation_.row[2]);
        rotation_.row[1] = cross(rotation_.row[2], rotation_.row[0]);
        MeridianCutter cutter;
        for (const Segment& segment : meridian) cutter.add(segment);
        pieces_ = std::move(cutter.pieces);
        double r_max = 0.0;
        z_low_ = INFINITY;
        z_high_ = -INFINITY;
        for (const Piece& p : pieces_) {
            r_max = greater(r_max, greater(p.r_start, p.r_end));
            z_low_ = lesser(z_low_, lesser(p.z_start, p.z_end));
            z_high_ = greater(z_high_, greater(p.z_start, p.z_end));
        }
        for (const double z : {z_low_, z_high_}) {
            const Vector centre = base_ + z * rotation_.row[2];
            const Vector& n = rotation_.row[2];
            const Vector reach = {r_max * std::sqrt(greater(0.0, 1.0 - n.x * n.x)),
                                  r_max * std::sqrt(greater(0.0, 1.0 - n.y * n.y)),
                                  r_max * std::sqrt(greater(0.0, 1.0 - n.z * n.z))};
            bounds_.include(centre - reach);
            bounds_.include(centre + reach);
        }
        r2_high_ = (1.0 + 1e-8) * r_max * r_max;
        const double size = greater(r_max, z_high_ - z_low_);
        inverse_size_ = 1.0 / size;
        margin_ = 1e-9 * size;
        noise_ = 2e-15 * greater(r_max, greater(-z_low_, z_high_));
        std::vector<int> order(pieces_.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
        root_ = build(order.data(), static_cast<int>(order.size()));
    }

    static constexpr double largest_slack() { return 0.0; }

    const Box& bounds() const { return bounds_; }

    // Calls visit(hit) for the crossings with t in [t_min, t_best], which the visitor may shorten as it goes. `start`
    // is the hit that the ray starts at, if it starts on this surface: that root is not looked for again.
    template <class Visit>
    void crossings(const Ray& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        walk(Chart(*this, ray), t_min, t_best, start, visit);
    }

    void place(const Ray& ray, const Hit& hit, Vector& point, Vector& normal) const {
        const Vector o = rotation_.to_local(ray.origin - base_), d = rotation_.to_local(ray.direction);
        const double x = o.x + hit.t * d.x, y = o.y + hit.t * d.y;
        const CurvePoint c = pieces_[hit.part].at(hit.u);
        const double r = std::sqrt(x * x + y * y);
        const double inverse_r = 1.0 / r;
        const double ex = r > 0.0 ? x * inverse_r : 1.0, ey = r > 0.0 ? y * inverse_r : 0.0;
        const double radius = greater(c.r, 0.0);
        point = base_ + rotation_.to_world({radius * ex, radius * ey, c.z});
        // A collapsed control polygon has no tangent at its end; the chord's stands in for it.
        double dr = c.dr, dz = c.dz;
        if (dr == 0.0 && dz == 0.0) {
            const Piece& p = pieces_[hit.part];
            dr = p.r_end - p.r_start;
            dz = p.z_end - p.z_start;
        }
        const double scale = 1.0 / std::sqrt(dr * dr + dz * dz);
        normal = rotation_.to_world({scale * dz * ex, scale * dz * ey, -scale * dr});
    }

private:
    static constexpr int width = lane_count;

    // Boxes in float32, larger than what is in them by more than its rounding.
    struct Node {
        Lanes r2_low, r2_high, z_low, z_high;
        std::int32_t child[width];  // a node, or ~piece
        unsigned children = 0;      // one bit each
    };

    struct Chart {
        double A, B, C, z0, dz;
        double c, a, slope;  // closest approach, horizontal speed, dz / a
        double shift;        // tau = t - shift
        double inverse_dz, inverse_a, inverse_A;
        double px, py, dx, dy;
        bool flat;

        Chart(const Revolved& body, const Ray& ray) {
            const Vector o = body.rotation_.to_local(ray.origin - body.base_);
            const Vector d = body.rotation_.to_local(ray.direction);
            dx = d.x;
            dy = d.y;
            dz = d.z;
            A = dx * dx + dy * dy;
            flat = dz * dz < A;
            inverse_A = A > 1e-200 ? 1.0 / A : 0.0;
            a = std::sqrt(A);
            inverse_a = a * inverse_A;
            shift = -(o.x * dx + o.y * dy) * inverse_A;
            if (!flat) {
                const double low = (body.z_low_ - o.z) / dz, high = (body.z_high_ - o.z) / dz;
                shift = lesser(greater(shift, lesser(low, high)), greater(low, high));
            }
            px = o.x + shift * dx;
            py = o.y + shift * dy;
            z0 = o.z + shift * dz;
            C = px * px + py * py;
            c = std::sqrt(C);
            B = flat ? 0.0 : px * dx + py * dy;
            slope = flat ? dz * inverse_a : 0.0;
            inverse_dz = std::fabs(dz) > 1e-290 ? 1.0 / dz : 1e290;
        }
    };

    // A ray as nodes see it.
    struct Culling {
        float A, B, C, z0, inverse_A, inverse_dz, z_margin;

        explicit Culling(const Chart& ray)
            : A(static_cast<float>(ray.A)),
              B(static_cast<float>(ray.B)),
              C(static_cast<float>(ray.C)),
              z0(static_cast<float>(ray.z0)),
              inverse_A(static_cast<float>(ray.inverse_A)),
              inverse_dz(static_cast<float>(lesser(greater(ray.inverse_dz, -1e30), 1e30))),
              z_margin(2.0f * float_rounding * std::fabs(z0 * inverse_dz)) {}
    };
    static constexpr float float_rounding = 1.2e-7f;

    int build(const int* first, int count) {
        const int index = static_cast<int>(nodes_.size());
        nodes_.emplace_back();
        // Groups of neighbouring pieces along the chain: a chain is its own best hierarchy.
        int size = 1;
        while (size * width < count) size *= width;
        if (size > 1) size = std::max(width, (count + width - 1) / width);
        const double r2_margin = 1e-6 * r2_high_, z_margin = 1e-6 / inverse_size_;
        for (int start = 0, k = 0; start < count; start += size, ++k) {
            const int n = std::min(size, count - start);
            double r_low = INFINITY, r_high = 0.0, z_low = INFINITY, z_high = -INFINITY;
            for (int i = start; i < start + n; ++i) {
                const Piece& p = pieces_[first[i]];
                r_low = lesser(r_low, lesser(p.r_start, p.r_end));
                r_high = greater(r_high, greater(p.r_start, p.r_end));
                z_low = lesser(z_low, lesser(p.z_start, p.z_end));
                z_high = greater(z_high, greater(p.z_start, p.z_end));
            }
            const int child = n == 1 ? ~first[start] : build(first + start, n);
            const double rounding = 1e-6 * greater(std::fabs(z_low), std::fabs(z_high));
            Node& node = nodes_[index];
            node.r2_low.set(k, static_cast<float>(r_low * r_low - r2_margin));
            node.r2_high.set(k, static_cast<float>(r_high * r_high + r2_margin));
            node.z_low.set(k, static_cast<float>(z_low - z_margin - rounding));
            node.z_high.set(k, static_cast<float>(z_high + z_margin + rounding));
            node.child[k] = child;
            node.children |= 1u << k;
        }
        return index;
    }

    // For each child the interval of tau in which the ray can be inside its box: the slab of z, then the annulus of r,
    // whose r^2 is a convex function of tau. Empty where high < low. Products and roots are widened by their rounding;
    // that of differences the boxes have room for.
    static void reach(const Node& node, const Culling& ray, bool flat, float tau_low, float tau_high, Lanes& low,
                      Lanes& high) {
        const Lanes t1 = (node.z_low - ray.z0) * ray.inverse_dz, t2 = (node.z_high - ray.z0) * ray.inverse_dz;
        const Lanes near = smaller(t1, t2), far = larger(t1, t2);
        const Lanes margin = larger(far, -near) * (4.0f * float_rounding) + ray.z_margin;
        low = larger(near - margin, every(tau_low));
        high = smaller(far + margin, every(tau_high));
        const Lanes nothing = every(-INFINITY);
        if (flat) {
            constexpr float more = 1.0f + 4.0f * float_rounding, less = 1.0f - 4.0f * float_rounding;
            const Lanes none = every(0.0f);
            const Lanes outer = (node.r2_high - ray.C) * ray.inverse_A;
            const Lanes inner = (node.r2_low - ray.C) * ray.inverse_A;
            const Lanes out = square_root(larger(outer, none)) * more, in = square_root(larger(inner, none)) * less;
            low = larger(low, -out);
            high = smaller(high, out);
            low = where_greater(low, -in, larger(low, in), low);
            high = where_greater(in, high, smaller(high, -in), high);
            high = where_greater(none, outer, nothing, high);
        } else {
            const Lanes nearest = smaller(larger(every(-ray.B * ray.inverse_A), low), high);
            const Lanes r2_low = low * (low * ray.A + 2.0f * ray.B) + ray.C;
            const Lanes r2_high = high * (high * ray.A + 2.0f * ray.B) + ray.C;
            const Lanes r2_nearest = nearest * (nearest * ray.A + 2.0f * ray.B) + ray.C;
            high = where_greater(r2_nearest, node.r2_high, nothing, high);
            high = where_greater(node.r2_low, larger(r2_low, r2_high), nothing, high);
        }
    }

    template <class Visit>
    void walk(const Chart& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        if (ray.C > r2_high_) return;
        const auto tau = [&](double t, double way) {
            const double exact = t - ray.shift;
            return static_cast<float>(exact + way * (margin_ + 1e-6 * std::fabs(exact)));
        };
        const Culling culling(ray);
        const float tau_min = tau(t_min, -1.0);
        float tau_best = tau(t_best, 1.0);
        double known_best = t_best;
        // What waits, the nearest last.
        float waiting_low[8 * width], waiting_high[8 * width];
        std::int32_t waiting[8 * width];
        waiting_low[0] = tau_min;
        waiting_high[0] = INFINITY;
        waiting[0] = root_;
        int depth = 1;
        while (depth > 0) {
            --depth;
            if (t_best != known_best) {
                known_best = t_best;
                tau_best = tau(t_best, 1.0);
            }
            if (waiting_low[depth] > tau_best) continue;
            const std::int32_t child = waiting[depth];
            if (child < 0) {
                solve(ray, ~child, waiting_low[depth], waiting_high[depth], start, visit);
                continue;
            }
            const Node& node = nodes_[child];
            Lanes low, high;
            reach(node, culling, ray.flat, tau_min, tau_best, low, high);
            const int first = depth;
            for (unsigned reached = where_no_larger(low, high) & node.children; reached != 0; reached &= reached - 1) {
                const int k = lowest_bit(reached);
                const float its_low = low[k];
                int place = depth++;
                for (; place > first && waiting_low[place - 1] < its_low; --place) {
                    waiting_low[place] = waiting_low[place - 1];
                    waiting_high[place] = waiting_high[place - 1];
                    waiting[place] = waiting[place - 1];
                }
                waiting_low[place] = its_low;
                waiting_high[place] = high[k];
                waiting[place] = node.child[k];
            }
        }
    }

    template <class Visit>
    void solve(const Chart& ray, int number, float tau_low, float tau_high, const Hit& start, Visit&& visit) const {
        const Piece& piece = pieces_[number];
        const double u_start = number == start.part ? start.u : -1.0;
        if (!ray.flat) {
            isolate(SteepChart(ray, piece), ray, number, u_start, visit);
            return;
        }
        if (greater(piece.r_start, piece.r_end) <= ray.c) return;
        for (const double side : {-1.0, 1.0}) {
            if (side < 0.0 ? tau_low > 0.0f : tau_high < 0.0f) continue;
            const bool started_here = side * ray.shift < 0.0;
            isolate(FlatChart(ray, piece, side), ray, number, started_here ? u_start : -1.0, visit);
        }
    }

    struct Value {
        double g, slope;
    };

    // Flat rays. A piece that reaches inside the closest approach c is entered at r = c, where g has a square root;
    // with u = u_c +- x^2 it is smooth again. Elsewhere x = u.
    struct FlatChart {
        const Chart& ray;
        const Piece& piece;
        double side, k;
        int clip = 0;  // +1: the piece starts inside c, -1: it ends there
        double u_clip = 0.0, x_end = 1.0;

        FlatChart(const Chart& chart, const Piece& p, double s) : ray(chart), piece(p), side(s), k(s * chart.slope) {
            if (lesser(p.r_start, p.r_end) > ray.c || p.r_start == p.r_end) return;
            if (ray.c == 0.0) return;
            clip = p.r_start < p.r_end ? 1 : -1;
            u_clip = parameter_at_radius(p, ray.c);
            x_end = std::sqrt(clip > 0 ? 1.0 - u_clip : u_clip);
        }

        double parameter(double x) const { return clip == 0 ? x : u_clip + clip * x * x; }

        // sqrt(r^2 - c^2), and its rate in x. Where clipped, r - c is u - u_c times a divided difference, so that
        // neither loses digits as x goes to zero.
        Value half_chord(double x, const CurvePoint& p) const {
            if (clip == 0) {
                const double square = (p.r - ray.c) * (p.r + ray.c);
                const double root = std::sqrt(square > 0.0 ? square : 0.0);
                return {root, root > 0.0 ? p.r * p.dr / root : p.dr};
            }
            const double u = parameter(x);
            const double steepness = clip * piece.radius_difference(u, u_clip, ray.c) * (p.r + ray.c);
            const double root = std::sqrt(steepness > 0.0 ? steepness : 0.0);
            return {x * root, root > 0.0 ? 2.0 * clip * p.r * p.dr / root : 0.0};
        }

        Value at(double x) const {
            const CurvePoint p = piece.at(parameter(x));
            const double stretch = clip == 0 ? 1.0 : 2.0 * clip * x;
            const Value chord = half_chord(x, p);
            return {(p.z - ray.z0) - k * chord.g, p.dz * stretch - k * chord.slope};
        }

        // At a joint, from numbers that both pieces share.
        Value joint(double r, double z, double dr, double dz) const {
            const double square = (r - ray.c) * (r + ray.c);
            const double root = std::sqrt(square > 0.0 ? square : 0.0);
            return {(z - ray.z0) - k * root, dz - k * (root > 0.0 ? r * dr / root : dr)};
        }

        Value start() const {
            if (clip == 0) return joint(piece.r_start, piece.z_start, piece.dr_start, piece.dz_start);
            // Both branches meet at the closest approach and must see the same sign there.
            const double slope = at(0.0).slope;
            if (u_clip == 0.0) return {piece.z_start - ray.z0, slope};
            if (u_clip == 1.0) return {piece.z_end - ray.z0, slope};
            return {piece.at(u_clip).z - ray.z0, slope};
        }
        Value end() const {
            if (clip == 0) return joint(piece.r_end, piece.z_end, piece.dr_end, piece.dz_end);
            const double r = clip < 0 ? piece.r_start : piece.r_end, z = clip < 0 ? piece.z_start : piece.z_end;
            return {joint(r, z, 0.0, 0.0).g, at(x_end).slope};
        }

        double tau(double x, const CurvePoint& p) const { return side * half_chord(x, p).g * ray.inverse_a; }

        // dg/du = (d . n) r / (A tau): the sense of a crossing is the sense in which g changes sign.
        bool entering(bool rising) const { return (rising == (clip >= 0)) == (side < 0.0); }
    };

    struct SteepChart {
        const Chart& ray;
        const Piece& piece;
        static constexpr double x_end = 1.0;

        SteepChart(const Chart& chart, const Piece& p) : ray(chart), piece(p) {}

        double parameter(double x) const { return x; }

        Value at(double x) const {
            const CurvePoint p = piece.at(x);
            const double t = (p.z - ray.z0) * ray.inverse_dz;
            const double r2 = ray.C + t * (2.0 * ray.B + t * ray.A);
            const double r = std::sqrt(r2 > 0.0 ? r2 : 0.0);
            const double climb = (ray.B + ray.A * t) * p.dz * ray.inverse_dz;
            return {p.r - r, p.dr - (r > 0.0 ? climb / r : 0.0)};
        }

        double joint(double r, double z) const {
            const double t = (z - ray.z0) * ray.inverse_dz;
            const double r2 = ray.C + t * (2.0 * ray.B + t * ray.A);
            const double g = r - std::sqrt(r2 > 0.0 ? r2 : 0.0);
            // A ray through the very end on the axis crosses the piece: across the axis lies its mirror image.
            return r == 0.0 && g == 0.0 ? -1e-300 : g;
        }

        Value start() const { return {joint(piece.r_start, piece.z_start), at(0.0).slope}; }
        Value end() const { return {joint(piece.r_end, piece.z_end), at(1.0).slope}; }

        double tau(double, const CurvePoint& p) const { return (p.z - ray.z0) * ray.inverse_dz; }

        // dg/du = -(d . n) r / (dz rho).
        bool entering(bool rising) const { return rising == (ray.dz > 0.0); }
    };

    static double parameter_at_radius(const Piece& piece, double radius) {
        double low = 0.0, high = 1.0;
        const bool rising = piece.r_end > piece.r_start;
        double u = (radius - piece.r_start) / (piece.r_end - piece.r_start);
        for (int i = 0; i < 60; ++i) {
            const CurvePoint p = piece.at(u);
            ((p.r < radius) == rising ? low : high) = u;
            double next = u - (p.r - radius) / p.dr;
            if (!(next > low && next < high)) next = 0.5 * (low + high);
            if (std::fabs(next - u) < 1e-15) break;
            u = next;
        }
        return u;
    }

    template <class Function>
    struct Part {
        double low, high;
        Value at_low, at_high;
    };

    // Splits the piece until g, seen as the cubic with its end values and slopes, can have at most one root on a part.
    // The bends of the piece and of the hyperbola may add up to an inflection of g, so end slopes alone are not enough.
    template <class Function, class Visit>
    void isolate(const Function& function, const Chart& ray, int number, double u_start, Visit&& visit) const {
        constexpr int deepest_split = 48;
        Part<Function> waiting[deepest_split + 2];
        int count = 0;
        Part<Function> part = {0.0, function.x_end, function.start(), function.end()};
        for (;;) {
            const double third = (part.high - part.low) / 3.0;
            const double g0 = part.at_low.g, g3 = part.at_high.g;
            const double g1 = g0 + third * part.at_low.slope, g2 = g3 - third * part.at_high.slope;
            const bool monotone = g3 > g0 ? g1 >= g0 && g2 >= g1 && g3 >= g2 : g1 <= g0 && g2 <= g1 && g3 <= g2;
            const bool crosses = (g0 >= 0.0) != (g3 >= 0.0);
            bool settled = monotone || count + 2 > deepest_split || !(part.high - part.low > 1e-14);
            if (!settled) {
                const double lowest = lesser(lesser(g0, g1), lesser(g2, g3));
                const double highest = greater(greater(g0, g1), greater(g2, g3));
                const double distance = g0 >= 0.0 ? lowest : -highest;
                // Where a ray runs along the surface g is rounding errors only, and splitting would find each of them.
                settled = (!crosses && distance > 0.25 * (highest - lowest)) || greater(highest, -lowest) <= noise_;
            }
            if (!settled) {
                const double middle = 0.5 * (part.low + part.high);
                const Value value = function.at(middle);
                waiting[count++] = {middle, part.high, value, part.at_high};
                part = {part.low, middle, part.at_low, value};
                continue;
            }
            if (crosses) {
                const double u_low = function.parameter(part.low), u_high = function.parameter(part.high);
                const bool starts_here = u_start >= lesser(u_low, u_high) && u_start <= greater(u_low, u_high);
                if (!starts_here) report(function, ray, number, part, visit);
            }
            if (count == 0) return;
            part = waiting[--count];
        }
    }

    // The cubic through both ends with x as a function of g: where it says that g is zero.
    template <class Function>
    static double guess(const Part<Function>& part) {
        const double g0 = part.at_low.g, g1 = part.at_high.g, span = g1 - g0;
        const double s = -g0 / span, t = 1.0 - s;
        const double m0 = span / part.at_low.slope, m1 = span / part.at_high.slope;
        const double x =
            t * t * (1.0 + 2.0 * s) * part.low + s * s * (3.0 - 2.0 * s) * part.high + s * t * t * m0 - s * s * t * m1;
        return x >= part.low && x <= part.high ? x : part.low + s * (part.high - part.low);
    }

    // Newton within a bracket, by bisection where Newton leaves it.
    template <class Function>
    static double root(const Function& function, const Part<Function>& part) {
        const bool rising = part.at_low.g < 0.0;
        double low = part.low, high = part.high, x = guess(part);
        double previous = high - low;
        for (int i = 0; i < 80; ++i) {
            const Value value = function.at(x);
            ((value.g < 0.0) == rising ? low : high) = x;
            double next = x - value.g / value.slope;
            if (!(next >= low && next <= high)) next = 0.5 * (low + high);
            const double step = std::fabs(next - x);
            x = next;
            // Near a double root Newton's steps only halve, and a small one does not mean that the root is near.
            if (step < 1e-15 || (step < 1e-9 && step < 0.01 * previous)) break;
            previous = step;
        }
        return x;
    }

    struct Root {
        double u, tau;
        bool converged;
    };

    // Newton in (u, tau) together: no square root, so full accuracy where the charts' own would lose it. For a flat ray
    // u hardly depends on tau and settles first: what both steps leave of the first equation must have become small.
    Root polished(const Piece& piece, const Chart& ray, double u, double tau, CurvePoint p) const {
        double step = 1.0;
        for (int i = 0; i < 5; ++i, p = piece.at(u)) {
            const double f1 = ray.C + tau * (2.0 * ray.B + tau * ray.A) - p.r * p.r;
            const double f2 = ray.z0 + tau * ray.dz - p.z;
            const double climb = ray.B + ray.A * tau;
            const double rr = p.r * p.dr;
            const double inverse = 0.5 / (rr * ray.dz - climb * p.dz);
            const double d_u = (f1 * ray.dz - 2.0 * climb * f2) * inverse;
            const double d_tau = (f1 * p.dz - 2.0 * rr * f2) * inverse;
            u += d_u;
            tau += d_tau;
            const double before = step;
            step = std::fabs(d_u);
            if (step < 1e-8 && step < 0.01 * before) {
                // The next step would be this, in u and in tau; near the axis and for flat rays it may not be small.
                const double left = (ray.A * d_tau * d_tau + p.dr * p.dr * d_u * d_u) * std::fabs(inverse);
                if (left * (std::fabs(ray.dz) + std::fabs(p.dz) * inverse_size_) < 1e-15) return {u, tau, true};
            }
            if (!(step < 0.25)) break;
        }
        return {u, tau, false};
    }

    template <class Function, class Visit>
    void report(const Function& function, const Chart& ray, int number, const Part<Function>& part,
                Visit&& visit) const {
        const Piece& piece = pieces_[number];
        double x = guess(part);
        double u = function.parameter(x);
        CurvePoint p = piece.at(u);
        Root found = polished(piece, ray, u, function.tau(x, p), p);
        const double u_low = function.parameter(part.low), u_high = function.parameter(part.high);
        const double slack = 1e-9;
        if (!found.converged || !(found.u >= lesser(u_low, u_high) - slack) ||
            !(found.u <= greater(u_low, u_high) + slack)) {
            x = root(function, part);
            u = function.parameter(x);
            p = piece.at(u);
            const double tau = function.tau(x, p);
            found = polished(piece, ray, u, tau, p);
            if (!found.converged || !(std::fabs(found.u - u) < 1e-6)) found = {u, tau, false};
        }
        const double on_piece = lesser(greater(found.u, 0.0), 1.0);
        visit(Hit{found.tau + ray.shift, function.entering(part.at_high.g >= 0.0), number, on_piece, 0.0});
    }

    std::vector<Piece> pieces_;
    std::vector<Node> nodes_;
    int root_ = 0;
    Vector base_;
    Rotation rotation_;
    Box bounds_;
    double z_low_, z_high_, r2_high_, inverse_size_, margin_, noise_;
};

}  // namespace glass
