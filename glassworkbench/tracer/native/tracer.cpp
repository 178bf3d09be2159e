// The C interface: turns arrays into a scene, and shares the work out over threads.
#if defined(__GNUC__)
#define GLASS_EXPORT __attribute__((visibility("default")))
#else
#define GLASS_EXPORT
#endif
#include "tracer.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <thread>
#include <utility>

#include "cells.hpp"
#include "scene.hpp"
#include "transport.hpp"

struct glass_scene {
    glass::Scene scene;
};

namespace {

using glass::Vector;

Vector vector(const double* p) { return {p[0], p[1], p[2]}; }
glass::Colour colour(const double* p) { return {p[0], p[1], p[2]}; }

template <class Number>
void put(const glass::Colour& colour, Number* p) {
    p[0] = static_cast<Number>(colour.r);
    p[1] = static_cast<Number>(colour.g);
    p[2] = static_cast<Number>(colour.b);
}

glass::Ellipsoid ellipsoid_from(const double* centre, const double* semi_axes, const double* rotation) {
    glass::Rotation frame;
    for (int k = 0; k < 3; ++k) frame.row[k] = {rotation[k], rotation[3 + k], rotation[6 + k]};
    return {vector(centre), vector(semi_axes), frame};
}

glass::Camera camera_from(const glass_camera& c) {
    glass::Camera camera;
    camera.parallel = c.parallel != 0;
    camera.origin = vector(c.origin);
    camera.right = vector(c.right);
    camera.up = vector(c.up);
    camera.forward = vector(c.forward);
    camera.half_height = c.half_height;
    camera.width = c.width;
    camera.height = c.height;
    return camera;
}

bool cancelled(const glass_control* control) { return __atomic_load_n(&control->cancel, __ATOMIC_RELAXED) != 0; }

template <class Work>
std::int32_t guarded(Work&& work) {
    try {
        return work();
    } catch (const std::exception&) {
        return GLASS_FAILED;
    }
}

glass::Settings settings_from(const glass_settings& s) {
    return {s.cutoff, std::clamp<std::int32_t>(s.maximum_depth, 1, 1000), s.absorption != 0};
}

// Has work(i) done for each i in [0, n), in chunks that threads take in turn, by a worker for each thread, made by
// make_worker(). Which thread does which chunk changes nothing: each i writes its own results.
template <class MakeWorker>
std::int32_t share(std::int64_t n, std::int64_t chunk, std::int32_t threads, glass_control* control,
                   MakeWorker&& make_worker) {
    std::atomic<std::int64_t> next{0};
    const auto run = [&] {
        auto work = make_worker();
        for (;;) {
            const std::int64_t first = next.fetch_add(chunk, std::memory_order_relaxed);
            if (first >= n) return;
            const std::int64_t last = std::min(n, first + chunk);
            for (std::int64_t i = first; i < last; ++i) {
                if (cancelled(control)) return;
                work(i);
            }
            __atomic_fetch_add(&control->done, last - first, __ATOMIC_RELAXED);
        }
    };
    std::vector<std::thread> others;
    for (std::int32_t k = 1; k < threads; ++k) others.emplace_back(run);
    run();
    for (std::thread& other : others) other.join();
    return cancelled(control) ? GLASS_CANCELLED : GLASS_OK;
}

template <class Surface>
std::int32_t add(glass_scene* scene, Surface&& surface) {
    scene->scene.bodies.emplace_back(std::forward<Surface>(surface));
    return GLASS_OK;
}

}  // namespace

extern "C" {

GLASS_EXPORT int32_t glass_interface_version(void) { return GLASS_INTERFACE_VERSION; }

GLASS_EXPORT int32_t glass_vector_width(void) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))
        return 8;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return 4;
#endif
    return 2;
}

GLASS_EXPORT glass_scene* glass_scene_new(void) {
    try {
        return std::make_unique<glass_scene>().release();
    } catch (const std::exception&) {
        return nullptr;
    }
}

GLASS_EXPORT void glass_scene_free(glass_scene* scene) { std::unique_ptr<glass_scene>{scene}; }

GLASS_EXPORT int32_t glass_add_revolved(glass_scene* scene, const double* meridian, int64_t n, const double* base,
                                        const double* axis) {
    return guarded([&] {
        std::vector<glass::Segment> segments(static_cast<std::size_t>(n));
        for (glass::Segment& segment : segments)
            for (glass::Control& control : segment) {
                control = {meridian[0], meridian[1], meridian[2]};
                meridian += 3;
            }
        return add(scene, glass::Revolved(segments, vector(base), vector(axis)));
    });
}

