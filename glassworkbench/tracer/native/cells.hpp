// Mean radiance of pixels, without random samples. The scene is traced at the corners of a cell, at first a pixel. A
// path that arrives from all four corners after the same events is interpolated between them: its light is averaged
// over the cell without further tracing, exact to second order, with the third samples of each row and column telling
// how good that is. Where paths begin or end inside a cell (silhouettes, total reflection), and where the light they
// lead to has an edge, the cell is cut into quarters, the worst first, until the error comes below the tolerance. Faint
// paths are many, and matter little: the samples inside a pixel leave them to its corners.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "scene.hpp"
#include "transport.hpp"

namespace glass {

struct Pixel {
    Colour radiance;
    double sampling = 0.0;  // estimated error
    double pruned = 0.0;    // bound on the error of what was left out
    double depth = INFINITY;
};

class Cells {
public:
    static constexpr int tile_size = 32;     // pixels
    static constexpr int most_halvings = 3;  // of a pixel, before any error is asked for

    Cells(const Scene& scene, const Settings& settings, const Camera& camera, double tolerance, int halvings,
          const Colour& ambient, std::function<bool()> stopped)
        : scene_(scene),
          transport_(scene, settings),
          camera_(camera),
          tolerance_(tolerance),
          cutoff_(settings.cutoff),
          bright_cutoff_(bright * settings.cutoff),
          coarsest_(finest >> std::clamp(halvings, 0, most_halvings)),
          ambient_(ambient),
          stopped_(std::move(stopped)),
          likely_light_(std::fmin(scene.brightest, 3.0 * ambient.largest())),
          worst_light_(std::fmax(ambient.largest(), scene.brightest - smallest(ambient))) {}

    std::int64_t rays = 0, crossings = 0, leaks = 0;

    // Calls deliver(column, row, pixel) for each wanted pixel of a tile. A pixel depends on nothing but the block of
    // two by two pixels that it lies in.
    template <class Wanted, class Deliver>
    void tile(std::int64_t left, std::int64_t top, Wanted&& wanted, Deliver&& deliver) {
        arrivals_.clear();
        samples_.clear();
        lattice_.fill(-1);
        for (int y = 0; y < tile_size; y += 2)
            for (int x = 0; x < tile_size; x += 2) {
                std::array<bool, 4> here;
                bool any = false;
                for (int k = 0; k < 4; ++k) any |= here[k] = wanted(left + x + k % 2, top + y + k / 2);
                if (stopped_()) return;
                if (any) block(left, top, x, y, here, deliver);
            }
    }

private:
    struct Sample {
        std::uint32_t first, faint, last;  // of its arrivals, the bright and then the faint, both sorted by their keys
        Colour left_out;
    };

    using Corners = std::array<const Arrival*, 4>;

    // Second differences of neighbours in a row plus those in a column.
    struct Bend {
        double origin = 0.0, direction = 0.0;
        Colour value;  // of weight times light, with its sign; none where a light's edge lies between
    };

    struct Estimate {
        Colour value;
        Colour left_out;
        double smooth = 0.0;                  // error of interpolation
        double jump = 0.0;                    // error where paths begin and end
        bool level = false, upright = false;  // how the edge lies at which they do, if it lies so

        double error() const { return smooth + jump; }
    };
    friend Estimate operator+(const Estimate& a, const Estimate& b) {
        return {a.value + b.value, a.left_out + b.left_out, a.smooth + b.smooth,
                a.jump + b.jump,   a.level || b.level,      a.upright || b.upright};
    }

    struct Leaf {
        int x, y, size;  // in units of the finest lattice
        Estimate estimate;
    };

    static constexpr int finest = 32;  // cells along a pixel
    static constexpr int stride = finest + 1;
    static constexpr int most_samples = 1024;    // more for one pixel
    static constexpr double jump_share = 0.25;   // a jump's place within a cell is unknown to this share of its area
    static constexpr double hidden_share = 0.4;  // of the light that paths without a match may meet unseen between them
    static constexpr double wild_spread = 0.05;  // rad, from corner to corner: what lies between is not to be trusted,
    static constexpr double wild_share = 0.2;    // and may be off by this share of the light
    static constexpr double straight = 0.1;      // an edge's light changes less along it, as a share of what it changes
    static constexpr double bright = 8.0;        // a path that a cut-off so many times larger would keep
    static constexpr double faint_share = 0.5;   // of the allowed error, that pixels' corners may leave in faint paths
    static constexpr double caution = 2.0;       // factor on an interpolated ray's error where it decides
    static constexpr int light_points = 64;      // in a cell, where a light's edge crosses it
    static constexpr int most_lookups = 8;       // along a cell, of an environment's light
    static constexpr double golden_ratio = 0.6180339887498949;

