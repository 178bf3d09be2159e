// Polynomials in Bernstein form on [0, 1]: products, derivatives, subdivision, roots.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace glass {

using Bernstein = std::vector<double>;  // coefficients, degree = size - 1

inline double binomial(int n, int k) {
    double value = 1.0;
    for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
    return value;
}

inline Bernstein product(const Bernstein& a, const Bernstein& b) {
    const int m = static_cast<int>(a.size()) - 1, n = static_cast<int>(b.size()) - 1;
    Bernstein c(m + n + 1, 0.0);
    for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j) c[i + j] += binomial(m, i) * binomial(n, j) / binomial(m + n, i + j) * a[i] * b[j];
    return c;
}

inline Bernstein difference(Bernstein a, const Bernstein& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
    return a;
}

inline Bernstein derivative(const Bernstein& a) {
    const int n = static_cast<int>(a.size()) - 1;
    Bernstein d(std::max(n, 1), 0.0);
    for (int i = 0; i < n; ++i) d[i] = n * (a[i + 1] - a[i]);
    return d;
}

// De Casteljau: the control values of the parts left and right of u.
inline void subdivide(const Bernstein& a, double u, Bernstein& left, Bernstein& right) {
    Bernstein work = a;
    left.clear();
    right.assign(a.size(), 0.0);
    const int n = static_cast<int>(a.size());
    for (int level = 0; level < n; ++level) {
        left.push_back(work.front());
        right[n - 1 - level] = work.back();
        for (std::size_t i = 0; i + 1 < work.size(); ++i) work[i] += u * (work[i + 1] - work[i]);
        work.pop_back();
    }
}

// Parameters strictly inside (0, 1) where the polynomial changes sign, by subdivision (Lane & Riesenfeld 1981).
inline void sign_changes(const Bernstein& a, double low, double high, int depth, std::vector<double>& found) {
    int changes = 0;
    double previous = 0.0;
    for (double c : a) {
        if (c != 0.0 && previous != 0.0 && (c > 0.0) != (previous > 0.0)) ++changes;
        if (c != 0.0) previous = c;
    }
    if (changes == 0) return;
    const double middle = 0.5 * (low + high);
    if (depth == 0) {
        found.push_back(middle);
        return;
    }
    Bernstein left, right;
    subdivide(a, 0.5, left, right);
    sign_changes(left, low, middle, depth - 1, found);
    if (left.back() == 0.0 && left.size() > 1 && (left[left.size() - 2] > 0.0) != (right[1] > 0.0))
        found.push_back(middle);
    sign_changes(right, middle, high, depth - 1, found);
}

}  // namespace glass
