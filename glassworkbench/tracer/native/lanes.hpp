// Eight float64 numbers side by side: the compiler's vector extension, in whatever registers the build has.
#pragma once

#include <cmath>

namespace glass {

typedef double Lanes __attribute__((vector_size(64)));
constexpr int lane_count = 8;

inline Lanes every(double value) { return Lanes{} + value; }
inline Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
inline Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
inline Lanes square_root(Lanes a) {
    for (int k = 0; k < lane_count; ++k) a[k] = std::sqrt(a[k]);
    return a;
}

}  // namespace glass