    static double smallest(const Colour& c) { return lesser(c.r, lesser(c.g, c.b)); }
    static Colour magnitude(const Colour& c) { return {std::fabs(c.r), std::fabs(c.g), std::fabs(c.b)}; }
    static void widen(const Colour& c, Colour& low, Colour& high) {
        low = {lesser(low.r, c.r), lesser(low.g, c.g), lesser(low.b, c.b)};
        high = {greater(high.r, c.r), greater(high.g, c.g), greater(high.b, c.b)};
    }

    std::int32_t traced(double column, double row, double cutoff) {
        Sample sample{static_cast<std::uint32_t>(arrivals_.size()), 0, 0, {}};
        const Answer answer =
            transport_.arrivals(camera_.ray(column, row), cutoff, [&](const Arrival& a) { arrivals_.push_back(a); });
        sample.last = static_cast<std::uint32_t>(arrivals_.size());
        sample.left_out = answer.left_out;
        const auto first = arrivals_.begin() + sample.first;
        const auto faint =
            std::partition(first, arrivals_.end(), [&](const Arrival& a) { return a.kept >= bright_cutoff_; });
        sample.faint = static_cast<std::uint32_t>(faint - arrivals_.begin());
        const auto by_key = [](const Arrival& a, const Arrival& b) { return a.key < b.key; };
        std::sort(first, faint, by_key);
        std::sort(faint, arrivals_.end(), by_key);
        samples_.push_back(sample);
        rays += 1;
        crossings += answer.crossings;
        leaks += answer.leaks;
        return static_cast<std::int32_t>(samples_.size()) - 1;
    }

    template <class Deliver>
    void block(std::int64_t left, std::int64_t top, int x, int y, const std::array<bool, 4>& wanted,
               Deliver&& deliver) {
        std::array<std::int32_t, 9> points;
        for (int i = 0; i < 9; ++i) {
            const int column = x + i % 3, row = y + i / 3;
            std::int32_t& place = lattice_[row * (tile_size + 1) + column];
            if (place < 0) place = traced(static_cast<double>(left + column), static_cast<double>(top + row), cutoff_);
            points[i] = place;
        }
        const std::array<Estimate, 4> bright = bright_cells(points), faint = faint_cells(points);
        const std::size_t arrivals = arrivals_.size(), samples = samples_.size();
        for (int k = 0; k < 4; ++k) {
            if (!wanted[k]) continue;
            const std::int64_t column = left + x + k % 2, row = top + y + k / 2;
            const int corner = 3 * (k / 2) + k % 2;
            Pixel pixel = refined(static_cast<double>(column), static_cast<double>(row),
                                  {points[corner], points[corner + 1], points[corner + 3], points[corner + 4]},
                                  bright[k], faint[k]);
            pixel.depth = transport_.depth(camera_.ray(column + 0.5, row + 0.5));
            deliver(column, row, pixel);
            arrivals_.resize(arrivals);
            samples_.resize(samples);
        }
    }

    double pruned(const Estimate& e) const { return e.left_out.largest() * worst_light_; }

