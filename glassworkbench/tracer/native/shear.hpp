// A surface seen along a ray, and how often a polygon winds about it.
#pragma once

#include <cmath>
#include <utility>

#include "vector.hpp"

namespace glass {

// Space seen along a ray: its origin at (0, 0), its direction the third axis (the largest component of the direction),
// the others sheared so that the ray stays in place. A surface that turns counter-clockwise here is left by the ray.
struct Shear {
    int kx, ky, kz;
    double sx, sy, sz;
    Vector origin;

    explicit Shear(const Ray& ray) : origin(ray.origin) {
        const Vector& d = ray.direction;
        kz = std::fabs(d.x) > std::fabs(d.y) ? (std::fabs(d.x) > std::fabs(d.z) ? 0 : 2)
                                             : (std::fabs(d.y) > std::fabs(d.z) ? 1 : 2);
        kx = (kz + 1) % 3;
        ky = (kx + 1) % 3;
        if (d[kz] < 0.0) std::swap(kx, ky);
        sx = d[kx] / d[kz];
        sy = d[ky] / d[kz];
        sz = 1.0 / d[kz];
    }

    // z is the coordinate along the ray: t = sz z.
    Vector direction(const Vector& v) const { return {v[kx] - sx * v[kz], v[ky] - sy * v[kz], v[kz]}; }
    Vector point(const Vector& p) const { return direction(p - origin); }
};

inline double area(const Vector& p, const Vector& q) { return p.x * q.y - q.x * p.y; }

// What the edge from p to q adds to the winding number about the ray of a closed polygon seen along it: +-1 where the
// edge crosses the half-axis x > 0. The way back adds the opposite, in floating point too.
inline int winding(const Vector& p, const Vector& q, double area_pq) {
    const bool rises = q.y >= 0.0;
    if ((p.y >= 0.0) == rises) return 0;
    return rises ? (area_pq > 0.0) : -(area_pq < 0.0);
}

}  // namespace glass
