// Light through smooth glass, without random numbers: at each interface the ray splits into its reflected and its
// refracted part, the heavier is followed first, and parts lighter than the cut-off are left out. Their weight times
// the brightest light bounds what is missing.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "fresnel.hpp"
#include "scene.hpp"

namespace glass {

struct Settings {
    double cutoff = 1e-3;
    int maximum_depth = 256;
    bool absorption = true;
};

struct Answer {
    Colour radiance;
    Colour left_out;  // weight of the paths that were not followed to their end
    double bound = 0.0;
    double depth = INFINITY;
    std::int64_t crossings = 0;
    std::int64_t leaks = 0;
};

// The end of a path: at a panel, or out of the scene.
struct Arrival {
    std::uint64_t key;
    Colour weight;
    Ray ray;
    Colour light;
    const Panel* panel;  // none where the path left the scene
};

struct Crossing {
    Vector point;
    int body;
    bool entering;
    int medium_before, medium_after;
    double cos_incident, reflectance;
};

constexpr int longest_path = 4096;  // crossings of any kind along one path, interfaces or not

// One for each thread: it keeps its stack of waiting rays from one camera ray to the next.
class Transport {
public:
    Transport(const Scene& scene, const Settings& settings) : scene_(scene), settings_(settings) {}

    Answer radiance(const Ray& camera_ray) {
        return arrivals(camera_ray, [](const Arrival&) {});
    }

    // The same; each path that arrives at light, or leaves the scene, is handed to `arrive`.
    template <class Arrive>
    Answer arrivals(const Ray& camera_ray, Arrive&& arrive) {
        return settings_.absorption ? trace<true>(camera_ray, arrive) : trace<false>(camera_ray, arrive);
    }

    // Distance to the first change of medium along the ray, infinite where there is none.
    double depth(const Ray& ray) const {
        Path path = start(ray);
        Answer unused;
        double travelled = 0.0;
        for (int i = 0; i < longest_path; ++i) {
            const Next next = nearest(path);
            if (next.body < 0 || light_before(path.ray, next.hit.t).panel != nullptr) break;
            travelled += next.hit.t;
            const Meeting m = meet(path, next, unused);
            if (m.medium_before != m.medium_after) return travelled;
            path = refracted(path, next, m);
        }
        return INFINITY;
    }

    // The path of the refracted ray (the reflected one where reflection is total), interface by interface.
    template <class Record>
    void follow(const Ray& ray, Record&& record) const {
        Path path = start(ray);
        Answer answer;
        for (int i = 0; i < longest_path; ++i) {
            const Next next = nearest(path);
            if (next.body < 0 || light_before(path.ray, next.hit.t).panel != nullptr) return;
            const Meeting m = meet(path, next, answer);
            if (m.medium_before != m.medium_after)
                if (!record(Crossing{m.point, next.body, next.hit.entering, m.medium_before, m.medium_after, m.cosine,
                                     m.interface.reflectance}))
                    return;
            path = m.interface.reflectance >= 1.0 ? reflected(path, next, m) : refracted(path, next, m);
        }
    }

private:
    struct Path {
        Ray ray;
        Colour weight;
        std::uint64_t key;  // the same for paths that met the same bodies in the same ways
        std::uint32_t bits;
        int depth;      // interfaces so far
        int crossings;  // crossings of any kind so far
        int last_body;
        Hit last_hit;
    };

    struct Next {
        Hit hit;
        int body = -1;
    };

    Path start(const Ray& ray) const { return {ray, {1, 1, 1}, 0, inside_bits(ray), 0, 0, -1, {}}; }

    static std::uint64_t extended(std::uint64_t key, const Next& next, bool through) {
        key ^= (static_cast<std::uint64_t>(next.body) << 2 | std::uint64_t{next.hit.entering} << 1 | through) + 1;
        return (key * 0x9E3779B97F4A7C15u) ^ (key >> 29);
    }

    struct Meeting {
        Vector point, normal;  // the normal against the ray
        std::uint32_t bits_after;
        int medium_before, medium_after;
        double cosine;
        Interface interface;
    };

