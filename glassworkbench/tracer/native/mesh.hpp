// A closed triangle mesh with vertex normals, in a bounding volume hierarchy.
//
// The ray-triangle test is the watertight one of Woop, Benthin and Wald (2013) in float64: a ray through a shared edge
// or vertex meets the mesh the right number of times.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "vector.hpp"

namespace glass {

class Mesh {
public:
    using Triangle = std::array<std::int32_t, 3>;

    Mesh(std::vector<Vector> vertices, std::vector<Vector> normals, std::vector<Triangle> triangles)
        : vertices_(std::move(vertices)), normals_(std::move(normals)), triangles_(std::move(triangles)) {
        std::vector<Box> boxes(triangles_.size());
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            for (const std::int32_t corner : triangles_[i]) boxes[i].include(vertices_[corner]);
        order_.resize(triangles_.size());
        for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::int32_t>(i);
        nodes_.reserve(2 * triangles_.size());
        build(boxes, 0, static_cast<std::int32_t>(order_.size()));
        std::vector<Triangle> sorted(triangles_.size());
        for (std::size_t i = 0; i < order_.size(); ++i) sorted[i] = triangles_[order_[i]];
        triangles_ = std::move(sorted);
        order_ = {};
    }

    const Box& bounds() const { return nodes_.front().box; }

    template <class Visit>
    void crossings(const Ray& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        const Shear shear(ray);
        const Vector inverse = {1.0 / ray.direction.x, 1.0 / ray.direction.y, 1.0 / ray.direction.z};
        std::int32_t stack[128];
        int depth = 0;
        stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[stack[--depth]];
            if (!overlaps(node.box, ray.origin, inverse, t_min, t_best)) continue;
            if (node.count > 0) {
                for (std::int32_t i = node.first; i < node.first + node.count; ++i)
                    if (i != start.part) test(ray, shear, i, visit);
                continue;
            }
            const bool second_first = ray.direction[node.axis] < 0.0;
            const std::int32_t left = static_cast<std::int32_t>(&node - nodes_.data()) + 1;
            stack[depth++] = second_first ? left : node.first;
            stack[depth++] = second_first ? node.first : left;
        }
    }

    void place(const Ray& ray, const Hit& hit, Vector& point, Vector& normal) const {
        const Triangle& t = triangles_[hit.part];
        const double w = 1.0 - hit.u - hit.v;
        point = w * vertices_[t[0]] + hit.u * vertices_[t[1]] + hit.v * vertices_[t[2]];
        const Vector facet = facet_normal(hit, {});
        normal = normalised(w * normals_[t[0]] + hit.u * normals_[t[1]] + hit.v * normals_[t[2]]);
        // A vertex normal that disagrees with the facet about which side the ray comes from cannot be used here.
        if (!((dot(normal, ray.direction) < 0.0) == hit.entering)) normal = facet;
    }

    Vector facet_normal(const Hit& hit, const Vector&) const {
        const Triangle& t = triangles_[hit.part];
        return normalised(cross(vertices_[t[1]] - vertices_[t[0]], vertices_[t[2]] - vertices_[t[0]]));
    }

private:
    struct Node {
        Box box;
        std::int32_t first = 0;  // first triangle of a leaf, or the second child
        std::int32_t count = 0;
        int axis = 0;
    };

    struct Shear {
        int kx, ky, kz;
        double sx, sy, sz;

        explicit Shear(const Ray& ray) {
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
    };

    static bool overlaps(const Box& box, const Vector& o, const Vector& inverse, double t_min, double t_best) {
        // The far side is widened by the rounding of two products (Ize 2013).
        constexpr double widen = 1.0 + 8e-16;
        double low = t_min, high = t_best;
        for (int axis = 0; axis < 3; ++axis) {
            double a = (box.low[axis] - o[axis]) * inverse[axis];
            double b = (box.high[axis] - o[axis]) * inverse[axis];
            if (a > b) std::swap(a, b);
            // NaN (a flat box met by a parallel ray in its plane) leaves the interval as it is.
            const double margin = 1e-12 * std::fabs(b);
            if (a - margin > low) low = a - margin;
            if (b * widen + margin < high) high = b * widen + margin;
        }
        return low <= high;
    }

