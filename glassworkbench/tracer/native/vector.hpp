// Points and directions in space.
#pragma once

#include <cmath>

namespace glass {

// Unlike std::fmin and std::fmax they are one instruction; of a NaN and a number they return the second.
inline double lesser(double a, double b) { return a < b ? a : b; }
inline double greater(double a, double b) { return a > b ? a : b; }

// Copied number by number: a copy in wider registers would wait for the numbers just written.
struct Vector {
    double x = 0.0, y = 0.0, z = 0.0;

    Vector() = default;
    Vector(double x, double y, double z) : x(x), y(y), z(z) {}
    Vector(const Vector& o) : x(o.x), y(o.y), z(o.z) {}
    Vector& operator=(const Vector& o) {
        x = o.x;
        y = o.y;
        z = o.z;
        return *this;
    }

    double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator-(const Vector& a) { return {-a.x, -a.y, -a.z}; }
inline Vector operator*(double s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector normalised(const Vector& a) { return (1.0 / length(a)) * a; }

// Rows are the axes of a local frame, seen from the world.
struct Rotation {
    Vector row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

    Vector to_local(const Vector& v) const { return {dot(row[0], v), dot(row[1], v), dot(row[2], v)}; }
    Vector to_world(const Vector& v) const { return v.x * row[0] + v.y * row[1] + v.z * row[2]; }
};

struct Ray {
    Vector origin;
    Vector direction;  // unit length

    Vector at(double t) const { return origin + t * direction; }
};

struct Box {
    Vector low{INFINITY, INFINITY, INFINITY};
    Vector high{-INFINITY, -INFINITY, -INFINITY};

    void include(const Vector& p) {
        low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y), std::fmin(low.z, p.z)};
        high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y), std::fmax(high.z, p.z)};
    }
    void include(const Box& b) {
        include(b.low);
        include(b.high);
    }
    bool contains(const Vector& p) const {
        return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z && p.z <= high.z;
    }
    double half_area() const {
        const Vector e = high - low;
        return e.x < 0.0 ? 0.0 : e.x * e.y + e.y * e.z + e.z * e.x;
    }
    double largest_coordinate() const {
        double size = 0.0;
        for (int axis = 0; axis < 3; ++axis)
            size = std::fmax(size, std::fmax(std::fabs(low[axis]), std::fabs(high[axis])));
        return size;
    }
};

// Where a ray crosses a surface. `part` and `u`, `v` say where on the surface; the surface itself knows the normal.
// `slack` is how far along the ray it may lie from where its order among others is right: 0 but at creases.
// `component` tells the pieces of a body apart that has several, each of them smooth.
struct Hit {
    double t = INFINITY;
    bool entering = false;
    int part = -1;
    double u = 0.0, v = 0.0;
    double slack = 0.0;
    int component = 0;

    Hit() = default;
    Hit(double t, bool entering, int part, double u, double v, double slack = 0.0)
        : t(t), entering(entering), part(part), u(u), v(v), slack(slack) {}
    Hit(const Hit& o)
        : t(o.t), entering(o.entering), part(o.part), u(o.u), v(o.v), slack(o.slack), component(o.component) {}
    Hit& operator=(const Hit& o) {
        t = o.t;
        entering = o.entering;
        part = o.part;
        u = o.u;
        v = o.v;
        slack = o.slack;
        component = o.component;
        return *this;
    }
};

}  // namespace glass