    Pixel refined(double column, double row, const std::array<std::int32_t, 4>& corners, const Estimate& bright,
                  const Estimate& faint) {
        const double allowed = std::fmax(tolerance_ - pruned(faint), 0.5 * tolerance_);
        const bool all = faint.error() > faint_share * allowed;  // whether the faint paths are refined too
        const Estimate beside = all ? Estimate{} : faint;
        leaves_.clear();
        leaves_.push_back({0, 0, finest, all ? bright + faint : bright});
        double error = bright.error() + faint.error();
        if (error > allowed || coarsest_ < finest) {
            fine_.fill(-1);
            fine_[0] = corners[0];
            fine_[finest] = corners[1];
            fine_[finest * stride] = corners[2];
            fine_[finest * stride + finest] = corners[3];
            for (std::size_t i = 0; i < leaves_.size(); ++i)
                while (leaves_[i].size > coarsest_ && !stopped_()) split(column, row, i, all);
            error = beside.error() + total_error();
            const std::int64_t limit = rays + most_samples;
            while (error > allowed && rays < limit && !stopped_()) {
                std::size_t worst = 0;
                double most = 0.0;
                for (std::size_t i = 0; i < leaves_.size(); ++i) {
                    const Leaf& leaf = leaves_[i];
                    const double share = area(leaf) * leaf.estimate.error();
                    if (leaf.size > 1 && share > most) {
                        most = share;
                        worst = i;
                    }
                }
                if (most <= 0.0) break;
                split(column, row, worst, all);
                error = beside.error() + total_error();
            }
        }
        Pixel pixel;
        pixel.radiance = beside.value;
        Colour left_out = beside.left_out;
        for (const Leaf& leaf : leaves_) {
            pixel.radiance = pixel.radiance + area(leaf) * leaf.estimate.value;
            left_out = left_out + area(leaf) * leaf.estimate.left_out;
        }
        pixel.radiance = pixel.radiance + left_out * ambient_;
        pixel.sampling = error;
        pixel.pruned = left_out.largest() * worst_light_;
        return pixel;
    }

    static double area(const Leaf& leaf) {
        const double side = static_cast<double>(leaf.size) / finest;
        return side * side;
    }

    // Errors of interpolation may all have one sign. Those at jumps have none in common, but along an edge that runs
    // with the pixel's rows or columns from one side to the other.
    double total_error() {
        double smooth = 0.0;
        for (const Leaf& leaf : leaves_) smooth += area(leaf) * leaf.estimate.smooth;
        return smooth + std::sqrt(greater(jumps_along(&Leaf::y), jumps_along(&Leaf::x)));
    }

    // Leaves of one size at one place.
    struct Line {
        double sum, squares;  // of their errors at jumps
        int length;           // of those whose edge runs along it
    };

    double jumps_along(int Leaf::*place) {
        const bool Estimate::*lies = place == &Leaf::y ? &Estimate::level : &Estimate::upright;
        const auto line = [&](const Leaf& leaf) -> Line& { return lines_[(finest + leaf.*place) / leaf.size]; };
        for (const Leaf& leaf : leaves_) line(leaf) = {};
        for (const Leaf& leaf : leaves_) {
            const double jump = area(leaf) * leaf.estimate.jump;
            Line& along = line(leaf);
            along.sum += jump;
            along.squares += jump * jump;
            along.length += leaf.estimate.*lies ? leaf.size : 0;
        }
        double squares = 0.0;
        for (const Leaf& leaf : leaves_) {
            squares += line(leaf).length == finest ? line(leaf).sum * line(leaf).sum : line(leaf).squares;
            line(leaf) = {};
        }
        return squares;
    }

    void split(double column, double row, std::size_t chosen, bool all) {
        const Leaf leaf = leaves_[chosen];
        const int half = leaf.size / 2;
        std::array<std::int32_t, 9> points;
        for (int i = 0; i < 9; ++i) {
            const int x = leaf.x + half * (i % 3), y = leaf.y + half * (i / 3);
            std::int32_t& place = fine_[y * stride + x];
            if (place < 0)
                place = traced(column + static_cast<double>(x) / finest, row + static_cast<double>(y) / finest,
                               all ? cutoff_ : bright_cutoff_);
            points[i] = place;
        }
        std::array<Estimate, 4> estimates = bright_cells(points);
        if (all) {
            const std::array<Estimate, 4> faint = faint_cells(points);
            for (int k = 0; k < 4; ++k) estimates[k] = estimates[k] + faint[k];
        }
        leaves_[chosen] = {leaf.x, leaf.y, half, estimates[0]};
        for (int k = 1; k < 4; ++k)
            leaves_.push_back({leaf.x + half * (k % 2), leaf.y + half * (k / 2), half, estimates[k]});
    }

    // The four cells between three by three samples, as their bright paths, or the faint ones and what is left out, see
    // them.
    std::array<Estimate, 4> bright_cells(const std::array<std::int32_t, 9>& points) const {
        std::array<Estimate, 4> cells;
        add_paths(points, &Sample::first, &Sample::faint, cells);
        return cells;
    }
    std::array<Estimate, 4> faint_cells(const std::array<std::int32_t, 9>& points) const {
        std::array<Estimate, 4> cells;
        for (int k = 0; k < 4; ++k)
            for (const int corner : corners_of(k))
                cells[k].left_out = cells[k].left_out + 0.25 * samples_[points[corner]].left_out;
        add_paths(points, &Sample::faint, &Sample::last, cells);
        return cells;
    }

