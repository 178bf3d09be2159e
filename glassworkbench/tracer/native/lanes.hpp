// Numbers side by side: the compiler's vector extension, in whatever registers the build has.
#pragma once

#include <cmath>
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace glass {

// For boxes: they have room for the rounding of float32.
typedef float FloatLanes __attribute__((vector_size(64)));
typedef std::int32_t FloatMask __attribute__((vector_size(64)));
constexpr int float_lane_count = 16;

inline FloatLanes every(float value) { return FloatLanes{} + value; }

// Of a NaN and a number the second.
inline FloatLanes smaller(const FloatLanes& a, const FloatLanes& b) {
#if defined(__AVX512F__)
    return reinterpret_cast<FloatLanes>(
        _mm512_maskz_min_ps(0xffff, reinterpret_cast<__m512>(a), reinterpret_cast<__m512>(b)));
#else
    return a < b ? a : b;
#endif
}
inline FloatLanes larger(const FloatLanes& a, const FloatLanes& b) {
#if defined(__AVX512F__)
    return reinterpret_cast<FloatLanes>(
        _mm512_maskz_max_ps(0xffff, reinterpret_cast<__m512>(a), reinterpret_cast<__m512>(b)));
#else
    return a > b ? a : b;
#endif
}

inline FloatLanes square_root(FloatLanes a) {
#if defined(__AVX512F__)
    return reinterpret_cast<FloatLanes>(_mm512_maskz_sqrt_ps(0xffff, reinterpret_cast<__m512>(a)));
#else
    for (int k = 0; k < float_lane_count; ++k) a[k] = std::sqrt(a[k]);
    return a;
#endif
}

// Bit k says whether a[k] <= b[k].
inline unsigned where_no_larger(const FloatLanes& a, const FloatLanes& b) {
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask(reinterpret_cast<__m512>(a), reinterpret_cast<__m512>(b), _CMP_LE_OQ);
#else
    const FloatMask mask = a <= b;
    unsigned bits = 0;
    for (int k = 0; k < float_lane_count; ++k) bits |= static_cast<unsigned>(mask[k] & 1) << k;
    return bits;
#endif
}
// The number of the lowest bit that is set.
inline int lowest_bit(unsigned bits) { return __builtin_ctz(bits); }

}  // namespace glass
