// What a smooth interface does to unpolarised light.
#pragma once

#include <cmath>

namespace glass {

struct Interface {
    double reflectance;    // 1 at total internal reflection
    double cos_refracted;  // 0 at total internal reflection
    double ratio;          // n1 / n2
};

// Fresnel's equations, averaged over the two polarisations. 1 - sin^2 is formed as (1 - s)(1 + s): near the critical
// angle the plain form loses half the digits.
inline Interface fresnel(double cos_incident, double n1, double n2) {
    const double ratio = n1 / n2;
    const double sine = ratio * std::sqrt((1.0 - cos_incident) * (1.0 + cos_incident));
    if (sine >= 1.0) return {1.0, 0.0, ratio};
    const double cos_refracted = std::sqrt((1.0 - sine) * (1.0 + sine));
    const double s_sum = n1 * cos_incident + n2 * cos_refracted, p_sum = n1 * cos_refracted + n2 * cos_incident;
    const double inverse = 1.0 / (s_sum * p_sum);
    const double s = (n1 * cos_incident - n2 * cos_refracted) * p_sum * inverse;
    const double p = (n1 * cos_refracted - n2 * cos_incident) * s_sum * inverse;
    return {0.5 * (s * s + p * p), cos_refracted, ratio};
}

}  // namespace glass