    void add_paths(const std::array<std::int32_t, 9>& points, std::uint32_t Sample::*first, std::uint32_t Sample::*last,
                   std::array<Estimate, 4>& cells) const {
        std::array<const Arrival*, 9> next, end;
        for (int i = 0; i < 9; ++i) {
            const Sample& sample = samples_[points[i]];
            next[i] = arrivals_.data() + sample.*first;
            end[i] = arrivals_.data() + sample.*last;
        }
        std::array<std::array<Colour, 4>, 4> unmatched;  // of each cell, at its corners
        std::array<std::array<double, 4>, 4> loose{};    // their weight
        for (;;) {
            std::uint64_t key = UINT64_MAX;
            bool any = false;
            for (int i = 0; i < 9; ++i)
                if (next[i] != end[i]) {
                    key = std::min(key, next[i]->key);
                    any = true;
                }
            if (!any) break;
            std::array<const Arrival*, 9> path;
            for (int i = 0; i < 9; ++i) path[i] = next[i] != end[i] && next[i]->key == key ? next[i]++ : nullptr;
            std::array<Bend, 3> rows, columns;
            std::array<bool, 3> row_known, column_known;
            for (int i = 0; i < 3; ++i) {
                row_known[i] = bend(path[3 * i], path[3 * i + 1], path[3 * i + 2], rows[i]);
                column_known[i] = bend(path[i], path[3 + i], path[6 + i], columns[i]);
            }
            for (int k = 0; k < 4; ++k) {
                const std::array<int, 4> at = corners_of(k);
                const Corners corners{path[at[0]], path[at[1]], path[at[2]], path[at[3]]};
                if (corners[0] && corners[1] && corners[2] && corners[3]) {
                    const int c = k % 2, r = k / 2;
                    Bend whole = larger(rows[r], row_known[r], rows[r + 1], row_known[r + 1], corners[0], corners[1],
                                        corners[2], corners[3]);
                    const Bend down = larger(columns[c], column_known[c], columns[c + 1], column_known[c + 1],
                                             corners[0], corners[2], corners[1], corners[3]);
                    whole.origin += down.origin;
                    whole.direction += down.direction;
                    whole.value = whole.value + down.value;
                    add_matched(corners, whole, cells[k]);
                } else {
                    for (int j = 0; j < 4; ++j)
                        if (corners[j]) {
                            unmatched[k][j] = unmatched[k][j] + corners[j]->weight * corners[j]->light;
                            loose[k][j] += corners[j]->weight.largest();
                        }
                }
            }
        }
        for (int k = 0; k < 4; ++k) {
            Colour low = unmatched[k][0], high = low, sum;
            for (const Colour& at : unmatched[k]) {
                widen(at, low, high);
                sum = sum + at;
            }
            cells[k].value = cells[k].value + 0.25 * sum;
            const auto apart = [&](int i, int j) {
                return magnitude(unmatched[k][i] + -1.0 * unmatched[k][j]).largest();
            };
            const double range = (high + -1.0 * low).largest();
            cells[k].level |= range > 0.0 && apart(0, 1) + apart(2, 3) < straight * range;
            cells[k].upright |= range > 0.0 && apart(0, 2) + apart(1, 3) < straight * range;
            const double most = *std::max_element(loose[k].begin(), loose[k].end());
            cells[k].jump += jump_share * range + hidden_share * most * likely_light_;
        }
    }

    static std::array<int, 4> corners_of(int cell) {
        const int first = 3 * (cell / 2) + cell % 2;
        return {first, first + 1, first + 3, first + 4};
    }

    static bool bend(const Arrival* a, const Arrival* b, const Arrival* c, Bend& bend) {
        if (!a || !b || !c) return false;
        bend.origin = length(a->ray.origin - 2.0 * b->ray.origin + c->ray.origin);
        bend.direction = length(a->ray.direction - 2.0 * b->ray.direction + c->ray.direction);
        if (a->panel == b->panel && b->panel == c->panel)
            bend.value = a->weight * a->light + -2.0 * (b->weight * b->light) + c->weight * c->light;
        return true;
    }

