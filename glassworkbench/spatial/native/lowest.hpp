// The point s of a curved triangle where |p - s| - t(s) is lowest, t linear over the triangle.
//
// Over a plane at distance d, with the gradient g of t in it, the minimum lies d g / sqrt(1 - g^2) from p's foot. The
// function is convex, so that is the minimum over the triangle if inside, else it lies on a side, where the same holds
// in one dimension. A thickness that grows faster than the distance (|g| >= 1) pushes the minimum to an end.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace spatial {

struct Vector {
    double x = 0.0, y = 0.0, z = 0.0;

    double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(double s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Triangle {
    std::array<Vector, 3> corner;
    std::array<Vector, 3> normal;
    std::array<double, 3> thickness;
    // Four times the height of the surface over the middles of the sides 01, 12, 20: see surface().
    std::array<double, 3> sag;
};

using Shares = std::array<double, 3>;

constexpr std::array<std::array<int, 2>, 3> kSides = {{{0, 1}, {1, 2}, {2, 0}}};

// The harmonic mean of the slopes with which the surface leaves a side at its ends: see sags() in bulge.py.
inline void set_sags(Triangle& triangle) {
    for (int side = 0; side < 3; ++side) {
        const auto [i, j] = kSides[side];
        const Vector along = triangle.corner[j] - triangle.corner[i];
        const double start = -dot(triangle.normal[i], along), end = dot(triangle.normal[j], along);
        triangle.sag[side] = start * end > 0.0 ? 2.0 * start * end / (start + end) : 0.0;
    }
}

// Between two corners i and j the surface stands b_i b_j sag_ij above the chord.
inline Vector surface(const Triangle& triangle, const Shares& b) {
    Vector point, normal;
    double height = 0.0;
    for (int k = 0; k < 3; ++k) {
        point = point + b[k] * triangle.corner[k];
        normal = normal + b[k] * triangle.normal[k];
        const auto [i, j] = kSides[k];
        height += b[i] * b[j] * triangle.sag[k];
    }
    return point + (height / std::max(std::sqrt(dot(normal, normal)), 1e-300)) * normal;
}

inline Shares lowest_on_sides(const Triangle& triangle, const Vector& p) {
    Shares best = {1.0, 0.0, 0.0};
    double lowest = std::numeric_limits<double>::infinity();
    for (const auto& [i, j] : kSides) {
        const Vector along = triangle.corner[j] - triangle.corner[i], offset = p - triangle.corner[i];
        const double length = std::max(std::sqrt(dot(along, along)), 1e-300);
        const double foot = dot(offset, along) / length;
        const double gap = std::sqrt(std::max(dot(offset, offset) - foot * foot, 0.0));
        const double rise = triangle.thickness[j] - triangle.thickness[i], slope = rise / length;
        double share;
        if (std::abs(slope) >= 1.0) {
            share = slope > 0.0 ? 1.0 : 0.0;
        } else {
            share = std::clamp((foot + gap * slope / std::sqrt(1.0 - slope * slope)) / length, 0.0, 1.0);
        }
        const double beyond = foot - share * length;
        const double value = std::sqrt(gap * gap + beyond * beyond) - (triangle.thickness[i] + share * rise);
        if (value < lowest) {
            lowest = value;
            best = {0.0, 0.0, 0.0};
            best[i] = 1.0 - share;
            best[j] = share;
        }
    }
    return best;
}

inline Shares lowest(const Triangle& triangle, const Vector& p) {
    const Vector ab = triangle.corner[1] - triangle.corner[0], ac = triangle.corner[2] - triangle.corner[0];
    const Vector ap = p - triangle.corner[0];
    const double d00 = dot(ab, ab), d01 = dot(ab, ac), d11 = dot(ac, ac), d20 = dot(ap, ab), d21 = dot(ap, ac);
    const double determinant = d00 * d11 - d01 * d01;
    if (determinant > 1e-24 * d00 * d11) {
        double v = (d11 * d20 - d01 * d21) / determinant, w = (d00 * d21 - d01 * d20) / determinant;
        const double t1 = triangle.thickness[1] - triangle.thickness[0];
        const double t2 = triangle.thickness[2] - triangle.thickness[0];
        const double gv = (d11 * t1 - d01 * t2) / determinant, gw = (d00 * t2 - d01 * t1) / determinant;
        const double squared = gv * t1 + gw * t2;
        if (squared < 1.0) {
            const double gap = std::max(dot(ap, ap) - (v * d20 + w * d21), 0.0);
            const double reach = std::sqrt(gap / (1.0 - squared));
            v += reach * gv;
            w += reach * gw;
            if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return {1.0 - v - w, v, w};
        }
    }
    return lowest_on_sides(triangle, p);
}

}  // namespace spatial
