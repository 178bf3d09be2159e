// Many ellipsoids that do not touch, as one body: the bubbles of a glass.
#pragma once

#include <cstdint>
#include <vector>

#include "ellipsoid.hpp"
#include "hierarchy.hpp"
#include "vector.hpp"

namespace glass {

class Ellipsoids {
public:
    explicit Ellipsoids(const std::vector<Ellipsoid>& ellipsoids) : hierarchy_(boxes(ellipsoids)) {
        ellipsoids_.reserve(ellipsoids.size());
        for (const std::int32_t number : hierarchy_.order()) ellipsoids_.push_back(ellipsoids[number]);
    }

    static constexpr double largest_slack() { return 0.0; }

    const Box& bounds() const { return hierarchy_.bounds(); }

    // Both crossings of each ellipsoid or none, so a line enters the body as often as it leaves.
    template <class Visit>
    void crossings(const Ray& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        hierarchy_.visit(ray, t_min, t_best, [&](std::int32_t number) {
            ellipsoids_[number].crossings(ray, t_min, t_best, start, [&](Hit hit) {
                hit.part = number;
                hit.component = number;
                visit(hit);
            });
        });
    }

    void place(const Ray& ray, const Hit& hit, Vector& point, Vector& normal) const {
        ellipsoids_[hit.part].place(ray, hit, point, normal);
    }

private:
    static std::vector<Box> boxes(const std::vector<Ellipsoid>& ellipsoids) {
        std::vector<Box> boxes;
        boxes.reserve(ellipsoids.size());
        for (const Ellipsoid& ellipsoid : ellipsoids) boxes.push_back(ellipsoid.bounds());
        return boxes;
    }

    Hierarchy hierarchy_;
    std::vector<Ellipsoid> ellipsoids_;
};

}  // namespace glass
