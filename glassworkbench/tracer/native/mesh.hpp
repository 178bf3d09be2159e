// A closed triangle mesh with vertex normals, in a bounding volume hierarchy of eight children a node.
//
// The ray-triangle test is the watertight one of Woop, Benthin and Wald (2013) in float64: a ray through a shared edge
// or vertex meets the mesh the right number of times.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "lanes.hpp"
#include "vector.hpp"

namespace glass {

class Mesh {
public:
    using Triangle = std::array<std::int32_t, 3>;

    Mesh(const std::vector<Vector>& vertices, std::vector<Vector> normals, const std::vector<Triangle>& triangles)
        : normals_(std::move(normals)) {
        Builder builder(vertices, triangles);
        bounds_ = builder.nodes.front().box;
        corners_.reserve(triangles.size());
        triangles_.reserve(triangles.size());
        for (const std::int32_t number : builder.order) {
            const Triangle& t = triangles[number];
            triangles_.push_back(t);
            corners_.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
        }
        collapse(builder.nodes, 0);
    }

    const Box& bounds() const { return bounds_; }

    template <class Visit>
    void crossings(const Ray& ray, double t_min, const double& t_best, const Hit& start, Visit&& visit) const {
        const Shear shear(ray);
        const Slabs slabs(ray);
        struct Entry {
            double t;
            std::int32_t child, count;
        };
        Entry stack[lane_count * 64];
        int depth = 0;
        stack[depth++] = {t_min, 0, 0};
        while (depth > 0) {
            const Entry entry = stack[--depth];
            if (entry.t > t_best) continue;
            if (entry.count > 0) {
                for (std::int32_t i = entry.child; i < entry.child + entry.count; ++i)
                    if (i != start.part) test(ray, shear, i, visit);
                continue;
            }
            const Node& node = nodes_[entry.child];
            Lanes low, high;
            slabs.overlap(node, t_min, t_best, low, high);
            // Nearest last, so that it is taken first.
            const int first = depth;
            for (int k = 0; k < node.children; ++k) {
                if (!(low[k] <= high[k])) continue;
                int place = depth++;
                while (place > first && stack[place - 1].t < low[k]) {
                    stack[place] = stack[place - 1];
                    --place;
                }
                stack[place] = {low[k], node.child[k], node.count[k]};
            }
        }
    }

    void place(const Ray& ray, const Hit& hit, Vector& point, Vector& normal) const {
        const Triangle& t = triangles_[hit.part];
        const double w = 1.0 - hit.u - hit.v;
        const Corners& c = corners_[hit.part];
        point = w * c[0] + hit.u * c[1] + hit.v * c[2];
        const Vector facet = facet_normal(hit, {});
        normal = normalised(w * normals_[t[0]] + hit.u * normals_[t[1]] + hit.v * normals_[t[2]]);
        // A vertex normal that disagrees with the facet about which side the ray comes from cannot be used here.
        if (!((dot(normal, ray.direction) < 0.0) == hit.entering)) normal = facet;
    }

    Vector facet_normal(const Hit& hit, const Vector&) const {
        const Corners& c = corners_[hit.part];
        return normalised(cross(c[1] - c[0], c[2] - c[0]));
    }

private:
    using Corners = std::array<Vector, 3>;

    struct Node {
        Lanes low[3], high[3];
        std::int32_t child[lane_count];  // a node, or the first triangle of a leaf
        std::int32_t count[lane_count];  // triangles of a leaf, or 0
        int children = 0;
    };

    struct Slabs {
        double origin[3], inverse[3];

        explicit Slabs(const Ray& ray)
            : origin{ray.origin.x, ray.origin.y, ray.origin.z},
              inverse{1.0 / ray.direction.x, 1.0 / ray.direction.y, 1.0 / ray.direction.z} {}

        // Where the ray is inside each child's box; empty where high < low. The ends are widened by more than the
        // rounding of two products (Ize 2013); a NaN, from a ray in the plane of a flat box, leaves them as they are.
        void overlap(const Node& node, double t_min, double t_best, Lanes& low, Lanes& high) const {
            low = every(t_min);
            high = every(t_best);
            for (int axis = 0; axis < 3; ++axis) {
                const Lanes a = (node.low[axis] - origin[axis]) * inverse[axis];
                const Lanes b = (node.high[axis] - origin[axis]) * inverse[axis];
                const Lanes near = smaller(a, b), far = larger(a, b);
                const Lanes margin = 1e-12 * larger(far, -far);
                const Lanes enter = near - margin, leave = far + margin;
                low = enter > low ? enter : low;
                high = leave < high ? leave : high;
            }
        }
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

