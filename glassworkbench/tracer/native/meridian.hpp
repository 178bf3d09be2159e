// A meridian cut into pieces on which r and z are monotone and the curve bends one way by a small angle.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "bernstein.hpp"

namespace glass {

struct Control {
    double r, z, weight;
};
using Segment = std::array<Control, 4>;

struct CurvePoint {
    double r, z, dr, dz;  // derivatives with respect to u
};

// One piece. Neighbours share their end points to the last bit: the sign of a ray's distance to a joint is the
// same number seen from both, so a ray through a joint crosses exactly one of the two.
struct Piece {
    double r[4], z[4], w[4];  // power basis in u; r and z are multiplied by the weight where it varies
    bool rational = false;
    double r_start, z_start, r_end, z_end;
    double dr_start, dz_start, dr_end, dz_end;  // as at(0) and at(1) have them

    CurvePoint at(double u) const {
        const double x = r[0] + u * (r[1] + u * (r[2] + u * r[3]));
        const double y = z[0] + u * (z[1] + u * (z[2] + u * z[3]));
        const double dx = r[1] + u * (2.0 * r[2] + 3.0 * u * r[3]);
        const double dy = z[1] + u * (2.0 * z[2] + 3.0 * u * z[3]);
        if (!rational) return {x, y, dx, dy};
        const double inverse = 1.0 / (w[0] + u * (w[1] + u * (w[2] + u * w[3])));
        const double dw = w[1] + u * (2.0 * w[2] + 3.0 * u * w[3]);
        const double px = x * inverse, py = y * inverse;
        return {px, py, (dx - px * dw) * inverse, (dy - py * dw) * inverse};
    }

    // (r(u) - radius) / (u - v), where r(v) = radius, without the cancellation.
    double radius_difference(double u, double v, double radius) const {
        const double square = u + v, cube = u * u + u * v + v * v;
        const double rise = r[1] + r[2] * square + r[3] * cube;
        if (!rational) return rise;
        const double weight = w[0] + u * (w[1] + u * (w[2] + u * w[3]));
        return (rise - radius * (w[1] + w[2] * square + w[3] * cube)) / weight;
    }
};

inline void power_basis(const Bernstein& b, double (&p)[4]) {
    p[0] = b[0];
    p[1] = 3.0 * (b[1] - b[0]);
    p[2] = 3.0 * ((b[2] - b[1]) - (b[1] - b[0]));
    p[3] = (b[3] - b[0]) - 3.0 * (b[2] - b[1]);
}

class MeridianCutter {
public:
    // Twelve degrees: a hyperbola and a piece that bends less meet at most twice on each branch.
    static constexpr double largest_turn = 0.21;
    static constexpr double smallest_piece = 1e-9;  // in u

    std::vector<Piece> pieces;

    void add(const Segment& segment) {
        Bernstein r(4), z(4), w(4);
        bool rational = false;
        for (int k = 0; k < 4; ++k) {
            w[k] = segment[k].weight / segment[0].weight;
            rational = rational || w[k] != 1.0;
        }
        for (int k = 0; k < 4; ++k) {
            r[k] = segment[k].r * w[k];
            z[k] = segment[k].z * w[k];
        }
        std::vector<double> cuts = {0.0};
        const Bernstein dr = difference(product(derivative(r), w), product(r, derivative(w)));
        const Bernstein dz = difference(product(derivative(z), w), product(z, derivative(w)));
        sign_changes(dr, 0.0, 1.0, 50, cuts);
        sign_changes(dz, 0.0, 1.0, 50, cuts);
        sign_changes(difference(product(dr, derivative(dz)), product(dz, derivative(dr))), 0.0, 1.0, 50, cuts);
        std::sort(cuts.begin(), cuts.end());
        // A cut within rounding of another, or of an end, would leave a piece whose tangent is noise.
        const auto crowded = [](double a, double b) { return b - a < smallest_piece; };
        cuts.erase(std::unique(cuts.begin(), cuts.end(), crowded), cuts.end());
        while (cuts.size() > 1 && crowded(cuts.back(), 1.0)) cuts.pop_back();
        cuts.push_back(1.0);

        double r_start = segment[0].r, z_start = segment[0].z;
        for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
            cut(r, z, w, rational, cuts[i], cuts[i + 1], segment, r_start, z_start);
    }

private:
    static Bernstein part(const Bernstein& a, double low, double high) {
        Bernstein left, right, inner, rest;
        subdivide(a, high, left, rest);
        subdivide(left, high > 0.0 ? low / high : 0.0, inner, right);
        return right;
    }

    void cut(const Bernstein& r, const Bernstein& z, const Bernstein& w, bool rational, double low, double high,
             const Segment& segment, double& r_start, double& z_start) {
        const Bernstein pr = part(r, low, high), pz = part(z, low, high), pw = part(w, low, high);
        double turn = 0.0;
        double previous_r = 0.0, previous_z = 0.0;
        for (int k = 0; k < 3; ++k) {
            const double step_r = pr[k + 1] / pw[k + 1] - pr[k] / pw[k], step_z = pz[k + 1] / pw[k + 1] - pz[k] / pw[k];
            if (k > 0 && (step_r != 0.0 || step_z != 0.0) && (previous_r != 0.0 || previous_z != 0.0))
                turn += std::fabs(
                    std::atan2(previous_r * step_z - previous_z * step_r, previous_r * step_r + previous_z * step_z));
            if (step_r != 0.0 || step_z != 0.0) previous_r = step_r, previous_z = step_z;
        }
        if (turn > largest_turn && high - low > 1e-6) {
            const double middle = 0.5 * (low + high);
            cut(r, z, w, rational, low, middle, segment, r_start, z_start);
            cut(r, z, w, rational, middle, high, segment, r_start, z_start);
            return;
        }
        Piece piece;
        piece.rational = rational;
        power_basis(pr, piece.r);
        power_basis(pz, piece.z);
        power_basis(pw, piece.w);
        piece.r_start = r_start;
        piece.z_start = z_start;
        piece.r_end = high == 1.0 ? segment[3].r : std::fmax(pr[3] / pw[3], 0.0);
        piece.z_end = high == 1.0 ? segment[3].z : pz[3] / pw[3];
        r_start = piece.r_end;
        z_start = piece.z_end;
        const CurvePoint start = piece.at(0.0), end = piece.at(1.0);
        piece.dr_start = start.dr;
        piece.dz_start = start.dz;
        piece.dr_end = end.dr;
        piece.dz_end = end.dz;
        pieces.push_back(piece);
    }
};

}  // namespace glass