GLASS_EXPORT int32_t glass_add_mesh(glass_scene* scene, const double* vertices, const double* normals,
                                    int64_t vertex_count, const int32_t* triangles, int64_t triangle_count) {
    return guarded([&] {
        std::vector<Vector> points(static_cast<std::size_t>(vertex_count)), directions(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i] = vector(vertices + 3 * i);
            directions[i] = vector(normals + 3 * i);
        }
        std::vector<glass::Mesh::Triangle> corners(static_cast<std::size_t>(triangle_count));
        for (std::size_t i = 0; i < corners.size(); ++i)
            corners[i] = {triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]};
        return add(scene, glass::Mesh(points, std::move(directions), corners));
    });
}

GLASS_EXPORT int32_t glass_add_patches(glass_scene* scene, const int32_t* shapes, int64_t sheet_count,
                                       const double* knots, const double* control_points, int64_t triangle_count,
                                       const int32_t* sheet_of_triangle, const double* corners, const double* uv,
                                       const int32_t* pole, int64_t edge_count, const double* edges,
                                       const int32_t* edge, const int32_t* along, const double* low, const double* high,
                                       const double* cone_axis, const double* cone_sine) {
    return guarded([&] {
        std::vector<glass::Sheet> sheets;
        for (int64_t i = 0; i < sheet_count; ++i, shapes += 4) {
            const double* const v_knots = knots + shapes[2] + 1;
            const double* const end = v_knots + shapes[3] + 1;
            sheets.emplace_back(shapes[0], shapes[1], std::vector<double>(knots, v_knots),
                                std::vector<double>(v_knots, end), control_points);
            knots = end;
            control_points += 4 * int64_t{shapes[2]} * shapes[3] * (shapes[0] + 1) * (shapes[1] + 1);
        }
        std::vector<glass::CurvedEdge> curves(static_cast<std::size_t>(edge_count));
        for (glass::CurvedEdge& curve : curves)
            for (Vector& point : curve.point) {
                point = vector(edges);
                edges += 3;
            }
        std::vector<glass::CurvedTriangle> triangles(static_cast<std::size_t>(triangle_count));
        std::vector<glass::Box> boxes(triangles.size());
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            glass::CurvedTriangle& triangle = triangles[i];
            for (int k = 0; k < 3; ++k) {
                triangle.corner[k] = vector(corners + 9 * i + 3 * k);
                triangle.edge[k] = edge[3 * i + k];
                triangle.along[k] = along[3 * i + k] != 0;
                triangle.u[k] = uv[6 * i + 2 * k];
                triangle.v[k] = uv[6 * i + 2 * k + 1];
            }
            triangle.sheet = sheet_of_triangle[i];
            triangle.pole = pole[i];
            triangle.cone_axis = vector(cone_axis + 3 * i);
            triangle.cone_sine = cone_sine[i];
            boxes[i].include(vector(low + 3 * i));
            boxes[i].include(vector(high + 3 * i));
        }
        return add(scene, glass::Patches(std::move(sheets), std::move(curves), triangles, boxes));
    });
}

GLASS_EXPORT int32_t glass_add_ellipsoid(glass_scene* scene, const double* centre, const double* semi_axes,
                                         const double* rotation) {
    return guarded([&] { return add(scene, ellipsoid_from(centre, semi_axes, rotation)); });
}

GLASS_EXPORT int32_t glass_add_ellipsoids(glass_scene* scene, int64_t n, const double* centres, const double* semi_axes,
                                          const double* rotations) {
    return guarded([&] {
        std::vector<glass::Ellipsoid> ellipsoids;
        for (int64_t i = 0; i < n; ++i)
            ellipsoids.push_back(ellipsoid_from(centres + 3 * i, semi_axes + 3 * i, rotations + 9 * i));
        return add(scene, glass::Ellipsoids(ellipsoids));
    });
}

GLASS_EXPORT int32_t glass_set_media(glass_scene* scene, const int32_t* medium_of_bits, int64_t combinations,
                                     const double* refractive_indices, const double* absorptions, int64_t media) {
    return guarded([&] {
        scene->scene.medium_of_bits.assign(medium_of_bits, medium_of_bits + combinations);
        for (int64_t k = 0; k < media; ++k)
            scene->scene.media.push_back({refractive_indices[k], colour(absorptions + 3 * k)});
        return GLASS_OK;
    });
}

GLASS_EXPORT int32_t glass_add_panel(glass_scene* scene, const double* origin, const double* u, const double* v,
                                     const double* radiance) {
    return guarded([&] {
        scene->scene.panels.emplace_back(vector(origin), vector(u), vector(v), colour(radiance));
        return GLASS_OK;
    });
}

