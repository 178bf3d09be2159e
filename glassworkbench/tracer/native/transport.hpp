// Light through smooth glass, without random numbers: at each interface the ray splits into its reflected and its
// refracted part, the heavier is followed first, and parts lighter than the cut-off are left out. Their weight times
// the brightest light bounds what is missing.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>
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
    double kept;  // the weight at its last interface: any larger cut-off would have left the path out
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
        return arrivals(camera_ray, settings_.cutoff, [](const Arrival&) {});
    }

    // The same; each path that arrives at light, or leaves the scene, is handed to `arrive`.
    template <class Arrive>
    Answer arrivals(const Ray& camera_ray, double cutoff, Arrive&& arrive) {
        return settings_.absorption ? trace<true>(camera_ray, cutoff, arrive)
                                    : trace<false>(camera_ray, cutoff, arrive);
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
        double kept;        // the weight at the last interface
        std::uint64_t key;  // the same for paths that met the same pieces of bodies in the same ways
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

    Path start(const Ray& ray) const { return {ray, {1, 1, 1}, 1.0, 0, inside_bits(ray), 0, 0, -1, {}}; }

    static std::uint64_t extended(std::uint64_t key, const Next& next, bool through) {
        key ^= (static_cast<std::uint64_t>(next.hit.component) << 8 | static_cast<std::uint64_t>(next.body) << 2 |
                std::uint64_t{next.hit.entering} << 1 | through) +
               1;
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

    // The nearest crossing ahead.
    Next nearest(const Path& path) const {
        Next next;
        for (int k = 0; k < static_cast<int>(scene_.bodies.size()); ++k) {
            View view = look(path, k, scene_.start_tolerance, next.hit.t);
            const bool missed = k == path.last_body && view.beyond.part < 0 && view.inside;
            if (view.here.part >= 0 || missed || view.contradicted()) {
                view = settled(path, k);
                if (view.here.part >= 0) return {view.here, k};
            }
            if (view.beyond.t < next.hit.t) next = {view.beyond, k};
        }
        return next;
    }

    // What a ray sees of a body: its nearest crossing beyond the tolerance, and the last one here in the sense that is
    // due. Here are the surfaces that the ray starts on or has just crossed, and at an edge or an apex others, of which
    // rounding decides the distance and its sign.
    struct View {
        bool inside;
        Hit here, beyond;

        bool contradicted() const { return beyond.part >= 0 && beyond.entering == inside; }
    };

    View look(const Path& path, int body, double behind, double farthest) const {
        View view{((path.bits >> body) & 1u) != 0, {}, {}};
        const Hit start = body == path.last_body ? path.last_hit : Hit{};
        double best = farthest;
        const auto visit = [&](const Hit& hit) {
            if (hit.t > scene_.start_tolerance) {
                if (!(hit.t < best)) return;
                best = hit.t;
                view.beyond = hit;
            } else if (-hit.t <= greater(scene_.start_tolerance, greater(hit.slack, start.slack))) {
                if (hit.entering != view.inside && (view.here.part < 0 || hit.t > view.here.t)) view.here = hit;
            }
        };
        std::visit([&](const auto& surface) { surface.crossings(path.ray, -behind, best, start, visit); },
                   scene_.bodies[body]);
        return view;
    }

    // What counts of a body that has crossings here, or ahead in the wrong sense: `here` only where the next one
    // farther on says that it was passed, and `beyond` in the right order.
    View settled(const Path& path, int body) const {
        const double slack =
            std::visit([](const auto& surface) { return surface.largest_slack(); }, scene_.bodies[body]);
        View view = look(path, body, greater(slack, scene_.start_tolerance), INFINITY);
        const auto passed = [&] { return view.beyond.part < 0 ? view.inside : view.contradicted(); };
        if (!passed()) {
            view.here = {};
            return view;
        }
        if (view.here.part < 0 && slack > 0.0) put_in_order(path, body, view);
        if (view.here.part < 0 && passed() && body == path.last_body && balanced(path.ray, body)) {
            // The start lies a little off the surface, and the ray beside it: what is left to cross is the start.
            view.here = path.last_hit;
            view.here.entering = !view.inside;
            view.here.t = 0.0;
        }
        view.here.t = greater(view.here.t, 0.0);
        return view;
    }

    // The crossing that is due may come a little after one that is not.
    void put_in_order(const Path& path, int body, View& view) const {
        const Hit first = view.beyond;
        if (first.part < 0) return;
        double best = INFINITY;
        const auto visit = [&](const Hit& hit) {
            if (hit.entering == view.inside || !(hit.t > first.t) || !(hit.t < best)) return;
            best = hit.t;
            if (hit.t - first.t <= greater(hit.slack, first.slack)) view.beyond = hit;
        };
        std::visit(
            [&](const auto& surface) {
                surface.crossings(path.ray, first.t, best, body == path.last_body ? path.last_hit : Hit{}, visit);
            },
            scene_.bodies[body]);
    }

    // Whether the whole line of a ray enters a body as often as it leaves it.
    bool balanced(const Ray& ray, int body) const {
        int balance = 0;
        const double everything = INFINITY;
        std::visit(
            [&](const auto& surface) {
                surface.crossings(ray, -INFINITY, everything, Hit{},
                                  [&](const Hit& hit) { balance += hit.entering ? 1 : -1; });
            },
            scene_.bodies[body]);
        return balance == 0;
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
                if constexpr (std::is_same_v<std::decay_t<decltype(surface)>, Mesh>)
                    keep_sides(surface, path, next, n1, n2, m);
            },
            scene_.bodies[next.body]);
        return m;
    }

    // A normal interpolated over a facet may send a ray to the facet's wrong side; the facet's own cannot.
    static void keep_sides(const Mesh& mesh, const Path& path, const Next& next, double n1, double n2, Meeting& m) {
        const Vector facet = mesh.facet_normal(next.hit);
        const double way = next.hit.entering ? 1.0 : -1.0;
        const bool back = way * dot(facet, reflected_direction(path, m)) > 0.0;
        const bool on = m.interface.reflectance >= 1.0 || way * dot(facet, refracted_direction(path, m)) < 0.0;
        if (!back || !on) meet_with(path, next, n1, n2, facet, m);
    }

    static void meet_with(const Path& path, const Next& next, double n1, double n2, const Vector& normal, Meeting& m) {
        m.normal = next.hit.entering ? normal : -normal;
        m.cosine = lesser(greater(-dot(path.ray.direction, m.normal), 0.0), 1.0);
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
                path.kept,
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
                path.kept,
                extended(path.key, next, true),
                m.bits_after,
                path.depth + interface,
                path.crossings + 1,
                next.body,
                next.hit};
    }

    template <bool absorbing, class Arrive>
    Answer trace(const Ray& camera_ray, double cutoff, Arrive&& arrive) {
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
                    arrive(Arrival{path.key, path.kept, path.weight, path.ray, radiance, light.panel});
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
                    if (keep(path, cutoff, answer)) continue;
                    break;
                }
                Path back = reflected(path, next, m), on = refracted(path, next, m);
                back.weight = reflectance * path.weight;
                on.weight = (1.0 - reflectance) * path.weight;
                const bool back_counts = keep(back, cutoff, answer), on_counts = keep(on, cutoff, answer);
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

    bool keep(Path& path, double cutoff, Answer& answer) const {
        path.kept = path.weight.largest();
        if (path.kept >= cutoff) return true;
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
