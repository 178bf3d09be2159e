// Where in a pixel its samples lie: the first two dimensions of Sobol's sequence, a (0, 2)-sequence in base 2, shifted
// digitally by a hash of the pixel so that neighbours do not alias together. Any first 4^k samples are stratified.
#pragma once

#include <cstdint>

namespace glass {

inline std::uint32_t reversed_bits(std::uint32_t n) {
    n = (n << 16) | (n >> 16);
    n = ((n & 0x00ff00ffu) << 8) | ((n & 0xff00ff00u) >> 8);
    n = ((n & 0x0f0f0f0fu) << 4) | ((n & 0xf0f0f0f0u) >> 4);
    n = ((n & 0x33333333u) << 2) | ((n & 0xccccccccu) >> 2);
    return ((n & 0x55555555u) << 1) | ((n & 0xaaaaaaaau) >> 1);
}

inline std::uint32_t second_dimension(std::uint32_t n) {
    std::uint32_t value = 0;
    for (std::uint32_t v = 1u << 31; n != 0; n >>= 1, v ^= v >> 1)
        if (n & 1u) value ^= v;
    return value;
}

inline std::uint64_t hashed(std::uint64_t x) {  // splitmix64's finaliser (Steele, Lea, Flood 2014)
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

struct SamplePoint {
    double x, y;  // in [0, 1)
};

inline SamplePoint sample_point(std::int64_t pixel, std::uint32_t number) {
    const std::uint64_t shift = hashed(static_cast<std::uint64_t>(pixel));
    constexpr double scale = 1.0 / 4294967296.0;
    return {scale * (reversed_bits(number) ^ static_cast<std::uint32_t>(shift)),
            scale * (second_dimension(number) ^ static_cast<std::uint32_t>(shift >> 32))};
}

}  // namespace glass