GLASS_EXPORT int32_t glass_set_environment(glass_scene* scene, const double* pixels, int64_t height, int64_t width) {
    return guarded([&] {
        glass::Environment& environment = scene->scene.environment;
        environment.height = height;
        environment.width = width;
        environment.pixels.resize(static_cast<std::size_t>(height * width));
        for (std::size_t i = 0; i < environment.pixels.size(); ++i) environment.pixels[i] = colour(pixels + 3 * i);
        return GLASS_OK;
    });
}

GLASS_EXPORT int32_t glass_finish(glass_scene* scene, double brightest) {
    scene->scene.brightest = brightest;
    scene->scene.finish();
    return GLASS_OK;
}

GLASS_EXPORT int32_t glass_radiance(const glass_scene* scene, const glass_settings* settings, int32_t threads,
                                    glass_control* control, int64_t n, const double* origins, const double* directions,
                                    double* radiance, double* left_out, double* bound, double* depth,
                                    int64_t* crossings, int64_t* leaks) {
    return guarded([&] {
        const auto make_worker = [&] {
            return [&, transport = glass::Transport(scene->scene, settings_from(*settings))](std::int64_t i) mutable {
                const glass::Ray ray{vector(origins + 3 * i), glass::normalised(vector(directions + 3 * i))};
                const glass::Answer answer = transport.radiance(ray);
                put(answer.radiance, radiance + 3 * i);
                put(answer.left_out, left_out + 3 * i);
                bound[i] = answer.bound;
                depth[i] = answer.depth;
                crossings[i] = answer.crossings;
                leaks[i] = answer.leaks;
            };
        };
        return share(n, 16, threads, control, make_worker);
    });
}

GLASS_EXPORT int32_t glass_image(const glass_scene* scene, const glass_settings* settings, const glass_camera* camera,
                                 double tolerance, int32_t halvings, const double* ambient, int32_t threads,
                                 glass_control* control, int64_t n, const int64_t* tiles, const uint8_t* wanted,
                                 float* radiance, float* sampling, float* pruned, float* depth, int64_t* totals) {
    return guarded([&] {
        const glass::Camera view = camera_from(*camera);
        const std::int64_t width = camera->width, height = camera->height;
        const std::int64_t across = (width + glass::Cells::tile_size - 1) / glass::Cells::tile_size;
        std::atomic<std::int64_t> rays{0}, crossings{0}, leaks{0};
        const auto is_wanted = [&](std::int64_t column, std::int64_t row) {
            return column < width && row < height && wanted[row * width + column] != 0;
        };
        const auto deliver = [&](std::int64_t column, std::int64_t row, const glass::Pixel& pixel) {
            const std::int64_t k = row * width + column;
            put(pixel.radiance, radiance + 3 * k);
            sampling[k] = static_cast<float>(pixel.sampling);
            pruned[k] = static_cast<float>(pixel.pruned);
            depth[k] = static_cast<float>(pixel.depth);
        };
        const auto make_worker = [&] {
            return
                [&, cells = glass::Cells(scene->scene, settings_from(*settings), view, tolerance, halvings,
                                         colour(ambient), [&] { return cancelled(control); })](std::int64_t i) mutable {
                    cells.tile(tiles[i] % across * glass::Cells::tile_size, tiles[i] / across * glass::Cells::tile_size,
                               is_wanted, deliver);
                    rays.fetch_add(std::exchange(cells.rays, 0), std::memory_order_relaxed);
                    crossings.fetch_add(std::exchange(cells.crossings, 0), std::memory_order_relaxed);
                    leaks.fetch_add(std::exchange(cells.leaks, 0), std::memory_order_relaxed);
                };
        };
        const std::int32_t outcome = share(n, 1, threads, control, make_worker);
        totals[0] += rays.load();
        totals[1] += crossings.load();
        totals[2] += leaks.load();
        return outcome;
    });
}

GLASS_EXPORT int64_t glass_follow(const glass_scene* scene, const double* origin, const double* direction, int64_t room,
                                  int32_t* numbers, double* values) {
    try {
        int64_t count = 0;
        glass::Transport(scene->scene, glass::Settings{})
            .follow({vector(origin), glass::normalised(vector(direction))}, [&](const glass::Crossing& c) {
                if (count >= room) return false;
                int32_t* const n = numbers + 4 * count;
                double* const v = values + 5 * count;
                n[0] = c.body;
                n[1] = c.entering;
                n[2] = c.medium_before;
                n[3] = c.medium_after;
                v[0] = c.point.x;
                v[1] = c.point.y;
                v[2] = c.point.z;
                v[3] = c.cos_incident;
                v[4] = c.reflectance;
                return ++count < room;
            });
        return count;
    } catch (const std::exception&) {
        return -1;
    }
}

}  // extern "C"
