// A closed triangle mesh with vertex normals.
//
// Whether a triangle is crossed, and in which sense, is the winding number of its projection about the ray: the sum of
// what its edges add. An edge adds the opposite in the triangle on its other side, whatever the rounding, so over a
// closed mesh every line enters as often as it leaves, through edges and vertices too. Projected by the shear of Woop,
// Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2 (2013).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hierarchy.hpp"
#include "shear.hpp"
#include "vector.hpp"

namespace glass {

class Mesh {
public:
    using Triangle = std::array<std::int32_t, 3>;

    Mesh(const std::vector<Vector>& vertices, std::vector<Vector> normals, const std::vector<Triangle>& triangles)
        : hierarchy_(boxes(vertices, triangles)), normals_(std::move(normals)) {
        corners_.reserve(triangles.size());
        triangles_.reserve(triangles.size());
        for (const std::int32_t number : hierarchy_.order()) {
            const Triangle& t = triangles[number];
            triangles_.push_back(t);
            corners_.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
        }
    }

    static constexpr double largest_slack() { return 0.0; }

    const Box& bounds() const { return hierarchy_.bounds(); }

    template <class Visit>
    void crossings(const Ray& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        const Shear shear(ray);
        hierarchy_.visit(ray, t_min, t_best, [&](std::int32_t number) {
            if (number != start.part) test(shear, number, visit);
        });
    }

    void place(const Ray& ray, const Hit& hit, Vector& point, Vector& normal) const {
        const Triangle& t = triangles_[hit.part];
        const double w = 1.0 - hit.u - hit.v;
        const Corners& c = corners_[hit.part];
        point = w * c[0] + hit.u * c[1] + hit.v * c[2];
        const Vector facet = facet_normal(hit);
        normal = normalised(w * normals_[t[0]] + hit.u * normals_[t[1]] + hit.v * normals_[t[2]]);
        // A vertex normal that disagrees with the facet about which side the ray comes from cannot be used here.
        if (!((dot(normal, ray.direction) < 0.0) == hit.entering)) normal = facet;
    }

    Vector facet_normal(const Hit& hit) const {
        const Corners& c = corners_[hit.part];
        return normalised(cross(c[1] - c[0], c[2] - c[0]));
    }

private:
    using Corners = std::array<Vector, 3>;

    static std::vector<Box> boxes(const std::vector<Vector>& vertices, const std::vector<Triangle>& triangles) {
        std::vector<Box> boxes(triangles.size());
        for (std::size_t i = 0; i < triangles.size(); ++i)
            for (const std::int32_t corner : triangles[i]) boxes[i].include(vertices[corner]);
        return boxes;
    }

    template <class Visit>
    void test(const Shear& shear, std::int32_t number, Visit&& visit) const {
        const Corners& corners = corners_[number];
        const Vector a = shear.point(corners[0]), b = shear.point(corners[1]), c = shear.point(corners[2]);
        const double u = area(b, c), v = area(c, a), w = area(a, b);
        const int turns = winding(b, c, u) + winding(c, a, v) + winding(a, b, w);
        if (turns == 0) return;
        const double total = u + v + w;
        // Seen edge-on, to the last digit: any point of it is as good.
        const double second = total == 0.0 ? 1.0 / 3.0 : v / total, third = total == 0.0 ? 1.0 / 3.0 : w / total;
        const double depth = (1.0 - second - third) * a.z + second * b.z + third * c.z;
        visit(Hit{shear.sz * depth, turns < 0, number, second, third});
    }

    Hierarchy hierarchy_;
    std::vector<Vector> normals_;
    std::vector<Triangle> triangles_;
    std::vector<Corners> corners_;
};

}  // namespace glass
