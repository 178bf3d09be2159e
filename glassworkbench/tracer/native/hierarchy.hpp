// A bounding volume hierarchy of sixteen children a node, over items that have boxes.
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
        const float from = below(t_min);
        float to = above(t_best);
        double known_best = t_best;
        // What waits, the nearest last.
        constexpr int room = 64 * width;
        float waiting_t[room];
        std::int32_t waiting[room], waiting_count[room];
        waiting_t[0] = from;
        waiting[0] = waiting_count[0] = 0;
        int depth = 1;
        while (depth > 0) {
            --depth;
            if (t_best != known_best) {
                known_best = t_best;
                to = above(t_best);
            }
            if (waiting_t[depth] > to) continue;
            const std::int32_t first_item = waiting[depth], items = waiting_count[depth];
            if (items > 0) {
                for (std::int32_t i = first_item; i < first_item + items; ++i) visit(i);
                continue;
            }
            const Node& node = nodes_[first_item];
            Lanes low, high;
            slabs.overlap(node, from, to, low, high);
            const int first = depth;
            for (unsigned reached = where_no_larger(low, high) & node.children; reached != 0; reached &= reached - 1) {
                const int k = lowest_bit(reached);
                const float t = low[k];
                int place = depth++;
                for (; place > first && waiting_t[place - 1] < t; --place) {
                    waiting_t[place] = waiting_t[place - 1];
                    waiting[place] = waiting[place - 1];
                    waiting_count[place] = waiting_count[place - 1];
                }
                waiting_t[place] = t;
                waiting[place] = node.child[k];
                waiting_count[place] = node.count[k];
            }
        }
    }

private:
    static constexpr int width = lane_count;
    static constexpr float rounding = 1.2e-7f;  // of a float32, relative

    // Float32 numbers beyond the rounding of a few operations.
    static float below(double value) { return static_cast<float>(value - 8.0 * rounding * std::fabs(value)); }
    static float above(double value) { return static_cast<float>(value + 8.0 * rounding * std::fabs(value)); }

    // Boxes in float32, no smaller than the exact ones.
    struct Node {
        Lanes side[2][3];           // low, high
        std::int32_t child[width];  // a node, or the first item of a leaf
        std::int32_t count[width];  // items of a leaf, or 0
        unsigned children = 0;      // one bit each
    };

    struct Slabs {
        int nearer[3];  // 1 where the ray comes from a box's high side
        float origin[3], inverse[3];
        float margin[3];  // of t, for the rounding of the origin

        explicit Slabs(const Ray& ray) {
            for (int axis = 0; axis < 3; ++axis) {
                origin[axis] = static_cast<float>(ray.origin[axis]);
                inverse[axis] = static_cast<float>(lesser(greater(1.0 / ray.direction[axis], -1e30), 1e30));
                margin[axis] = 2.0f * rounding * std::fabs(origin[axis] * inverse[axis]);
                nearer[axis] = inverse[axis] < 0.0f;
            }
        }

        // Where the ray is inside each child's box; empty where high < low. The far ends are widened by more than the
        // rounding of near and far ends (Ize 2013).
        void overlap(const Node& node, float t_min, float t_best, Lanes& low, Lanes& high) const {
            low = every(t_min);
            high = every(t_best);
            for (int axis = 0; axis < 3; ++axis) {
                const Lanes near = (node.side[nearer[axis]][axis] - origin[axis]) * inverse[axis];
                const Lanes far = (node.side[1 - nearer[axis]][axis] - origin[axis]) * inverse[axis];
                low = larger(near - margin[axis], low);
                high = smaller(far + larger(far, -far) * (8.0f * rounding) + margin[axis], high);
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

    // Takes the children of the children in, the largest first, until a node has sixteen.
    std::int32_t collapse(const std::vector<typename Builder::BinaryNode>& binary, std::int32_t top) {
        std::vector<std::int32_t> children = {top};
        while (children.size() < width) {
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
                wide.side[0][axis].set(k, below(node.box.low[axis]));
                wide.side[1][axis].set(k, above(node.box.high[axis]));
            }
            wide.child[k] = child;
            wide.count[k] = node.count;
            wide.children |= 1u << k;
        }
        return index;
    }

    std::vector<std::int32_t> order_;
    std::vector<Node> nodes_;
    Box bounds_;
};

}  // namespace glass
