// Bodies, the media in them, lights and the camera.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>
#include <vector>

#include "ellipsoid.hpp"
#include "ellipsoids.hpp"
#include "mesh.hpp"
#include "patch.hpp"
#include "revolved.hpp"
#include "vector.hpp"

namespace glass {

struct Colour {
    double r = 0.0, g = 0.0, b = 0.0;

    double largest() const { return greater(r, greater(g, b)); }
};

inline Colour operator*(const Colour& a, const Colour& b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
inline Colour operator*(double s, const Colour& a) { return {s * a.r, s * a.g, s * a.b}; }
inline Colour operator+(const Colour& a, const Colour& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }

struct Medium {
    double refractive_index = 1.0;
    Colour absorption_per_mm;
};

struct Panel {
    Vector origin, u, v, normal;
    double uu, uv, vv, inverse;
    Colour radiance;

    Panel(const Vector& origin, const Vector& u, const Vector& v, const Colour& radiance)
        : origin(origin),
          u(u),
          v(v),
          normal(cross(u, v)),
          uu(dot(u, u)),
          uv(dot(u, v)),
          vv(dot(v, v)),
          inverse(1.0 / (uu * vv - uv * uv)),
          radiance(radiance) {}

    // Distance at which the ray meets the panel, or infinity.
    double distance(const Ray& ray) const {
        double a, b;
        const double t = place(ray, a, b);
        return t > 0.0 && a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0 ? t : INFINITY;
    }

    // Distance at which the ray meets the panel's plane, and where: the panel is [0, 1] x [0, 1].
    double place(const Ray& ray, double& a, double& b) const {
        const double t = dot(origin - ray.origin, normal) / dot(ray.direction, normal);
        const Vector p = ray.at(t) - origin;
        const double pu = dot(p, u), pv = dot(p, v);
        a = (pu * vv - pv * uv) * inverse;
        b = (pv * uu - pu * uv) * inverse;
        return t;
    }
};

struct Environment {
    std::int64_t height = 0, width = 0;
    std::vector<Colour> pixels;

    Colour radiance(const Vector& d) const {
        if (pixels.empty()) return {};
        if (pixels.size() == 1) return pixels.front();
        const double polar = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), d.z);
        const double row = std::fmin(std::fmax(polar / M_PI * height - 0.5, 0.0), height - 1.0);
        const double column = (std::atan2(d.y, d.x) / (2.0 * M_PI) + 0.5) * width - 0.5;
        const std::int64_t top = std::min(static_cast<std::int64_t>(row), std::max<std::int64_t>(height - 2, 0));
        const std::int64_t bottom = std::min(top + 1, height - 1);
        const double whole = std::floor(column);
        const std::int64_t left = (static_cast<std::int64_t>(whole) + width) % width, right = (left + 1) % width;
        const double y = row - top, x = column - whole;
        const auto pixel = [&](std::int64_t i, std::int64_t j) { return pixels[i * width + j]; };
        return (1.0 - y) * ((1.0 - x) * pixel(top, left) + x * pixel(top, right)) +
               y * ((1.0 - x) * pixel(bottom, left) + x * pixel(bottom, right));
    }
};

// An environment at one, two, four ... pixels to a pixel.
struct Surroundings {
    std::vector<Environment> levels;

    explicit Surroundings(const Environment& finest = {}) {
        levels.push_back(finest);
        while (levels.back().height > 1 && levels.back().width > 1) {
            const Environment& fine = levels.back();
            Environment coarse;
            coarse.height = (fine.height + 1) / 2;
            coarse.width = (fine.width + 1) / 2;
            coarse.pixels.resize(static_cast<std::size_t>(coarse.height * coarse.width));
            for (std::int64_t i = 0; i < coarse.height; ++i)
                for (std::int64_t j = 0; j < coarse.width; ++j) {
                    Colour sum;
                    for (int k = 0; k < 4; ++k)
                        sum = sum + fine.pixels[std::min(2 * i + k / 2, fine.height - 1) * fine.width +
                                                std::min(2 * j + k % 2, fine.width - 1)];
                    coarse.pixels[i * coarse.width + j] = 0.25 * sum;
                }
            levels.push_back(std::move(coarse));
        }
    }

    Colour radiance(const Vector& direction, int level) const {
        return levels[std::clamp(level, 0, static_cast<int>(levels.size()) - 1)].radiance(direction);
    }
};

struct Camera {
    bool parallel = false;  // telecentric: rays start side by side instead of fanning out
    Vector origin, right, up, forward;
    double half_height = 1.0;  // of the image: in mm if parallel, else at distance 1
    double width = 1.0, height = 1.0;

    // The ray of an image point in pixels from the upper left corner.
    Ray ray(double column, double row) const {
        const double x = (2.0 * column - width) / height * half_height;
        const double y = (1.0 - 2.0 * row / height) * half_height;
        const Vector offset = x * right + y * up;
        if (parallel) return {origin + offset, forward};
        return {origin, normalised(forward + offset)};
    }
};

using Surface = std::variant<Revolved, Patches, Mesh, Ellipsoid, Ellipsoids>;

struct Scene {
    std::vector<Surface> bodies;
    std::vector<std::int32_t> medium_of_bits;
    std::vector<Medium> media;
    std::vector<Panel> panels;
    Environment environment;
    Surroundings surroundings;
    double brightest = 0.0;
    double start_tolerance = 0.0;  // mm; nearer than this a crossing may be the surface that the ray starts on

    void finish() {
        surroundings = Surroundings(environment);
        double size = 0.0;
        for (const Surface& body : bodies)
            size = std::fmax(size, std::visit([](const auto& s) { return s.bounds().largest_coordinate(); }, body));
        start_tolerance = 1e-9 * size;
    }
};

}  // namespace glass