    template <class Visit>
    void test(const Ray& ray, const Shear& s, std::int32_t number, Visit&& visit) const {
        const Triangle& triangle = triangles_[number];
        const Vector a = vertices_[triangle[0]] - ray.origin, b = vertices_[triangle[1]] - ray.origin,
                     c = vertices_[triangle[2]] - ray.origin;
        const double ax = a[s.kx] - s.sx * a[s.kz], ay = a[s.ky] - s.sy * a[s.kz];
        const double bx = b[s.kx] - s.sx * b[s.kz], by = b[s.ky] - s.sy * b[s.kz];
        const double cx = c[s.kx] - s.sx * c[s.kz], cy = c[s.ky] - s.sy * c[s.kz];
        const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
        if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return;
        const double determinant = u + v + w;
        if (determinant == 0.0) return;
        const double scale = 1.0 / determinant;
        const double t = scale * s.sz * (u * a[s.kz] + v * b[s.kz] + w * c[s.kz]);
        visit(Hit{t, determinant > 0.0, number, v * scale, w * scale});
    }

    void build(const std::vector<Box>& boxes, std::int32_t first, std::int32_t count) {
        const std::size_t index = nodes_.size();
        nodes_.emplace_back();
        Box box, centres;
        for (std::int32_t i = first; i < first + count; ++i) {
            const Box& b = boxes[order_[i]];
            box.include(b);
            centres.include(0.5 * (b.low + b.high));
        }
        nodes_[index].box = box;
        const Vector extent = centres.high - centres.low;
        const int axis = extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);
        if (count <= 2 || !(extent[axis] > 0.0)) {
            nodes_[index].first = first;
            nodes_[index].count = count;
            return;
        }
        constexpr int bins = 16;
        const double low = centres.low[axis], scale = bins / extent[axis];
        const auto bin_of = [&](std::int32_t triangle) {
            const Box& b = boxes[triangle];
            return std::min(bins - 1, static_cast<int>((0.5 * (b.low[axis] + b.high[axis]) - low) * scale));
        };
        Box bin_box[bins];
        int bin_count[bins] = {};
        for (std::int32_t i = first; i < first + count; ++i) {
            const int k = bin_of(order_[i]);
            bin_box[k].include(boxes[order_[i]]);
            ++bin_count[k];
        }
        double right_cost[bins];
        Box sweep;
        int n = 0;
        for (int k = bins - 1; k > 0; --k) {
            sweep.include(bin_box[k]);
            n += bin_count[k];
            right_cost[k] = n == 0 ? 0.0 : n * sweep.half_area();
        }
        sweep = Box{};
        n = 0;
        int best = 0;
        double best_cost = INFINITY;
        for (int k = 0; k + 1 < bins; ++k) {
            sweep.include(bin_box[k]);
            n += bin_count[k];
            if (n == 0 || n == count) continue;
            const double cost = n * sweep.half_area() + right_cost[k + 1];
            if (cost < best_cost) {
                best_cost = cost;
                best = k;
            }
        }
        const auto middle = std::partition(order_.begin() + first, order_.begin() + first + count,
                                           [&](std::int32_t triangle) { return bin_of(triangle) <= best; });
        const std::int32_t left = static_cast<std::int32_t>(middle - order_.begin()) - first;
        build(boxes, first, left);
        nodes_[index].first = static_cast<std::int32_t>(nodes_.size());
        nodes_[index].axis = axis;
        build(boxes, first + left, count - left);
    }

    std::vector<Vector> vertices_, normals_;
    std::vector<Triangle> triangles_;
    std::vector<std::int32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace glass
