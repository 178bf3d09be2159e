// Sixteen float32 numbers side by side, in whatever registers the build has. For boxes: they have room for its
// rounding.
#pragma once

#include <cmath>
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace glass {

constexpr int lane_count = 16;

// In parts as wide as a register: of wider vectors compilers make single numbers.
struct Lanes {
#if defined(__AVX512F__)
    static constexpr int width = 16;
#elif defined(__AVX2__)
    static constexpr int width = 8;
#else
    static constexpr int width = 4;
#endif
    static constexpr int parts = lane_count / width;
    typedef float Part __attribute__((vector_size(4 * width)));
    typedef std::int32_t Mask __attribute__((vector_size(4 * width)));

    Part part[parts];

    float operator[](int k) const { return part[k / width][k % width]; }
    void set(int k, float value) { part[k / width][k % width] = value; }

    template <class Function>
    static Lanes each(Function&& function) {
        Lanes result;
        for (int k = 0; k < parts; ++k) result.part[k] = function(k);
        return result;
    }
};

inline Lanes every(float value) {
    return Lanes::each([&](int) { return Lanes::Part{} + value; });
}
inline Lanes operator+(const Lanes& a, const Lanes& b) {
    return Lanes::each([&](int k) { return a.part[k] + b.part[k]; });
}
inline Lanes operator-(const Lanes& a, const Lanes& b) {
    return Lanes::each([&](int k) { return a.part[k] - b.part[k]; });
}
inline Lanes operator*(const Lanes& a, const Lanes& b) {
    return Lanes::each([&](int k) { return a.part[k] * b.part[k]; });
}
inline Lanes operator-(const Lanes& a) {
    return Lanes::each([&](int k) { return -a.part[k]; });
}
inline Lanes operator+(const Lanes& a, float b) { return a + every(b); }
inline Lanes operator-(const Lanes& a, float b) { return a - every(b); }
inline Lanes operator*(const Lanes& a, float b) { return a * every(b); }

// In each lane x where a > b, else y.
inline Lanes where_greater(const Lanes& a, const Lanes& b, const Lanes& x, const Lanes& y) {
    return Lanes::each([&](int k) { return a.part[k] > b.part[k] ? x.part[k] : y.part[k]; });
}

// Of a NaN and a number the second.
inline Lanes smaller(const Lanes& a, const Lanes& b) {
    return Lanes::each([&](int k) -> Lanes::Part {
#if defined(__AVX512F__)
        return (Lanes::Part)_mm512_maskz_min_ps(0xffff, (__m512)a.part[k], (__m512)b.part[k]);
#elif defined(__AVX2__)
        return (Lanes::Part)_mm256_min_ps((__m256)a.part[k], (__m256)b.part[k]);
#elif defined(__SSE2__)
        return (Lanes::Part)_mm_min_ps((__m128)a.part[k], (__m128)b.part[k]);
#else
        return a.part[k] < b.part[k] ? a.part[k] : b.part[k];
#endif
    });
}
inline Lanes larger(const Lanes& a, const Lanes& b) {
    return Lanes::each([&](int k) -> Lanes::Part {
#if defined(__AVX512F__)
        return (Lanes::Part)_mm512_maskz_max_ps(0xffff, (__m512)a.part[k], (__m512)b.part[k]);
#elif defined(__AVX2__)
        return (Lanes::Part)_mm256_max_ps((__m256)a.part[k], (__m256)b.part[k]);
#elif defined(__SSE2__)
        return (Lanes::Part)_mm_max_ps((__m128)a.part[k], (__m128)b.part[k]);
#else
        return a.part[k] > b.part[k] ? a.part[k] : b.part[k];
#endif
    });
}

inline Lanes square_root(const Lanes& a) {
    return Lanes::each([&](int k) -> Lanes::Part {
#if defined(__AVX512F__)
        return (Lanes::Part)_mm512_maskz_sqrt_ps(0xffff, (__m512)a.part[k]);
#elif defined(__AVX2__)
        return (Lanes::Part)_mm256_sqrt_ps((__m256)a.part[k]);
#elif defined(__SSE2__)
        return (Lanes::Part)_mm_sqrt_ps((__m128)a.part[k]);
#else
        Lanes::Part root;
        for (int lane = 0; lane < Lanes::width; ++lane) root[lane] = std::sqrt(a.part[k][lane]);
        return root;
#endif
    });
}

// Bit k says whether a[k] <= b[k].
inline unsigned where_no_larger(const Lanes& a, const Lanes& b) {
    unsigned bits = 0;
    for (int k = 0; k < Lanes::parts; ++k) {
#if defined(__AVX512F__)
        bits |= _mm512_cmp_ps_mask((__m512)a.part[k], (__m512)b.part[k], _CMP_LE_OQ);
#else
        const Lanes::Mask mask = a.part[k] <= b.part[k];
#if defined(__AVX2__)
        bits |= static_cast<unsigned>(_mm256_movemask_ps((__m256)mask)) << (k * Lanes::width);
#elif defined(__SSE2__)
        bits |= static_cast<unsigned>(_mm_movemask_ps((__m128)mask)) << (k * Lanes::width);
#else
        for (int lane = 0; lane < Lanes::width; ++lane)
            bits |= static_cast<unsigned>(mask[lane] & 1) << (k * Lanes::width + lane);
#endif
#endif
    }
    return bits;
}

// The number of the lowest bit that is set.
inline int lowest_bit(unsigned bits) { return __builtin_ctz(bits); }

}  // namespace glass
