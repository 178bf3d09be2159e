// Triangles in a hierarchy of boxes, searched for the lowest |p - s| - t(s) from the likeliest box to the least likely.
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

#include "lowest.hpp"

namespace spatial {

struct Found {
    double clearance = std::numeric_limits<double>::infinity();
    double distance = 0.0;
    Vector foot;
    std::int32_t triangle = 0;
};

class Tree {
public:
    explicit Tree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)), order_(triangles_.size()) {
        std::iota(order_.begin(), order_.end(), 0);
        centres_.reserve(triangles_.size());
        for (auto& triangle : triangles_) {
            set_sags(triangle);
            centres_.push_back((1.0 / 3.0) * (triangle.corner[0] + triangle.corner[1] + triangle.corner[2]));
        }
        nodes_.reserve(triangles_.size());
        if (!triangles_.empty()) build(0, static_cast<std::int32_t>(triangles_.size()));
    }

    // What decides about a point near by is a good guess: it rules out most boxes from the start.
    Found search(const Vector& p, std::int32_t guess = 0) const {
        Found found;
        if (nodes_.empty()) return found;
        improve(found, guess, p);
        struct Waiting {
            double bound;
            std::int32_t node;
        };
        std::array<Waiting, 128> waiting;
        int count = 0;
        waiting[count++] = {bound(nodes_[0], p), 0};
        while (count > 0) {
            const Waiting next = waiting[--count];
            if (next.bound >= found.clearance) continue;
            const Node& node = nodes_[next.node];
            if (node.count > 0) {
                for (std::int32_t k = node.first; k < node.first + node.count; ++k) improve(found, order_[k], p);
                continue;
            }
            Waiting left = {bound(nodes_[next.node + 1], p), next.node + 1};
            Waiting right = {bound(nodes_[node.first], p), node.first};
            if (left.bound < right.bound) std::swap(left, right);
            waiting[count++] = left;
            waiting[count++] = right;
        }
        return found;
    }

private:
    // A triangle costs more than several boxes.
    static constexpr std::int32_t kLeaf = 1;

    struct Node {
        Vector low, high;
        double thickest = 0.0;
        // Of a leaf its triangles; of an inner node (count 0) the right child, the left one follows the node.
        std::int32_t first = 0, count = 0;
    };

    static double bound(const Node& node, const Vector& p) {
        double squared = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            const double gap = std::max({node.low[axis] - p[axis], 0.0, p[axis] - node.high[axis]});
            squared += gap * gap;
        }
        return std::sqrt(squared) - node.thickest;
    }

    void improve(Found& found, std::int32_t number, const Vector& p) const {
        const Triangle& triangle = triangles_[number];
        const Shares shares = lowest(triangle, p);
        const Vector foot = surface(triangle, shares), gap = p - foot;
        const double distance = std::sqrt(dot(gap, gap));
        double thickness = 0.0;
        for (int k = 0; k < 3; ++k) thickness += shares[k] * triangle.thickness[k];
        if (distance - thickness < found.clearance) found = {distance - thickness, distance, foot, number};
    }

    void build(std::int32_t first, std::int32_t last) {
        const auto place = static_cast<std::int32_t>(nodes_.size());
        nodes_.push_back(around(first, last));
        if (last - first <= kLeaf) {
            nodes_[place].first = first;
            nodes_[place].count = last - first;
            return;
        }
        const Vector size = nodes_[place].high - nodes_[place].low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::int32_t middle = first + (last - first) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                         [&](std::int32_t a, std::int32_t b) {
                             const double at = centres_[a][axis], bt = centres_[b][axis];
                             return at != bt ? at < bt : a < b;
                         });
        build(first, middle);
        nodes_[place].first = static_cast<std::int32_t>(nodes_.size());
        build(middle, last);
    }

    Node around(std::int32_t first, std::int32_t last) const {
        constexpr double kFar = std::numeric_limits<double>::infinity();
        std::array<double, 3> low = {kFar, kFar, kFar}, high = {-kFar, -kFar, -kFar};
        double thickest = -kFar;
        for (std::int32_t k = first; k < last; ++k) {
            const Triangle& triangle = triangles_[order_[k]];
            // The surface leaves the flat triangle by no more than a quarter of its sags.
            double bulge = 0.0;
            for (const double sag : triangle.sag) bulge += 0.25 * std::abs(sag);
            for (const Vector& corner : triangle.corner) {
                for (int axis = 0; axis < 3; ++axis) {
                    low[axis] = std::min(low[axis], corner[axis] - bulge);
                    high[axis] = std::max(high[axis], corner[axis] + bulge);
                }
            }
            for (const double thickness : triangle.thickness) thickest = std::max(thickest, thickness);
        }
        return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}, thickest, 0, 0};
    }

    std::vector<Triangle> triangles_;
    std::vector<std::int32_t> order_;
    std::vector<Vector> centres_;
    std::vector<Node> nodes_;
};

}  // namespace spatial
