// The C interface of the nearest-point search; ctypes calls it from nearest.py.
#include <atomic>
#include <exception>
#include <memory>
#include <thread>

#include "tree.hpp"

#define SPATIAL_API extern "C" __attribute__((visibility("default")))

namespace {

using spatial::Tree;
using spatial::Vector;

Vector vector_at(const double* values) { return {values[0], values[1], values[2]}; }

}  // namespace

SPATIAL_API int spatial_interface_version() { return 1; }

// corners and normals: count x 3 x 3; thickness: count x 3. Returns null where memory runs out.
SPATIAL_API Tree* spatial_tree_new(const double* corners, const double* normals, const double* thickness,
                                   std::int64_t count) {
    try {
        std::vector<spatial::Triangle> triangles(static_cast<std::size_t>(count));
        for (std::int64_t n = 0; n < count; ++n) {
            for (int k = 0; k < 3; ++k) {
                triangles[n].corner[k] = vector_at(corners + 9 * n + 3 * k);
                triangles[n].normal[k] = vector_at(normals + 9 * n + 3 * k);
                triangles[n].thickness[k] = thickness[3 * n + k];
            }
        }
        return std::make_unique<Tree>(std::move(triangles)).release();
    } catch (const std::exception&) {
        return nullptr;
    }
}

SPATIAL_API void spatial_tree_free(Tree* tree) { std::unique_ptr<Tree>{tree}; }

// points, feet: count x 3; clearance, distance, triangle: count.
SPATIAL_API void spatial_tree_search(const Tree* tree, const double* points, std::int64_t count, int threads,
                                     double* clearance, double* distance, double* feet, std::int32_t* triangle) {
    std::atomic<std::int64_t> next{0};
    constexpr std::int64_t kBatch = 256;
    const auto work = [&]() {
        for (std::int64_t first = next.fetch_add(kBatch); first < count; first = next.fetch_add(kBatch)) {
            spatial::Found found;
            for (std::int64_t n = first; n < std::min(first + kBatch, count); ++n) {
                found = tree->search(vector_at(points + 3 * n), found.triangle);
                clearance[n] = found.clearance;
                distance[n] = found.distance;
                for (int axis = 0; axis < 3; ++axis) feet[3 * n + axis] = found.foot[axis];
                triangle[n] = found.triangle;
            }
        }
    };
    std::vector<std::thread> others;
    for (int k = 1; k < threads && k * kBatch < count; ++k) {
        try {
            others.emplace_back(work);
        } catch (const std::exception&) {
            break;
        }
    }
    work();
    for (auto& other : others) other.join();
}