    struct Light {
        double t;
        const Panel* panel;
    };

    // The nearest panel that the ray meets before `end`, or none and `end` itself.
    Light light_before(const Ray& ray, double end) const {
        Light light{end, nullptr};
        for (const Panel& panel : scene_.panels) {
            const double t = panel.distance(ray);
            if (t < light.t) light = {t, &panel};
        }
        return light;
    }

    std::uint32_t inside_bits(const Ray& ray) const {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < scene_.bodies.size(); ++k) {
            std::visit(
                [&](const auto& surface) {
                    if (!surface.bounds().contains(ray.origin)) return;
                    int count = 0;
                    const double everything = INFINITY;
                    surface.crossings(ray, 0.0, everything, Hit{}, [&](const Hit& hit) { count += hit.t > 0.0; });
                    bits |= static_cast<std::uint32_t>(count & 1) << k;
                },
                scene_.bodies[k]);
        }
        return bits;
    }

    Next nearest(const Path& path) const {
        Next next;
        double best = INFINITY;
        const double tolerance = scene_.start_tolerance;
        for (int k = 0; k < static_cast<int>(scene_.bodies.size()); ++k) {
            const bool inside = (path.bits >> k) & 1u;
            const double lowest = k == path.last_body ? 0.0 : -tolerance;
            const auto visit = [&](const Hit& hit) {
                if (!(hit.t > lowest) || !(hit.t < best)) return;
                // Here already: the surface that the ray starts on or has just crossed.
                if (hit.entering == inside && hit.t <= tolerance) return;
                best = hit.t;
                next.hit = hit;
                next.body = k;
            };
            std::visit(
                [&](const auto& surface) {
                    surface.crossings(path.ray, lowest, best, k == path.last_body ? path.last_hit : Hit{}, visit);
                },
                scene_.bodies[k]);
        }
        next.hit.t = std::fmax(next.hit.t, 0.0);
        return next;
    }

    Meeting meet(const Path& path, const Next& next, Answer& answer) const {
        Meeting m;
        const std::uint32_t bit = 1u << next.body;
        answer.crossings += 1;
        answer.leaks += next.hit.entering == ((path.bits & bit) != 0);
        m.bits_after = next.hit.entering ? path.bits | bit : path.bits & ~bit;
        m.medium_before = scene_.medium_of_bits[path.bits];
        m.medium_after = scene_.medium_of_bits[m.bits_after];
        const double n1 = scene_.media[m.medium_before].refractive_index;
        const double n2 = scene_.media[m.medium_after].refractive_index;
        std::visit(
            [&](const auto& surface) {
                Vector normal;
                surface.place(path.ray, next.hit, m.point, normal);
                if (m.medium_before == m.medium_after || n1 == n2) {
                    m.normal = normal;
                    m.cosine = 1.0;
                    m.interface = {0.0, 1.0, 1.0};
                    return;
                }
                meet_with(path, next, n1, n2, normal, m);
                // A normal interpolated over a facet may send a ray to the facet's wrong side; the facet's own cannot.
                const Vector facet = surface.facet_normal(next.hit, normal);
                const double way = next.hit.entering ? 1.0 : -1.0;
                const bool back = way * dot(facet, reflected_direction(path, m)) > 0.0;
                const bool on = m.interface.reflectance >= 1.0 || way * dot(facet, refracted_direction(path, m)) < 0.0;
                if (!back || !on) meet_with(path, next, n1, n2, facet, m);
            },
            scene_.bodies[next.body]);
        return m;
    }

    static void meet_with(const Path& path, const Next& next, double n1, double n2, const Vector& normal, Meeting& m) {
        m.normal = next.hit.entering ? normal : -normal;
        m.cosine = std::fmin(std::fmax(-dot(path.ray.direction, m.normal), 0.0), 1.0);
        m.interface = fresnel(m.cosine, n1, n2);
    }

    static Vector reflected_direction(const Path& path, const Meeting& m) {
        return normalised(path.ray.direction + (2.0 * m.cosine) * m.normal);
    }

