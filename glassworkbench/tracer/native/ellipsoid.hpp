// An ellipsoid.
#pragma once

#include <cmath>

#include "vector.hpp"

namespace glass {

class Ellipsoid {
public:
    Ellipsoid(const Vector& centre, const Vector& semi_axes, const Rotation& rotation)
        : centre_(centre), semi_axes_(semi_axes), rotation_(rotation) {
        Vector reach{};
        for (int k = 0; k < 3; ++k) {
            const Vector arm = semi_axes_[k] * rotation_.row[k];
            reach = {std::hypot(reach.x, arm.x), std::hypot(reach.y, arm.y), std::hypot(reach.z, arm.z)};
        }
        bounds_.include(centre_ - reach);
        bounds_.include(centre_ + reach);
    }

    static constexpr double largest_slack() { return 0.0; }

    const Box& bounds() const { return bounds_; }

    // Calls visit(hit) for both crossings. The ray is shifted to its closest approach to the centre of the unit
    // sphere, so the discriminant is formed without cancellation.
    template <class Visit>
    void crossings(const Ray& ray, double, const double&, const Hit&, Visit&& visit) const {
        const Vector o = to_sphere(ray.origin - centre_);
        const Vector d = to_sphere(ray.direction);
        const double a = dot(d, d);
        const double shift = -dot(o, d) / a;
        const Vector closest = o + shift * d;
        const double distance = length(closest);
        const double discriminant = (1.0 - distance) * (1.0 + distance) / a;
        if (discriminant <= 0.0) return;
        const double half_chord = std::sqrt(discriminant);
        visit(Hit{shift - half_chord, true, 0, 0.0, 0.0});
        visit(Hit{shift + half_chord, false, 0, 0.0, 0.0});
    }

    // The point of a hit, moved onto the surface, and the outward normal there.
    void place(const Ray& ray, const Hit& hit, Vector& point, Vector& normal) const {
        const Vector q = normalised(to_sphere(ray.at(hit.t) - centre_));
        point = centre_ + rotation_.to_world({semi_axes_.x * q.x, semi_axes_.y * q.y, semi_axes_.z * q.z});
        normal = normalised(rotation_.to_world({q.x / semi_axes_.x, q.y / semi_axes_.y, q.z / semi_axes_.z}));
    }

private:
    Vector to_sphere(const Vector& v) const {
        const Vector local = rotation_.to_local(v);
        return {local.x / semi_axes_.x, local.y / semi_axes_.y, local.z / semi_axes_.z};
    }

    Vector centre_, semi_axes_;
    Rotation rotation_;
    Box bounds_;
};

}  // namespace glass
