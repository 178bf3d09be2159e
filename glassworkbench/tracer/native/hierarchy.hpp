// A bounding volume hierarchy of eight children a node, over items that have boxes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "lanes.hpp"
#include "vector.hpp"

namespace glass {

class Hierarchy {
public:
    // Afterwards item k of the hierarchy is the caller's box number order()[k].
    explicit Hierarchy(const std::vector<Box>& boxes) {
        Builder builder(boxes);
        bounds_ = builder.nodes.front().box;
        order_ = std::move(builder.order);
        collapse(builder.nodes, 0);
    }

    const Box& bounds() const { return bounds_; }
    const std::vector<std::int32_t>& order() const { return order_; }

    // Calls visit(item) for the items whose boxes the ray meets between t_min and t_best, the nearest boxes first.
    // The visitor may lower t_best.
    template <class Visit>
    void visit(const Ray& ray, double t_min, const double& t_best, Visit&& visit) const {
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
                for (std::int32_t i = entry.child; i < entry.child + entry.count; ++i) visit(i);
                continue;
            }
            const Node& node = nodes_[entry.child];
            Lanes low, high;
            slabs.overlap(node, t_min, t_best, low, high);
            // Nearest last, so that it is taken first.
            const int first = depth;
            unsigned reached = where_no_larger(low, high) & ((1u << node.children) - 1u);
            for (; reached != 0; reached &= reached - 1) {
                const int k = lowest_bit(reached);
                int place = depth++;
                while (place > first && stack[place - 1].t < low[k]) {
                    stack[place] = stack[place - 1];
                    --place;
                }
                stack[place] = {low[k], node.child[k], node.count[k]};
            }
        }
    }

private:
    struct Node {
        Lanes low[3], high[3];
        std::int32_t child[lane_count];  // a node, or the first item of a leaf
        std::int32_t count[lane_count];  // items of a leaf, or 0
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

    // The binary hierarchy from which the wide one is made, by the surface area heuristic in 16 bins.
    struct Builder {
        struct BinaryNode {
            Box box;
            std::int32_t first = 0;  // first item of a leaf, or the second child; the first child is the next node
            std::int32_t count = 0;
        };

        const std::vector<Box>& boxes;
        std::vector<std::int32_t> order;
        std::vector<BinaryNode> nodes;

        explicit Builder(const std::vector<Box>& boxes) : boxes(boxes), order(boxes.size()) {
            std::iota(order.begin(), order.end(), 0);
            nodes.reserve(2 * boxes.size());
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
            const auto bin_of = [&](std::int32_t item) {
                const Box& b = boxes[item];
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
                                               [&](std::int32_t item) { return bin_of(item) <= best; });
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

    std::vector<std::int32_t> order_;
    std::vector<Node> nodes_;
    Box bounds_;
};

}  // namespace glass