    static Vector refracted_direction(const Path& path, const Meeting& m) {
        if (m.interface.ratio == 1.0) return path.ray.direction;
        const double ratio = m.interface.ratio;
        return normalised(ratio * path.ray.direction + (ratio * m.cosine - m.interface.cos_refracted) * m.normal);
    }

    static Path reflected(const Path& path, const Next& next, const Meeting& m) {
        return {{m.point, reflected_direction(path, m)},
                path.weight,
                extended(path.key, next, false),
                path.bits,
                path.depth + 1,
                path.crossings + 1,
                next.body,
                next.hit};
    }

    static Path refracted(const Path& path, const Next& next, const Meeting& m) {
        const bool interface = m.medium_before != m.medium_after;
        return {{m.point, refracted_direction(path, m)},
                path.weight,
                extended(path.key, next, true),
                m.bits_after,
                path.depth + interface,
                path.crossings + 1,
                next.body,
                next.hit};
    }

    template <bool absorbing, class Arrive>
    Answer trace(const Ray& camera_ray, Arrive&& arrive) {
        Answer answer;
        waiting_.clear();
        waiting_.push_back(start(camera_ray));
        double travelled = 0.0;
        while (!waiting_.empty()) {
            Path path = waiting_.back();
            waiting_.pop_back();
            for (;;) {
                const Next next = nearest(path);
                const Light light = light_before(path.ray, next.hit.t);
                const double end = light.t;
                if (absorbing) {
                    const Colour& alpha = scene_.media[scene_.medium_of_bits[path.bits]].absorption_per_mm;
                    if (alpha.largest() > 0.0 && end < INFINITY)
                        path.weight = path.weight * Colour{std::exp(-alpha.r * end), std::exp(-alpha.g * end),
                                                           std::exp(-alpha.b * end)};
                }
                if (light.panel != nullptr || next.body < 0) {
                    answer.leaks += light.panel == nullptr && path.bits != 0;
                    const Colour radiance = light.panel != nullptr ? light.panel->radiance
                                                                   : scene_.environment.radiance(path.ray.direction);
                    answer.radiance = answer.radiance + path.weight * radiance;
                    arrive(Arrival{path.key, path.weight, path.ray, radiance, light.panel});
                    break;
                }
                const Meeting m = meet(path, next, answer);
                const bool first_path = path.depth == 0;
                if (first_path) travelled += end;
                if (m.medium_before != m.medium_after && first_path) answer.depth = travelled;
                const bool too_deep = m.medium_before != m.medium_after && path.depth >= settings_.maximum_depth;
                if (too_deep || path.crossings >= longest_path) {
                    leave_out(path, answer);
                    break;
                }
                const double reflectance = m.interface.reflectance;
                if (reflectance <= 0.0 || reflectance >= 1.0) {
                    path = reflectance >= 1.0 ? reflected(path, next, m) : refracted(path, next, m);
                    if (keep(path, answer)) continue;
                    break;
                }
                Path back = reflected(path, next, m), on = refracted(path, next, m);
                back.weight = reflectance * path.weight;
                on.weight = (1.0 - reflectance) * path.weight;
                const bool back_counts = keep(back, answer), on_counts = keep(on, answer);
                if (back_counts && on_counts) {
                    const bool back_first = reflectance > 0.5;
                    waiting_.push_back(back_first ? on : back);
                    path = back_first ? back : on;
                } else if (back_counts) {
                    path = back;
                } else if (on_counts) {
                    path = on;
                } else {
                    break;
                }
            }
        }
        return answer;
    }

    bool keep(const Path& path, Answer& answer) const {
        const double weight = path.weight.largest();
        if (weight >= settings_.cutoff) return true;
        leave_out(path, answer);
        return false;
    }

    void leave_out(const Path& path, Answer& answer) const {
        answer.left_out = answer.left_out + path.weight;
        answer.bound += path.weight.largest() * scene_.brightest;
    }

    const Scene& scene_;
    const Settings settings_;
    std::vector<Path> waiting_;
};

}  // namespace glass