    // The larger bend of two rows; where neither is known, as large as the change from corner to corner.
    static Bend larger(const Bend& first, bool first_known, const Bend& second, bool second_known, const Arrival* a,
                       const Arrival* b, const Arrival* c, const Arrival* d) {
        if (!first_known && !second_known)
            return {greater(length(a->ray.origin - b->ray.origin), length(c->ray.origin - d->ray.origin)),
                    greater(length(a->ray.direction - b->ray.direction), length(c->ray.direction - d->ray.direction)),
                    {}};
        if (!first_known) return second;
        if (!second_known) return first;
        return {greater(first.origin, second.origin), greater(first.direction, second.direction),
                0.5 * (first.value + second.value)};
    }

    void add_matched(const Corners& corners, const Bend& bend, Estimate& cell) const {
        const Panel* const panel = corners[0]->panel;
        bool same = true;
        for (const Arrival* a : corners) same &= a->panel == panel;
        const double off_origin = 0.125 * bend.origin, off_direction = 0.125 * bend.direction;
        const double spread = greater(length(corners[0]->ray.direction - corners[3]->ray.direction),
                                      length(corners[1]->ray.direction - corners[2]->ray.direction));
        if (!scene_.panels.empty() && spread > wild_spread) {
            add_edge(corners, off_origin, off_direction, cell);
            cell.smooth += wild_share * weight(corners) * likely_light_ * lesser(1.0, 2.0 * spread);
            return;
        }
        if (same && panel != nullptr) {
            add_smooth(corners, bend, cell);
            const double t = panel->distance(corners[0]->ray);
            const double off = off_origin + t * off_direction;
            const double margin = panel_margin(*panel, corners);
            if (caution * off > margin) cell.smooth += 0.25 * weight(corners) * panel->radiance.largest();
            return;
        }
        if (!same || may_meet_panel(corners, caution * off_origin, caution * off_direction)) {
            add_edge(corners, off_origin, off_direction, cell);
            return;
        }
        if (scene_.environment.pixels.empty()) return;
        const double texel = M_PI / static_cast<double>(scene_.environment.height);
        if (scene_.environment.pixels.size() == 1 || spread <= texel) {
            add_smooth(corners, bend, cell);
        } else {
            add_environment(corners, off_direction, spread, texel, cell);
        }
    }

    static double weight(const Corners& corners) {
        double w = 0.0;
        for (const Arrival* a : corners) w = greater(w, a->weight.largest());
        return w;
    }

    // Trapezoidal rule with the end correction of Euler and Maclaurin.
    void add_smooth(const Corners& corners, const Bend& bend, Estimate& cell) const {
        Colour sum;
        for (const Arrival* a : corners) sum = sum + a->weight * a->light;
        const Colour correction = (1.0 / 12.0) * bend.value;
        cell.value = cell.value + 0.25 * sum + -1.0 * correction;
        cell.smooth += 0.5 * magnitude(correction).largest();
    }

    // How far inside the panel the corners' rays meet it, in mm.
    static double panel_margin(const Panel& panel, const Corners& corners) {
        double margin = INFINITY;
        const double u = std::sqrt(panel.uu), v = std::sqrt(panel.vv);
        for (const Arrival* a : corners) {
            double x, y;
            panel.place(a->ray, x, y);
            margin = lesser(margin, lesser(lesser(x, 1.0 - x) * u, lesser(y, 1.0 - y) * v));
        }
        return margin;
    }

    // Whether a ray between the corners' rays, which all miss the panels, may meet one.
    bool may_meet_panel(const Corners& corners, double off_origin, double off_direction) const {
        for (const Panel& panel : scene_.panels) {
            const double u = std::sqrt(panel.uu), v = std::sqrt(panel.vv);
            unsigned common = 31u;
            for (const Arrival* a : corners) {
                double x, y;
                const double t = panel.place(a->ray, x, y);
                if (!(t > 0.0)) {
                    common &= 16u;
                    continue;
                }
                const double off = off_origin + t * off_direction;
                common &= unsigned{-x * u > off} | unsigned{(x - 1.0) * u > off} << 1 | unsigned{-y * v > off} << 2 |
                          unsigned{(y - 1.0) * v > off} << 3;
            }
            if (common == 0) return true;
        }
        return false;
    }

