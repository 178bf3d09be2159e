// A grid of rational Bezier patches, evaluated with its first derivatives.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "vector.hpp"

namespace glass {

struct SheetPoint {
    Vector point, by_u, by_v;
};

class Sheet {
public:
    static constexpr int highest_degree = 25;
    typedef double Homogeneous __attribute__((vector_size(32)));  // w x, w y, w z, w

    Sheet(int degree_u, int degree_v, std::vector<double> u_knots, std::vector<double> v_knots,
          const double* control_points)
        : degree_u_(degree_u), degree_v_(degree_v), u_knots_(std::move(u_knots)), v_knots_(std::move(v_knots)) {
        control_.resize((u_knots_.size() - 1) * (v_knots_.size() - 1) * (degree_u + 1) * (degree_v + 1));
        for (Homogeneous& point : control_) {
            point = Homogeneous{control_points[0], control_points[1], control_points[2], control_points[3]};
            control_points += 4;
        }
    }

    SheetPoint at(double u, double v) const {
        switch (100 * degree_u_ + degree_v_) {
            case 101:
                return evaluate<1, 1>(u, v);
            case 102:
                return evaluate<1, 2>(u, v);
            case 103:
                return evaluate<1, 3>(u, v);
            case 201:
                return evaluate<2, 1>(u, v);
            case 202:
                return evaluate<2, 2>(u, v);
            case 203:
                return evaluate<2, 3>(u, v);
            case 301:
                return evaluate<3, 1>(u, v);
            case 302:
                return evaluate<3, 2>(u, v);
            case 303:
                return evaluate<3, 3>(u, v);
            default:
                return evaluate<0, 0>(u, v);
        }
    }

private:
    // The patch that a parameter lies in or next to, its place there, and the patch's width.
    struct Place {
        std::size_t cell;
        double t, width;

        Place(const std::vector<double>& knots, double parameter) : cell(0) {
            const std::size_t last = knots.size() - 2;
            if (last > 0)
                cell = static_cast<std::size_t>(std::upper_bound(knots.begin() + 1, knots.end() - 1, parameter) -
                                                knots.begin()) -
                       1;
            width = knots[cell + 1] - knots[cell];
            t = (parameter - knots[cell]) / width;
        }
    };

    // Bernstein polynomials and their derivatives, each degree from the one below it.
    static void bernstein(int degree, double t, double* value, double* slope) {
        const double s = 1.0 - t;
        value[0] = 1.0;
        for (int n = 1; n <= degree; ++n) {
            if (n == degree) {
                slope[0] = -degree * value[0];
                for (int i = 1; i < n; ++i) slope[i] = degree * (value[i - 1] - value[i]);
                slope[n] = degree * value[n - 1];
            }
            value[n] = t * value[n - 1];
            for (int i = n - 1; i > 0; --i) value[i] = s * value[i] + t * value[i - 1];
            value[0] = s * value[0];
        }
    }

    static Vector affine(const Homogeneous& p, const Vector& point, double inverse_weight) {
        return inverse_weight * Vector{p[0] - point.x * p[3], p[1] - point.y * p[3], p[2] - point.z * p[3]};
    }

    // Degrees known to the compiler, or 0 for any.
    template <int known_u, int known_v>
    SheetPoint evaluate(double u, double v) const {
        const int m = known_u > 0 ? known_u : degree_u_, n = known_v > 0 ? known_v : degree_v_;
        constexpr int room_u = known_u > 0 ? known_u + 1 : highest_degree + 1;
        constexpr int room_v = known_v > 0 ? known_v + 1 : highest_degree + 1;
        const Place i(u_knots_, u), j(v_knots_, v);
        double bu[room_u], su[room_u], bv[room_v], sv[room_v];
        bernstein(m, i.t, bu, su);
        bernstein(n, j.t, bv, sv);
        const Homogeneous* row = control_.data() + (i.cell * (v_knots_.size() - 1) + j.cell) * (m + 1) * (n + 1);
        Homogeneous value{}, by_u{}, by_v{};
        for (int a = 0; a <= m; ++a, row += n + 1) {
            Homogeneous along = bv[0] * row[0], slope = sv[0] * row[0];
            for (int b = 1; b <= n; ++b) {
                along += bv[b] * row[b];
                slope += sv[b] * row[b];
            }
            value += bu[a] * along;
            by_u += su[a] * along;
            by_v += bu[a] * slope;
        }
        const double inverse = 1.0 / value[3];
        const Vector point = inverse * Vector{value[0], value[1], value[2]};
        return {point, affine(by_u, point, inverse / i.width), affine(by_v, point, inverse / j.width)};
    }

    int degree_u_, degree_v_;
    std::vector<double> u_knots_, v_knots_;
    std::vector<Homogeneous> control_;
};

}  // namespace glass