    template <class Visit>
    void test(const Ray& ray, const Shear& s, std::int32_t number, Visit&& visit) const {
        const Corners& corners = corners_[number];
        const Vector a = corners[0] - ray.origin, b = corners[1] - ray.origin, c = corners[2] - ray.origin;
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

    // The binary hierarchy from which the wide one is made, by the surface area heuristic in 16 bins.
    struct Builder {
        struct BinaryNode {
            Box box;
            std::int32_t first = 0;  // first triangle of a leaf, or the second child; the first child is the next node
            std::int32_t count = 0;
        };

        std::vector<Box> boxes;
        std::vector<std::int32_t> order;
        std::vector<BinaryNode> nodes;

        Builder(const std::vector<Vector>& vertices, const std::vector<Triangle>& triangles)
            : boxes(triangles.size()), order(triangles.size()) {
            for (std::size_t i = 0; i < triangles.size(); ++i) {
                for (const std::int32_t corner : triangles[i]) boxes[i].include(vertices[corner]);
                order[i] = static_cast<std::int32_t>(i);
            }
            nodes.reserve(2 * triangles.size());
            build(0, static_cast<std::int32_t>(order.size()));
        }

        void build(std::int32_t first, std::int32_t count) {
            const std::size_t index = nodes.size();
            nodes.emplace_back();
            Box box, centres;
            for (std::int32_t i = first; i < first + count; ++i) {
                const Box& b = boxes[order[i]];
                box.include(b);
                centres.include(0.5 * (b.low + b.high));
            }
            nodes[index].box = box;
            const Vector extent = centres.high - centres.low;
            const int axis = extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);
            if (count <= 2 || !(extent[axis] > 0.0)) {
                nodes[index].first = first;
                nodes[index].count = count;
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
                const int k = bin_of(order[i]);
                bin_box[k].include(boxes[order[i]]);
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
            const auto middle = std::partition(order.begin() + first, order.begin() + first + count,
                                               [&](std::int32_t triangle) { return bin_of(triangle) <= best; });
            const std::int32_t left = static_cast<std::int32_t>(middle - order.begin()) - first;
            build(first, left);
            nodes[index].first = static_cast<std::int32_t>(nodes.size());
            build(first + left, count - left);
        }
    };

    // Takes the children of the children in, the largest first, until a node has eight.
    std::int32_t collapse(const std::vector<typename Builder::BinaryNode>& binary, std::int32_t top) {
        std::vector<std::int32_t> children = {top};
        while (children.size() < lane_count) {
            int largest = -1;
            double area = -1.0;
            for (std::size_t k = 0; k < children.size(); ++k) {
                const auto& node = binary[children[k]];
                if (node.count == 0 && node.box.half_area() > area) {
                    area = node.box.half_area();
                    largest = static_cast<int>(k);
                }
            }
            if (largest < 0) break;
            const std::int32_t opened = children[largest];
            children[largest] = opened + 1;
            children.push_back(binary[opened].first);
        }
        const std::int32_t index = static_cast<std::int32_t>(nodes_.size());
        nodes_.emplace_back();
        for (std::size_t k = 0; k < children.size(); ++k) {
            const auto& node = binary[children[k]];
            const std::int32_t child = node.count > 0 ? node.first : collapse(binary, children[k]);
            Node& wide = nodes_[index];
            for (int axis = 0; axis < 3; ++axis) {
                wide.low[axis][k] = node.box.low[axis];
                wide.high[axis][k] = node.box.high[axis];
            }
            wide.child[k] = child;
            wide.count[k] = node.count;
            wide.children = static_cast<int>(k) + 1;
        }
        return index;
    }

    std::vector<Vector> normals_;
    std::vector<Triangle> triangles_;
    std::vector<Corners> corners_;
    std::vector<Node> nodes_;
    Box bounds_;
};

}  // namespace glass