    Ray between(const Corners& c, double x, double y, Colour& weight) const {
        const double w[4] = {(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y};
        Ray ray;
        weight = {};
        for (int i = 0; i < 4; ++i) {
            ray.origin = ray.origin + w[i] * c[i]->ray.origin;
            ray.direction = ray.direction + w[i] * c[i]->ray.direction;
            weight = weight + w[i] * c[i]->weight;
        }
        return ray;
    }

    Colour light(const Ray& ray) const {
        const Panel* met = nullptr;
        double nearest = INFINITY;
        for (const Panel& panel : scene_.panels) {
            const double t = panel.distance(ray);
            if (t < nearest) {
                nearest = t;
                met = &panel;
            }
        }
        return met != nullptr ? met->radiance : scene_.environment.radiance(ray.direction);
    }

    // An edge of a panel crosses the cell: the light of rays in between is looked up, many of them.
    void add_edge(const Corners& corners, double off_origin, double off_direction, Estimate& cell) const {
        Colour sum, low{INFINITY, INFINITY, INFINITY}, high;
        for (int i = 0; i < light_points; ++i) {
            Colour weight;
            const double turn = i * golden_ratio;
            const Ray ray = between(corners, (i + 0.5) / light_points, turn - std::floor(turn), weight);
            const Colour value = weight * light(ray);
            sum = sum + value;
            widen(value, low, high);
        }
        for (const Arrival* a : corners) widen(a->weight * a->light, low, high);
        cell.value = cell.value + (1.0 / light_points) * sum;
        double reach = 0.0;  // mm, from corner to corner
        double off = 0.0;
        for (const Panel& panel : scene_.panels) {
            const double t = length(panel.origin + 0.5 * (panel.u + panel.v) - corners[0]->ray.origin);
            off = greater(off, off_origin + t * off_direction);
            for (int k : {0, 1}) reach = greater(reach, length(corners[k]->ray.at(t) - corners[3 - k]->ray.at(t)));
        }
        const double range = (high + -1.0 * low).largest();
        cell.smooth += range * (reach > 0.0 ? lesser(0.5, off / reach) : 0.5);
        cell.jump += 0.02 * range;
    }

    // The light of directions in between is looked up, at as many of them as the spread of each row and column asks
    // for: fewer where the path weighs little.
    void add_environment(const Corners& corners, double off_direction, double spread, double texel,
                         Estimate& cell) const {
        const auto apart = [&](int i, int j) {
            return length(corners[i]->ray.direction - corners[j]->ray.direction) / texel;
        };
        const double across = greater(apart(0, 1), apart(2, 3)), down = greater(apart(0, 2), apart(1, 3));
        const double importance = weight(corners) * scene_.brightest / tolerance_;
        const int most = importance > 1.0 ? most_lookups : importance > 0.125 ? most_lookups / 2 : most_lookups / 4;
        const int columns = std::clamp(static_cast<int>(std::ceil(0.25 * across)), 1, most);
        const int rows = std::clamp(static_cast<int>(std::ceil(0.25 * down)), 1, most);
        const int level = static_cast<int>(std::log2(greater(1.0, 0.5 * greater(across / columns, down / rows))));
        Colour sum, low{INFINITY, INFINITY, INFINITY}, high;
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i) {
                Colour weight;
                const Ray ray = between(corners, (i + 0.5) / columns, (j + 0.5) / rows, weight);
                const Colour light = scene_.surroundings.radiance(ray.direction, level);
                sum = sum + weight * light;
                widen(light, low, high);
            }
        cell.value = cell.value + (1.0 / (rows * columns)) * sum;
        for (const Arrival* a : corners) widen(a->light, low, high);
        const double range = weight(corners) * (high + -1.0 * low).largest();
        cell.smooth += range * (lesser(0.5, caution * off_direction / spread) + 0.02 + lesser(0.2, 0.5 * spread));
    }

    const Scene& scene_;
    Transport transport_;
    const Camera camera_;
    const double tolerance_;
    const double cutoff_, bright_cutoff_;
    const int coarsest_;  // size of the largest cells, in units of the finest lattice
    const Colour ambient_;
    const std::function<bool()> stopped_;
    const double likely_light_;  // where nothing is known of it
    const double worst_light_;
    std::vector<Arrival> arrivals_;
    std::vector<Sample> samples_;
    std::vector<Leaf> leaves_;
    std::array<Line, 2 * finest> lines_;
    std::array<std::int32_t, (tile_size + 1) * (tile_size + 1)> lattice_;
    std::array<std::int32_t, stride * stride> fine_;
};

}  // namespace glass
